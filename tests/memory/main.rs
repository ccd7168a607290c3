//! Memory that the library takes: allocations on the heap, and the size of the process.
//!
//! This is a separate binary, since it replaces the global allocator, and since each test must be alone in
//! its process.

use std::sync::Mutex;

mod cpu;
mod embed;
#[path = "../common/heap.rs"]
mod heap;
#[path = "../common/host/mod.rs"]
mod host;
#[cfg(target_os = "linux")]
mod resident;

/// Lock that each test holds while it runs, so that no other test takes memory.
static ALONE: Mutex<()> = Mutex::new(());
