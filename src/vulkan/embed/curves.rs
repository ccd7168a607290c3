//! Defines the buffer of curves on the device, its layout, and the passes that lift curves to the surface.

use crate::vulkan::device::device_memory::DeviceMemory;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use gpu_allocator::MemoryLocation;

use super::access::Access;
use super::bound_sets::BoundSets;
use super::host_sets::{self, Content, Part};
use super::inputs::{PointMemory, Points};
use super::recording::{Recording, grid_size};
use super::solver::Solver;
use super::surface::FrameSurface;
use crate::constants::{self, CURVE_WORDS, VERTEX_WORDS, WORKGROUP};
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::device::barrier::SHADER_WRITE;
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::memory::{Buffer, BufferInfo};
use crate::vulkan::device::passes::{LIFT_FROM_BUFFER, LIFT_FROM_IMAGE};
use crate::vulkan::device::pipelines::{Pipeline, Pipelines};
use crate::vulkan::device::shaders::lift_from_buffer::Push as Lift;
use crate::vulkan::profile::PassKind;

/// Vertex of a contour or path. Graphics pipelines can read it as it is: [`CurveVertex::attributes`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct CurveVertex {
    /// x, y and z, interpolated between the host's points as by [`crate::geometry::Curve::lift`]. On a height
    /// field they are column and row times the spacing, and the height.
    pub position: [f32; 3],
    /// Arrival time at the vertex, which is the level of a contour.
    pub time: f32,
    /// Row, fractional.
    pub row: f32,
    /// Column, fractional.
    pub col: f32,
}

impl CurveVertex {
    /// Distance between consecutive vertices in bytes.
    pub const BYTES: u32 = size_of::<Self>() as u32;

    /// Returns the vertex attributes for a binding: position, time, and row and column. They take three
    /// shader locations, beginning with `location`.
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

/// Properties of a curve. The record begins with the `VkDrawIndirectCommand` that `vkCmdDrawIndirect` reads.
///
/// The contours of a recording are a single curve of separate segments.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct CurveRecord {
    /// Number of vertices that are drawn. For contours it is the number of vertices that fit the buffer. For
    /// a path it is the number of all its vertices, or 0 if the path is not complete.
    pub vertex_count: u32,
    /// Number of instances: 1.
    pub instance_count: u32,
    /// Index of the curve's first vertex, counted from the first vertex of the first curve.
    pub first_vertex: u32,
    /// First instance: 0.
    pub first_instance: u32,
    /// For contours, the number of vertices that they need, whether or not the buffer has room for them. For
    /// a path, the number of vertices as far as it was traced.
    pub vertices: u32,
    status: u32,
    source: u32,
    /// For a path, the map's value at its start.
    pub distance: f32,
    /// For a path, its length as far as it was traced. It is measured in the same way as the map.
    pub length: f32,
}

/// Status of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CurveStatus {
    /// The curve is complete. A path has arrived at a source.
    Complete,
    /// There are more vertices than there is room for.
    OutOfRoom,
    /// The path starts where no front arrives: in a hole, or cut off from the sources.
    Unreached,
    /// The path starts off the grid or at NaN, or no start was given for it.
    Outside,
    /// The path ends where the map does not lead on to a source. The map has not converged, belongs to other
    /// sources, or has a pit there.
    Lost,
}

impl CurveRecord {
    /// Distance between consecutive records in bytes.
    pub const BYTES: u32 = size_of::<Self>() as u32;

    /// Returns the status of the curve.
    pub fn status(&self) -> CurveStatus {
        match self.status {
            constants::COMPLETE => CurveStatus::Complete,
            constants::OUT_OF_ROOM => CurveStatus::OutOfRoom,
            constants::UNREACHED => CurveStatus::Unreached,
            constants::OUTSIDE => CurveStatus::Outside,
            constants::LOST | constants::UNDER_WAY.. => CurveStatus::Lost,
        }
    }

    /// Returns the source at which a path has arrived, as its place in the given order; `None` if it has not
    /// arrived.
    pub fn source(&self) -> Option<u32> {
        (self.status == constants::COMPLETE).then_some(self.source)
    }
}

