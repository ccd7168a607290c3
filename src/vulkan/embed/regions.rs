//! Regions of the points nearest to each source, on the device.

use crate::vulkan::device_memory::DeviceMemory;
use ash::vk;
use gpu_allocator::MemoryLocation;

use super::access::Access;
use super::bound_sets::BoundSets;
use super::curves;
use super::host_sets::{self, Content, Part};
use super::inputs::{PointSource, SourceInput};
use super::recording::{Recording, grid_size};
use super::solver::{Solver, over_any};
use super::surface::Surface;
use crate::constants::{FLOW_JUMPS, PARENT_JUMPS};
use crate::surface::Chart;
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::barrier::{CLEAR, SHADER, SHADER_WRITE};
use crate::vulkan::limits::Limits;
use crate::vulkan::memory::{Buffer, BufferInfo};
use crate::vulkan::passes::{REGION_FLOW, REGION_LABELS, REGION_STARTS, REGION_WAYS};
use crate::vulkan::pipelines::Pipeline;
use crate::vulkan::profile::{PassKind, PassRecord, Work};
use crate::vulkan::record::dispatched;
use crate::vulkan::shaders::region_starts::Push;

/// Room for the regions of the points nearest to each source, and the passes that find them:
/// [`Recording::regions`].
///
/// ```no_run
/// # use geosweep::ash::{self, vk};
/// # use geosweep::gpu_allocator::vulkan::Allocator;
/// # use geosweep::vulkan::{VulkanError, embed::*};
/// # use geosweep::Wavefront;
/// # fn host(
/// #     device: &ash::Device, allocator: &mut Allocator, solver: &Solver, surface: &Surface,
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
/// solver.record(device, commands, surface).regions(&regions, &RegionFrame {
///     before: Access::NONE,
///     sources: SourceInput::Inline(&sources),
///     reader: Access::FRAGMENT_READ,
/// })?;
/// // A fragment shader at row r and column c finds 0 or 1 in labels[r * N + c].
///
/// // At the end, once no frame is in flight:
/// regions.destroy(device, allocator);
/// # Ok(()) }
/// ```
///
/// Dropping it frees nothing: the host calls [`Regions::destroy`], before or after the surface's.
#[derive(Debug)]
pub struct Regions {
    chart: Chart,
    wavefront: Wavefront,
    buffer: Option<Buffer>,
    /// The host's buffer, if there is none of their own.
    hosts: Option<vk::Buffer>,
    /// Of the inline sources, and of the surface's source buffers.
    sets: Option<BoundSets>,
    /// In their order.
    pipelines: [Pipeline<Push>; 4],
}

/// Labels in a buffer with the usages `STORAGE_BUFFER`, `VERTEX_BUFFER` and `TRANSFER_SRC`, from its
/// first byte: a 32-bit unsigned number for each grid point, row-major. So shaders find that of a vertex
/// by its number, or it is an attribute of the vertices, `R32_UINT` and 4 bytes apart: labels are not
/// for filtering, and an image would add nothing but layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RegionBuffer {
    /// The buffer, which is longer.
    pub buffer: vk::Buffer,
    /// Bytes of all labels: 4 M N.
    pub bytes: u64,
}

/// What [`Recording::regions`] takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionFrame<'a> {
    /// How the host has written the sources.
    pub before: Access,
    /// All sources of the map, those added to it too. Their places in this list are the labels.
    pub sources: SourceInput<'a>,
    /// How the host reads the labels, this frame and the frame before. [`Access::NONE`] on another
    /// queue, after a semaphore, with regions for each frame in flight.
    pub reader: Access,
}

/// Of a point two links, of one word, and two places.
const POINT_WORDS: u64 = 2 + 2 * 2;
const WORD: u64 = size_of::<u32>() as u64;

