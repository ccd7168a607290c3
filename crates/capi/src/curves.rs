//! Contours and paths in the form in which the device stores them for drawing.

use ash::vk;

use super::arguments::{reference, write};
use super::shared::same_fields;
use super::status::calls;
use geosweep::vulkan::embed::{self, CurveStatus};

/// Size in bytes of a curve's record in a `GeosweepCurves`. It is the stride of indirect draws, and the size
/// that `geosweep_curve_record_from_bytes` reads.
pub const GEOSWEEP_CURVE_RECORD_BYTES: u32 = 36;
const _: () = assert!(GEOSWEEP_CURVE_RECORD_BYTES == embed::CurveRecord::BYTES);

/// Value of `GeosweepCurveRecord::source` for a path that has not arrived at a source.
pub const GEOSWEEP_NO_SOURCE: u32 = 0xFFFF_FFFF;

/// Buffer in which contours or paths are stored. Unless it is your own, it belongs to the contours or paths
/// and has the usages `VERTEX_BUFFER`, `INDIRECT_BUFFER`, `STORAGE_BUFFER` and `TRANSFER_SRC`.
///
/// `vkCmdDrawIndirect` draws curve k with an offset of k x `GEOSWEEP_CURVE_RECORD_BYTES`. Contours are a list
/// of lines, and a path is a strip of lines. Bind the buffer as a vertex buffer with an offset of
/// `vertices_offset`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepCurves {
    /// The buffer: records from its first byte, then vertices.
    pub buffer: vk::Buffer,
    /// Offset of the first vertex in bytes.
    pub vertices_offset: u64,
    /// Number of curves, and thus of records. It is 1 for contours.
    pub curves: u32,
    /// Largest number of vertices of each curve.
    pub capacity: u32,
}

/// Vertex of a contour or path in the buffer. A pipeline has three attributes for it, with the formats
/// `VK_FORMAT_R32G32B32_SFLOAT`, `VK_FORMAT_R32_SFLOAT` and `VK_FORMAT_R32G32_SFLOAT` at the offsets 0, 12
/// and 16.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepCurveVertex {
    /// Coordinates x, y and z on the surface.
    pub position: [f32; 3],
    /// Distance at the vertex. For a contour, this is its level.
    pub time: f32,
    /// Row on the grid, with its fraction.
    pub row: f32,
    /// Column on the grid, with its fraction.
    pub col: f32,
}

const _: () = assert!(size_of::<GeosweepCurveVertex>() == embed::CurveVertex::BYTES as usize);

/// State of a curve after its recording has run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum GeosweepCurveStatus {
    /// The curve is complete. A path has arrived at a source.
    Complete = 0,
    /// The curve needs more vertices than there is room for.
    OutOfRoom = 1,
    /// The path starts where no front arrives: in a hole, or where no source can be reached.
    Unreached = 2,
    /// The path starts off the grid or at NaN, or no start was given for it.
    Outside = 3,
    /// The path ends where the map does not lead on to a source. The map has not converged, belongs to other
    /// sources, or has a local minimum there.
    Lost = 4,
}

/// Record of a curve. In the buffer it begins with a `VkDrawIndirectCommand`.
/// `geosweep_curve_record_from_bytes` reads all of it.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepCurveRecord {
    /// State of the curve.
    pub status: GeosweepCurveStatus,
    /// Number of vertices that are drawn. Contours draw the vertices that there was room for; a path draws
    /// all its vertices or none.
    pub vertex_count: u32,
    /// Index of the curve's first vertex, counted from the first vertex of the first curve.
    pub first_vertex: u32,
    /// Number of vertices. For contours, this is the number that all contours need; for a path, the number up
    /// to where the path ends.
    pub vertices: u32,
    /// Index of the source at which a path has arrived, in the order in which sources were given. It is
    /// `GEOSWEEP_NO_SOURCE` if there is none.
    pub source: u32,
    /// Distance at the start of a path.
    pub distance: f32,
    /// Length of a path up to where it ends, measured in the same way as the map.
    pub length: f32,
}

same_fields! {
    embed::CurveBuffer => GeosweepCurves { buffer, vertices_offset, curves, capacity };
}

impl From<CurveStatus> for GeosweepCurveStatus {
    fn from(status: CurveStatus) -> Self {
        match status {
            CurveStatus::Complete => Self::Complete,
            CurveStatus::OutOfRoom => Self::OutOfRoom,
            CurveStatus::Unreached => Self::Unreached,
            CurveStatus::Outside => Self::Outside,
            CurveStatus::Lost => Self::Lost,
        }
    }
}

impl From<embed::CurveRecord> for GeosweepCurveRecord {
    fn from(record: embed::CurveRecord) -> Self {
        Self {
            status: record.status().into(),
            vertex_count: record.vertex_count,
            first_vertex: record.first_vertex,
            vertices: record.vertices,
            source: record.source().unwrap_or(GEOSWEEP_NO_SOURCE),
            distance: record.distance,
            length: record.length,
        }
    }
}

calls! {
    /// Reads the record of a curve from `GEOSWEEP_CURVE_RECORD_BYTES` bytes that you have copied from the buffer.
    fn geosweep_curve_record_from_bytes(bytes: *const u8, record: *mut GeosweepCurveRecord) {
        let bytes = reference(bytes.cast::<[u8; embed::CurveRecord::BYTES as usize]>(), "bytes")?;
        write(record, "record", bytemuck::pod_read_unaligned::<embed::CurveRecord>(bytes).into())?;
    }
}
