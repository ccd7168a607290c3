//! Converts sources and their fronts to the form in which shaders read them.

mod anchors;
mod seeds;

pub(super) use anchors::{ANCHOR_BYTES, Anchors};
pub(crate) use seeds::{SEED_BYTES, SOURCE_BYTES, SeedTexel, curvatures, seed_texels};