impl Regions {
    pub(super) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        (solver, surface): (&Solver, &Surface),
        wavefront: Wavefront,
        hosts: Option<vk::Buffer>,
    ) -> Result<Self, VulkanError> {
        let chart = surface.grid.chart;
        let info = info(&solver.limits, chart)?;
        let make = |pass| solver.pipelines.make(device, pass, wavefront);
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
        };
        if let Some(buffer) = &new.buffer {
            solver.pipelines.name(info.name, buffer.buffer);
        }
        let sets = new
            .contents((device, &solver.limits), surface)
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

    /// What the sets hold.
    fn contents(
        &self,
        on: (&ash::Device, &Limits),
        surface: &Surface,
    ) -> Result<Vec<Content>, VulkanError> {
        let bytes = info(on.1, self.chart)?.size;
        let output = Part::new(on, "regions", self.labels().buffer, 0, bytes)?;
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

    /// Where the labels are.
    pub fn labels(&self) -> RegionBuffer {
        let own = || self.buffer.as_ref().map_or(vk::Buffer::null(), |buffer| buffer.buffer);
        let buffer = self.hosts.unwrap_or_else(own);
        RegionBuffer { buffer, bytes: WORD * self.chart.points() as u64 }
    }

    /// Most records that [`Recording::regions`] makes in a [`crate::vulkan::profile::Profile`],
    /// beside those of [`Solver::passes_of_frame`].
    pub fn passes(&self) -> u32 {
        // Numbers are cleared and sources come, are looked at twice, and ways begin.
        let [flowing, jumping] = rounds(self.chart);
        1 + 1 + 2 + 1 + flowing + jumping
    }

    /// Bytes taken from the allocator's memory blocks.
    pub fn bytes(&self) -> u64 {
        self.buffer.as_ref().map_or(0, Buffer::bytes)
    }

    /// Has the regions read the surface's sources that were replaced since they were made
    /// ([`Surface::set_sources`]). Recordings in flight go on with those before.
    ///
    /// # Errors
    /// If they were made for another surface or destroyed, or all of their descriptor sets are in flight.
    pub fn rebind(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &Surface,
    ) -> Result<(), VulkanError> {
        let sets = self.sets.as_ref().ok_or(VulkanError::Destroyed)?;
        sets.check_surface(surface)?;
        let contents = self.contents((device, &solver.limits), surface)?;
        match &mut self.sets {
            Some(sets) => sets.rebind(device, surface, &contents),
            None => Ok(()),
        }
    }

    /// Bytes of a buffer of the host's: [`Solver::regions_into`].
    pub fn buffer_bytes(chart: Chart) -> u64 {
        (WORD * POINT_WORDS).saturating_mul(chart.points() as u64)
    }

    /// Has labels from now on go to another buffer of the host's. Recordings in flight go on with the one before.
    ///
    /// # Errors
    /// As [`Regions::rebind`], or if they were made with a buffer of their own, or this one is too small.
    pub fn set_buffer(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &Surface,
        buffer: vk::Buffer,
    ) -> Result<(), VulkanError> {
        let before = self.hosts.replace(buffer);
        let bound = match before {
            Some(_) => self.rebind(device, solver, surface),
            None => Err(curves::own_buffer("regions")),
        };
        if bound.is_err() {
            self.hosts = before;
        }
        bound
    }

    /// Whether a recording of the regions may not have run: known with [`super::Tools::checks`] alone.
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
    /// Bytes that regions take from the allocator's memory blocks on this device, before they are
    /// made.
    ///
    /// # Errors
    /// As [`Solver::regions`].
    pub fn bytes_for_regions(
        &self,
        device: &ash::Device,
        chart: Chart,
    ) -> Result<u64, VulkanError> {
        Regions::bytes_for(device, &self.limits, chart)
    }

    /// Makes room for the regions of maps of a surface with one wavefront: 24 bytes a grid point. The
    /// one call that allocates for regions; the first of the solver and a wavefront also makes their
    /// pipelines.
    ///
    /// # Errors
    /// If shaders do not see so much in one buffer, or memory runs out. Nothing is left behind then.
    pub fn regions(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &Surface,
        wavefront: Wavefront,
    ) -> Result<Regions, VulkanError> {
        Regions::new(device, allocator, (self, surface), over_any(wavefront), None)
    }

    /// The same with a buffer of the host's for the labels and what they are found by, from its first byte: with usage `STORAGE_BUFFER` and `TRANSFER_DST`, and what its readers ask for.
    /// [`Regions::buffer_bytes`] says how large it has to be. It is the host's to destroy, and may be another in each
    /// frame ([`Regions::set_buffer`]).
    ///
    /// # Errors
    /// As [`Solver::regions`], or if the buffer is too small, as far as that can be told.
    pub fn regions_into(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &Surface,
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

/// How many passes make ways longer, and how many go from parent to parent: so many as lead past as many
/// points as the grid has, and in all an even number, which leaves the labels where they belong.
fn rounds(chart: Chart) -> [u32; 2] {
    let [flowing, jumping] = [FLOW_JUMPS, PARENT_JUMPS].map(|jumps| {
        let reaches =
            |rounds: &u32| (u64::from(jumps) + 1).saturating_pow(*rounds) >= chart.points() as u64;
        (1..).find(reaches).expect("powers grow beyond any number of points")
    });
    [flowing, jumping + (flowing + jumping) % 2]
}

impl Recording<'_> {
    /// Finds which source is the nearest to each grid point, initial values included, and leaves the
    /// labels for the host to read: the source's place in the list, counting from 0, and
    /// [`crate::geometry::NO_REGION`] in holes and where no front arrives. To be recorded after the
    /// map, in the same command buffer or after [`Recording::begin`]; the commands wait for what
    /// `before` has written and until the reader of commands before has done, and the reader of
    /// commands after waits for them.
    ///
    /// Labels follow the map: each point has that of the source to which its front leads back, found
    /// in as many passes as the logarithm of the grid's points says, whatever the map is. The same
    /// map gives the same labels. They are those of [`crate::geometry::Voronoi`] but for points
    /// within a cell of a border, or two (three with planar fronts), where sources are four cells apart
    /// or more; the border behind a closer pair may turn about it, by up to 18 degrees on the plane,
    /// where both lie in one cell. A point as far from two sources has one of their labels, always the
    /// same. Of sources at one place the first has the region. A curve that is many sources in the
    /// list has as many labels: shaders can look up in a table of the host's which curve one is of.
    ///
    /// # Errors
    /// If the regions were made for another surface or wavefront, there is no map, or the sources are too
    /// many.
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
        let ours = (CLEAR.0 | SHADER.0, CLEAR.1 | SHADER.1);
        recorder.barrier((stages | SHADER.0, access | SHADER.1), ours);
        let record = PassRecord { dispatches: 0, ..PassRecord::new(PassKind::Regions) };
        let work = Work::of_bytes(0, 2 * labels.bytes);
        let pass = recorder.pass_with(PassRecord { work, ..record });
        recorder.fill(labels.buffer, 0, 2 * labels.bytes);
        drop(pass);
        recorder.barrier(CLEAR, SHADER);
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
        let run = |pass: usize, size, push: Push, work, last: Access| {
            let _pass =
                recorder.pass_with(PassRecord { work, ..dispatched(PassKind::Regions, size) });
            recorder.host_pass(regions.pipelines[pass], set.set, &push, size);
            recorder.barrier(SHADER_WRITE, last.side());
        };
        let (ours, all) = (Access::new(SHADER.0, SHADER.1), [chart.cols as u32, chart.rows as u32]);
        for is_last in [0, 1] {
            run(0, [count, 1], Push { is_last, ..push }, work_of_starts(count), ours);
        }
        run(1, all, push, work_of_ways(chart, regions.wavefront), ours);
        let [flowing, jumping] = rounds(chart);
        // How far ways lead, the device finds.
        for number in 0..flowing + jumping {
            let is_last = number + 1 == flowing + jumping;
            let push = Push { from: number as i32 % 2, is_last: is_last.into(), ..push };
            let pass = if number < flowing { 2 } else { 3 };
            run(pass, all, push, Work::default(), if is_last { frame.reader } else { ours });
        }
        sets.are_used(self.note());
        Ok(labels)
    }
}

/// What it takes to look at so many sources once; around how many points they lie, their places say.
fn work_of_starts(count: u32) -> Work {
    let bytes = size_of::<PointSource>() as u64 * u64::from(count);
    Work { bytes_read: Some(bytes), ..Work::default() }
}

/// What is read to begin the ways to all points: the earliest source's front and its number, the map's
/// and four lengths. What is written: a link and a place.
fn work_of_ways(chart: Chart, wavefront: Wavefront) -> Work {
    let curvatures = if wavefront.is_curved() { 2 } else { 0 };
    let points = WORD * chart.points() as u64;
    Work::of_bytes(points * (2 + 1 + 4 + curvatures), points * 3)
}
