//! What a profile says of passes, against counts and clocks of the tests' own.

mod bench;
mod capabilities;
#[path = "../common/mod.rs"]
mod common;
mod curves;
mod frames;
#[path = "../embed/host/mod.rs"]
mod host;
mod pairwise;
mod regions;
mod renderer;
#[cfg(feature = "tracing")]
mod spans;
mod times;
mod work;
