//! Chooses the sizes of the portions in which a grid is updated.

use ash::vk;

use super::plan::Portions;
use crate::Wavefront;
use crate::vulkan::device::{memory_types, tile_lanes};
use crate::vulkan::{TexelChart, TileLanes, VulkanError};

/// Sizes of portions. Shaders receive them as specialization constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Tuning {
    /// Invocations of a workgroup of a raster scan, one for each texel of a line. If a whole line fits a workgroup,
    /// with [`scan_lines`](Tuning::scan_lines) - 1 texels to spare at each end, a dispatch takes many blocks of lines
    /// in turn.
    pub scan_width: u32,
    /// Lines of texels in a block, which one dispatch of a raster scan takes. At each end of a workgroup,
    /// `scan_lines - 1` texels are computed by the neighbouring workgroup too.
    pub scan_lines: u32,
    /// Whether opposite raster scans run in pairs, each in one half of the grid at a time. An iteration then has half
    /// as many barriers, and a device may work on both scans at once. Otherwise the four scans run in turn. The map
    /// is the same. The two scans access different texels, but validation layers before 1.3.290 track images and
    /// buffers as a whole, and would report a hazard between them. So a barrier separates the two where
    /// [`crate::vulkan::HeadlessSolver`] turns the layers on, and with [`crate::vulkan::embed::Tools::checks`].
    pub scan_pairs: bool,
    /// Number of points on a side of a tile; even.
    pub tile: u32,
    /// Largest number of points along a side of a small grid. Tiles of small grids have 16 points a side if
    /// [`tile`](Tuning::tile) is larger, with their edges in shared memory. See [`Tuning::on_grid`].
    pub small_grid: u32,
    /// Largest number of iterations of four scans inside a tile in one round.
    pub inner: u32,
    /// Division of the points of a tile among invocations.
    pub tile_lanes: TileLanes,
    /// Whether the lengths of a tile's edges are copied to shared memory. Otherwise each scan reads them from
    /// their image, one line ahead.
    pub tile_edges: bool,
    /// Largest number of iterations of raster scans, or of rounds of tiles, in a submission. `None` selects
    /// it by the size of the grid. On large grids a submission has fewer iterations than this.
    pub together: Option<u32>,
    /// Largest number of texels that a submission visits; a single dispatch may visit more. `None` selects 4 million.
    /// Operating systems reset a device that is busy for seconds, and nothing else is drawn meanwhile. An iteration
    /// that visits more texels is cut into several submissions ([`parts`](super::plan::parts)). Recordings into a
    /// renderer's command buffer are not cut.
    pub visits: Option<u64>,
    /// Whether shaders of headless maps and matrices access only the device's own memory. Inputs and results are then
    /// copied between it and the host's memory. This is the default if the device has memory of its own, since its
    /// shaders would access the host's memory over a bus.
    pub staged: bool,
}

impl Tuning {
    /// Returns the best sizes for a device. The instance must be for Vulkan 1.1 or later.
    pub fn of(instance: &ash::Instance, physical_device: vk::PhysicalDevice) -> Self {
        // SAFETY: the physical device is from this instance.
        let properties = unsafe { instance.get_physical_device_properties(physical_device) };
        let shuffles = tile_lanes::shuffles(instance, physical_device);
        // SAFETY: as above.
        let memory = unsafe { instance.get_physical_device_memory_properties(physical_device) };
        let sizes = Self::for_limits(properties.device_type, &properties.limits, shuffles);
        Self { staged: memory_types::need_staging(&memory), ..sizes }
    }

    fn for_limits(
        kind: vk::PhysicalDeviceType,
        limits: &vk::PhysicalDeviceLimits,
        shuffles: bool,
    ) -> Self {
        let wanted = match kind {
            vk::PhysicalDeviceType::CPU => Self::ON_CPU,
            _ => Self { tile_lanes: TileLanes::of_gpu(shuffles), ..Self::ON_GPU },
        };
        let sizes = [wanted.tile, 16].into_iter().flat_map(|tile| [(tile, true), (tile, false)]);
        let bytes = limits.max_compute_shared_memory_size;
        let fits = |&(tile, edges): &(u32, bool)| Self::tile_bytes(tile, edges) <= bytes;
        let (tile, tile_edges) = sizes.into_iter().find(fits).unwrap_or((8, false));
        let small_grid = if tile > SMALL_TILE { wanted.small_grid } else { 0 };
        let scan_width = wanted.scan_width.min(limits.max_compute_work_group_invocations);
        Self { scan_width, tile, small_grid, tile_edges, ..wanted }
    }

