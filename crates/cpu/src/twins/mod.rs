//! Implements the shaders' schedules point by point, each in the order of its shader. Tests and studies compare twin
//! and shader after any number of iterations. The twins are slow. They need the feature `twins` and are not covered by
//! the crate's promises of compatibility.

mod blocks;
mod chart_lines;
mod phases;
mod regions;
mod scan;
mod surroundings;
mod tile_round;

pub use blocks::{Visits, scan_due, scan_in_pairs};
pub use phases::ScanOrder;
pub use regions::regions;
pub use scan::{scan_in_turn, scan_outward};
pub use surroundings::{CentralSource, surroundings};
pub use tile_round::{Rounds, tile_rounds, tile_rounds_within};

use super::behind::Behind;
use super::scan::Scan;
use geosweep_surface::Chart;

/// Returns the neighbours behind a point in each of the four scans of an iteration.
fn behind(chart: Chart) -> [Behind; 4] {
    Scan::ALL.map(|scan| Behind::of(chart, scan))
}
