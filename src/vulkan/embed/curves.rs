//! Curves on the device: their buffer, its layout, and the passes that lift them to the surface.

use crate::vulkan::device_memory::DeviceMemory;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use gpu_allocator::MemoryLocation;

use super::access::Access;
use super::bound_sets::BoundSets;
use super::host_sets::{self, Content, Part};
use super::inputs::{PointMemory, Points};
use super::recording::{Recording, grid_size};
use super::solver::Solver;
use super::surface::Surface;
use crate::constants::{self, CURVE_WORDS, VERTEX_WORDS, WORKGROUP};
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::barrier::SHADER_WRITE;
use crate::vulkan::limits::Limits;
use crate::vulkan::memory::{Buffer, BufferInfo};
use crate::vulkan::passes::{LIFT_FROM_BUFFER, LIFT_FROM_IMAGE};
use crate::vulkan::pipelines::{Pipeline, Pipelines};
use crate::vulkan::profile::PassKind;
use crate::vulkan::record::dispatched;
use crate::vulkan::shaders::lift_from_buffer::Push as Lift;

/// A vertex of a contour or path, to be bound as it is: [`CurveVertex::attributes`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct CurveVertex {
    /// x, y and z: between the points of the host's, as [`crate::geometry::Curve::lift`] has it;
    /// of a height field column and row times the spacing, and the height.
    pub position: [f32; 3],
    /// The arrival time there, a contour's level.
    pub time: f32,
    /// Row, fractional.
    pub row: f32,
    /// Column, fractional.
    pub col: f32,
}

impl CurveVertex {
    /// Bytes from vertex to vertex.
    pub const BYTES: u32 = size_of::<Self>() as u32;

    /// Position, time, and row and column, at so many shader locations from the first.
    pub fn attributes(binding: u32, location: u32) -> [vk::VertexInputAttributeDescription; 3] {
        let attribute = |index, format, offset| vk::VertexInputAttributeDescription {
            location: location + index,
            binding,
            format,
            offset,
        };
        [
            attribute(0, vk::Format::R32G32B32_SFLOAT, 0),
            attribute(1, vk::Format::R32_SFLOAT, 12),
            attribute(2, vk::Format::R32G32_SFLOAT, 16),
        ]
    }
}

/// What is known of a curve, first of all what `vkCmdDrawIndirect` reads: a `VkDrawIndirectCommand`.
///
/// The contours of a recording are one curve of separate pieces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct CurveRecord {
    /// How many vertices are drawn: of contours those that there was room for, of a path all of them
    /// or none.
    pub vertex_count: u32,
    /// 1.
    pub instance_count: u32,
    /// The curve's first vertex, counted from that of the first curve.
    pub first_vertex: u32,
    /// 0.
    pub first_instance: u32,
    /// Of contours how many vertices there would be with room for all; of a path how many there are,
    /// as far as it has come.
    pub vertices: u32,
    status: u32,
    source: u32,
    /// Of a path: the map's value at its start.
    pub distance: f32,
    /// Of a path: its length, measured as the map measures, as far as it has come.
    pub length: f32,
}

/// What has become of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CurveStatus {
    /// All of it is there: a path has arrived at a source.
    Complete,
    /// There are more vertices than there is room for.
    OutOfRoom,
    /// A path starts where no front arrives: in a hole, or cut off from the sources.
    Unreached,
    /// A path starts off the grid, at what is not a number, or there is no start for it.
    Outside,
    /// A path ends where the map does not lead on to a source, since it has not converged, belongs
    /// to other sources, or has a pit there.
    Lost,
}

impl CurveRecord {
    /// Bytes from record to record.
    pub const BYTES: u32 = size_of::<Self>() as u32;

    /// What has become of the curve.
    pub fn status(&self) -> CurveStatus {
        match self.status {
            constants::COMPLETE => CurveStatus::Complete,
            constants::OUT_OF_ROOM => CurveStatus::OutOfRoom,
            constants::UNREACHED => CurveStatus::Unreached,
            constants::OUTSIDE => CurveStatus::Outside,
            constants::LOST | constants::UNDER_WAY.. => CurveStatus::Lost,
        }
    }

