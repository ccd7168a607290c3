//! Constants shared with the shaders, from glsl/constants.glsl.

include!(concat!(env!("OUT_DIR"), "/constants.rs"));
