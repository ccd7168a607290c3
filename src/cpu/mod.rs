//! The CPU engine: rotated raster scans in lanes, [`RotatedScan`]; and, point by point, the
//! references it is held against: directed scans, fast marching and, with the feature `twins`, the shaders'
//! twins.
//!
//! All share one update and one array layout (a border of points that are never reached), and
//! converge to the same map. Single precision is for use, double precision for reference. What a front is,
//! how it starts, goes on and is compared, is said in one file for each kind (`fronts/`).
//!
//! [`RotatedScan`] updates a row from the row behind it, sixteen points at once with AVX-512
//! (`line_update.rs`); columns are rows of a transposed panel of sixteen (`panel.rs`, `transposed.rs`); and a
//! scan visits only tiles beside which something has changed since it passed (`tiles.rs`), if anything
//! follows from that (`due.rs`).

mod behind;
mod ceilings;
mod clusters;
mod connections;
mod due;
mod fast_marching;
#[cfg(test)]
mod floor_plans;
mod fronts;
mod line;
mod line_update;
mod merge;
mod pairwise;
mod panel;
mod point_fronts;
mod progress;
mod raster_scan;
mod rotated_scan;
mod scan;
mod scan_copy;
mod scanner;
pub(crate) mod settled;
mod sight_lines;
mod solution;
mod stream;
mod stretch;
mod surroundings;
mod tiles;
mod transpose;
mod transposed;
#[cfg(any(test, feature = "twins"))]
pub mod twins;

pub use crate::lanes::Instructions;
pub use ceilings::Ceilings;
pub use connections::Connections;
pub use fast_marching::{fast_marching, fast_marching_with};
pub use pairwise::PairwiseScan;
pub(crate) use progress::{Progress, bend_units};
pub use raster_scan::raster_scan;
pub use rotated_scan::{RotatedScan, rotated_scan};
pub(crate) use settled::Visited;
pub use solution::Solution;