    /// Sizes for devices that are CPUs. Measured on lavapipe (Mesa 22.3, two cores, 1200 x 1200 points):
    /// blocks of four lines take 0.8 of the time of single lines with planar fronts, and 0.65 with curved ones. Blocks
    /// of eight lines take 0.8 and 0.75. With workgroups of 128 invocations instead of 64, a dispatch takes blocks in
    /// turn up to 244 points a side instead of 116. On grids between these sizes, the larger workgroups take 0.4 to 1.1
    /// of the time, and at 320 points a side 0.9 to 2.1.
    pub const ON_CPU: Self = Self {
        scan_width: 64,
        scan_lines: 4,
        scan_pairs: false,
        tile: 16,
        small_grid: 0,
        inner: 4,
        tile_lanes: TileLanes::Pairs,
        tile_edges: true,
        together: None,
        visits: None,
        staged: false,
    };
    /// Sizes for GPUs, measured on an NVIDIA H200 (docs/devices). Pairs of scans take 0.6 to 0.8 of the time of
    /// scans in turn from 64 to 1200 points a side. Blocks of 16 lines in place of 8 take 0.9 of the time at 1200
    /// points. At that size tiles of 32 points take 0.9 of the time of tiles of 16 or 24 points, and one iteration in a
    /// tile takes 0.7 of the time of two. On small grids a round has few tiles, which run at the same time, and takes
    /// as long as the consecutive lines of a single tile. Up to 128 points a side, tiles of 16 points need 1.0 to 1.9
    /// times as many rounds as tiles of 32 points, but only 0.5 to 0.95 as many consecutive lines in all
    /// (`tests/maps/tile_order.rs`).
    const ON_GPU: Self = Self {
        scan_width: 128,
        scan_lines: 8,
        scan_pairs: true,
        tile: 32,
        small_grid: 128,
        inner: 1,
        tile_lanes: TileLanes::Points,
        tile_edges: true,
        together: None,
        visits: None,
        staged: false,
    };

    /// Returns these sizes as they are on a grid. Small grids have smaller tiles.
    pub fn on_grid(self, texels: TexelChart) -> Self {
        if self.has_small_tiles(texels) { self.with_small_tiles() } else { self }
    }

    /// Returns whether a grid has smaller tiles than others.
    pub(crate) fn has_small_tiles(&self, texels: TexelChart) -> bool {
        self.tile > SMALL_TILE && texels.inner().into_iter().all(|side| 2 * side <= self.small_grid)
    }

    /// Returns these sizes with the tiles of small grids.
    pub(crate) fn with_small_tiles(self) -> Self {
        Self { tile: SMALL_TILE, tile_edges: true, ..self }
    }

    /// Returns these sizes with the edges of tiles in shared memory, if they fit `bytes` bytes of it, and in
    /// their image otherwise.
    pub(crate) fn with_edges_placed(self, bytes: u32) -> Self {
        Self { tile_edges: Self::tile_bytes(self.tile, true) <= bytes, ..self }
    }

    /// Checks that a device has room for these sizes.
    pub(crate) fn check(
        &self,
        limits: &vk::PhysicalDeviceLimits,
        shuffles: bool,
    ) -> Result<(), VulkanError> {
        let Self {
            scan_width,
            scan_lines,
            tile,
            inner,
            tile_lanes,
            tile_edges,
            together,
            visits,
            ..
        } = *self;
        let refuse = |reason: String| Err(VulkanError::Tuning(reason));
        let most =
            limits.max_compute_work_group_invocations.min(limits.max_compute_work_group_size[0]);
        let bytes = limits.max_compute_shared_memory_size;
        if scan_lines == 0 || scan_lines > MOST_LINES {
            return refuse(format!(
                "a block of a scan has {scan_lines} lines, but must have from 1 to {MOST_LINES}"
            ));
        }
        if scan_width > most || 32 * scan_width > bytes {
            return refuse(format!("a workgroup of {scan_width} invocations is too large"));
        }
        if scan_width <= 2 * (scan_lines - 1) {
            return refuse(format!("{scan_width} invocations are too few for {scan_lines} lines"));
        }
        if !(8..=64).contains(&tile) || tile % 2 != 0 || tile_lanes.invocations() * tile > most {
            return refuse(format!(
                "a tile cannot have {tile} points a side; it must have an even number from 8 to 64 for which the \
                 device's workgroups are large enough"
            ));
        }
        if Self::tile_bytes(tile, tile_edges) > bytes {
            return refuse(format!("a tile of {tile} points a side does not fit {bytes} bytes"));
        }
        if self.small_grid > 0 && Self::tile_bytes(SMALL_TILE, true) > bytes {
            return refuse(format!("tiles of small grids do not fit {bytes} bytes"));
        }
        if tile_lanes == TileLanes::Shuffled && !shuffles {
            return refuse("the device does not shuffle within subgroups".into());
        }
        if inner == 0 {
            return refuse("a tile needs at least one iteration".into());
        }
        if together == Some(0) {
            return refuse("a submission needs at least one iteration".into());
        }
        if visits == Some(0) {
            return refuse("a submission must visit at least one texel".into());
        }
        Ok(())
    }

    /// Returns the bytes of shared memory of a tile with curved fronts: edge lengths where wanted, Gaussian
    /// curvature, slowness and four copies of the fronts, at its points and those around it.
    fn tile_bytes(tile: u32, edges: bool) -> u32 {
        let of_edges = if edges { 16 } else { 0 };
        (tile + 2).pow(2) * (of_edges + 8 + 4 * 8) + 100
    }

