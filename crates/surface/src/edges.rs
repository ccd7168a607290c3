//! Edge lengths, the solvers' only knowledge of a surface.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use super::arc::EdgeRule;
use super::chart::{Block, Chart, Direction, EdgeSlot, STORED};
use super::even_grid::EvenGrid;
use super::fan::Fan;
use super::gluing::Groups;
use super::obtuse::lists::ObtuseTriangles;
use super::obtuse::parts::SplitParts;
use super::real::Real;

/// The lengths of the edges from every grid point to its east, north, north-east and north-west neighbours.
/// The edges to the other four neighbours are stored at the neighbour. A missing edge (border, hole) has the
/// length [`Real::FAR`].
///
/// The update of a triangle uses three such edges, so it needs no special case for masks and metrics. The arrays have a
/// border of missing points. They take 16 bytes per point in single precision.
///
/// A clone shares the arrays and the data that solvers compute and store with them, so cloning is cheap. Long-lived
/// solvers own a clone. The memory is freed with the last clone.
#[derive(Clone, Debug)]
pub struct EdgeLengths<R> {
    /// The shared arrays. Fast loops borrow an array before they start, so that they do not follow this pointer
    /// for each point.
    pub(super) shared: Arc<SharedEdges<R>>,
    /// See [`Self::front_meets_itself`].
    pub(super) beside_a_source: bool,
}

/// The data that all clones of [`EdgeLengths`] share.
#[derive(Debug)]
pub(super) struct SharedEdges<R> {
    pub(super) chart: Chart,
    /// One array for each direction of [`STORED`], so that neighbours' lengths are adjacent in memory.
    pub(super) lengths: [Vec<R>; 4],
    pub(super) rule: EdgeRule,
    /// See [`EdgeLengths::front_meets_itself`].
    pub(super) slowed_unevenly: bool,
    /// See [`EdgeLengths::slowness`].
    pub(super) slowness: Option<Arc<Vec<R>>>,
    /// See `metric_curvature.rs`.
    pub(super) metric_curvature: Option<Vec<R>>,
    /// The grid of the surface, if it is a floor plan.
    pub(super) floor: Option<EvenGrid>,
    /// See `gaussian_curvature.rs`. Empty until it is requested.
    pub(super) gaussian_curvature: OnceLock<Arc<Vec<R>>>,
    /// See `fan/mod.rs`. Empty until they are requested.
    pub(super) fans: OnceLock<Arc<Vec<Fan<R>>>>,
    /// See `obtuse/lists.rs`.
    pub(super) obtuse: ObtuseTriangles,
    /// See `obtuse/parts.rs`.
    pub(super) parts: SplitParts<R>,
    /// See [`EdgeLengths::copies`].
    pub(super) copies: Option<Groups>,
    /// Strips of the grid across its seams.
    pub(super) strips: Vec<Strip<R>>,
    /// Whether these are the edges of a glued surface or of a strip of one.
    pub(super) of_glued: bool,
}

/// A part of a grid that goes on over a seam, measured like any surface. Its values replace the grid's own values
/// beside the seam, since those values depend on points beyond the seam (`gluing/strips.rs`).
#[derive(Clone, Debug)]
pub(super) struct Strip<R> {
    pub edges: EdgeLengths<R>,
    /// Row and column of the strip's first point.
    pub first: (isize, isize),
    /// The points of the grid that take their values from the strip.
    pub block: Block,
}