    /// Of a path that has arrived: at which source, in the order given.
    pub fn source(&self) -> Option<u32> {
        (self.status == constants::COMPLETE).then_some(self.source)
    }
}

const _: () =
    assert!(CurveRecord::BYTES == 4 * CURVE_WORDS && CurveVertex::BYTES == 4 * VERTEX_WORDS);

/// A buffer of curves, with the usages `VERTEX_BUFFER`, `INDIRECT_BUFFER`, `STORAGE_BUFFER` and
/// `TRANSFER_SRC`: [`CurveRecord`]s from its first byte, then [`CurveVertex`]es.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CurveBuffer {
    /// The buffer.
    pub buffer: vk::Buffer,
    /// How many curves, and so records, there are.
    pub curves: u32,
    /// Bytes before the first vertex: what the vertex buffer is bound with.
    pub vertices_offset: u64,
    /// Room for vertices of each curve.
    pub capacity: u32,
}

/// Where in a buffer of curves everything is.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurveLayout {
    pub(super) curves: u32,
    /// Vertices of a curve.
    pub(super) capacity: u32,
    /// Words between records and vertices.
    pub(super) between: u32,
}

/// Workgroups that lift a curve, at most.
const LIFTERS: u32 = 256;

impl CurveLayout {
    pub(super) fn first_vertex(self) -> u64 {
        u64::from(self.curves) * u64::from(CURVE_WORDS) + u64::from(self.between)
    }

    pub(super) fn bytes(self) -> u64 {
        let vertices = u64::from(self.curves) * u64::from(self.capacity);
        size_of::<f32>() as u64 * (self.first_vertex() + vertices * u64::from(VERTEX_WORDS))
    }

    pub(super) fn info(self, name: &'static str) -> BufferInfo {
        BufferInfo { name, size: self.bytes(), location: MemoryLocation::GpuOnly }
    }

    /// Refuses what shaders do not see in one buffer, or cannot count.
    pub(super) fn check(self, what: &'static str, limits: &Limits) -> Result<(), VulkanError> {
        check_bytes(what, limits, self.bytes())
    }
}

/// Refuses a buffer of which shaders see only a part.
pub(super) fn check_bytes(
    what: &'static str,
    limits: &Limits,
    bytes: u64,
) -> Result<(), VulkanError> {
    let most = limits.storage_range.min(i32::MAX as u64);
    if bytes > most {
        let reason =
            format!("their buffer would have {bytes} bytes, and shaders see {most} at most");
        return Err(VulkanError::Curves { what, reason });
    }
    Ok(())
}

/// Buffers and descriptors of contours or paths on a surface.
#[derive(Debug)]
pub(super) struct Curves {
    pub(super) layout: CurveLayout,
    reads: Reads,
    /// The host's buffer for the curves, if they have none of their own.
    hosts: Option<vk::Buffer>,
    /// With curves as the first of them, unless the host has them; then what passes count in.
    buffers: Vec<Buffer>,
    /// For each of the surface's points the pass that lifts curves to them.
    lifting: Vec<Pipeline<Lift>>,
    /// Of the passes that trace the curves, then of those that lift them.
    sets: Option<BoundSets>,
}

/// What [`Curves`] are made of.
pub(super) struct CurvesInfo<'a> {
    pub(super) layout: CurveLayout,
    pub(super) reads: Reads,
    /// The curves' own, and others that passes use.
    pub(super) buffers: &'a [BufferInfo],
    /// A buffer of the host's in place of the first.
    pub(super) hosts: Option<vk::Buffer>,
}

/// What the passes that trace curves read beside the map.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reads {
    /// So many bytes of counts in the second buffer.
    Counts(u64),
    /// Sources: inline ones, then those in each of the surface's buffers.
    Sources,
}

