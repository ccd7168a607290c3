//! Describes the contents of the host's images and buffers.

use ash::vk;
use bytemuck::{Pod, Zeroable};

use crate::surface::{Chart, Seed, SourceError};
use crate::vulkan::grid_images::INLINE_SOURCES;
use crate::vulkan::point_kind::PointKind;

/// Points of a surface in device memory of the host.
///
/// A point is a hole if one of its coordinates, its height, an entry of its metric or its slowness is NaN,
/// infinite or beyond 1e12, or if its slowness is negative. A slowness of 0 makes travel free: values below
/// 1e-12 count as 1e-12.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Points {
    /// Location of the points.
    pub memory: PointMemory,
    /// Meaning of the floats of a point.
    pub kind: PointKind,
    /// Index of the float that is the point's slowness, counted from the first float of the point. With
    /// `None` the slowness is 1 everywhere. In an image the floats are the four components.
    pub slowness: Option<u32>,
}

/// Device memory with one entry per grid point, row-major. The host keeps it alive until all recordings that
/// read it have run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointMemory {
    /// Buffer of 32-bit floats, such as a vertex buffer. Its usage is `STORAGE_BUFFER`.
    Buffer {
        /// Buffer handle.
        buffer: vk::Buffer,
        /// Offset of the first point's position, height or metric in bytes; a multiple of 4.
        offset: u64,
        /// Distance between consecutive points in bytes; a multiple of 4.
        stride: u64,
    },
    /// Image of at least N x M texels (width x height) with components that shaders read as floats, such as
    /// R32G32B32A32_SFLOAT for positions or R32_SFLOAT for heights. Its usage is `SAMPLED`.
    Image {
        /// 2D view of the image.
        view: vk::ImageView,
        /// Layout of the image whenever a recording reads it.
        layout: vk::ImageLayout,
    },
}

impl PointMemory {
    /// Returns the number of 32-bit words between consecutive points in a buffer; 0 for an image.
    pub(super) fn stride_words(self) -> i32 {
        match self {
            Self::Buffer { stride, .. } => stride as i32 / size_of::<f32>() as i32,
            Self::Image { .. } => 0,
        }
    }
}

impl Points {
    /// Returns points given as positions in a buffer. Each is three floats, and consecutive points are
    /// `stride` bytes apart.
    pub fn positions(buffer: vk::Buffer, stride: u64) -> Self {
        let memory = PointMemory::Buffer { buffer, offset: 0, stride };
        Self { memory, kind: PointKind::Positions, slowness: None }
    }

    /// Returns the number of floats of a point that are read.
    pub(super) fn floats(&self) -> u64 {
        u64::from(self.kind.floats()).max(self.slowness.map_or(0, |index| u64::from(index) + 1))
    }
}

/// Source: a point of the surface at which the distance, or arrival time, is known.
///
/// In a buffer that the host's shaders write, a source is a `vec4`, or four floats. An entry is skipped if it
/// is off the grid or in a hole, or if its time is NaN or not below 1e30. A shader that has fewer sources
/// than the buffer holds writes NaN to the remaining entries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PointSource {
    /// Row, from 0 to M - 1. A fractional row lies between grid points.
    pub row: f32,
    /// Column, from 0 to N - 1; may be fractional.
    pub col: f32,
    /// Distance, or arrival time, at the source.
    pub time: f32,
    /// Curvature of the front at the source, for a source at a grid point and the curved wavefront. It is 0
    /// or [`Seed::AT_SOURCE`] if the source is a point, and [`PointSource::STRAIGHT`] if the grid point is
    /// one of many on a straight line. A source between grid points is always a point. In a buffer, a
    /// curvature that is negative, infinite or NaN also means a point.
    pub curvature: f32,
}

impl PointSource {
    /// Curvature of a straight front.
    pub const STRAIGHT: f32 = crate::constants::FLAT as f32;

    /// Returns a point source with time 0.
    pub fn at(row: f32, col: f32) -> Self {
        Self { row, col, time: 0.0, curvature: Seed::AT_SOURCE as f32 }
    }

    pub(super) fn check(&self, chart: Chart) -> Result<(), SourceError> {
        let [row, col, time] = [self.row, self.col, self.time].map(f64::from);
        let (last_row, last_col) = (chart.rows - 1, chart.cols - 1);
        let inside =
            (0.0..=last_row as f64).contains(&row) && (0.0..=last_col as f64).contains(&col);
        if !inside {
            return Err(SourceError::Outside { row, col, last_row, last_col });
        }
        let usable = time.is_finite() && time < crate::surface::FAR;
        if !usable {
            return Err(SourceError::Initial { row, col, initial: time });
        }
        let curvature = self.curvature.into();
        let usable = (0.0..=f64::from(f32::MAX)).contains(&curvature);
        if usable { Ok(()) } else { Err(SourceError::Curvature { row, col, curvature }) }
    }
}

/// Buffer of [`PointSource`]s. Its usage is `STORAGE_BUFFER`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SourceBuffer {
    /// Buffer handle.
    pub buffer: vk::Buffer,
    /// Offset of the first source in bytes; a multiple of 4.
    pub offset: u64,
    /// Number of sources.
    pub count: u32,
}

/// Places at which distances are looked up. A place is two floats: row and column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lookup {
    /// Buffer that holds the places. Its usage is `STORAGE_BUFFER`.
    pub places: vk::Buffer,
    /// Offset of the first place in bytes; a multiple of 4.
    pub places_offset: u64,
    /// Buffer that receives the distances, one float per place. Its usage is `STORAGE_BUFFER`.
    pub distances: vk::Buffer,
    /// Offset of the first distance in bytes; a multiple of 4.
    pub distances_offset: u64,
    /// Number of places.
    pub count: u32,
}

/// Sources of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SourceInput<'a> {
    /// Sources in the program's memory, at most 1024. They are copied into the command buffer.
    Inline(&'a [PointSource]),
    /// All sources in the surface's source buffer with this number.
    Buffer(usize),
    /// Sources in another part of such a buffer, such as the part of a ring buffer for this frame.
    BufferAt {
        /// Number of the surface's source buffer.
        number: usize,
        /// Offset in bytes from the surface's first source in that buffer; a multiple of 4.
        offset: u64,
    },
}

impl SourceInput<'_> {
    /// Largest number of inline sources.
    pub const MOST_INLINE: usize = INLINE_SOURCES;

    /// Returns whether a source may lie between grid points. For a buffer this is always true, since its
    /// contents are unknown.
    pub(super) fn may_lie_inside_cells(&self) -> bool {
        let is_inside =
            |source: &PointSource| source.row.fract() != 0.0 || source.col.fract() != 0.0;
        match self {
            Self::Inline(sources) => sources.iter().any(is_inside),
            Self::Buffer(_) | Self::BufferAt { .. } => true,
        }
    }

    /// Returns the number of the source buffer and the offset in bytes from its first source; `None` for
    /// inline sources.
    pub(super) fn buffer(&self) -> Option<(usize, u64)> {
        match *self {
            Self::Inline(_) => None,
            Self::Buffer(number) => Some((number, 0)),
            Self::BufferAt { number, offset } => Some((number, offset)),
        }
    }
}
