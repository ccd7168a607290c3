//! Solves distance maps on the CPU: [`RotatedScan`] runs rotated raster scans in SIMD lanes. The
//! point-by-point references that it is tested against are here too: directed scans, fast marching and, with
//! the feature `twins`, the shaders' twins.
//!
//! All solvers share one update and one array layout, which has a border of points that are never reached.
//! They converge to the same map. Single precision is for use, double precision for reference. Each kind of
//! front has a file in `fronts/`, which says what the front is, how it starts, continues and is compared.
//!
//! [`RotatedScan`] updates a row from the row behind it, sixteen points at once with AVX-512
//! (`line_update.rs`). Columns are updated as rows of a transposed panel of sixteen (`panel.rs`,
//! `transposed.rs`). A scan visits only tiles beside which something has changed since it last passed
//! (`tiles.rs`), and only if that change has an effect (`due.rs`). Large grids are scanned patch by patch, as
//! fronts come to them, by all threads (`patches/`).

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
mod order;
mod pairwise;
mod panel;
mod patches;
mod point_fronts;
mod prepared;
mod progress;
mod raster_scan;
mod rotated_scan;
mod scan;
mod scan_copy;
mod scanner;
mod scans;
pub(crate) mod settled;
mod sight_lines;
mod solution;
mod span;
mod stream;
mod surroundings;
mod tiles;
mod transpose;
mod transposed;
#[cfg(any(test, feature = "twins"))]
pub mod twins;
mod typical_edge;
mod window;

pub use crate::lanes::Instructions;
pub use ceilings::CpuCeilings;
pub use connections::Connections;
pub use fast_marching::{fast_marching, fast_marching_with};
pub use order::Order;
pub use pairwise::PairwiseScan;
pub use patches::PatchCounts;
pub(crate) use progress::{Progress, bend_units};
pub use raster_scan::raster_scan;
pub use rotated_scan::{RotatedScan, rotated_scan};
pub(crate) use settled::Visited;
pub use solution::Solution;
