//! What the library takes of memory: allocations on the heap, and the size of the process.
//!
//! A binary of its own, since it replaces the global allocator, and since each test has to be alone
//! in its process.

use std::sync::Mutex;

mod cpu;
mod embed;
#[path = "../common/heap.rs"]
mod heap;
#[path = "../common/host/mod.rs"]
mod host;
#[cfg(target_os = "linux")]
mod resident;

/// Held by a test as long as it runs: no other may take memory meanwhile.
static ALONE: Mutex<()> = Mutex::new(());
