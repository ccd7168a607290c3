//! Constants shared with the shaders, generated from `glsl/shared/constants.glsl`.

// Some constants are used only by the shaders' twins, or only with an optional feature.
#![allow(dead_code)]

include!(concat!(env!("OUT_DIR"), "/constants.rs"));
