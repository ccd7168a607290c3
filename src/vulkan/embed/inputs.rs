//! What the host's images and buffers hold.

use ash::vk;
use bytemuck::{Pod, Zeroable};

use crate::surface::{Chart, Seed, SourceError};
use crate::vulkan::point_kind::PointKind;

/// The points of a surface in memory of the host's on the device.
///
/// A point with a coordinate, height, entry of the metric or slowness that is NaN, infinite or beyond
/// 1e12, or with a negative slowness, is a hole. Travel is free where the slowness is 0: one below 1e-12 counts as 1e-12.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Points {
    /// Where they are.
    pub memory: PointMemory,
    /// What is there.
    pub kind: PointKind,
    /// Which float of a point, counted from its first, is its slowness; 1 everywhere if `None`. In
    /// an image these are the four components.
    pub slowness: Option<u32>,
}

/// Memory with one entry a grid point, row-major.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointMemory {
    /// A buffer with 32-bit floats, such as a vertex buffer. Usage `STORAGE_BUFFER`.
    Buffer {
        /// The buffer.
        buffer: vk::Buffer,
        /// Bytes before the first point's position or height; a multiple of 4.
        offset: u64,
        /// Bytes from point to point; a multiple of 4.
        stride: u64,
    },
    /// An image of at least N x M texels (width x height) with components that shaders read as
    /// floats: R32G32B32A32_SFLOAT for positions, say, or R32_SFLOAT for heights. Usage `SAMPLED`.
    Image {
        /// A 2D view.
        view: vk::ImageView,
        /// The layout in which the image is whenever it is read.
        layout: vk::ImageLayout,
    },
}

impl PointMemory {
    /// 32-bit words from point to point in a buffer.
    pub(super) fn stride_words(self) -> i32 {
        match self {
            Self::Buffer { stride, .. } => stride as i32 / size_of::<f32>() as i32,
            Self::Image { .. } => 0,
        }
    }
}

impl Points {
    /// Positions in a buffer, three floats each, so many bytes apart.
    pub fn positions(buffer: vk::Buffer, stride: u64) -> Self {
        let memory = PointMemory::Buffer { buffer, offset: 0, stride };
        Self { memory, kind: PointKind::Positions, slowness: None }
    }

    /// Floats of a point, as far as they are looked at.
    pub(super) fn floats(&self) -> u64 {
        u64::from(self.kind.floats()).max(self.slowness.map_or(0, |index| u64::from(index) + 1))
    }
}

/// A source: a point of the surface where the distance, or time, is known.
///
/// In a buffer that the host's shaders write, this is a `vec4`, or four floats. An entry that is not
/// on the grid, in a hole, or has a time that is NaN or not below 1e30 is passed over, so a shader
/// that has fewer sources than the buffer has room for writes NaN for the rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PointSource {
    /// Row, from 0 to M - 1, fractional between grid points.
    pub row: f32,
    /// Column, from 0 to N - 1.
    pub col: f32,
    /// Distance, or time, at the source.
    pub time: f32,
    /// Curvature of the front there, for a source at a grid point and the curved wavefront: 0 or
    /// [`Seed::AT_SOURCE`] if the source is a point, [`PointSource::STRAIGHT`] if the grid point is one of
    /// many on a straight line. Between grid points sources are points. What a shader writes that is
    /// negative, infinite or no number stands for a point as well.
    pub curvature: f32,
}

impl PointSource {
    /// The curvature of a straight front.
    pub const STRAIGHT: f32 = crate::constants::FLAT as f32;

    /// A point source.
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

/// A buffer of [`PointSource`]s. Usage `STORAGE_BUFFER`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SourceBuffer {
    /// The buffer.
    pub buffer: vk::Buffer,
    /// Bytes before the first; a multiple of 4.
    pub offset: u64,
    /// How many.
    pub count: u32,
}

/// Places at which distances are looked up: two floats each, row and column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lookup {
    /// A buffer with the places. Usage `STORAGE_BUFFER`.
    pub places: vk::Buffer,
    /// Bytes before the first; a multiple of 4.
    pub places_offset: u64,
    /// A buffer for the distances, one float each. Usage `STORAGE_BUFFER`.
    pub distances: vk::Buffer,
    /// Bytes before the first; a multiple of 4.
    pub distances_offset: u64,
    /// How many.
    pub count: u32,
}

/// The sources of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SourceInput<'a> {
    /// From the program's memory, copied into the command buffer: at most 1024.
    Inline(&'a [PointSource]),
    /// From the surface's source buffer with this number.
    Buffer(usize),
    /// From a part of that buffer, as in a ring of which each frame has another part.
    BufferAt {
        /// The number of the surface's source buffer.
        number: usize,
        /// Bytes beyond the first source that the surface has there; a multiple of 4.
        offset: u64,
    },
}

impl SourceInput<'_> {
    /// Whether a source may lie between grid points: nobody knows what is in a buffer.
    pub(super) fn may_lie_inside_cells(&self) -> bool {
        let is_inside =
            |source: &PointSource| source.row.fract() != 0.0 || source.col.fract() != 0.0;
        match self {
            Self::Inline(sources) => sources.iter().any(is_inside),
            Self::Buffer(_) | Self::BufferAt { .. } => true,
        }
    }

    /// The number of its buffer and the bytes beyond its first source, if it is in one.
    pub(super) fn buffer(&self) -> Option<(usize, u64)> {
        match *self {
            Self::Inline(_) => None,
            Self::Buffer(number) => Some((number, 0)),
            Self::BufferAt { number, offset } => Some((number, offset)),
        }
    }
}
