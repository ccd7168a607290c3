//! Bodies that are fuzzed: they accept any bytes and panic if something is wrong.
//!
//! cargo-fuzz (`fuzz/`) and the test on stable Rust call the same bodies.

#![allow(dead_code, unused_imports, reason = "each target of cargo-fuzz calls one body")]

pub mod dice;
mod readers;
mod surface;

pub use readers::UNFINISHED;

/// A body with the name of its target and of its folder of seeds.
#[derive(Clone, Copy)]
pub struct Body {
    pub name: &'static str,
    pub run: fn(&[u8]),
}

pub const BODIES: [Body; 10] = [
    Body { name: "npy", run: readers::npy },
    Body { name: "npz", run: readers::npz },
    Body { name: "png", run: readers::png },
    Body { name: "tiff", run: readers::tiff },
    Body { name: "asc", run: readers::asc },
    Body { name: "exr", run: readers::exr },
    Body { name: "table", run: readers::table },
    Body { name: "matrix", run: readers::matrix },
    Body { name: "checkpoint", run: readers::checkpoint },
    Body { name: "surface", run: surface::surface },
];

/// Runs the body with this name.
pub fn run(name: &str, data: &[u8]) {
    let body = BODIES.iter().find(|body| body.name == name);
    (body.expect("a body has this name").run)(data);
}