const _: () =
    assert!(CurveRecord::BYTES == 4 * CURVE_WORDS && CurveVertex::BYTES == 4 * VERTEX_WORDS);

/// Buffer of curves: [`CurveRecord`]s from its first byte, followed by [`CurveVertex`]es. It has the usages
/// `VERTEX_BUFFER`, `INDIRECT_BUFFER`, `STORAGE_BUFFER` and `TRANSFER_SRC`, unless the host provides it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CurveBuffer {
    /// Buffer handle.
    pub buffer: vk::Buffer,
    /// Number of curves, and so of records.
    pub curves: u32,
    /// Offset of the first vertex in bytes, with which the vertex buffer is bound.
    pub vertices_offset: u64,
    /// Room for each curve, in vertices.
    pub capacity: u32,
}

/// Layout of a buffer of curves.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurveLayout {
    pub(super) curves: u32,
    /// Room for each curve, in vertices.
    pub(super) capacity: u32,
    /// Number of words between the records and the vertices.
    pub(super) between: u32,
}

/// Largest number of workgroups that lift a single curve.
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

    /// Returns an error if shaders cannot access the whole buffer, or cannot count its words.
    pub(super) fn check(self, what: &'static str, limits: &Limits) -> Result<(), VulkanError> {
        check_bytes(what, limits, self.bytes())
    }
}

/// Returns an error if shaders cannot access a buffer of this size as a whole.
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

/// Buffers and descriptor sets of the contours or paths of a surface.
#[derive(Debug)]
pub(super) struct Curves {
    pub(super) layout: CurveLayout,
    reads: Reads,
    /// Host's buffer for the curves; `None` if they have one of their own.
    hosts: Option<vk::Buffer>,
    /// Own buffers. The first holds the curves, unless the host provides that buffer. The last is the buffer
    /// in which passes count.
    buffers: Vec<Buffer>,
    /// For each of the surface's points, the pass that lifts curves to them.
    lifting: Vec<Pipeline<Lift>>,
    /// Descriptor sets of the passes that trace the curves, followed by those of the passes that lift them.
    sets: Option<BoundSets>,
}

/// Parameters of [`Curves`].
pub(super) struct CurvesInfo<'a> {
    pub(super) layout: CurveLayout,
    pub(super) reads: Reads,
    /// Buffer of the curves, followed by others that the passes use.
    pub(super) buffers: &'a [BufferInfo],
    /// Host's buffer in place of the first one.
    pub(super) hosts: Option<vk::Buffer>,
}

/// Inputs of the passes that trace curves, beside the map.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reads {
    /// This many bytes of counts in the last buffer.
    Counts(u64),
    /// Sources: the inline ones, followed by those of each of the surface's buffers.
    Sources,
}

