//! Results of tuning: the numbers that are varied, and the times of maps with each value.

use std::time::Duration;

use geosweep::surface::Seed;
use geosweep::vulkan::{Schedule, Tuning};
use geosweep::{Surface, Wavefront};

/// A number of [`Tuning`] that is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knob {
    /// No number: the device's default portions.
    Untuned,
    Lines,
    Width,
    Tile,
    Inner,
    /// The number of iterations of raster scans, or of rounds of tiles, in a submission.
    Together,
    /// All suggested numbers together.
    Suggested,
}

impl Knob {
    pub fn name(self) -> &'static str {
        match self {
            Self::Untuned => "untuned",
            Self::Lines => "lines a block",
            Self::Width => "invocations a group",
            Self::Tile => "points a tile's side",
            Self::Inner => "iterations in a tile",
            Self::Together => "in a submission",
            Self::Suggested => "as suggested",
        }
    }

    /// Returns `tuning` with this number set to `value`.
    pub fn set(self, tuning: Tuning, value: u32) -> Tuning {
        match self {
            Self::Untuned | Self::Suggested => tuning,
            Self::Lines => Tuning { scan_lines: value, ..tuning },
            Self::Width => Tuning { scan_width: value, ..tuning },
            Self::Tile => Tuning { tile: value, small_grid: 0, ..tuning },
            Self::Inner => Tuning { inner: value, ..tuning },
            Self::Together => Tuning { together: Some(value), ..tuning },
        }
    }
}

/// A surface to solve on.
pub struct Task {
    pub name: String,
    pub surface: Surface,
    pub seeds: Vec<Seed>,
}

/// The timing of a map with certain portions.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// The index of the task in [`Swept::tasks`].
    pub task: usize,
    pub best: Duration,
    /// The best time of the untuned map. The two maps are timed alternately, since the speed of a device and its other
    /// load change from minute to minute.
    pub untuned: Duration,
    pub iterations: u32,
    /// The largest difference from the untuned map, relative to its largest distance. It is infinite if one
    /// map reaches a point and the other does not.
    pub difference: f64,
}

/// All maps with the same portions.
pub struct Row {
    pub schedule: Schedule,
    pub knob: Knob,
    pub value: u32,
    pub maps: Vec<Map>,
    /// The reason why the device cannot use the value, if it cannot.
    pub refused: Option<String>,
    /// The geometric mean of the ratios to the untuned times.
    pub ratio: Option<f64>,
}

/// The largest acceptable difference from the untuned map, relative to its largest distance. Larger differences are
/// errors: each map is iterated until its changes are a tenth of this.
pub const SAME: f64 = 1e-5;

impl Row {
    pub fn differs(&self) -> bool {
        self.maps.iter().any(|map| map.difference > SAME)
    }
}

/// The results of all measurements.
pub struct Swept {
    pub device: String,
    pub wavefront: Wavefront,
    pub tasks: Vec<Task>,
    pub untuned: Tuning,
    pub suggested: Tuning,
    /// The rows: for each schedule the untuned one and each value of each knob, then for each schedule the suggested
    /// values if they differ from the untuned ones.
    pub rows: Vec<Row>,
    pub left_out: Vec<String>,
}

impl Swept {
    pub fn differing(&self) -> Vec<&Row> {
        self.rows.iter().filter(|row| row.differs()).collect()
    }
}
