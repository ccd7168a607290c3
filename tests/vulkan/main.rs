//! The Vulkan engine under the validation layers: without a renderer, embedded in one, and profiled.

mod anchored;
mod bounds;
mod closed;
mod closed_pairwise;
#[path = "../common/mod.rs"]
mod common;
mod embed;
mod headless;
#[path = "../common/host/mod.rs"]
mod host;
mod limits;
mod pairwise;
mod profile;
mod scan_pairs;
#[cfg(feature = "shaderc")]
mod spirv;
mod staging;
mod tile_lanes;
