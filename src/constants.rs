//! Constants shared with the shaders, from glsl/constants.glsl.

// Some serve the shaders' twins or a feature alone.
#![allow(dead_code)]

include!(concat!(env!("OUT_DIR"), "/constants.rs"));
