//! Defines the meaning of the floats of a grid point, and the passes and sizes on a device that depend on it.

use super::device::passes::{
    CommonPass, EDGES_FROM_HEIGHTS, EDGES_FROM_METRIC, EDGES_FROM_POSITIONS,
};
use super::device::shaders::edges_from_heights;
use crate::surface::Spacing;

/// Meaning of the floats of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointKind {
    /// Three coordinates.
    Positions,
    /// Height over a rectangular grid.
    Heights(Spacing),
    /// Metric alone, in index coordinates: the entries rr, rc and cc of [`crate::MetricTensor`], in square
    /// units. If the metric is not positive definite, lengths are wrong.
    Metric,
}

/// Properties of a kind that passes need.
struct Traits {
    floats: u32,
    spacing: Option<Spacing>,
    edges: CommonPass<edges_from_heights::Push>,
    has_positions: bool,
}

impl PointKind {
    fn traits(self) -> Traits {
        let of_three = |edges| Traits { floats: 3, spacing: None, edges, has_positions: true };
        match self {
            Self::Positions => of_three(EDGES_FROM_POSITIONS),
            Self::Heights(spacing) => {
                let spacing = Some(spacing);
                Traits { floats: 1, spacing, ..of_three(EDGES_FROM_HEIGHTS) }
            }
            Self::Metric => Traits { has_positions: false, ..of_three(EDGES_FROM_METRIC) },
        }
    }

    /// Returns the number of floats of a point, without its slowness.
    pub fn floats(self) -> u32 {
        self.traits().floats
    }

    /// Returns the bytes of a point in the upload buffer, which also contains its slowness.
    pub(crate) fn uploaded_bytes(self) -> u64 {
        4 * (u64::from(self.floats()) + 1)
    }

    /// Returns the spacing of columns and rows, if points are heights.
    pub(crate) fn spacing(self) -> Option<Spacing> {
        self.traits().spacing
    }

    /// Returns the spacing of columns and rows in single precision; 0 for points that are not heights.
    pub(crate) fn spacing_in_single(self) -> [f32; 2] {
        self.spacing().map_or([0.0; 2], |of| [of.dx as f32, of.dy as f32])
    }

    /// Returns the pass that measures edges.
    pub(crate) fn edges(self) -> CommonPass<edges_from_heights::Push> {
        self.traits().edges
    }

    /// Returns whether points have positions. Then a curve can be lifted to them, and edges can be arcs.
    pub(crate) fn has_positions(self) -> bool {
        self.traits().has_positions
    }
}
