//! Edge lengths: all that the solvers know of a surface.

use std::ops::Range;
use std::sync::OnceLock;

use glam::DVec3;
use rayon::prelude::*;

use super::arc::EdgeRule;
use super::chart::{Chart, Direction};
use super::even_grid::EvenGrid;
use super::gaussian_curvature::gaussian_curvature;
use super::geometry::Geometry;
use super::measure::RowBends;
use super::points::Row;
use super::real::Real;
use super::{Surface, SurfaceError};

/// Shortest length of an edge between distinct points, in the surface's unit.
pub const SHORTEST_EDGE: f64 = 1e-12;
/// Longest length of an edge: squares and sums of such lengths stay within single precision
/// and below [`super::FAR`].
pub const LONGEST_EDGE: f64 = crate::constants::LONGEST_EDGE;

/// Rows that are measured together, so that each row's points and bends serve the next.
const BAND: usize = 32;

/// The lengths of the edges from every grid point to its east, north, north-east and north-west
/// neighbours; the other four are stored at the neighbour. An edge that does not exist (border,
/// hole) is [`Real::FAR`] long.
///
/// A triangle of the update is three such edges, so masks, metrics and slowness need no special
/// case anywhere else. The arrays have a border of missing points, and take 16 bytes a point in
/// single precision.
#[derive(Clone, Debug)]
pub struct EdgeLengths<R> {
    chart: Chart,
    /// One array for each of [`STORED`], so that neighbours' lengths lie side by side.
    lengths: [Vec<R>; 4],
    rule: EdgeRule,
    /// Of floor plans.
    floor: Option<EvenGrid>,
    gaussian_curvature: OnceLock<Vec<R>>,
}

/// The directions stored at a point, in this order, here and in the shaders.
pub(crate) const STORED: [Direction; 4] =
    [Direction::East, Direction::North, Direction::NorthEast, Direction::NorthWest];

/// Where the length of an edge is stored: an offset from the point, and one of [`STORED`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeSlot {
    offset: isize,
    stored: usize,
}

impl EdgeSlot {
    /// Its length at as many points in a row of bordered arrays, one for each of [`STORED`].
    pub(crate) fn row<'a, R>(self, planes: [&'a [R]; 4], first: usize, points: usize) -> &'a [R] {
        &planes[self.stored][first.wrapping_add_signed(self.offset)..][..points]
    }

    /// The edge from the point `at` (an offset from the point that the slot is used for).
    pub(crate) fn new(chart: Chart, at: isize, to: Direction) -> Self {
        match STORED.iter().position(|&direction| direction == to) {
            Some(stored) => Self { offset: at, stored },
            None => Self::new(chart, at + chart.offset(to), to.opposite()),
        }
    }
}

impl<R: Real> EdgeLengths<R> {
    /// Measures the edges of a surface, in parallel over rows.
    ///
    /// In single precision positions are taken relative to the middle of the surface, as on the
    /// device: the rounded points make a surface as good, and both engines see the same one.
    ///
    /// # Errors
    /// [`SurfaceError::EdgeLength`] if a length is neither zero (points that coincide, at a pole
    /// for example) nor between [`SHORTEST_EDGE`] and [`LONGEST_EDGE`]; [`SurfaceError::TooLarge`] if
    /// a height or coordinate there lies beyond the latter.
    pub fn new(surface: &Surface) -> Result<Self, SurfaceError> {
        let (chart, origin) = (surface.chart(), surface.origin());
        // Zeros come without work; every one of them is written below, by many threads at once.
        let mut lengths = [(); 4].map(|_| vec![R::zero(); chart.bordered_points()]);
        for plane in &mut lengths {
            let last = plane.len() - chart.stride();
            plane[..chart.stride()].fill(R::FAR);
            plane[last..].fill(R::FAR);
        }
        let [east, north, north_east, north_west] = &mut lengths;
        let rows = |plane| bordered_rows(chart, plane);
        (rows(east), rows(north), rows(north_east), rows(north_west))
            .into_par_iter()
            .chunks(BAND)
            .enumerate()
            .try_for_each(|(band, mut lines)| {
                let first = band * BAND;
                surface.measure_rows(first..first + lines.len(), origin, |row, lengths| {
                    let (east, north, north_east, north_west) = &mut lines[row - first];
                    for (line, lengths) in
                        [east, north, north_east, north_west].into_iter().zip(lengths)
                    {
                        line[0] = R::FAR;
                        line[1..=chart.cols].copy_from_slice(lengths);
                        line[chart.cols + 1] = R::FAR;
                    }
                })
            })?;
        let (rule, floor) = (surface.edge_rule(), surface.floor());
        Ok(Self { chart, lengths, rule, floor, gaussian_curvature: OnceLock::new() })
    }

