//! Data of a surface that scans of one kind of front need, and its preparation for many maps.

use super::panel::{Grid, Panel};
use super::transposed::TransposedEdges;
use crate::Instructions;
use crate::fronts::{LaneKind, SurfaceArray};
use crate::limit::Limit;
use crate::scan::Scan;
use geosweep_surface::Monitor;
use geosweep_surface::{Chart, EdgeLengths, Real};

/// A kind of front over a surface, and the surface's data in the order that scans need.
#[derive(Clone, Debug)]
pub(crate) struct Prepared<R: Real, K: LaneKind<R>> {
    pub edges: EdgeLengths<R>,
    pub kind: K,
    /// Data of each surface point that the front needs.
    surface_data: SurfaceArray<K::SurfaceData>,
    pub settings: Settings,
    /// Transposed edges, for straight fronts on large grids. The second map fills them. Other fronts already need more
    /// data per point.
    transposed: Option<TransposedEdges<R>>,
    /// Whether a map has been solved.
    solved: bool,
}

/// Settings of a solver, for all its maps.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// The limit of the next map, or the current one of the last map. It falls with the times of its targets. Arrival
    /// times after it are not final.
    pub limit: Limit,
    pub instructions: Instructions,
    pub monitor: Monitor,
}

/// Minimum number of grid points for storing transposed edges. On smaller grids these edges and the panels would take
/// more than 40 bytes per point. They would also save less time, since the arrays to transpose fit near caches.
const TRANSPOSED_FROM: usize = 256 * 256;

/// Number of iterations of a map after which the parts of many obtuse triangles are stored. On a plane sheared by 60
/// degrees a map needs two iterations; storing the parts at once makes it 1.5 times as slow. On steep hills a map needs
/// 20 iterations; not storing the parts makes it 1.3 to 1.8 times as slow.
pub(crate) const FEW_ITERATIONS: u32 = 3;

impl<R: Real, K: LaneKind<R>> Prepared<R, K> {
    pub(crate) fn new(edges: &EdgeLengths<R>, kind: K) -> Self {
        if K::NEEDS_EDGES {
            // Otherwise a scan would store the parts of obtuse triangles, while other threads wait for it.
            edges.store_few_parts();
        }
        let chart = edges.chart();
        let carries_nothing = size_of::<K::Carried>() == 0;
        let keeps_edges = carries_nothing && chart.points() >= TRANSPOSED_FROM;
        Self {
            edges: edges.clone(),
            surface_data: kind.surface_data(chart),
            kind,
            settings: Settings {
                limit: Limit::NONE,
                instructions: Instructions::best(),
                monitor: Monitor::default(),
            },
            transposed: keeps_edges.then(|| TransposedEdges::new(chart)),
            solved: false,
        }
    }

    /// Returns the chart of the surface.
    pub(crate) fn chart(&self) -> Chart {
        self.edges.chart()
    }

    /// Returns the surface's data.
    pub(crate) fn grid(&self) -> Grid<'_, R, K::SurfaceData> {
        let transposed = self.transposed.as_ref().and_then(TransposedEdges::filled);
        Grid { edges: &self.edges, transposed, surface_data: &self.surface_data }
    }

    /// Returns a panel for scans of this surface.
    pub(crate) fn panel(&self) -> Panel<R, K::Carried, K::SurfaceData> {
        let mut panel = Panel::new(self.chart(), K::NEEDS_EDGES);
        if self.grid().transposed.is_some() {
            panel.free_edges_back();
        }
        panel
    }

    /// Stores data before the second map that make it and all later ones faster: the parts of all obtuse triangles, and
    /// the edges between columns in the order that scans to the right and left need. Returns whether this call has
    /// stored these edges.
    pub(crate) fn prepare(&mut self) -> bool {
        if !std::mem::replace(&mut self.solved, true) {
            return false;
        }
        self.store_parts();
        let was_filled = self.grid().transposed.is_some();
        if let Some(transposed) = &mut self.transposed {
            transposed.fill(&self.edges, self.settings.instructions);
        }
        !was_filled && self.transposed.is_some()
    }

    /// Lowers the limit to the time that its targets need, given the arrival times.
    pub(crate) fn lower_limit(&mut self, times: &[R]) {
        let chart = self.chart();
        self.settings.limit.lower(|[row, col]| times[chart.bordered(row, col)].wide());
    }

    /// Stores the parts of all obtuse triangles, if that has not been done yet.
    pub(crate) fn store_parts(&self) {
        if K::NEEDS_EDGES {
            self.edges.parts_on_side(Scan::DOWN.back());
        }
    }

    /// Returns the memory in bytes, without the edge lengths and the data stored with them.
    pub(crate) fn bytes(&self) -> usize {
        self.surface_data.bytes()
            + self.transposed.as_ref().map_or(0, TransposedEdges::bytes)
            + self.kind.bytes()
    }
}
