//! Lines of points and the spans that an update takes of them. Kinds of fronts (`fronts/`) update them, and scans
//! (`rotated/`) pass over them.

pub(super) mod line;
pub(crate) mod settled;
pub(super) mod span;
pub(super) mod window;

pub(crate) use settled::Visited;
