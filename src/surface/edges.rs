//! Edge lengths: all that the solvers know of a surface.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use rayon::prelude::*;

use super::arc::EdgeRule;
use super::chart::{Block, Chart, Direction, EdgeSlot, STORED};
use super::even_grid::EvenGrid;
use super::geometry::Geometry;
use super::gluing::{Groups, Strips};
use super::measure::RowBends;
use super::obtuse::cells::{MarkedCells, RowAbove};
use super::obtuse::lists::ObtuseTriangles;
use super::obtuse::parts::Parts;
use super::points::Row;
use super::real::{LONGEST_EDGE, Real, SHORTEST_EDGE};
use super::{Surface, SurfaceError};

/// Number of rows that are measured together, so that each row's points and bends serve the next row.
const BAND: usize = 32;
/// Smallest number of them, where there are many threads.
const LEAST_BAND: usize = 8;

/// The lengths of the edges from every grid point to its east, north, north-east and north-west neighbours.
/// The edges to the other four neighbours are stored at the neighbour. A missing edge (border, hole) has the
/// length [`Real::FAR`].
///
/// The update of a triangle uses three such edges, so masks, metrics and slowness need no special case
/// anywhere else. The arrays have a border of missing points. They take 16 bytes per point in single
/// precision.
///
/// A clone shares the arrays and whatever solvers compute and store with them, so cloning is cheap. Solvers that
/// live long hold a clone. The memory is freed with the last one.
#[derive(Clone, Debug)]
pub struct EdgeLengths<R> {
    /// The shared arrays. Fast loops borrow an array before they start, so that they do not follow this pointer
    /// for each point.
    pub(super) shared: Arc<SharedEdges<R>>,
    /// See [`Self::front_meets_itself`].
    beside_a_source: bool,
}

/// The data that all clones of [`EdgeLengths`] share.
#[derive(Debug)]
pub(super) struct SharedEdges<R> {
    chart: Chart,
    /// One array for each direction of [`STORED`], so that neighbours' lengths are adjacent in memory.
    lengths: [Vec<R>; 4],
    rule: EdgeRule,
    /// See [`EdgeLengths::front_meets_itself`].
    slowed_unevenly: bool,
    /// See [`EdgeLengths::slowness`].
    slowness: Option<Arc<Vec<R>>>,
    /// See `metric_curvature.rs`.
    pub(super) metric_curvature: Option<Vec<R>>,
    /// The grid of the surface, if it is a floor plan.
    floor: Option<EvenGrid>,
    /// See `gaussian_curvature.rs`. Empty until it is requested.
    pub(super) gaussian_curvature: OnceLock<Arc<Vec<R>>>,
    /// See `obtuse/lists.rs`.
    pub(super) obtuse: ObtuseTriangles,
    /// See `obtuse/parts.rs`.
    pub(super) parts: Parts<R>,
    /// See [`Self::copies`].
    copies: Option<Groups>,
    /// See `gluing/strips.rs`.
    strips: Strips<R>,
    /// Whether the surface, or that of which this is a strip, is glued.
    of_glued: bool,
}

impl<R: Real> EdgeLengths<R> {
    /// Measures the edges of a surface, in parallel over rows.
    ///
    /// In single precision, positions are taken relative to the middle of the surface, as on the device. The
    /// rounded points make an equally good surface, and both engines see the same one.
    ///
    /// # Errors
    /// [`SurfaceError::EdgeLength`] if a length is neither zero (points that coincide, for example at a pole)
    /// nor between [`SHORTEST_EDGE`] and [`LONGEST_EDGE`]. [`SurfaceError::TooLarge`] if a height or
    /// coordinate at that edge exceeds [`LONGEST_EDGE`].
    pub fn new(surface: &Surface) -> Result<Self, SurfaceError> {
        Self::measured(surface, || Ok(()))
    }

    /// Measures the edges of a surface as [`Self::new`] does, as long as `go_on` does not fail.
    pub(crate) fn measured<E: From<SurfaceError> + Send>(
        surface: &Surface,
        go_on: impl Fn() -> Result<(), E> + Sync,
    ) -> Result<Self, E> {
        Self::measured_from(surface, surface.origin(), go_on)
    }

