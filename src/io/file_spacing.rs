//! Defines the information in files of heights on the distance between their points.

use crate::surface::Spacing;

/// The information in a file of heights on the distance between its points.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum FileSpacing {
    /// The file gives no distance.
    Unknown,
    /// A distance, in the unit of the heights.
    Known(Spacing, LinearUnit),
    /// The file gives a distance in degrees. The text says how this is known.
    Degrees(&'static str),
    /// The file gives a distance that cannot be used. The text says why.
    Unusable(String),
}

/// The unit of lengths in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LinearUnit {
    /// Name of the unit, if it is a common one.
    pub name: Option<&'static str>,
    /// Whether the file states the unit. Otherwise it is the default.
    pub said: bool,
}
