//! Represents the distances between points as a file of heights states them.

use geosweep_surface::Spacing;

/// Distances between points, as a file of heights states them.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum FileSpacing {
    /// The file gives no distance.
    Unknown,
    /// The distances between columns and between rows. They are in the unit of the heights; if the file does not say
    /// so, this is assumed.
    Known(Spacing, LinearUnit),
    /// The distances are, or may be, in degrees. The text says why.
    Degrees(&'static str),
    /// The file gives a distance that cannot be used. The text says why.
    Unusable(String),
}

/// The unit of the distances and heights in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LinearUnit {
    /// `m`, `ft` or `US ft`; `None` for other units, and for an ESRI ASCII grid without a `.prj`.
    pub name: Option<&'static str>,
    /// Whether the file, or the `.prj` beside it, states the unit of its distances. Otherwise metres are assumed.
    pub said: bool,
}