    /// Measures the edges of a surface as [`Self::measured`] does, with positions relative to `origin`.
    pub(super) fn measured_from<E: From<SurfaceError> + Send>(
        surface: &Surface,
        origin: DVec3,
        go_on: impl Fn() -> Result<(), E> + Sync,
    ) -> Result<Self, E> {
        let chart = surface.chart();
        // Zeroed memory costs nothing here; every value is written below, by many threads at once.
        let mut lengths = [(); 4].map(|_| vec![R::zero(); chart.bordered_points()]);
        lengths.iter_mut().for_each(|plane| chart.fill_border_rows(plane, R::FAR));
        let [east, north, north_east, north_west] = &mut lengths;
        let rows = |plane| chart.bordered_rows_mut(plane);
        let mut cells = MarkedCells::none(chart);
        (rows(east), rows(north), rows(north_east), rows(north_west), cells.rows_mut())
            .into_par_iter()
            .chunks(BAND)
            .enumerate()
            .try_for_each(|(band, mut lines)| {
                go_on()?;
                let first = band * BAND;
                let mut row_above = RowAbove::none(chart.cols);
                let band = first.saturating_sub(1)..first + lines.len();
                surface.measure_rows(band, origin, |row, lengths| {
                    row_above.next(lengths);
                    let Some(row) = row.checked_sub(first) else { return };
                    let (east, north, north_east, north_west, marks) = &mut lines[row];
                    marks.copy_from_slice(&row_above.marks);
                    for (line, lengths) in
                        [east, north, north_east, north_west].into_iter().zip(lengths)
                    {
                        let [before, line @ .., after] = &mut **line else { continue };
                        (*before, *after) = (R::FAR, R::FAR);
                        line.copy_from_slice(lengths);
                    }
                })?;
                Ok::<_, E>(())
            })?;
        let strips = Strips::measure(surface, origin)?;
        strips.replace_lengths(surface, &mut lengths);
        let bordered = |index: usize| {
            let (row, col) = chart.position(index);
            chart.bordered(row, col)
        };
        let slowness = surface.bordered_slowness();
        // The cells were marked by other lengths than those of the surface: with a slowness the edges are
        // weighted, and beside seams they have changed since.
        let obtuse = match (slowness.is_some() || surface.is_glued(), cells.any()) {
            (true, _) => ObtuseTriangles::default(),
            (false, true) => ObtuseTriangles::within(cells),
            (false, false) => ObtuseTriangles::none(),
        };
        let shared = SharedEdges {
            chart,
            lengths,
            rule: surface.edge_rule(),
            slowed_unevenly: surface.is_slowed_unevenly(),
            slowness: slowness.map(Arc::new),
            metric_curvature: surface.metric_curvature(),
            floor: surface.floor(),
            gaussian_curvature: OnceLock::new(),
            obtuse,
            parts: Parts::default(),
            copies: surface.copies().map(|groups| groups.mapped(bordered)),
            strips,
            of_glued: surface.is_glued(),
        };
        Ok(Self { shared: Arc::new(shared), beside_a_source: false })
    }