    /// The edges between the points of a part of the grid, from its first row and column.
    ///
    /// # Panics
    /// If the grid has no such part.
    pub(crate) fn window(&self, [row, col]: [usize; 2], chart: Chart) -> Self {
        let mut lengths = [(); 4].map(|_| vec![R::FAR; chart.bordered_points()]);
        for ((to, window), whole) in STORED.into_iter().zip(&mut lengths).zip(self.planes()) {
            for line in 0..chart.rows {
                let first = self.chart.bordered(row + line, col);
                let window = &mut window[chart.bordered(line, 0)..][..chart.cols];
                window.copy_from_slice(&whole[first..][..chart.cols]);
                for (at, length) in window.iter_mut().enumerate() {
                    if chart.neighbour(line, at, to).is_none() {
                        *length = R::FAR;
                    }
                }
            }
        }
        let (rule, floor) = (self.rule, self.floor);
        Self { chart, lengths, rule, floor, gaussian_curvature: OnceLock::new() }
    }

    /// The grid's size.
    pub fn chart(&self) -> Chart {
        self.chart
    }

    /// Length of the edge to a neighbour, or [`Real::FAR`] if there is none.
    ///
    /// # Panics
    /// If the grid has no such point.
    pub fn length(&self, row: usize, col: usize, to: Direction) -> R {
        assert!(row < self.chart.rows && col < self.chart.cols, "point outside the grid");
        self.at(self.chart.bordered(row, col), EdgeSlot::new(self.chart, 0, to))
    }

    /// Gaussian curvature at each point of the bordered array, from the lengths alone; see
    /// `gaussian_curvature.rs`. Computed when it is first asked for.
    pub(crate) fn gaussian_curvature(&self) -> &[R] {
        self.gaussian_curvature.get_or_init(|| gaussian_curvature(self))
    }

    /// The grid, if the surface is a floor plan ([`Surface::is_floor_plan`]).
    pub(crate) fn floor(&self) -> Option<EvenGrid> {
        self.floor
    }

    /// The rule by which they were measured.
    pub(crate) fn rule(&self) -> EdgeRule {
        self.rule
    }

    /// Bytes held, with those of the Gaussian curvature once a curved wavefront has asked for it.
    pub fn bytes(&self) -> usize {
        let curvature = self.gaussian_curvature.get().map(Vec::as_slice);
        let planes = self.lengths.iter().map(Vec::as_slice).chain(curvature);
        planes.map(std::mem::size_of_val).sum()
    }

    #[inline]
    pub(crate) fn at(&self, point: usize, slot: EdgeSlot) -> R {
        self.lengths[slot.stored][point.wrapping_add_signed(slot.offset)]
    }

    /// The lengths of an edge of as many points in a row.
    #[inline(always)]
    pub(crate) fn row(&self, first: usize, slot: EdgeSlot, points: usize) -> &[R] {
        &self.lengths[slot.stored][first.wrapping_add_signed(slot.offset)..][..points]
    }

    /// The lengths of all edges to the east, north, north-east and north-west, as bordered arrays.
    pub(crate) fn planes(&self) -> [&[R]; 4] {
        self.lengths.each_ref().map(Vec::as_slice)
    }
}

/// The grid's rows in a bordered array, each with a point of the border at either end.
fn bordered_rows<R: Real>(
    chart: Chart,
    plane: &mut [R],
) -> impl IndexedParallelIterator<Item = &mut [R]> {
    plane.par_chunks_exact_mut(chart.stride()).skip(1).take(chart.rows)
}

/// The grid's rows in a bordered array.
pub(super) fn inner_rows<R: Real>(
    chart: Chart,
    plane: &mut [R],
) -> impl IndexedParallelIterator<Item = &mut [R]> {
    bordered_rows(chart, plane).map(move |row| &mut row[1..=chart.cols])
}

impl Surface {
    /// Whether all edges are of a length that the solvers can handle; see [`EdgeLengths::new`].
    pub fn check_edges(&self) -> Result<(), SurfaceError> {
        let origin = self.origin();
        let bands = self.rows().div_ceil(BAND);
        (0..bands).into_par_iter().map(|band| band * BAND).try_for_each(|first| {
            let rows = first..(first + BAND).min(self.rows());
            self.measure_rows::<f32>(rows, origin, |_, _| ())
        })
    }