impl Curves {
    pub(super) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        (solver, surface): (&Solver, &Surface),
        CurvesInfo { layout, reads, buffers, hosts }: CurvesInfo,
    ) -> Result<Self, VulkanError> {
        let (made, lifting) = (Vec::new(), Vec::new());
        let mut new = Self { layout, reads, hosts, buffers: made, lifting, sets: None };
        let own = &buffers[usize::from(hosts.is_some())..];
        let created = new
            .allocate(device, allocator, &solver.pipelines, own)
            .and_then(|()| new.describe(device, solver, surface));
        match created {
            Ok(()) => Ok(new),
            Err(error) => {
                new.destroy(device, allocator);
                Err(error)
            }
        }
    }

    fn allocate(
        &mut self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        pipelines: &Pipelines,
        infos: &[BufferInfo],
    ) -> Result<(), VulkanError> {
        for &info in infos {
            let buffer = Buffer::new(device, allocator, info)?;
            pipelines.name(info.name, buffer.buffer);
            self.buffers.push(buffer);
        }
        Ok(())
    }

    fn describe(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &Surface,
    ) -> Result<(), VulkanError> {
        let contents = self.contents((device, &solver.limits), surface)?;
        self.sets = Some(BoundSets::new(device, &solver.pipelines, surface, &contents)?);
        self.lifting = lifting(device, solver, surface)?;
        Ok(())
    }

    /// What the sets hold.
    fn contents(
        &self,
        on: (&ash::Device, &Limits),
        surface: &Surface,
    ) -> Result<Vec<Content>, VulkanError> {
        let output = whole(on, self.output(), self.layout.bytes())?;
        let mut contents = match self.reads {
            Reads::Counts(bytes) => vec![Content::Input(whole(on, self.counts(), bytes)?)],
            Reads::Sources => host_sets::all_sources(on, &surface.grid, &surface.sources)?,
        };
        for points in &surface.points {
            contents.push(host_sets::points_content(on, points, surface.grid.chart)?);
        }
        Ok(contents.into_iter().map(|input| input.and_output(output)).collect())
    }

    /// Writes another buffer of the host's from now on.
    pub(super) fn set_buffer(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &Surface,
        buffer: vk::Buffer,
    ) -> Result<(), VulkanError> {
        let before = self.hosts.replace(buffer);
        let bound = match before {
            Some(_) => self.rebind(device, solver, surface),
            None => Err(own_buffer("contours or paths")),
        };
        if bound.is_err() {
            self.hosts = before;
        }
        bound
    }

    /// Has them read what is now the surface's.
    pub(super) fn rebind(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &Surface,
    ) -> Result<(), VulkanError> {
        self.sets()?.check_surface(surface)?;
        let contents = self.contents((device, &solver.limits), surface)?;
        let lifting = lifting(device, solver, surface)?;
        if let Some(sets) = &mut self.sets {
            sets.rebind(device, surface, &contents)?;
        }
        self.lifting = lifting;
        Ok(())
    }

    /// Unless they were destroyed.
    pub(super) fn sets(&self) -> Result<&BoundSets, VulkanError> {
        self.sets.as_ref().ok_or(VulkanError::Destroyed)
    }

    /// Whether a followed recording of them may not have run.
    pub(super) fn is_in_flight(&self) -> bool {
        self.sets.as_ref().is_some_and(BoundSets::are_in_flight)
    }

    pub(super) fn bytes(&self) -> u64 {
        self.buffers.iter().map(Buffer::bytes).sum()
    }

    /// With the curves.
    pub(super) fn output(&self) -> vk::Buffer {
        let own = || self.buffers.first().map_or(vk::Buffer::null(), |buffer| buffer.buffer);
        self.hosts.unwrap_or_else(own)
    }

    /// What passes count in.
    pub(super) fn counts(&self) -> vk::Buffer {
        self.buffers.last().map_or(vk::Buffer::null(), |buffer| buffer.buffer)
    }

    pub(super) fn curves(&self) -> CurveBuffer {
        let CurveLayout { curves, capacity, .. } = self.layout;
        let vertices_offset = size_of::<f32>() as u64 * self.layout.first_vertex();
        CurveBuffer { buffer: self.output(), curves, vertices_offset, capacity }
    }

    /// Refuses to be recorded for another surface, or with points that this one does not have, or
    /// that have no positions.
    pub(super) fn check(&self, recording: &Recording, points: usize) -> Result<(), VulkanError> {
        let sets = self.sets()?;
        sets.check_surface(recording.surface)?;
        let (_, Points { kind, .. }) = recording.points(points)?;
        sets.check_points(recording.surface, points)?;
        if !kind.has_positions() {
            let reason = "a metric has no positions to lift them to".into();
            return Err(VulkanError::Curves { what: "contours or paths", reason });
        }
        recording.surface.state.check_map()
    }

    /// Lifts all curves to the surface's points with this number, and lets the reader read. The last of a recording
    /// that was checked.
    pub(super) fn lift(&self, recording: &Recording, points: usize, reader: Access) {
        let Recording { recorder, surface, .. } = recording;
        let (Some(sets), pipeline) = (&self.sets, self.lifting[points]) else { return };
        let traced = sets.sets().len() - self.lifting.len();
        let set = recording.points_in(sets.sets()[traced + points]);
        surface.sets.points[points].is_read(&surface.flight);
        let Points { memory, kind, .. } = surface.points[points];
        let spacing = kind.spacing().map_or([0.0; 2], |of| [of.dx as f32, of.dy as f32]);
        let CurveLayout { curves, capacity, .. } = self.layout;
        let lift = Lift {
            grid: grid_size(surface.grid.chart),
            first_word: set.first_word,
            stride: memory.stride_words(),
            spacing,
            first_vertex: self.layout.first_vertex() as i32,
            capacity: capacity as i32,
        };
        let lifters = if curves == 1 { capacity.div_ceil(WORKGROUP).clamp(1, LIFTERS) } else { 1 };
        let size = [WORKGROUP * lifters, curves];
        // How many vertices there are to lift, the device finds.
        let _pass = recorder.pass_with(dispatched(PassKind::Lift, size));
        recorder.host_pass(pipeline, set.set, &lift, size);
        recorder.barrier(SHADER_WRITE, reader.side());
        sets.are_used(recording.note());
    }

    pub(super) fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        if let Some(mut sets) = self.sets.take() {
            sets.destroy(device);
        }
        self.buffers.drain(..).for_each(|mut buffer| buffer.destroy(device, allocator));
    }
}

