//! What the library takes of memory: allocations on the heap, and the size of the process.
//!
//! A binary of its own, since it replaces the global allocator, and since all tests here are alone in
//! their process while they measure.

mod cpu;
mod embed;
#[path = "../common/heap.rs"]
mod heap;
#[path = "../common/host/mod.rs"]
mod host;
#[cfg(target_os = "linux")]
mod resident;
