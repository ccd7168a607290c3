//! Finds on the device the regions of the points nearest to each source.

use crate::vulkan::device::device_memory::DeviceMemory;
use ash::vk;
use gpu_allocator::MemoryLocation;

use super::access::Access;
use super::bound_sets::BoundSets;
use super::curves;
use super::host_sets::{self, Content, Part};
use super::inputs::{PointSource, SourceInput};
use super::recording::{Recording, grid_size};
use super::solver::{Solver, over_any};
use super::surface::FrameSurface;
use crate::constants::{FLOW_JUMPS, PARENT_JUMPS};
use crate::surface::Chart;
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::copies::Copies;
use crate::vulkan::device::barrier::{SHADER, SHADER_WRITE, TRANSFER_WRITE};
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::memory::{Buffer, BufferInfo};
use crate::vulkan::device::passes::{
    REGION_COPIES, REGION_FLOW, REGION_LABELS, REGION_STARTS, REGION_WAYS, SHARE_STARTS,
};
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::shaders::region_starts::Push;
use crate::vulkan::device::shaders::share_starts::Push as Share;
use crate::vulkan::profile::PassKind;
use crate::vulkan::record::Moved;

/// Buffer for the regions of the points nearest to each source, and the passes that find them:
/// [`Recording::regions`].
///
/// ```no_run
/// # use geosweep::ash::{self, vk};
/// # use geosweep::gpu_allocator::vulkan::Allocator;
/// # use geosweep::vulkan::{VulkanError, embed::*};
/// # use geosweep::Wavefront;
/// # fn host(
/// #     device: &ash::Device, allocator: &mut Allocator, solver: &Solver, surface: &FrameSurface,
/// #     commands: vk::CommandBuffer,
/// # ) -> Result<(), VulkanError> {
/// // Once, for maps with the curved wavefront:
/// let mut regions = solver.regions(device, allocator, surface, Wavefront::Curved)?;
/// let labels = regions.labels();
/// let shaders_see =
///     vk::DescriptorBufferInfo { buffer: labels.buffer, offset: 0, range: labels.bytes };
///
/// // Every frame, after the map of the same sources:
/// let sources = [PointSource::at(120.5, 80.25), PointSource::at(30.0, 200.0)];
/// let frame = RegionFrame::new(SourceInput::Inline(&sources), Access::FRAGMENT_READ);
/// solver.record(device, commands, surface).regions(&regions, &frame)?;
/// // A fragment shader at row r and column c finds 0 or 1 in labels[r * N + c].
///
/// // At the end, once no frame is in flight:
/// regions.destroy(device, allocator);
/// # Ok(()) }
/// ```
///
/// Dropping a value of this type frees nothing. The host calls [`Regions::destroy`], before or after it
/// destroys the surface.
#[derive(Debug)]
pub struct Regions {
    chart: Chart,
    wavefront: Wavefront,
    buffer: Option<Buffer>,
    /// Host's buffer; `None` if the regions have one of their own.
    hosts: Option<vk::Buffer>,
    /// Descriptor sets of the inline sources, followed by those of the surface's source buffers.
    sets: Option<BoundSets>,
    /// Pipelines of the passes, in the order of the passes.
    pipelines: [Pipeline<Push>; 4],
    over_copies: Option<OverCopies>,
}

/// Passes over the copies of points of a glued surface.
#[derive(Clone, Copy, Debug)]
struct OverCopies {
    starts: Pipeline<Share>,
    ways: Pipeline<Push>,
}

/// Buffer of labels. From its first byte it holds a 32-bit unsigned integer for each grid point, row-major.
/// It has the usages `STORAGE_BUFFER`, `VERTEX_BUFFER` and `TRANSFER_SRC`, unless the host provides it.
///
/// Shaders read the label of a vertex by the vertex's index, or as a vertex attribute of format `R32_UINT`, 4
/// bytes apart. Labels are not an image, since they cannot be filtered and an image would only add layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RegionBuffer {
    /// Buffer handle. The buffer is longer than the labels.
    pub buffer: vk::Buffer,
    /// Size of all labels in bytes: 4 M N.
    pub bytes: u64,
}

