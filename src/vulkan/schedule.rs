//! In which order the points of a grid are updated, and in how large portions.

use std::fmt;

use ash::vk;

use super::plan::Portions;
use super::{TexelChart, VulkanError};
use crate::Wavefront;
use crate::name::{UnknownName, by_name};
use crate::surface::Chart;

/// The order of updates on the device. All lead to the same map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Schedule {
    /// The paper's: four rotated scans over the whole grid, one after another, several lines of
    /// texels a dispatch.
    Raster,
    /// All points at once from their eight triangles, again and again. A front advances by one
    /// point an update, so it is for tiny grids, and for comparison.
    AllPoints,
    /// Rounds of scans inside tiles, in shared memory; a round visits the tiles beside which the
    /// one before has changed something.
    Tiles,
}

impl Schedule {
    /// All schedules.
    pub const ALL: [Self; 3] = [Self::Raster, Self::AllPoints, Self::Tiles];

    /// The name used on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Raster => "raster",
            Self::AllPoints => "all-points",
            Self::Tiles => "tiles",
        }
    }

    /// What it does, in a line: help for those who choose.
    pub fn about(self) -> &'static str {
        match self {
            Self::Raster => "Scans over rows and columns, as in the paper",
            Self::AllPoints => "All points at once: for tiny grids, and for comparison",
            Self::Tiles => "Tiles in the device's shared memory, where something has changed",
        }
    }

    /// The best schedule on a kind of device for a grid, as far as it is known.
    pub fn best_on(kind: vk::PhysicalDeviceType, chart: Chart) -> Self {
        let side = chart.rows.max(chart.cols);
        let on_cpu = kind == vk::PhysicalDeviceType::CPU;
        let choice = CHOICES.iter().find(|choice| choice.on_cpu == on_cpu && side <= choice.side);
        choice.map_or(Self::Raster, |choice| choice.schedule)
    }
}

/// By its [`name`](Schedule::name).
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

/// Sizes of portions, which shaders take as specialization constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Tuning {
    /// Invocations of a workgroup of a raster scan: texels of a line. Where a whole line fits (with one less than
    /// [`scan_lines`](Tuning::scan_lines) to spare at each end), a dispatch takes many blocks of lines in turn.
    pub scan_width: u32,
    /// Lines of texels in one dispatch of a raster scan. At each end of a workgroup all but one
    /// of so many texels are computed by its neighbour too.
    pub scan_lines: u32,
    /// Points on a side of a tile; even.
    pub tile: u32,
    /// Iterations of four scans inside a tile in one round, at most.
    pub inner: u32,
    /// Iterations of raster scans, or rounds of tiles, in a submission, at most; by default by the size of
    /// the grid. On large grids there are fewer iterations than asked for.
    pub together: Option<u32>,
    /// Texels that are visited in a submission, at most, as far as single dispatches allow: systems take a
    /// device that is busy for seconds for hung, and nothing else is drawn meanwhile. By default 4 million. An
    /// iteration that visits more is cut into several submissions ([`parts`](super::plan::parts)), but for recordings into a renderer's
    /// command buffer.
    pub visits: Option<u64>,
}

impl Tuning {
    /// The sizes for a device.
    pub fn of(properties: &vk::PhysicalDeviceProperties) -> Self {
        let limits = &properties.limits;
        let on_cpu = properties.device_type == vk::PhysicalDeviceType::CPU;
        let wanted = if on_cpu { Self::ON_CPU } else { Self::ON_GPU };
        let fits = |tile: u32| Self::tile_bytes(tile) <= limits.max_compute_shared_memory_size;
        let tile = if fits(wanted.tile) { wanted.tile } else { 8 };
        Self {
            scan_width: wanted.scan_width.min(limits.max_compute_work_group_invocations),
            tile,
            ..wanted
        }
    }

    /// Measured on lavapipe (Mesa 22.3, two cores, 1200 x 1200 points): blocks of four lines take
    /// 0.8 times as long as single lines with planar fronts and 0.65 times with curved ones; of
    /// eight, 0.8 and 0.75. Workgroups of 128, by which blocks go in turn up to 244 points a side in place of 116, take
    /// 0.4 to 1.1 times as long there and 0.9 to 2.1 times at 320 points.
    const ON_CPU: Self =
        Self { scan_width: 64, scan_lines: 4, tile: 16, inner: 4, together: None, visits: None };
    /// Of scans, not measured: fewer dispatches for an eighth more updates. A warp for each tile; with one iteration
    /// in it, in place of four, maps by tiles take an NVIDIA H200 0.55 to 0.65 of the time from 256 to 4096 points a
    /// side, and as long with 64.
    const ON_GPU: Self =
        Self { scan_width: 128, scan_lines: 8, tile: 16, inner: 1, together: None, visits: None };

