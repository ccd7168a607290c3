//! Profiles of passes, compared with the tests' own counts and clocks.

pub mod bench;
mod capabilities;
mod curves;
mod frames;
mod pairwise;
mod regions;
mod renderer;
#[cfg(feature = "tracing")]
mod spans;
mod submissions;
mod times;
mod ways;
mod work;
