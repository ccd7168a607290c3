//! The embedding interface, used by a renderer of the tests' own.

#[path = "../common/mod.rs"]
mod common;
mod faults;
mod frames;
mod host;
mod inputs;
mod stage;
