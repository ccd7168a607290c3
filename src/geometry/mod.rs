//! What people do with a distance map.

mod arrivals;
#[cfg(feature = "canonical")]
pub mod canonical;
mod chains;
mod contours;
mod curve;
mod paths;
mod sampling;
mod triangles;

pub use contours::{Contour, LevelError, Levels, MOST_LEVELS, contours};
pub use curve::{Curve, CurveError};
pub use paths::{Path, PathError, Paths};
pub use sampling::{Farthest, FarthestPoints, farthest};