impl Curves {
    pub(super) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        (solver, surface): (&Solver, &FrameSurface),
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
        surface: &FrameSurface,
    ) -> Result<(), VulkanError> {
        let contents = self.contents((device, &solver.limits), surface, self.output())?;
        self.sets = Some(BoundSets::new(device, &solver.pipelines, surface, &contents)?);
        self.lifting = lifting(device, solver, surface)?;
        Ok(())
    }

    /// Returns the contents of the descriptor sets, with curves in the buffer `output`.
    fn contents(
        &self,
        on: (&ash::Device, &Limits),
        surface: &FrameSurface,
        output: vk::Buffer,
    ) -> Result<Vec<Content>, VulkanError> {
        let output = whole(on, output, self.layout.bytes())?;
        let mut contents = match self.reads {
            Reads::Counts(bytes) => vec![Content::Input(whole(on, self.counts(), bytes)?)],
            Reads::Sources => host_sets::all_sources(on, &surface.grid, &surface.sources)?,
        };
        for points in &surface.points {
            contents.push(host_sets::points_content(on, points, surface.grid.chart)?);
        }
        Ok(contents.into_iter().map(|input| input.and_output(output)).collect())
    }

    /// Replaces the host's buffer in later recordings.
    pub(super) fn set_buffer(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
        buffer: vk::Buffer,
    ) -> Result<(), VulkanError> {
        if self.hosts.is_none() {
            return Err(own_buffer("contours or paths"));
        }
        self.bind(device, solver, surface, buffer)?;
        self.hosts = Some(buffer);
        Ok(())
    }

    /// Binds the current points and sources of the surface.
    pub(super) fn rebind(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
    ) -> Result<(), VulkanError> {
        self.bind(device, solver, surface, self.output())
    }

    /// Binds the surface's current points and sources, and the buffer `output` for the curves, by a version of the
    /// descriptor sets that no tracked recording in flight uses. Also chooses the passes that lift curves to the
    /// points again, since the points may have moved from a buffer to an image.
    fn bind(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
        output: vk::Buffer,
    ) -> Result<(), VulkanError> {
        self.sets()?.check_surface(surface)?;
        let contents = self.contents((device, &solver.limits), surface, output)?;
        let lifting = lifting(device, solver, surface)?;
        if let Some(sets) = &mut self.sets {
            sets.rebind(device, surface, &contents)?;
        }
        self.lifting = lifting;
        Ok(())
    }

    /// Returns the descriptor sets, or an error if the curves were destroyed.
    pub(super) fn sets(&self) -> Result<&BoundSets, VulkanError> {
        self.sets.as_ref().ok_or(VulkanError::Destroyed)
    }

    /// Returns whether a tracked recording of the curves may not have run.
    pub(super) fn is_in_flight(&self) -> bool {
        self.sets.as_ref().is_some_and(BoundSets::are_in_flight)
    }

    pub(super) fn bytes(&self) -> u64 {
        self.buffers.iter().map(Buffer::bytes).sum()
    }

    /// Returns the buffer that holds the curves.
    pub(super) fn output(&self) -> vk::Buffer {
        let own = || self.buffers.first().map_or(vk::Buffer::null(), |buffer| buffer.buffer);
        self.hosts.unwrap_or_else(own)
    }

    /// Returns the buffer that passes count in.
    pub(super) fn counts(&self) -> vk::Buffer {
        self.buffers.last().map_or(vk::Buffer::null(), |buffer| buffer.buffer)
    }

    pub(super) fn curves(&self) -> CurveBuffer {
        let CurveLayout { curves, capacity, .. } = self.layout;
        let vertices_offset = size_of::<f32>() as u64 * self.layout.first_vertex();
        CurveBuffer { buffer: self.output(), curves, vertices_offset, capacity }
    }

    /// Returns an error if the recording is for another surface, if the surface has no points with this
    /// number, if these points were replaced or have no positions, or if there is no map.
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

    /// Lifts all curves to the surface's points with this number, with a barrier before the reads of
    /// `reader`. These are the last commands of a recording that was checked before.
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
        // Only the device knows how many vertices there are to lift.
        let _pass = recorder.pass(PassKind::Lift);
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

/// Returns the error for a host's buffer where the curves have a buffer of their own.
pub(super) fn own_buffer(what: &'static str) -> VulkanError {
    let reason = "they have a buffer of their own: make them with the host's".into();
    VulkanError::HostBuffer { what, reason }
}

/// Returns, for each of the surface's points, the pass that reads them.
fn lifting(
    device: &ash::Device,
    solver: &Solver,
    surface: &FrameSurface,
) -> Result<Vec<Pipeline<Lift>>, VulkanError> {
    let pass = |points: &Points| match points.memory {
        PointMemory::Buffer { .. } => LIFT_FROM_BUFFER,
        PointMemory::Image { .. } => LIFT_FROM_IMAGE,
    };
    let make = |points| solver.pipelines.make(device, pass(points), Wavefront::Planar);
    surface.points.iter().map(make).collect()
}

/// Returns the whole of a buffer.
fn whole(on: (&ash::Device, &Limits), buffer: vk::Buffer, bytes: u64) -> Result<Part, VulkanError> {
    Part::new(on, "curves", buffer, 0, bytes)
}

/// Returns the bytes that buffers of these sizes take from the allocator.
pub(super) fn bytes_for(device: &ash::Device, infos: &[BufferInfo]) -> Result<u64, VulkanError> {
    infos.iter().map(|info| info.bytes(device)).sum()
}
