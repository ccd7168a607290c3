//! The interface for C and C++: its header, programs in C that are compiled and run, and its functions. The
//! tests call these as C would, with structs that start from zero.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/heap.rs"]
mod heap;
#[path = "../common/host/mod.rs"]
mod host;

mod allocations;
mod build;
mod caches;
mod closed;
mod cmake;
mod cpu_maps;
mod curves;
mod faults;
mod header;
mod maps;
mod memory;
mod mistakes;
mod misuse;
mod profile;
mod programs;
mod session;
mod states;
