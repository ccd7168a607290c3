//! Chooses the order in which the points of a grid are updated.

use std::fmt;

use ash::vk;

use crate::name::{UnknownName, by_name};
use crate::surface::Chart;

/// Order of updates on the device. All orders lead to the same map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Schedule {
    /// The schedule of the paper: four rotated scans over the whole grid, in turn or in pairs. A dispatch updates
    /// several lines of texels.
    Raster,
    /// Rounds of scans inside tiles, in shared memory. A round visits the tiles in which or beside which the previous
    /// round has changed a front.
    Tiles,
}

impl Schedule {
    /// All schedules.
    pub const ALL: [Self; 2] = [Self::Raster, Self::Tiles];

    /// Returns the name used on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Raster => "raster",
            Self::Tiles => "tiles",
        }
    }

    /// Returns a description of one line, for help texts.
    pub fn about(self) -> &'static str {
        match self {
            Self::Raster => "Scans over rows and columns, as in the paper",
            Self::Tiles => "Tiles in the device's shared memory, where something has changed",
        }
    }

    /// Returns the schedule that was fastest in measurements for a grid of this size on a device of this kind.
    pub fn best_on(kind: vk::PhysicalDeviceType, chart: Chart) -> Self {
        let side = chart.rows.max(chart.cols);
        let on_cpu = kind == vk::PhysicalDeviceType::CPU;
        let choice = CHOICES.iter().find(|choice| choice.on_cpu == on_cpu && side <= choice.side);
        choice.map_or(Self::Raster, |choice| choice.schedule)
    }
}

/// Parses the [`name`](Schedule::name) of a schedule.
impl std::str::FromStr for Schedule {
    type Err = UnknownName;

    fn from_str(text: &str) -> Result<Self, UnknownName> {
        by_name("schedule", text, &Self::ALL, |schedule| schedule.name())
    }
}

impl fmt::Display for Schedule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Range of devices and grids for which a schedule is the best.
struct Choice {
    on_cpu: bool,
    /// Largest number of rows or columns of the grid.
    side: usize,
    schedule: Schedule,
}

/// Best schedules. The first entry that applies is used.
const CHOICES: [Choice; 3] = [
    // Measured on lavapipe (Mesa 22.3, two cores), planar and curved fronts. Tiles take 0.2 to 1.0 of the
    // time of raster scans at 9 to 25 points a side, and 0.75 to 1.7 at 33 points. On such grids a dispatch costs more
    // than the work of a tile.
    Choice { on_cpu: true, side: 32, schedule: Schedule::Tiles },
    // Measured as above. From 49 points a side on, tiles take 2 to 20 times as long as raster scans on a sphere, since
    // barriers inside shaders are expensive on lavapipe. In a maze each round visits few tiles. When scans still
    // visited all blocks of lines, tiles took 0.4 to 0.9 of their time in mazes of 129 to 257 points a side. Now scans
    // skip blocks that are not due, and tiles take 1.3 to 2.2 times as long as scans there (medians of 5 pairs beside
    // other work).
    Choice { on_cpu: true, side: usize::MAX, schedule: Schedule::Raster },
    // Measured on an NVIDIA H200 (docs/devices), planar and curved fronts on a sphere: tiles take 0.2 to 0.8
    // of the time of raster scans from 64 to 4096 points a side.
    Choice { on_cpu: false, side: usize::MAX, schedule: Schedule::Tiles },
];
