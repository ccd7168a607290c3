//! Computes where the maps of a batch lie, in which portions they are computed, and how many at a time. The
//! layout is plain values and needs no device.

use ash::vk;

use super::progress;
use super::schedule::PairwiseSchedule;
use crate::constants::LAYERS;
use crate::surface::Chart;
use crate::update::Wavefront;
use crate::vulkan::TexelChart;

/// Limits of a device that matter for batches.
#[derive(Clone, Copy, Debug)]
pub(super) struct BatchLimits {
    pub(super) on_cpu: bool,
    /// Shared memory of a workgroup, in bytes.
    pub(super) shared_memory: u32,
    /// Largest number of invocations of a workgroup.
    pub(super) invocations: u32,
    /// Number of invocations of a subgroup.
    pub(super) subgroup: u32,
    /// Largest number of layers of an image.
    pub(super) layers: u32,
    /// Largest size of a storage buffer, in bytes.
    pub(super) buffer: u64,
}

impl BatchLimits {
    pub(super) fn of(properties: &vk::PhysicalDeviceProperties, subgroup: u32) -> Self {
        let limits = &properties.limits;
        Self {
            on_cpu: properties.device_type == vk::PhysicalDeviceType::CPU,
            shared_memory: limits.max_compute_shared_memory_size,
            invocations: limits
                .max_compute_work_group_invocations
                .min(limits.max_compute_work_group_size[0]),
            subgroup: subgroup.max(1),
            layers: limits.max_image_array_layers,
            buffer: limits.max_storage_buffer_range.into(),
        }
    }
}

/// Parameters of the workgroups that compute maps in shared memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Workgroup {
    /// Number of points for which shared memory has room.
    pub(super) room: u32,
    /// Distance in shared memory from a point to the one below it.
    pub(super) pitch: u32,
    pub(super) invocations: u32,
    /// Largest number of iterations in a dispatch.
    pub(super) iterations: u32,
    /// Whether the pipeline is for this size alone. Otherwise it is for all sizes that have this room.
    pub(super) is_known: bool,
}

/// Largest number of iterations in a dispatch. Most surfaces need no more. These iterations take far less
/// time than a dispatch may take before systems consider it hung.
const MOST_ITERATIONS: u32 = 32;
/// Largest number of trips through loops in a dispatch. Mesa's llvmpipe leaves the loops of a shader silently
/// after 65,535 trips of an invocation, counted over all loops.
const MOST_TRIPS: u32 = 60_000;
/// Largest number of invocations of a workgroup. With more of them, barriers cost more than lines gain.
const MOST_INVOCATIONS: u32 = 128;

impl Workgroup {
    /// Returns the workgroup for maps of a grid; `None` if a map does not fit.
    pub(super) fn fitting(
        chart: Chart,
        wavefront: Wavefront,
        limits: &BatchLimits,
    ) -> Option<Self> {
        let [rows, cols] = [chart.rows, chart.cols].map(|points| u32::try_from(points).ok());
        let (rows, cols) = (rows?, cols?);
        let numbers = |pitch: u32| rows.checked_mul(pitch)?.checked_mul(numbers(wavefront));
        let fits = |&pitch: &u32| {
            let bytes = numbers(pitch).and_then(|numbers| numbers.checked_mul(4));
            bytes.is_some_and(|bytes| bytes <= limits.shared_memory)
        };
        let pitch = [cols | 1, cols].into_iter().find(fits)?;

        let pairs = rows.max(cols).div_ceil(2);
        let most = MOST_INVOCATIONS.min(limits.invocations);
        // Workgroups have whole subgroups: Mesa 22.3's lavapipe may lose what a partly filled subgroup
        // computes.
        let pairs = pairs.div_ceil(pairs.div_ceil(most));
        let invocations = pairs.next_multiple_of(limits.subgroup).min(most);

        let shares = |points: u32| 1 + points.div_ceil(2).div_ceil(invocations);
        let trips = 2 * (rows * shares(cols) + cols * shares(rows)) + 5;
        let loads = 2 * numbers(pitch)?.div_ceil(invocations);
        let iterations = (MOST_TRIPS.checked_sub(loads)? / trips).min(MOST_ITERATIONS);
        let most = limits.shared_memory / (4 * self::numbers(wavefront));
        let area = rows * pitch;
        let room = if limits.on_cpu { area } else { room(area).min(most) };
        let is_known = limits.on_cpu;
        (iterations > 0).then_some(Self { room, pitch, invocations, iterations, is_known })
    }
}

/// Returns the number of points for which a pipeline has room, for maps that take `area` points. It exceeds
/// `area` by less than a quarter or by less than 64 points, so few pipelines serve all sizes.
fn room(area: u32) -> u32 {
    area.next_multiple_of((area.next_power_of_two() / 8).max(64))
}

