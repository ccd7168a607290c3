//! What files of heights say about the distance between their points.

use crate::surface::Spacing;

/// What a file of heights says about the distance between its points.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum FileSpacing {
    /// Nothing.
    Unknown,
    /// A distance, in the unit of the heights.
    Known(Spacing, LinearUnit),
    /// Something of no use, and why.
    Unusable(String),
}

/// The unit of lengths in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LinearUnit {
    /// If it is a usual one.
    pub name: Option<&'static str>,
    /// Whether the file says it, or it is what files without a word mean.
    pub said: bool,
}