    /// Measures the edges stored at the points of some rows in single precision, in parallel, and puts those
    /// of a point side by side as the device's texels have them.
    pub(crate) fn write_edges(
        &self,
        rows: Range<usize>,
        origin: DVec3,
        texels: &mut [[f32; 4]],
    ) -> Result<(), SurfaceError> {
        let cols = self.cols();
        texels.par_chunks_mut(BAND * cols).enumerate().try_for_each(|(band, texels)| {
            let first = rows.start + band * BAND;
            let band = first..first + texels.len() / cols;
            self.measure_rows(band, origin, |row, [east, north, north_east, north_west]| {
                let texels = &mut texels[(row - first) * cols..][..cols];
                for (col, texel) in texels.iter_mut().enumerate() {
                    *texel = [east[col], north[col], north_east[col], north_west[col]];
                }
            })
        })
    }

    /// Measures the edges stored at the points of some rows, and gives them to `store` row by row.
    /// The arithmetic is in `measure.rs`.
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
        // The points of the row before, of this one and of the next two; the bends of two rows before,
        // of this one and of the next, which the first row's three before it are read for.
        let mut points = [(); 4].map(|_| self.row(None, origin));
        let mut around = [(); 4].map(|_| RowBends::none(cols));
        let mut lengths = [(); 4].map(|_| vec![R::FAR; cols]);
        for ahead in rows.start..rows.end + 5 {
            points.rotate_left(1);
            points[3] = self.row(ahead.checked_sub(3), origin);
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

    /// Length of the straight step between two grid points, whatever the rule for edges, weighted
    /// by their mean slowness.
    pub(crate) fn length_between(&self, from: (usize, usize), to: (usize, usize)) -> f64 {
        let chart = self.chart();
        let sample = |(row, col)| self.geometry().sample(chart, row, col);
        let slowness = |(row, col)| self.slowness().map_or(1.0, |s| s[chart.index(row, col)]);
        0.5 * (slowness(from) + slowness(to)) * sample(from).length_to(sample(to))
    }
}

impl Surface {
    /// A value that is no length of any kind, where it makes an edge too long: often it stands for
    /// no data and nobody says so.
    fn cause(&self, error: SurfaceError) -> SurfaceError {
        let SurfaceError::EdgeLength { row, col, .. } = error else { return error };
        let beyond = |value: &f64| value.abs() > LONGEST_EDGE;
        // The bends of an edge depend on as many points around it.
        let rows = row.saturating_sub(3)..(row + 4).min(self.rows());
        for (row, col) in rows.flat_map(|row| {
            let cols = col.saturating_sub(3)..(col + 4).min(self.cols());
            cols.map(move |col| (row, col))
        }) {
            let index = self.chart().index(row, col);
            let value = match self.geometry() {
                _ if !self.has(row, col) => None,
                Geometry::Heights { heights, .. } => Some(heights[index]).filter(beyond),
                Geometry::Positions(at) => at[index].to_array().into_iter().find(beyond),
                Geometry::Metric(_) => None,
            };
            if let Some(value) = value {
                return SurfaceError::TooLarge { what: self.geometry().what(), value, row, col };
            }
        }
        error
    }
}

/// An error at the first edge of a row that is too short or too long.
fn check<R: Real>(row: usize, lengths: &[Vec<R>; 4]) -> Result<(), SurfaceError> {
    for col in 0..lengths[0].len() {
        for (lengths, direction) in lengths.iter().zip(STORED) {
            let length = lengths[col].wide();
            let usual = length == 0.0 || (SHORTEST_EDGE..=LONGEST_EDGE).contains(&length);
            if !usual && length != R::FAR.wide() {
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
        let ([row, col], chart) = ([3, 4], Chart { rows: 4, cols: 8 });
        let window = whole.window([row, col], chart);
        for (r, c) in (0..chart.rows).flat_map(|r| (0..chart.cols).map(move |c| (r, c))) {
            for to in Direction::ALL {
                let there = chart.neighbour(r, c, to).is_some();
                let expected = if there { whole.length(row + r, col + c, to) } else { f32::FAR };
                assert_eq!(window.length(r, c, to), expected, "{r},{c} {to:?}");
            }
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
        // Edges that are too long by the spacing alone are named as before.
        let wide = Surface::from_heights(5, 6, vec![0.0; 30], Spacing::square(1e20)).unwrap();
        let error = wide.check_edges().unwrap_err();
        assert!(matches!(error, SurfaceError::EdgeLength { row: 0, .. }), "{error}");
    }
}
