//! Solves distance maps on the CPU: [`RotatedScan`] runs rotated raster scans in SIMD lanes. Its tests compare it with
//! point-by-point references, also in this crate: directed scans and, with the feature `twins`, the shaders' twins.
//!
//! All solvers share one update and one array layout, which has a border of points that are never reached. They
//! converge to the same map. Single precision is for use, double precision for reference. Each kind of front has a file
//! in `fronts/`, which defines its data, its start, its update and its comparison.
//!
//! [`RotatedScan`] updates a row from the row behind it, sixteen points at once with AVX-512 (`line_update.rs`).
//! Columns are updated as rows of a transposed panel of sixteen (`panel.rs`, `transposed.rs`). A scan visits only tiles
//! beside which something has changed since it last passed (`tiles.rs`), and only if that change has an effect
//! (`due.rs`). On large grids, all threads scan patches in the order in which fronts reach them (`patches/`). Over a rough
//! slowness, points are updated one by one in that order (`buckets/`), which is fast marching.

mod behind;
mod ceilings;
mod fronts;
mod limit;
#[doc(hidden)]
pub mod lines;
mod pairwise;
mod points;
mod progress;
mod rotated;
mod scan;
mod solution;
mod sparse_rows;
mod surroundings;
mod target_estimate;
#[cfg(any(test, feature = "twins"))]
pub mod twins;

pub use ceilings::CpuCeilings;
pub use geosweep_surface::Instructions;
#[doc(hidden)]
pub use lines::Visited;
pub use pairwise::PairwiseScan;
pub use points::raster_scan;
#[doc(hidden)]
pub use progress::{Progress, bend_units};
pub use rotated::{Order, PatchCounts, RotatedScan, rotated_scan};
pub use solution::Solution;
pub use sparse_rows::SparseRows;
pub use surroundings::seeds_for;
#[doc(hidden)]
pub use surroundings::{FirstArrival, StraightFronts, needed_straight_fronts, straight_parts};
#[doc(hidden)]
pub use target_estimate::estimate_targets;
