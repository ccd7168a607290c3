//! Coordinate reference systems: the place and orientation of a grid on a map, units of length, and how much a map lengthens distances.
//!
//! File formats (`geosweep::io`) and the package for Python share this crate. It reads no files.

#[doc(hidden)]
pub mod c_number;
#[doc(hidden)]
pub mod ellipsoids;
#[doc(hidden)]
pub mod epsg_units;
mod georeference;
mod map_scale;
mod orientation;
#[doc(hidden)]
pub mod projection_file;
mod system_units;
#[doc(hidden)]
pub mod units;

pub use georeference::{CoordinateSystem, Georeference};
pub use map_scale::MapScale;
pub use orientation::Orientation;
pub use system_units::SystemUnits;
