//! Defines the buffer of curves on the device, its layout, and the passes that lift curves to the surface.

use ash::vk;
use bytemuck::{Pod, Zeroable};
use gpu_allocator::MemoryLocation;

use super::access::Access;
use super::inputs::{PointMemory, Points};
use super::outputs::{BufferKind, Output};
use super::recording::{Recording, grid_size};
use super::solver::Solver;
use super::surface::FrameSurface;
use crate::constants::{self, CURVE_WORDS, VERTEX_WORDS, WORKGROUP};
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::device::barrier::SHADER_WRITE;
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::memory::BufferInfo;
use crate::vulkan::device::passes::{LIFT_FROM_BUFFER, LIFT_FROM_IMAGE};
use crate::vulkan::device::pipelines::Pipeline;
pub(super) use crate::vulkan::device::shaders::lift_from_buffer::Push as Lift;
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
    /// Number of vertices to draw: for contours, those that fit the buffer; for a path, all of its vertices, or 0 if
    /// the path is not complete.
    pub vertex_count: u32,
    /// Number of instances: 1.
    pub instance_count: u32,
    /// Index of the curve's first vertex, counted from the first vertex of the first curve.
    pub first_vertex: u32,
    /// First instance: 0.
    pub first_instance: u32,
    /// Number of vertices needed: for contours, even if the buffer is too small; for a path, as far as it was traced.
    pub vertices: u32,
    status: u32,
    source: u32,
    /// Value of the map at a path's start.
    pub distance: f32,
    /// Length of a path as far as it was traced, in the measure of the map.
    pub length: f32,
}

/// Status of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CurveStatus {
    /// The curve is complete. A path has arrived at a source.
    Complete,
    /// The curve has more vertices than there is capacity for.
    OutOfRoom,
    /// The path starts where no front arrives: in a hole, or cut off from the sources.
    Unreached,
    /// The path starts off the grid or at NaN, or no start was given for it.
    Outside,
    /// The path ends where the map leads no further towards a source: the map has not converged, belongs to other
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

    /// Returns the source at which a path has arrived, as its index in the given order; `None` if the path has not
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
    /// Capacity of each curve, in vertices.
    pub capacity: u32,
}

/// Layout of a buffer of curves.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurveLayout {
    pub(super) curves: u32,
    /// Capacity of each curve, in vertices.
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

    /// Returns the parameters of the buffer, or an error if shaders cannot access all of it.
    pub(super) fn buffer(
        self,
        name: &'static str,
        limits: &Limits,
    ) -> Result<BufferInfo, VulkanError> {
        buffer_info(name, limits, self.bytes())
    }
}

/// Returns the parameters of an output's buffer, or an error if shaders cannot access the whole buffer, or cannot
/// count its words.
pub(super) fn buffer_info(
    name: &'static str,
    limits: &Limits,
    size: u64,
) -> Result<BufferInfo, VulkanError> {
    let most = limits.storage_range.min(i32::MAX as u64);
    if size > most {
        let reason =
            format!("their buffer would have {size} bytes, and shaders see {most} at most");
        return Err(VulkanError::Curves { what: name, reason });
    }
    Ok(BufferInfo { name, size, location: MemoryLocation::GpuOnly })
}

/// Kind of an output that is a buffer of curves.
pub trait CurveKind: BufferKind {}

impl<K: CurveKind> Output<K> {
    pub(super) fn layout(&self) -> CurveLayout {
        self.info.curves.expect("this kind of output has curves")
    }

    /// Returns the buffer of the curves. Contours have a single [`CurveRecord`] and are drawn as a list of lines. Each
    /// path has a record and is drawn as a strip of lines.
    pub fn curves(&self) -> CurveBuffer {
        let CurveLayout { curves, capacity, .. } = self.layout();
        let vertices_offset = size_of::<f32>() as u64 * self.layout().first_vertex();
        CurveBuffer { buffer: self.buffer(), curves, vertices_offset, capacity }
    }

    /// Returns an error if the recording is for another surface, if the surface has no points with this
    /// number, if these points were replaced or have no positions, or if there is no map.
    pub(super) fn check_points(
        &self,
        recording: &Recording,
        points: usize,
    ) -> Result<(), VulkanError> {
        let sets = self.sets()?;
        sets.check_surface(recording.surface)?;
        let (_, Points { kind, .. }) = recording.points(points)?;
        sets.check_points(recording.surface, points)?;
        if !kind.has_positions() {
            let reason = "a metric has no positions to lift them to".into();
            return Err(VulkanError::Curves { what: self.info.buffer.name, reason });
        }
        recording.surface.state.check_map()
    }

    /// Lifts all curves to the surface's points with this number, and records a barrier before the reads of `reader`.
    /// These commands end a recording, which was checked before.
    pub(super) fn lift(
        &self,
        recording: &Recording,
        points: usize,
        reader: Access,
    ) -> Result<CurveBuffer, VulkanError> {
        let Recording { recorder, surface, .. } = recording;
        let sets = self.sets()?.sets();
        let traced = sets.len() - self.lifting.len();
        let set = recording.at_points_offset(sets[traced + points]);
        surface.sets.points[points].is_read(&surface.flight);
        let Points { memory, kind, .. } = surface.points[points];
        let CurveLayout { curves, capacity, .. } = self.layout();
        let lift = Lift {
            grid: grid_size(surface.grid.chart),
            first_word: set.first_word,
            stride: memory.stride_words(),
            spacing: kind.spacing_in_single(),
            first_vertex: self.layout().first_vertex() as i32,
            capacity: capacity as i32,
        };
        let lifters = if curves == 1 { capacity.div_ceil(WORKGROUP).clamp(1, LIFTERS) } else { 1 };
        let size = [WORKGROUP * lifters, curves];
        // Only the device knows how many vertices there are to lift.
        let _pass = recorder.pass(PassKind::Lift);
        recorder.host_pass(self.lifting[points], set.set, &lift, size);
        recorder.barrier(SHADER_WRITE, reader.side());
        self.end(recording);
        Ok(self.curves())
    }
}

/// Returns, for each of the surface's points, the pass that reads them.
pub(super) fn lifting(
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
