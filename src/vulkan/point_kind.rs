//! What the floats of a grid point are, and all that depends on it on a device.

use super::passes::{CommonPass, EDGES_FROM_HEIGHTS, EDGES_FROM_METRIC, EDGES_FROM_POSITIONS};
use super::shaders::edges_from_heights;
use crate::surface::Spacing;

/// What the floats of a point are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointKind {
    /// Three coordinates.
    Positions,
    /// A height over a rectangular grid.
    Heights(Spacing),
    /// The metric alone, in index coordinates: the entries rr, rc and cc of
    /// [`crate::MetricTensor`], in square units. Where it is not positive definite, lengths are
    /// wrong.
    Metric,
}

/// What passes have to know of a kind.
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

    /// Floats of a point, without its slowness.
    pub(crate) fn floats(self) -> u32 {
        self.traits().floats
    }

    /// Bytes of a point in the upload buffer, which holds its slowness too.
    pub(crate) fn uploaded_bytes(self) -> u64 {
        4 * (u64::from(self.floats()) + 1)
    }

    /// Between columns and rows, where points are heights.
    pub(crate) fn spacing(self) -> Option<Spacing> {
        self.traits().spacing
    }

    /// The pass that measures edges.
    pub(crate) fn edges(self) -> CommonPass<edges_from_heights::Push> {
        self.traits().edges
    }

    /// Whether points lie somewhere: a curve can be lifted to them, and edges can be arcs.
    pub(crate) fn has_positions(self) -> bool {
        self.traits().has_positions
    }
}