/// Parameters of [`Recording::regions`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RegionFrame<'a> {
    /// Access by which the host has written the sources.
    pub before: Access,
    /// All sources of the map, including those that were added to it. A label is a place in this list.
    pub sources: SourceInput<'a>,
    /// Access by which the host reads the labels, in this frame and in the previous one. It is
    /// [`Access::NONE`] if another queue reads them after a semaphore. Each frame in flight then needs
    /// regions of its own.
    pub reader: Access,
}

impl<'a> RegionFrame<'a> {
    /// Returns the parameters of regions that do not wait for writes of the host.
    pub fn new(sources: SourceInput<'a>, reader: Access) -> Self {
        Self { before: Access::NONE, sources, reader }
    }

    /// Sets [`RegionFrame::before`].
    pub fn with_before(self, before: Access) -> Self {
        Self { before, ..self }
    }

    /// Sets [`RegionFrame::sources`].
    pub fn with_sources(self, sources: SourceInput<'a>) -> Self {
        Self { sources, ..self }
    }

    /// Sets [`RegionFrame::reader`].
    pub fn with_reader(self, reader: Access) -> Self {
        Self { reader, ..self }
    }
}

/// Number of words per grid point: two links of one word each, and two places of two words each.
const POINT_WORDS: u64 = 2 + 2 * 2;
const WORD: u64 = size_of::<u32>() as u64;

