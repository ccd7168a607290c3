//! geosweep in a renderer: surfaces drawn in 3D, coloured by distance maps that stay on the GPU.
//!
//! `cargo run --release --features formats --example viewer`
//!
//! A click or drag moves the source; a drag with the right button turns the camera, and the wheel zooms. S
//! switches to the next surface, C to the next schedule, W to the next wavefront. L draws lines of equal
//! distance as curves rather than in the fragment shader, and P draws the shortest path from under the
//! pointer to the source. A lets ten thousand agents walk to the source along the image of directions, and N
//! lets them step to one of eight neighbours instead, to compare. D puts a decal around the source by the log
//! map; again, it projects the decal from above, and once more, it removes the decal. + and - change its
//! size. Escape ends the program.
//!
//! S leads to closed surfaces too; `--surface builtin:globe:181x361` begins with one. Their distances pass seams
//! of the grid, and the camera sees them from below too. The viewer shows no paths, agents or decals on them.
//!
//! docs/figures/viewer.png: `--surface sheet --frames 60 --picture docs/figures/viewer.png`.
//!
//! The code that uses geosweep is in `map.rs`, `lines.rs`, `decal.rs` and `agents.rs`; the order of a frame's
//! passes is in `viewer.rs`.

mod after_map;
mod agents;
mod camera;
mod closed;
#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../shared/context.rs"]
mod context;
mod decal;
mod draw;
mod frames;
mod gpu;
mod lines;
mod map;
#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../shared/memory.rs"]
mod memory;
mod mesh;
mod options;
mod pick;
mod picture;
mod pipelines;
mod sets;
mod shaders;
mod shown;
mod stage;
mod surfaces;
mod swapchain;
mod timing;
mod view;
mod viewer;
mod window;

use std::error::Error;
use std::process::ExitCode;

use clap::Parser;

use options::Options;

/// A result whose error is a text for the user.
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