    /// Returns the sizes that a plan for a grid needs.
    pub fn portions(&self, wavefront: Wavefront, texels: TexelChart) -> Portions {
        let small = texels.rows.max(texels.cols) <= SMALL_SIDE;
        let iterations = if small && wavefront != Wavefront::Planar { 5 } else { 4 };
        Portions {
            lines: self.scan_lines,
            across: self.scan_texels(),
            pairs: self.scan_pairs,
            iterations: self.together.unwrap_or(iterations),
            tile: self.on_grid(texels).tile,
            rounds: self.together,
            visits: self.visits.unwrap_or(VISITS_TOGETHER),
        }
    }

    /// Returns the number of texels of a line that a workgroup of a raster scan writes.
    pub(crate) fn scan_texels(&self) -> u32 {
        self.scan_width - 2 * (self.scan_lines - 1)
    }
}

/// Number of points on a side of a tile of a small grid.
const SMALL_TILE: u32 = 16;

/// Largest number of lines in a block. Shaders have a word with one bit for each line that has changed.
const MOST_LINES: u32 = 32;

/// Default of [`Tuning::visits`]. An update of a texel reads and writes 96 bytes with planar fronts, and 144
/// with curved ones. A submission thus moves at most 0.6 GB, which takes 12 milliseconds on an integrated GPU
/// that moves 50 GB a second. With 1024 x 1024 points a submission still has four iterations, and with 8192 x 8192
/// points an eighth of a scan.
const VISITS_TOGETHER: u64 = 1 << 22;

/// Largest side in texels of a grid whose submissions have five iterations with circular, curved and anchored fronts.
/// Up to this size circular and curved fronts on smooth surfaces settle in five iterations (measured: sphere, peaks,
/// cone and torus of 33 to 129 points a side). On larger grids, and with planar fronts on any grid, four iterations
/// suffice. A second submission takes 6 % of the time of a small map on lavapipe.
const SMALL_SIDE: u32 = 96;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Chart;

    /// Tiles fit the shared memory that devices have, and edges stay in their image where that makes room.
    #[test]
    fn tiles_are_as_large_as_shared_memory_allows() {
        let of = |kind, kilobytes: u32| {
            let limits = vk::PhysicalDeviceLimits {
                max_compute_shared_memory_size: kilobytes << 10,
                max_compute_work_group_invocations: 1024,
                max_compute_work_group_size: [1024; 3],
                ..Default::default()
            };
            let tuning = Tuning::for_limits(kind, &limits, true);
            tuning.check(&limits, true).unwrap();
            let refused = Tuning { tile_lanes: TileLanes::Shuffled, ..tuning };
            assert!(refused.check(&limits, false).is_err());
            assert_eq!(tuning.with_edges_placed(limits.max_compute_shared_memory_size), tuning);
            (tuning.tile, tuning.tile_edges, tuning.tile_lanes)
        };
        let gpu = |kilobytes| of(vk::PhysicalDeviceType::DISCRETE_GPU, kilobytes);
        assert_eq!(gpu(64), (32, true, TileLanes::Shuffled));
        assert_eq!(gpu(48), (32, false, TileLanes::Shuffled));
        assert_eq!(gpu(32), (16, true, TileLanes::Shuffled));
        assert_eq!(gpu(16), (16, false, TileLanes::Shuffled));
        assert_eq!(of(vk::PhysicalDeviceType::CPU, 32), (16, true, TileLanes::Pairs));
    }

    #[test]
    fn small_grids_have_small_tiles() {
        let of = |tuning: Tuning, rows, cols| {
            let sizes = tuning.on_grid(TexelChart::new(Chart { rows, cols }).unwrap());
            (sizes.tile, sizes.tile_edges)
        };
        let gpu = Tuning { tile_edges: false, ..Tuning::ON_GPU };
        assert_eq!(of(gpu, 128, 127), (16, true));
        assert_eq!(of(gpu, 129, 20), (32, false));
        assert_eq!(of(Tuning { small_grid: 0, ..gpu }, 20, 20), (32, false));
        assert_eq!(of(Tuning { tile: 8, ..gpu }, 20, 20), (8, false));
        assert_eq!(of(Tuning::ON_CPU, 20, 20), (16, true));
    }

    /// Checks that tile sizes are measured with the edges placed as on a device that uses these sizes.
    #[test]
    fn edges_lie_in_shared_memory_where_they_fit() {
        let placed = |tile, kilobytes: u32| {
            Tuning { tile, ..Tuning::ON_GPU }.with_edges_placed(kilobytes << 10).tile_edges
        };
        assert_eq!([8, 16, 24, 32].map(|tile| placed(tile, 48)), [true, true, true, false]);
        assert_eq!([8, 16, 24, 32].map(|tile| placed(tile, 32)), [true, true, false, false]);
    }
}