impl Regions {
    pub(super) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        (solver, surface): (&Solver, &FrameSurface),
        wavefront: Wavefront,
        hosts: Option<vk::Buffer>,
    ) -> Result<Self, VulkanError> {
        let chart = surface.grid.chart;
        let info = info(&solver.limits, chart)?;
        let (pipelines, variant) = (&solver.pipelines, surface.finished_map(wavefront));
        let make = |pass| pipelines.make(device, pass, variant);
        let over_copies = match surface.is_glued() {
            true => Some(OverCopies {
                starts: pipelines.make(device, SHARE_STARTS, variant)?,
                ways: make(REGION_COPIES)?,
            }),
            false => None,
        };
        let pipelines =
            [make(REGION_STARTS)?, make(REGION_WAYS)?, make(REGION_FLOW)?, make(REGION_LABELS)?];
        let mut new = Self {
            chart,
            wavefront,
            buffer: match hosts {
                Some(_) => None,
                None => Some(Buffer::new(device, allocator, info)?),
            },
            hosts,
            sets: None,
            pipelines,
            over_copies,
        };
        if let Some(buffer) = &new.buffer {
            solver.pipelines.name(info.name, buffer.buffer);
        }
        let sets = new
            .contents((device, &solver.limits), surface, new.labels().buffer)
            .and_then(|contents| BoundSets::new(device, &solver.pipelines, surface, &contents));
        match sets {
            Ok(sets) => {
                new.sets = Some(sets);
                Ok(new)
            }
            Err(error) => {
                new.destroy(device, allocator);
                Err(error)
            }
        }
    }

    /// Returns the contents of the descriptor sets, with labels in the buffer `output`.
    fn contents(
        &self,
        on: (&ash::Device, &Limits),
        surface: &FrameSurface,
        output: vk::Buffer,
    ) -> Result<Vec<Content>, VulkanError> {
        let bytes = info(on.1, self.chart)?.size;
        let output = Part::new(on, "regions", output, 0, bytes)?;
        let sources = host_sets::all_sources(on, &surface.grid, &surface.sources)?;
        Ok(sources.into_iter().map(|input| input.and_output(output)).collect())
    }

    pub(super) fn bytes_for(
        device: &ash::Device,
        limits: &Limits,
        chart: Chart,
    ) -> Result<u64, VulkanError> {
        limits.texels(chart)?;
        info(limits, chart)?.bytes(device)
    }

    /// Returns where the labels are.
    pub fn labels(&self) -> RegionBuffer {
        let own = || self.buffer.as_ref().map_or(vk::Buffer::null(), |buffer| buffer.buffer);
        let buffer = self.hosts.unwrap_or_else(own);
        RegionBuffer { buffer, bytes: WORD * self.chart.points() as u64 }
    }

    /// Returns the largest number of records that [`Recording::regions`] makes in a
    /// [`crate::vulkan::profile::Profile`], in addition to those of [`Solver::passes_of_frame`].
    pub fn passes(&self) -> u32 {
        // The passes clear numbers, write the sources, examine these twice, and begin the ways back from all
        // points.
        let [flowing, jumping] = rounds(self.chart);
        let over_copies = if self.over_copies.is_some() { 2 + 1 } else { 0 };
        1 + 1 + 2 + 1 + over_copies + flowing + jumping
    }

    /// Returns the number of bytes taken from the allocator's memory blocks.
    pub fn bytes(&self) -> u64 {
        self.buffer.as_ref().map_or(0, Buffer::bytes)
    }

    /// Binds the surface's current sources, after [`FrameSurface::set_sources`] has replaced some of them.
    /// Recordings in flight still read the old ones, which the host keeps alive until these recordings have
    /// run.
    ///
    /// # Errors
    /// If the regions were made for another surface or were destroyed, or all of their descriptor sets are in
    /// flight.
    pub fn rebind(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
    ) -> Result<(), VulkanError> {
        self.bind(device, solver, surface, self.labels().buffer)
    }

    fn bind(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
        output: vk::Buffer,
    ) -> Result<(), VulkanError> {
        self.sets.as_ref().ok_or(VulkanError::Destroyed)?.check_surface(surface)?;
        let contents = self.contents((device, &solver.limits), surface, output)?;
        let sets = self.sets.as_mut().ok_or(VulkanError::Destroyed)?;
        sets.rebind(device, surface, &contents)
    }

    /// Returns the smallest size in bytes of a buffer of the host for [`Solver::regions_into`].
    pub fn buffer_bytes(chart: Chart) -> u64 {
        (WORD * POINT_WORDS).saturating_mul(chart.points() as u64)
    }

    /// Replaces the host's buffer in all later recordings of the regions. Recordings in flight still write
    /// the old buffer, which the host keeps alive until they have run.
    ///
    /// # Errors
    /// As for [`Regions::rebind`], or if the regions have a buffer of their own, or the new buffer is too
    /// small.
    pub fn set_buffer(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
        buffer: vk::Buffer,
    ) -> Result<(), VulkanError> {
        if self.hosts.is_none() {
            return Err(curves::own_buffer("regions"));
        }
        self.bind(device, solver, surface, buffer)?;
        self.hosts = Some(buffer);
        Ok(())
    }

    /// Returns whether a recording of the regions may not have run. This is known with
    /// [`super::Tools::checks`] only.
    pub fn is_in_flight(&self) -> bool {
        self.sets.as_ref().is_some_and(BoundSets::are_in_flight)
    }

    /// Frees everything. No submitted work may still use the regions. A second call does nothing.
    pub fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        if let Some(mut sets) = self.sets.take() {
            sets.destroy(device);
        }
        if let Some(mut buffer) = self.buffer.take() {
            buffer.destroy(device, allocator);
        }
    }
}

impl Solver {
    /// Returns the number of bytes that regions take from the allocator's memory blocks on this device. No
    /// memory is allocated.
    ///
    /// # Errors
    /// As for [`Solver::regions`].
    pub fn bytes_for_regions(
        &self,
        device: &ash::Device,
        chart: Chart,
    ) -> Result<u64, VulkanError> {
        Regions::bytes_for(device, &self.limits, chart)
    }

