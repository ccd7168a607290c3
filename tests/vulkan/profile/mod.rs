//! What a profile says of passes, against counts and clocks of the tests' own.

mod bench;
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
mod work;
