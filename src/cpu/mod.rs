//! The CPU engine: rotated raster scans in lanes, [`RotatedScan`]; and, point by point, the
//! references it is held against: directed scans, the shaders' twins and fast marching.
//!
//! All share one update and one array layout (a border of points that are never reached), and
//! converge to the same map. Single precision is for use, double precision for reference.
//!
//! [`RotatedScan`] updates a row from the row behind it, sixteen points at once with AVX-512
//! (`line_update.rs`); columns are rows of a transposed panel of sixteen (`panel.rs`, `turned.rs`); and a scan
//! visits only tiles beside which something has changed since it passed (`tiles.rs`), if anything
//! follows from that (`due.rs`).

mod anchored;
mod anchored_scan;
mod ceilings;
mod connections;
mod due;
mod fast_marching;
mod field;
#[cfg(test)]
mod floor_plans;
mod line;
mod line_update;
mod pairwise;
mod panel;
mod progress;
mod raster_scan;
mod rotated_scan;
mod settled;
mod state;
mod stream;
mod surroundings;
mod tiles;
mod transpose;
mod turned;
mod twins;

pub use crate::lanes::Instructions;
pub use ceilings::Ceilings;
pub use connections::Connections;
pub use fast_marching::{fast_marching, fast_marching_with};
pub use pairwise::PairwiseScan;
pub(crate) use progress::{Progress, bend_units};
pub use raster_scan::raster_scan;
pub use rotated_scan::{RotatedScan, rotated_scan};
pub(crate) use settled::{Visited, stays};
pub use state::Solution;
pub use twins::{
    Rounds, Visits, all_points, regions, scan_due, scan_in_turn, scan_outward, surroundings,
    tile_rounds,
};