    /// Creates regions of a surface, for maps with this wavefront. The memory takes 24 bytes per grid point.
    /// This is the only call that allocates for regions. The first call for a solver and a wavefront also
    /// creates the pipelines. The host calls [`Regions::destroy`] in the end.
    ///
    /// # Errors
    /// If the buffer is larger than shaders can access, or memory runs out. Nothing is left behind then.
    pub fn regions(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &FrameSurface,
        wavefront: Wavefront,
    ) -> Result<Regions, VulkanError> {
        Regions::new(device, allocator, (self, surface), over_any(wavefront), None)
    }

    /// Creates regions as [`Solver::regions`] does, but in a buffer of the host, from its first byte. The
    /// buffer holds the labels and the intermediate values of the passes. [`Regions::buffer_bytes`] returns
    /// the size that the buffer needs. Its usages are `STORAGE_BUFFER`, `TRANSFER_DST` and those of its
    /// readers.
    ///
    /// The host keeps the buffer alive until the recordings that write it have run, and destroys it. Each
    /// frame may use another buffer ([`Regions::set_buffer`]).
    ///
    /// # Errors
    /// As for [`Solver::regions`], or if the buffer is too small, as far as its memory requirements show
    /// that.
    pub fn regions_into(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &FrameSurface,
        wavefront: Wavefront,
        buffer: vk::Buffer,
    ) -> Result<Regions, VulkanError> {
        Regions::new(device, allocator, (self, surface), over_any(wavefront), Some(buffer))
    }
}

fn info(limits: &Limits, chart: Chart) -> Result<BufferInfo, VulkanError> {
    let size = Regions::buffer_bytes(chart);
    curves::check_bytes("regions", limits, size)?;
    Ok(BufferInfo { name: "regions", size, location: MemoryLocation::GpuOnly })
}

/// Returns the number of passes that make ways longer, and the number of passes that go from parent to
/// parent. The passes of each kind suffice for a way over as many points as the grid has. The sum of both
/// numbers is even, so that the labels end up in their place.
fn rounds(chart: Chart) -> [u32; 2] {
    let [flowing, jumping] = [FLOW_JUMPS, PARENT_JUMPS].map(|jumps| {
        let reaches =
            |rounds: &u32| (u64::from(jumps) + 1).saturating_pow(*rounds) >= chart.points() as u64;
        (1..).find(reaches).expect("powers grow beyond any number of points")
    });
    [flowing, jumping + (flowing + jumping) % 2]
}