/// Returns how many numbers are stored for a point of a map: the arrival time, and a curvature if fronts
/// carry one.
pub(super) fn numbers(wavefront: Wavefront) -> u32 {
    if wavefront.is_curved() { LAYERS } else { 1 }
}

/// Returns how many numbers the fan of a pair of points has, as in `glsl/passes/pairwise_fans.glsl`.
pub(super) fn fan_numbers(wavefront: Wavefront) -> u64 {
    if wavefront.is_curved() { 15 } else { 9 }
}

/// Layout of the maps of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BatchLayout {
    pub(super) chart: Chart,
    pub(super) wavefront: Wavefront,
    /// Workgroup of a map, if maps lie in shared memory.
    pub(super) workgroup: Option<Workgroup>,
    /// Largest number of maps in a batch.
    pub(super) maps: u32,
    /// Bytes of each of the two images of a batch; 0 if it has none.
    pub(super) image: u64,
    /// Bytes of the list of copies of points; 0 if the surface is not glued.
    pub(super) copies: u64,
}

/// Largest number of bytes of a batch's distances, and of its images. Estimated, not measured: a thousand
/// maps of 64 x 64 points fill any GPU, and so do the lines of texels of some dozens of larger maps.
const ON_GPU: [u64; 2] = [16 << 20, 256 << 20];
/// Limits for CPUs, in the same order. Measured on lavapipe (Mesa 22.3, two cores), maps in images, circular
/// fronts, one iteration: 1 and 4 MiB take the same time, 256 KiB take 1.5 times as long, and 16 MiB up to
/// three times as long.
const ON_CPU: [u64; 2] = [4 << 20, 4 << 20];

/// Largest number of maps in a batch, however small they are.
const MOST_MAPS: u64 = 4096;

impl BatchLayout {
    /// Returns the layout for the schedule `wanted`, or the best layout. Returns `None` if shared memory is
    /// wanted and maps do not fit it.
    pub(super) fn new(
        chart: Chart,
        texels: TexelChart,
        wavefront: Wavefront,
        wanted: Option<PairwiseSchedule>,
        limits: &BatchLimits,
    ) -> Option<Self> {
        let workgroup = match wanted {
            Some(PairwiseSchedule::SharedMemory) => {
                Some(Workgroup::fitting(chart, wavefront, limits)?)
            }
            Some(PairwiseSchedule::Images) => None,
            None => Workgroup::fitting(chart, wavefront, limits),
        };
        let [distances, images] = if limits.on_cpu { ON_CPU } else { ON_GPU };
        let row = 4 * chart.points() as u64;
        let texels = u64::from(texels.rows) * u64::from(texels.cols);
        let layers = u64::from(numbers(wavefront));
        let of_buffers = distances.min(limits.buffer / layers) / row;
        let maps = if workgroup.is_some() {
            of_buffers
        } else {
            let of_images = images / (2 * 16 * layers * texels);
            of_buffers.min(of_images).min(u64::from(limits.layers) / layers)
        };
        let maps = maps.clamp(1, MOST_MAPS) as u32;
        let image = if workgroup.is_some() { 0 } else { 16 * layers * texels * u64::from(maps) };
        Some(Self { chart, wavefront, workgroup, maps, image, copies: 0 })
    }

    pub(super) fn schedule(&self) -> PairwiseSchedule {
        match self.workgroup {
            Some(_) => PairwiseSchedule::SharedMemory,
            None => PairwiseSchedule::Images,
        }
    }

    /// Returns the layers of an image. There are at least two, since a single layer is not an array.
    pub(super) fn layers(&self) -> u32 {
        (self.maps * numbers(self.wavefront)).max(2)
    }

    /// Returns the bytes of the surface's fans, as `glsl/passes/pairwise_fans.glsl` places them.
    pub(super) fn fans(&self) -> u64 {
        let Chart { rows, cols } = self.chart;
        let pairs = 2 * (rows * cols.div_ceil(2) + cols * rows.div_ceil(2)) as u64;
        if self.workgroup.is_some() { 4 * fan_numbers(self.wavefront) * pairs } else { 0 }
    }

    /// Returns the bytes of the maps that are stored from one dispatch to the next.
    pub(super) fn kept(&self) -> u64 {
        self.workgroup.map_or(0, |workgroup| {
            let map = self.chart.rows as u64 * u64::from(workgroup.pitch * numbers(self.wavefront));
            4 * u64::from(self.maps) * map
        })
    }

    /// Returns the bytes of the distances of a batch.
    pub(super) fn distances(&self) -> u64 {
        4 * u64::from(self.maps) * self.chart.points() as u64
    }