    /// Whether a device has room for them.
    pub(crate) fn check(&self, limits: &vk::PhysicalDeviceLimits) -> Result<(), VulkanError> {
        let Self { scan_width, scan_lines, tile, inner, together, visits } = *self;
        let refuse = |reason: String| Err(VulkanError::Tuning(reason));
        let most =
            limits.max_compute_work_group_invocations.min(limits.max_compute_work_group_size[0]);
        let bytes = limits.max_compute_shared_memory_size;
        if scan_lines == 0 || scan_lines > MOST_LINES {
            return refuse(format!("{scan_lines} lines are not between 1 and {MOST_LINES}"));
        }
        if scan_width > most || 32 * scan_width > bytes {
            return refuse(format!("a workgroup of {scan_width} invocations is too large"));
        }
        if scan_width <= 2 * (scan_lines - 1) {
            return refuse(format!("of {scan_width} texels none is left for {scan_lines} lines"));
        }
        if !(2..=64).contains(&tile) || tile % 2 != 0 || 2 * tile > most {
            return refuse(format!("no tile has {tile} points a side"));
        }
        if Self::tile_bytes(tile) > bytes {
            return refuse(format!("a tile of {tile} points a side does not fit {bytes} bytes"));
        }
        if inner == 0 {
            return refuse("no iteration in a tile solves nothing".into());
        }
        if together == Some(0) {
            return refuse("no iteration in a submission solves nothing".into());
        }
        if visits == Some(0) {
            return refuse("no texel visited in a submission solves nothing".into());
        }
        Ok(())
    }

    /// Shared memory of a tile with curved fronts: edge lengths, Gaussian curvature and four
    /// copies of the fronts at its points and those around it.
    fn tile_bytes(tile: u32) -> u32 {
        (tile + 2).pow(2) * (16 + 4 + 4 * 8) + 16
    }

    /// What a plan for a grid needs to know of them.
    pub fn portions(&self, wavefront: Wavefront, texels: TexelChart) -> Portions {
        let small = texels.rows.max(texels.cols) <= SMALL_SIDE;
        let iterations = if small && wavefront != Wavefront::Planar { 5 } else { 4 };
        Portions {
            lines: self.scan_lines,
            across: self.scan_texels(),
            iterations: self.together.unwrap_or(iterations),
            tile: self.tile,
            rounds: self.together,
            visits: self.visits.unwrap_or(VISITS_TOGETHER),
        }
    }

    /// Texels of a line that a workgroup of a raster scan writes.
    pub(crate) fn scan_texels(&self) -> u32 {
        self.scan_width - 2 * (self.scan_lines - 1)
    }
}

/// Lines of a block, at most: shaders note in the bits of a word which of them have changed.
const MOST_LINES: u32 = 32;

/// Of each visited texel 96 bytes are read and written with planar fronts, and 144 with curved ones: 0.6 GB at
/// most, 12 milliseconds on an integrated GPU that moves 50 GB a second. A map of 1024 x 1024 points still has four
/// iterations in a submission, and one of 8192 x 8192 points an eighth of a scan.
const VISITS_TOGETHER: u64 = 1 << 22;

/// Up to so many texels a side, circular and curved fronts on smooth surfaces settle in five
/// iterations (measured: sphere, peaks, cone and torus of 33 to 129 points); beyond, and planar
/// fronts anywhere, in four. A second submission costs a small map 6 % of its time on lavapipe.
const SMALL_SIDE: u32 = 96;

/// Where a schedule is the best one.
struct Choice {
    on_cpu: bool,
    /// Most rows and columns of the grid.
    side: usize,
    schedule: Schedule,
}

/// Which schedule where; the first entry that applies counts.
const CHOICES: [Choice; 3] = [
    // Measured on lavapipe (Mesa 22.3, two cores), planar and curved, tiles over raster scans: 9
    // to 25 points a side 0.2 to 1.0 of the time; 33 points 0.75 to 1.7.
    // A dispatch costs more than a tile's work there. All points at once took twice as long at 9
    // points, where they did best.
    Choice { on_cpu: true, side: 32, schedule: Schedule::Tiles },
    // Measured as above: from 49 points on tiles take 2 to 20 times as long on a sphere, since
    // barriers inside shaders are dear there. In a maze, where each round visits few tiles, they took
    // 0.4 to 0.9 of the time at 129 to 257 points while scans visited all blocks of lines; since these
    // pass over what cannot change, tiles take 1.3 to 2.2 times as long (medians of 5 pairs beside other work).
    Choice { on_cpu: true, side: usize::MAX, schedule: Schedule::Raster },
    // Measured on an NVIDIA H200 (docs/devices): on a sphere tiles take 0.2 to 0.8 of the time of raster scans from 64 to
    // 4096 points a side, planar and curved.
    Choice { on_cpu: false, side: usize::MAX, schedule: Schedule::Tiles },
];
