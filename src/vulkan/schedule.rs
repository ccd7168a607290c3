//! In which order the points of a grid are updated, and in how large portions.

use std::fmt;

use ash::vk;

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
}

impl fmt::Display for Schedule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Sizes of portions, which shaders take as specialization constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Tuning {
    /// Invocations of a workgroup of a raster scan: texels of a line.
    pub scan_width: u32,
    /// Lines of texels in one dispatch of a raster scan. At each end of a workgroup all but one
    /// of so many texels are computed by its neighbour too.
    pub scan_lines: u32,
    /// Points on a side of a tile; even.
    pub tile: u32,
    /// Iterations of four scans inside a tile in one round, at most.
    pub inner: u32,
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
    /// eight, 0.8 and 0.75.
    const ON_CPU: Self = Self { scan_width: 64, scan_lines: 4, tile: 16, inner: 4 };
    /// Not measured: fewer dispatches for an eighth more updates, and a warp for each tile.
    const ON_GPU: Self = Self { scan_width: 128, scan_lines: 8, tile: 16, inner: 4 };

    /// Shared memory of a tile with curved fronts: edge lengths, Gaussian curvature and four
    /// copies of the fronts at its points and those around it.
    fn tile_bytes(tile: u32) -> u32 {
        (tile + 2).pow(2) * (16 + 4 + 4 * 8) + 16
    }

    /// Texels of a line that a workgroup of a raster scan writes.
    pub(crate) fn scan_texels(&self) -> u32 {
        self.scan_width - 2 * (self.scan_lines - 1)
    }
}

/// The schedule when none is asked for: on lavapipe tiles take some forty times as long as raster
/// scans on 1200 x 1200 points, and no GPU has been at hand to measure on.
pub(crate) const DEFAULT: Schedule = Schedule::Raster;