    /// Returns the bytes of all images and buffers.
    pub(super) fn bytes(&self) -> u64 {
        2 * self.image
            + self.fans()
            + self.kept()
            + self.distances()
            + 3 * progress::bytes(self.maps)
            + self.copies
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALLEST: BatchLimits = BatchLimits {
        on_cpu: false,
        shared_memory: 16 << 10,
        invocations: 128,
        subgroup: 32,
        layers: 256,
        buffer: 128 << 20,
    };

    fn square(side: usize) -> Chart {
        Chart { rows: side, cols: side }
    }

    fn layout(chart: Chart, wavefront: Wavefront, limits: &BatchLimits) -> BatchLayout {
        BatchLayout::new(chart, TexelChart::new(chart).unwrap(), wavefront, None, limits).unwrap()
    }

    #[test]
    fn a_map_of_64_by_64_points_fits_what_every_device_has() {
        let fits = |side, wavefront| Workgroup::fitting(square(side), wavefront, &SMALLEST);
        let workgroup = fits(64, Wavefront::Planar).unwrap();
        assert_eq!((workgroup.pitch, workgroup.invocations, workgroup.iterations), (64, 32, 32));
        assert_eq!(fits(65, Wavefront::Planar), None);
        assert_eq!(fits(64, Wavefront::Curved), None);
        assert_eq!(fits(45, Wavefront::Curved).unwrap().pitch, 45);
        // If there is room for it, the pitch is odd, so that columns do not share a bank.
        let more = BatchLimits { shared_memory: 48 << 10, ..SMALLEST };
        let workgroup = Workgroup::fitting(square(64), Wavefront::Curved, &more).unwrap();
        assert_eq!(workgroup.pitch, 65);
    }

    /// On GPUs drivers compile few pipelines for all sizes, and each map has room.
    #[test]
    fn maps_of_many_sizes_share_the_room_that_they_have() {
        let limits = BatchLimits { shared_memory: 48 << 10, ..SMALLEST };
        let of = |side| Workgroup::fitting(square(side), Wavefront::Curved, &limits);
        let all: Vec<_> = (4..=78).map_while(of).collect();
        assert_eq!(all.len(), 75);
        for (side, workgroup) in (4..).zip(&all) {
            let area = side * workgroup.pitch;
            let most = area + (area / 4).max(64);
            assert!((area..=most).contains(&workgroup.room), "{workgroup:?}");
            assert!(8 * workgroup.room <= limits.shared_memory && !workgroup.is_known);
        }
        let pipelines: std::collections::BTreeSet<_> =
            all.iter().map(|workgroup| (workgroup.room, workgroup.invocations)).collect();
        assert!(pipelines.len() <= 32, "{}", pipelines.len());
        let on_cpu = BatchLimits { on_cpu: true, ..limits };
        let known = Workgroup::fitting(square(30), Wavefront::Curved, &on_cpu).unwrap();
        assert!(known.is_known && known.room == 30 * known.pitch);
    }

    #[test]
    fn a_workgroup_has_whole_subgroups() {
        let corridors = Chart { rows: 141, cols: 12 };
        for (subgroup, invocations) in [(1, 71), (4, 72), (8, 72), (16, 80), (32, 96), (64, 128)] {
            let limits = BatchLimits { subgroup, ..SMALLEST };
            let workgroup = Workgroup::fitting(corridors, Wavefront::Planar, &limits).unwrap();
            assert_eq!(workgroup.invocations, invocations, "{subgroup}");
        }
    }

    #[test]
    fn long_lines_do_not_exhaust_the_loops_of_a_dispatch() {
        let plenty = BatchLimits { shared_memory: 1 << 20, ..SMALLEST };
        let long = |cols| Workgroup::fitting(Chart { rows: 1, cols }, Wavefront::Planar, &plenty);
        assert!(long(10_000).is_some_and(|workgroup| workgroup.iterations == 1));
        assert_eq!(long(100_000), None);
    }

    #[test]
    fn batches_keep_to_the_limits() {
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            for side in [1, 2, 33, 64, 100, 257, 1500, 4000] {
                for limits in [SMALLEST, BatchLimits { on_cpu: true, ..SMALLEST }] {
                    let layout = layout(square(side), wavefront, &limits);
                    let bounded = ON_GPU.iter().sum::<u64>() + (64 << 20);
                    assert!(layout.maps == 1 || layout.bytes() < bounded, "{layout:?}");
                    if layout.workgroup.is_none() {
                        assert!(layout.layers() <= limits.layers, "{layout:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn maps_that_do_not_fit_shared_memory_go_into_images() {
        let of = |side| layout(square(side), Wavefront::Circular, &SMALLEST).schedule();
        assert_eq!((of(64), of(65)), (PairwiseSchedule::SharedMemory, PairwiseSchedule::Images));
    }
}