/// Refuses a buffer of the host's in place of one that is not the host's.
pub(super) fn own_buffer(what: &'static str) -> VulkanError {
    let reason = "they have a buffer of their own: make them with the host's".into();
    VulkanError::HostBuffer { what, reason }
}

/// For each of the surface's points the pass that reads them.
fn lifting(
    device: &ash::Device,
    solver: &Solver,
    surface: &Surface,
) -> Result<Vec<Pipeline<Lift>>, VulkanError> {
    let pass = |points: &Points| match points.memory {
        PointMemory::Buffer { .. } => LIFT_FROM_BUFFER,
        PointMemory::Image { .. } => LIFT_FROM_IMAGE,
    };
    let make = |points| solver.pipelines.make(device, pass(points), Wavefront::Planar);
    surface.points.iter().map(make).collect()
}

/// A buffer of ours, all of it.
fn whole(on: (&ash::Device, &Limits), buffer: vk::Buffer, bytes: u64) -> Result<Part, VulkanError> {
    Part::new(on, "curves", buffer, 0, bytes)
}

/// What buffers of these sizes take from the allocator.
pub(super) fn bytes_for(device: &ash::Device, infos: &[BufferInfo]) -> Result<u64, VulkanError> {
    infos.iter().map(|info| info.bytes(device)).sum()
}
