//! Contours and paths, as the device leaves them for drawing.

use ash::vk;

use super::arguments::{Output, reference};
use super::status::{GeosweepStatus, guard};
use crate::vulkan::embed::{self, CurveStatus};

/// Bytes of a curve's record in a `GeosweepCurves`: from draw to draw, and what
/// `geosweep_curve_record_from_bytes` reads.
pub const GEOSWEEP_CURVE_RECORD_BYTES: u32 = 36;
const _: () = assert!(GEOSWEEP_CURVE_RECORD_BYTES == embed::CurveRecord::BYTES);

/// For `GeosweepCurveRecord::source`: the path has not arrived at a source.
pub const GEOSWEEP_NO_SOURCE: u32 = 0xFFFF_FFFF;

/// Where contours or paths are: a buffer with the usages `VERTEX_BUFFER`, `INDIRECT_BUFFER`,
/// `STORAGE_BUFFER` and `TRANSFER_SRC`, which belongs to them.
///
/// Curve k is drawn by `vkCmdDrawIndirect` with an offset of k x `GEOSWEEP_CURVE_RECORD_BYTES`,
/// contours as a list of lines, a path as a strip of lines, from the buffer bound as a vertex buffer
/// with an offset of `vertices_offset`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepCurves {
    /// The buffer: records from its first byte, then vertices.
    pub buffer: vk::Buffer,
    /// Bytes before the first vertex.
    pub vertices_offset: u64,
    /// How many curves, and so records, there are: 1 of contours.
    pub curves: u32,
    /// Room for vertices of each curve.
    pub capacity: u32,
}

/// A vertex of a contour or path in the buffer: three attributes of a pipeline, with the formats
/// `VK_FORMAT_R32G32B32_SFLOAT`, `VK_FORMAT_R32_SFLOAT` and `VK_FORMAT_R32G32_SFLOAT` at the
/// offsets 0, 12 and 16.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepCurveVertex {
    /// x, y and z, on the surface.
    pub position: [f32; 3],
    /// The distance there, a contour's level.
    pub time: f32,
    /// Fractional.
    pub row: f32,
    /// Fractional.
    pub col: f32,
}

const _: () = assert!(size_of::<GeosweepCurveVertex>() == embed::CurveVertex::BYTES as usize);

/// What has become of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum GeosweepCurveStatus {
    /// All of it is there: a path has arrived at a source.
    Complete = 0,
    /// There are more vertices than there is room for.
    OutOfRoom = 1,
    /// A path starts where no front arrives: in a hole, or cut off from the sources.
    Unreached = 2,
    /// A path starts off the grid, at what is not a number, or there is no start for it.
    Outside = 3,
    /// A path ends where the map does not lead on to a source, since it has not converged, belongs
    /// to other sources, or has a pit there.
    Lost = 4,
}

/// What is known of a curve. In the buffer it starts with a `VkDrawIndirectCommand`;
/// `geosweep_curve_record_from_bytes` reads all of it.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepCurveRecord {
    /// What has become of it.
    pub status: GeosweepCurveStatus,
    /// How many vertices are drawn: of contours those that there was room for, of a path all of them
    /// or none.
    pub vertex_count: u32,
    /// Its first vertex, counted from that of the first curve.
    pub first_vertex: u32,
    /// Of contours how many vertices there would be with room for all; of a path how many there are,
    /// as far as it has come.
    pub vertices: u32,
    /// Of a path that has arrived: at which source, in the order given; or `GEOSWEEP_NO_SOURCE`.
    pub source: u32,
    /// Of a path: the distance at its start.
    pub distance: f32,
    /// Of a path: its length, measured as the map measures, as far as it has come.
    pub length: f32,
}

impl From<embed::CurveBuffer> for GeosweepCurves {
    fn from(curves: embed::CurveBuffer) -> Self {
        let embed::CurveBuffer { buffer, curves, vertices_offset, capacity } = curves;
        Self { buffer, vertices_offset, curves, capacity }
    }
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

/// Reads the record of a curve that you have copied from the buffer: `GEOSWEEP_CURVE_RECORD_BYTES`
/// bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_curve_record_from_bytes(
    bytes: *const u8,
    record: *mut GeosweepCurveRecord,
) -> GeosweepStatus {
    guard(|| {
        const BYTES: usize = embed::CurveRecord::BYTES as usize;
        // SAFETY: the caller's promise.
        let (bytes, output) = unsafe {
            let output = Output::new(record, "record")?;
            (reference(bytes.cast::<[u8; BYTES]>(), "bytes")?, output)
        };
        output.write(bytemuck::pod_read_unaligned::<embed::CurveRecord>(bytes).into());
        Ok(())
    })
}