impl<R: Real> EdgeLengths<R> {
    /// Returns the edges between the points of a part of the grid.
    ///
    /// # Panics
    /// If the grid has no such part.
    #[doc(hidden)]
    pub fn window(&self, block: &Block) -> Self {
        let (chart, (row, col)) = (block.chart(), block.first());
        let cut = |whole: &[R], outside: R| {
            let mut window = vec![outside; chart.bordered_points()];
            for line in 0..chart.rows {
                let first = self.chart().bordered(row + line, col);
                chart.row_of_mut(&mut window, line).copy_from_slice(&whole[first..][..chart.cols]);
            }
            window
        };
        let mut lengths = self.planes().map(|whole| cut(whole, R::FAR));
        for (to, lengths) in STORED.into_iter().zip(&mut lengths) {
            let ends = |&(row, col): &(usize, usize)| chart.neighbour(row, col, to).is_none();
            for (row, col) in chart.places().filter(ends) {
                lengths[chart.bordered(row, col)] = R::FAR;
            }
        }
        let metric = self.shared.metric_curvature.as_deref();
        let shared = SharedEdges {
            chart,
            lengths,
            rule: self.shared.rule,
            slowed_unevenly: self.shared.slowed_unevenly,
            slowness: self.slowness().map(|whole| Arc::new(cut(whole, R::one()))),
            metric_curvature: metric.map(|whole| cut(whole, R::nan())),
            floor: self.shared.floor,
            gaussian_curvature: OnceLock::new(),
            fans: OnceLock::new(),
            obtuse: Default::default(),
            parts: SplitParts::default(),
            copies: None,
            strips: Vec::new(),
            of_glued: false,
        };
        Self { shared: Arc::new(shared), beside_a_source: self.beside_a_source }
    }

    /// Returns whether the front of a single source may meet itself, as the fronts of several sources meet each other.
    /// This is possible if the slowness is uneven, or if there are obtuse triangles, as on steep surfaces.
    #[doc(hidden)]
    #[inline]
    pub fn front_meets_itself(&self) -> bool {
        !self.beside_a_source && (self.shared.slowed_unevenly || self.has_obtuse_triangles())
    }

    /// Returns these edges for a region around a single source, in which the front has not gone far enough to
    /// meet itself.
    #[doc(hidden)]
    #[inline]
    pub fn beside_a_source(mut self) -> Self {
        self.beside_a_source = true;
        self
    }

    /// Returns, for a glued surface, the groups of copies of one surface point, by their indices in bordered arrays.
    #[doc(hidden)]
    #[inline]
    pub fn copies(&self) -> Option<&Groups> {
        self.shared.copies.as_ref()
    }

    /// Writes the lengths stored at the points of some rows, in the layout of [`Surface::write_edges`].
    #[doc(hidden)]
    pub fn write_texels(&self, rows: Range<usize>, texels: &mut [[R; 4]]) {
        let (chart, planes) = (self.chart(), self.planes());
        for (line, texels) in rows.zip(texels.chunks_exact_mut(chart.cols)) {
            for (col, texel) in texels.iter_mut().enumerate() {
                *texel = planes.map(|plane| plane[chart.bordered(line, col)]);
            }
        }
    }

    /// Returns the slowness at each point of the bordered array, or `None` if it is the same everywhere. The
    /// length of an edge on the surface is the stored length divided by the mean slowness of its ends. The
    /// value is 1 where there is no point.
    #[doc(hidden)]
    #[inline]
    pub fn slowness(&self) -> Option<&[R]> {
        self.shared.slowness.as_ref().map(|slowness| slowness.as_slice())
    }

    /// Returns the array of [`Self::slowness`] for data that may outlive these edges.
    #[doc(hidden)]
    #[inline]
    pub fn shared_slowness(&self) -> Option<Arc<Vec<R>>> {
        self.shared.slowness.clone()
    }

    /// Returns the grid's size.
    #[inline]
    pub fn chart(&self) -> Chart {
        self.shared.chart
    }

    /// Returns the length of the edge to a neighbour, or [`Real::FAR`] if there is none.
    ///
    /// # Panics
    /// If the grid has no such point.
    #[inline]
    pub fn length(&self, row: usize, col: usize, to: Direction) -> R {
        let chart = self.chart();
        assert!(row < chart.rows && col < chart.cols, "point outside the grid");
        self.at(chart.bordered(row, col), EdgeSlot::of(chart, to))
    }