impl Recording<'_> {
    /// Records the passes that find the nearest source to each grid point. The initial value of a source
    /// counts towards its distance. Returns the buffer that receives the labels for the host to read. A label
    /// is the source's place in the list, counted from 0, or [`crate::geometry::NO_REGION`] in holes and
    /// where no front arrives.
    ///
    /// Record them after the map: in the same command buffer, or after [`Recording::begin`] in another. The
    /// commands wait for the frame's `before` and for earlier reads by its `reader`. Later reads by that
    /// reader wait for the commands. `regions` and the buffer of sources must stay alive until the commands
    /// have run.
    ///
    /// Labels follow the map: each point gets the label of the source to which its front leads back. The
    /// number of passes depends on the logarithm of the number of grid points, whatever the map is. The same
    /// map always gives the same labels.
    ///
    /// If sources are at least four cells apart, labels are those of [`crate::geometry::Voronoi`], except at
    /// points within one or two cells of a border (three with planar fronts). If two sources are closer, the
    /// border between their regions may be rotated about the pair. On the plane it is rotated by up to 18
    /// degrees if both sources lie in the same cell.
    ///
    /// A point at the same distance from two sources gets one of their labels, always the same one. Of
    /// several sources at the same place, the first gets the region. A curve that is many sources in the list
    /// has as many labels. A table of the host can map these labels to curves.
    ///
    /// # Errors
    /// If the regions were destroyed or made for another surface or wavefront, there is no map, the sources
    /// are too many or do not fit the surface, or they were replaced since the last [`Regions::rebind`].
    pub fn regions(
        &self,
        regions: &Regions,
        frame: &RegionFrame,
    ) -> Result<RegionBuffer, VulkanError> {
        let sets = regions.sets.as_ref().ok_or(VulkanError::Destroyed)?;
        sets.check_surface(self.surface)?;
        self.check_sources(frame.sources)?;
        sets.check_sources(self.surface, frame.sources)?;
        self.surface.state.check_wavefront(regions.wavefront)?;
        let (recorder, labels, chart) = (&self.recorder, regions.labels(), regions.chart);
        let _group = recorder.group(c"geosweep: regions");
        let (stages, access) = frame.reader.and(frame.before).side();
        let ours = (TRANSFER_WRITE.0 | SHADER.0, TRANSFER_WRITE.1 | SHADER.1);
        recorder.barrier((stages | SHADER.0, access | SHADER.1), ours);
        let pass = recorder.pass(PassKind::Regions);
        recorder.fill(labels.buffer, 0, 2 * labels.bytes);
        drop(pass);
        recorder.barrier(TRANSFER_WRITE, SHADER);
        if let SourceInput::Inline(sources) = frame.sources {
            recorder.write_sources(bytemuck::cast_slice(sources));
        }
        let (inline, of_buffer) = (sets.sets()[0], |number| sets.sets()[1 + number]);
        let (set, count) = self.sources_in(frame.sources, inline, of_buffer);
        let push = Push {
            grid: grid_size(chart),
            first_word: set.first_word,
            count: count as i32,
            from: 0,
            is_last: 0,
        };
        let run = |pass: usize, size, push: Push, moved, last: Access| {
            let _pass = recorder.pass_moving(PassKind::Regions, moved);
            recorder.map_pass(regions.pipelines[pass], set.set, &push, size);
            recorder.barrier(SHADER_WRITE, last.side());
        };
        let groups = self.surface.grid.copies.as_ref().map_or(0, Copies::groups_by_rows);
        let (ours, all) = (Access::new(SHADER.0, SHADER.1), [chart.cols as u32, chart.rows as u32]);
        for is_last in [0, 1] {
            run(0, [count, 1], Push { is_last, ..push }, moved_by_starts(count), ours);
            if let Some(OverCopies { starts, .. }) = regions.over_copies {
                let first_word = (1 - is_last as i32) * chart.points() as i32;
                let share = Share { grid: push.grid, first_word };
                recorder.pass_over_groups(PassKind::Regions, starts, set.set, &share, groups);
                recorder.barrier(SHADER_WRITE, SHADER);
            }
        }
        run(1, all, push, moved_by_ways(chart, regions.wavefront), ours);
        if let Some(OverCopies { ways, .. }) = regions.over_copies {
            recorder.pass_over_groups(PassKind::Regions, ways, set.set, &push, groups);
            recorder.barrier(SHADER_WRITE, SHADER);
        }
        let [flowing, jumping] = rounds(chart);
        // Only the device knows how far ways lead.
        for number in 0..flowing + jumping {
            let is_last = number + 1 == flowing + jumping;
            let push = Push { from: number as i32 % 2, is_last: is_last.into(), ..push };
            let pass = if number < flowing { 2 } else { 3 };
            run(pass, all, push, [None; 2], if is_last { frame.reader } else { ours });
        }
        sets.are_used(self.note());
        Ok(labels)
    }
}

/// Returns the bytes moved to examine `count` sources once. How many points around them are accessed depends
/// on their places, and is not counted.
fn moved_by_starts(count: u32) -> Moved {
    [Some(size_of::<PointSource>() as u64 * u64::from(count)), None]
}

/// Returns the bytes moved to begin the ways to all points. The pass reads the front and number of the
/// earliest source, the front of the map, and four lengths. It writes a link and a place.
fn moved_by_ways(chart: Chart, wavefront: Wavefront) -> Moved {
    let curvatures = if wavefront.is_curved() { 2 } else { 0 };
    let points = WORD * chart.points() as u64;
    [Some(points * (2 + 1 + 4 + curvatures)), Some(points * 3)]
}
