//! Defines lines of points, and spans: the adjacent points of a line that are updated together. Kinds of fronts
//! (`fronts/`) update spans, and scans (`rotated/`) pass over lines.

pub(super) mod line;
pub(crate) mod settled;
pub(super) mod span;
pub(super) mod window;

pub(crate) use settled::Visited;
