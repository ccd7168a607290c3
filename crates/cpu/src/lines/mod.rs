//! Defines lines of points, and spans: the adjacent points of a line that are updated together. Kinds of fronts
//! (`fronts/`) update spans, and scans (`rotated/`) pass over lines.

pub(super) mod line;
#[doc(hidden)]
pub mod settled;
pub(super) mod span;
pub(super) mod window;

#[doc(hidden)]
pub use settled::Visited;