    /// Returns the even grid if the surface is a floor plan ([`Surface::is_floor_plan`]).
    #[doc(hidden)]
    #[inline]
    pub fn floor(&self) -> Option<EvenGrid> {
        self.shared.floor
    }

    /// Returns the rule by which the edges were measured.
    #[inline]
    pub(crate) fn rule(&self) -> EdgeRule {
        self.shared.rule
    }

    /// Returns the memory in bytes. This includes the Gaussian curvature and the parts of obtuse triangles once a
    /// solver has requested them.
    pub fn bytes(&self) -> usize {
        let SharedEdges {
            metric_curvature, gaussian_curvature, obtuse, parts, strips, copies, ..
        } = &*self.shared;
        let curvature = gaussian_curvature.get().map(|curvature| curvature.as_slice());
        let planes = self.planes().into_iter().chain(curvature);
        let planes = planes.chain(self.slowness()).chain(metric_curvature.as_deref());
        let of_strips: usize = strips.iter().map(|strip| strip.edges.bytes()).sum();
        let glued = of_strips + copies.as_ref().map_or(0, Groups::bytes);
        let found = obtuse.bytes() + parts.bytes();
        planes.map(std::mem::size_of_val).sum::<usize>() + found + glued
    }

    #[inline]
    #[doc(hidden)]
    pub fn at(&self, point: usize, slot: EdgeSlot) -> R {
        self.shared.lengths[slot.stored][slot.offset.from(point)]
    }

    /// Returns the lengths of the edges in one slot for `points` points of a row, beginning with `first`.
    #[inline(always)]
    #[doc(hidden)]
    pub fn row(&self, first: usize, slot: EdgeSlot, points: usize) -> &[R] {
        &self.shared.lengths[slot.stored][slot.offset.from(first)..][..points]
    }

    /// Returns two sets of eight lengths for each of a row's points in `cols`: the lengths of its edges, and
    /// the lengths of the bases, each from the end of one edge to the end of the next.
    #[inline(always)]
    pub(crate) fn fans(&self, row: usize, cols: Range<usize>) -> [[&[R]; 8]; 2] {
        let chart = self.chart();
        let first = chart.bordered(row, cols.start);
        let along = |slot: EdgeSlot| self.row(first, slot, cols.len());
        [
            Direction::ALL.map(|to| along(EdgeSlot::of(chart, to))),
            Direction::ALL.map(|to| along(EdgeSlot::new(chart, chart.offset(to), to.base()))),
        ]
    }

    /// Returns the slowness at each of a row's points in `cols` and at its eight neighbours, if the slowness
    /// is uneven.
    #[inline(always)]
    pub(crate) fn fan_slowness(&self, row: usize, cols: Range<usize>) -> Option<(&[R], [&[R]; 8])> {
        let (slowness, first) = (self.slowness()?, self.chart().bordered(row, cols.start));
        let along = |first: usize| &slowness[first..][..cols.len()];
        Some((along(first), Direction::ALL.map(|to| along(self.chart().beside(first, to)))))
    }

    /// Returns the lengths of all edges to the east, north, north-east and north-west, as bordered arrays.
    #[doc(hidden)]
    #[inline]
    pub fn planes(&self) -> [&[R]; 4] {
        self.shared.lengths.each_ref().map(Vec::as_slice)
    }
}

#[cfg(test)]
mod tests {
    use super::super::builtin::Builtin;
    use super::*;

    #[test]
    fn a_window_has_the_edges_between_its_points() {
        let whole = EdgeLengths::<f32>::new(&Builtin::Peaks.surface(9, 12).unwrap()).unwrap();
        let block = Block { rows: 3..7, cols: 4..12 };
        let (window, chart, (row, col)) = (whole.window(&block), block.chart(), block.first());
        for (r, c) in chart.places() {
            for to in Direction::ALL {
                let there = chart.neighbour(r, c, to).is_some();
                let expected = if there { whole.length(row + r, col + c, to) } else { f32::FAR };
                assert_eq!(window.length(r, c, to), expected, "{r},{c} {to:?}");
            }
        }
    }
}
