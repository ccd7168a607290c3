//! geosweep in a renderer: surfaces drawn in 3D, coloured by distance maps that stay on the GPU.
//!
//! `cargo run --release --features formats --example viewer`
//!
//! Click or drag moves the source; drag with the right button turns, the wheel zooms. S is the
//! next surface, C the next schedule, W the next wavefront; L draws lines of equal distance as
//! lines rather than in the fragment shader, P the shortest path from under the pointer to the
//! source. Escape is the end.
//!
//! docs/figures/viewer.png: `--surface sheet --frames 60 --picture docs/figures/viewer.png`.
//!
//! What is geosweep's in here is in `map.rs` and `lines.rs`; the order of a frame's passes is in `viewer.rs`.

mod camera;
mod draw;
mod frames;
mod gpu;
mod lines;
mod map;
mod memory;
mod options;
mod pick;
mod picture;
mod pipelines;
mod shaders;
mod stage;
mod surfaces;
mod swapchain;
mod timing;
mod validation;
mod view;
mod viewer;
mod window;

use std::error::Error;
use std::process::ExitCode;

use clap::Parser;

use options::Options;

/// What can go wrong, in words.
type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> ExitCode {
    match window::run(Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("viewer: {error}");
            ExitCode::FAILURE
        }
    }
}
