//! The shaders' schedules point by point, each in the order of its shader: for tests to hold one
//! against the other, after any number of iterations. They are slow.

mod all_points;
mod regions;
mod scan_due;
mod scan_in_turn;
mod surroundings;
mod tile_rounds;

pub use all_points::all_points;
pub use regions::regions;
pub use scan_due::{Visits, scan_due};
pub use scan_in_turn::{scan_in_turn, scan_outward};
pub use surroundings::surroundings;
pub use tile_rounds::{Rounds, tile_rounds};

use super::state::Behind;
use crate::surface::{Chart, Direction};

/// The four scans of an iteration, numbered from 1: the three neighbours a scan has just passed,
/// across the scan from west to east or from north to south.
const SCANS: [[Direction; 3]; 4] = [
    [Direction::NorthWest, Direction::North, Direction::NorthEast],
    [Direction::SouthWest, Direction::South, Direction::SouthEast],
    [Direction::NorthWest, Direction::West, Direction::SouthWest],
    [Direction::NorthEast, Direction::East, Direction::SouthEast],
];

/// The two triangles of each scan.
fn scan_triangles(chart: Chart) -> [Behind; 4] {
    SCANS.map(|behind| Behind::new(chart, behind))
}