    /// Returns the edges between the points of a part of the grid.
    ///
    /// # Panics
    /// If the grid has no such part.
    pub(crate) fn window(&self, block: &Block) -> Self {
        let (chart, (row, col)) = (block.chart(), block.first());
        let mut lengths = [(); 4].map(|_| vec![R::FAR; chart.bordered_points()]);
        for ((to, window), whole) in STORED.into_iter().zip(&mut lengths).zip(self.planes()) {
            for line in 0..chart.rows {
                let first = self.chart().bordered(row + line, col);
                let window = chart.row_of_mut(window, line);
                window.copy_from_slice(&whole[first..][..chart.cols]);
                for (at, length) in window.iter_mut().enumerate() {
                    if chart.neighbour(line, at, to).is_none() {
                        *length = R::FAR;
                    }
                }
            }
        }
        let cut = |whole: &[R], outside: R| {
            let mut window = vec![outside; chart.bordered_points()];
            for line in 0..chart.rows {
                let first = self.chart().bordered(row + line, col);
                chart.row_of_mut(&mut window, line).copy_from_slice(&whole[first..][..chart.cols]);
            }
            window
        };
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
            obtuse: Default::default(),
            parts: Parts::default(),
            copies: None,
            strips: Strips::default(),
            of_glued: false,
        };
        Self { shared: Arc::new(shared), beside_a_source: self.beside_a_source }
    }

    /// Returns whether the front of a single source may meet itself from cell to cell, as the fronts of
    /// several sources do. It may if the slowness is uneven, or if there are obtuse triangles, as on steep
    /// surfaces.
    pub(crate) fn front_meets_itself(&self) -> bool {
        !self.beside_a_source && (self.shared.slowed_unevenly || self.has_obtuse_triangles())
    }

    /// Returns these edges for a region around a single source, in which the front has not gone far enough to
    /// meet itself.
    pub(crate) fn beside_a_source(mut self) -> Self {
        self.beside_a_source = true;
        self
    }

    /// Returns these edges as those of a strip of a glued surface.
    pub(super) fn of_glued(mut self) -> Self {
        let shared = Arc::get_mut(&mut self.shared);
        shared.expect("edges that have just been measured have no clones").of_glued = true;
        self
    }

    /// Returns the groups of points that are one point of the surface, by their indices in bordered arrays, if
    /// the surface is glued.
    pub(crate) fn copies(&self) -> Option<&Groups> {
        self.shared.copies.as_ref()
    }

    /// Corrects the Gaussian curvature of a glued surface beside its seams.
    pub(super) fn across_seams(&self, curvature: &mut [R]) {
        if self.shared.of_glued {
            self.shared.strips.replace_curvature(self, curvature);
            self.share_curvature(curvature);
        }
    }

    /// Writes the lengths stored at the points of some rows, in the layout of [`Surface::write_edges`].
    pub(crate) fn write_texels(&self, rows: Range<usize>, texels: &mut [[R; 4]]) {
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
    pub(crate) fn slowness(&self) -> Option<&[R]> {
        self.shared.slowness.as_ref().map(|slowness| slowness.as_slice())
    }

    /// Returns the array of [`Self::slowness`] for data that may outlive these edges.
    pub(crate) fn shared_slowness(&self) -> Option<Arc<Vec<R>>> {
        self.shared.slowness.clone()
    }

    /// Returns the grid's size.
    pub fn chart(&self) -> Chart {
        self.shared.chart
    }

    /// Returns the length of the edge to a neighbour, or [`Real::FAR`] if there is none.
    ///
    /// # Panics
    /// If the grid has no such point.
    pub fn length(&self, row: usize, col: usize, to: Direction) -> R {
        let chart = self.chart();
        assert!(row < chart.rows && col < chart.cols, "point outside the grid");
        self.at(chart.bordered(row, col), EdgeSlot::of(chart, to))
    }

    /// Returns the even grid if the surface is a floor plan ([`Surface::is_floor_plan`]).
    pub(crate) fn floor(&self) -> Option<EvenGrid> {
        self.shared.floor
    }

    /// Returns the rule by which the edges were measured.
    pub(crate) fn rule(&self) -> EdgeRule {
        self.shared.rule
    }

    /// Returns the number of bytes held. This includes the Gaussian curvature and the parts of obtuse
    /// triangles once a solver has requested them.
    pub fn bytes(&self) -> usize {
        let SharedEdges {
            metric_curvature, gaussian_curvature, obtuse, parts, strips, copies, ..
        } = &*self.shared;
        let curvature = gaussian_curvature.get().map(|curvature| curvature.as_slice());
        let planes = self.planes().into_iter().chain(curvature);
        let planes = planes.chain(self.slowness()).chain(metric_curvature.as_deref());
        let glued = strips.bytes() + copies.as_ref().map_or(0, Groups::bytes);
        let found = obtuse.bytes() + parts.bytes();
        planes.map(std::mem::size_of_val).sum::<usize>() + found + glued
    }

    #[inline]
    pub(crate) fn at(&self, point: usize, slot: EdgeSlot) -> R {
        self.shared.lengths[slot.stored][slot.offset.from(point)]
    }

    /// Returns the lengths of the edges in one slot for `points` points of a row, beginning with `first`.
    #[inline(always)]
    pub(crate) fn row(&self, first: usize, slot: EdgeSlot, points: usize) -> &[R] {
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
    pub(crate) fn planes(&self) -> [&[R]; 4] {
        self.shared.lengths.each_ref().map(Vec::as_slice)
    }
}

impl Surface {
    /// Checks that the solvers can handle the lengths of all edges; see [`EdgeLengths::new`].
    pub fn check_edges(&self) -> Result<(), SurfaceError> {
        let origin = self.origin();
        let bands = self.rows().div_ceil(BAND);
        (0..bands).into_par_iter().map(|band| band * BAND).try_for_each(|first| {
            let rows = first..(first + BAND).min(self.rows());
            self.measure_rows::<f32>(rows, origin, |_, _| ())
        })
    }

    /// Measures the edges stored at the points of some rows in single precision, in parallel. The four
    /// lengths of a point are written side by side, in the layout of the device's texels. Returns whether any
    /// triangle with one of these edges is obtuse at a point that is updated from it.
    pub(crate) fn write_edges(
        &self,
        rows: Range<usize>,
        origin: DVec3,
        texels: &mut [[f32; 4]],
    ) -> Result<bool, SurfaceError> {
        let cols = self.cols();
        // All threads have work, although each band also reads the rows around it.
        let band_rows = rows.len().div_ceil(rayon::current_num_threads()).clamp(LEAST_BAND, BAND);
        let band_of = |(band, texels): (usize, &mut [[f32; 4]])| {
            let first = rows.start + band * band_rows;
            let band = first.saturating_sub(1)..first + texels.len() / cols;
            let (mut row_above, mut has_obtuse) = (RowAbove::none(cols), false);
            self.measure_rows(band, origin, |row, lengths| {
                row_above.next(lengths);
                has_obtuse |= row_above.marks.contains(&true);
                let Some(line) = row.checked_sub(first) else { return };
                let [east, north, north_east, north_west] = lengths;
                let texels = &mut texels[line * cols..][..cols];
                for (col, texel) in texels.iter_mut().enumerate() {
                    *texel = [east[col], north[col], north_east[col], north_west[col]];
                }
            })?;
            Ok(has_obtuse)
        };
        let bands = texels.par_chunks_mut(band_rows * cols).enumerate().map(band_of);
        bands.try_reduce(|| false, |a, b| Ok(a | b))
    }

    /// Measures the edges stored at the points of some rows, and passes them to `store` row by row. The
    /// arithmetic is in `measure.rs`.
    fn measure_rows<R: Real>(
        &self,
        rows: Range<usize>,
        origin: DVec3,
        mut store: impl FnMut(usize, &[Vec<R>; 4]),
    ) -> Result<(), SurfaceError> {
        let cols = self.cols();
        let bends = |rows: [&Row<R>; 3], bends: &mut RowBends<R>| {
            if self.edge_rule() == EdgeRule::Arc {
                self.bend_row(rows, bends);
            }
        };
        // `points` are those of the row before, this row and the next two. `around` are the bends of the two
        // rows before, this row and the next. For the first row, reading begins three rows before it.
        let mut points = [(); 4].map(|_| Row::missing(cols));
        let mut around = [(); 4].map(|_| RowBends::none(cols));
        let mut lengths = [(); 4].map(|_| vec![R::FAR; cols]);
        for ahead in rows.start..rows.end + 5 {
            points.rotate_left(1);
            points[3] = self.row(ahead as isize - 3, origin);
            around.rotate_left(1);
            bends([&points[1], &points[2], &points[3]], &mut around[3]);
            let Some(row) = ahead.checked_sub(5).filter(|row| rows.contains(row)) else { continue };
            if self.measure_row([&points[0], &points[1]], around.each_ref(), &mut lengths) {
                check(row, &lengths).map_err(|error| self.cause(error))?;
            }
            store(row, &lengths);
        }
        Ok(())
    }

    /// Returns the length of the straight step between two grid points, without slowness, whatever the rule
    /// for edges.
    pub(crate) fn length_on_surface(&self, from: (usize, usize), to: (usize, usize)) -> f64 {
        let chart = self.chart();
        let sample = |(row, col)| self.geometry().sample(chart, row, col);
        sample(from).length_to(sample(to))
    }

    /// Returns the length of a step of rows and columns under the metric at a point, or `None` if the surface
    /// is not given by a metric.
    pub(crate) fn metric_length(&self, at: (usize, usize), step: [f64; 2]) -> Option<f64> {
        let Geometry::Metric(metric) = self.geometry() else { return None };
        Some(metric[self.chart().index(at.0, at.1)].length(step))
    }
}

impl Surface {
    /// Finds the value that makes an edge too long, if the value itself exceeds [`LONGEST_EDGE`]: often it
    /// stands for no data. Returns an error that names it, or else `error`.
    fn cause(&self, error: SurfaceError) -> SurfaceError {
        let SurfaceError::EdgeLength { row, col, length, .. } = error else { return error };
        let value = |(row, col)| {
            let index = self.chart().index(row, col);
            let value = self.geometry().beyond(index, LONGEST_EDGE);
            Some((row, col, value.filter(|_| self.has(row, col))?))
        };
        // The bends of an edge depend on points up to three rows and columns around it.
        let near = || self.chart().around((row, col), 3).places().find_map(value);
        // A value that moves the middle of the surface beyond single precision spoils all edges.
        let anywhere = || {
            let points = (0..self.chart().points()).map(|index| self.chart().position(index));
            points.filter_map(value).reduce(|a, b| if b.2.abs() > a.2.abs() { b } else { a })
        };
        let found = if length.is_finite() { near() } else { anywhere() };
        found.map_or(error, |(row, col, value)| SurfaceError::TooLarge {
            what: self.geometry().what(),
            value,
            row,
            col,
        })
    }
}

/// Returns an error at the first edge of a row that is too short or too long.
fn check<R: Real>(row: usize, lengths: &[Vec<R>; 4]) -> Result<(), SurfaceError> {
    for col in 0..lengths[0].len() {
        for (lengths, direction) in lengths.iter().zip(STORED) {
            let length = lengths[col].wide();
            let usual = length == 0.0 || (SHORTEST_EDGE..=LONGEST_EDGE).contains(&length);
            if !usual && length != R::FAR.wide() {
                // A NaN comes from an edge so long that its square overflows: its bend is the difference of
                // two infinities.
                let length = if length.is_nan() { f64::INFINITY } else { length };
                return Err(SurfaceError::EdgeLength { row, col, direction, length });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::builtin::Builtin;
    use super::*;
    use crate::surface::Spacing;

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

    proptest::proptest! {
        /// The error names the largest value, however large it is and wherever it lies.
        #[test]
        fn the_largest_value_is_named(
            (rows, cols) in (1usize..20, 2usize..90),
            at in 0.0..1.0f64,
            exponent in 13i32..308,
            axis in 0usize..4,
            negative: bool,
        ) {
            let at = (at * (rows * cols) as f64) as usize;
            let value = if negative { -1.0 } else { 1.0 } * 10f64.powi(exponent);
            let chart = Chart { rows, cols };
            let surface = if axis == 3 {
                let mut heights = vec![0.5; rows * cols];
                heights[at] = value;
                Surface::from_heights(rows, cols, heights, Spacing::square(1.0)).unwrap()
            } else {
                let place = |(row, col)| DVec3::new(col as f64, row as f64, 1.0);
                let mut positions: Vec<_> = chart.places().map(place).collect();
                positions[at][axis] = value;
                Surface::from_positions(rows, cols, positions).unwrap()
            };
            let error = surface.check_edges().unwrap_err();
            let (row, col) = chart.position(at);
            let what = surface.geometry().what();
            proptest::prop_assert_eq!(error, SurfaceError::TooLarge { what, value, row, col });
        }
    }

    #[test]
    fn a_value_that_stands_for_no_data_is_named() {
        let mut heights = vec![0.0; 30];
        heights[3 * 6 + 4] = -3.4e38;
        let spacing = Spacing::square(1.0);
        let surface = Surface::from_heights(5, 6, heights.clone(), spacing).unwrap();
        let positions = heights
            .iter()
            .zip(0..)
            .map(|(&height, k)| DVec3::new(f64::from(k % 6), f64::from(k / 6), height));
        let bent = Surface::from_positions(5, 6, positions.collect()).unwrap();
        for (surface, what) in [(&surface, "height"), (&bent, "position")] {
            for rule in [EdgeRule::Arc, EdgeRule::Chord] {
                let error = surface.clone().with_edge_rule(rule).check_edges().unwrap_err();
                let named = SurfaceError::TooLarge { what, value: -3.4e38, row: 3, col: 4 };
                assert_eq!(error, named);
                assert!(error.to_string().contains("no data"), "{error}");
            }
            let mut mask = [true; 30];
            mask[3 * 6 + 4] = false;
            assert_eq!(surface.clone().with_mask(&mask).unwrap().check_edges(), Ok(()));
        }
        // Edges that are too long because of the spacing alone are still reported as edges.
        let wide = Surface::from_heights(5, 6, vec![0.0; 30], Spacing::square(1e20)).unwrap();
        let error = wide.check_edges().unwrap_err();
        assert!(matches!(error, SurfaceError::EdgeLength { row: 0, .. }), "{error}");
        let wider = Surface::from_heights(5, 6, vec![0.0; 30], Spacing::square(1e300)).unwrap();
        let message = wider.check_edges().unwrap_err().to_string();
        assert!(message.contains("is inf units long"), "{message}");
    }
}
