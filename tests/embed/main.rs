//! The embedding interface, used by a renderer of the tests' own.

#[path = "../common/mod.rs"]
mod common;
#[path = "../../examples/embed.rs"]
mod example;
mod faults;
mod frames;
mod host;
mod inputs;
mod stage;

/// It checks that every frame has converged.
#[test]
fn the_example_runs() {
    example::main().unwrap();
}
