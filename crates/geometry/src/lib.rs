//! Computes geometry from distance maps: contours, geodesic paths, directions, log maps, Voronoi regions,
//! offset curves, cut loci, even samples and canonical forms.

mod across_seams;
mod area;
mod arrivals;
#[cfg(feature = "canonical")]
pub mod canonical;
mod chains;
mod contours;
mod copies;
mod crest;
mod curve;
mod directions;
mod level_set;
mod map_error;
mod neighbourhood;
mod offset;
mod order;
mod paths;
mod ridges;
mod sampling;
mod voronoi;

pub use across_seams::join_over_seams;
pub use area::area;
pub use contours::{Contour, LevelError, Levels, MOST_LEVELS, contours};
pub use curve::{Curve, CurveError};
pub use directions::{
    BackDirections, Basis, LogMap, LogMapError, NO_BEARING, NO_LINK, NO_SOURCE, Nearest, SignError,
    signed_distances, signed_distances_by_mask, signed_distances_to_polygons,
};
pub use level_set::{LevelSetError, level_set};
pub use map_error::MapError;
pub use offset::{OffsetError, Side, offset_curves};
pub use paths::{Path, PathError, PathTracer};
pub use ridges::{Ridge, ridges};
pub use sampling::{Farthest, FarthestPoints, farthest};
pub use voronoi::{Border, NO_REGION, Voronoi};
