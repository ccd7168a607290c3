//! Measures the edges of a surface, row by row and in parallel. The arithmetic is in `measure.rs`.

use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock};

use glam::DVec3;
use rayon::prelude::*;

use super::arc::EdgeRule;
use super::chart::STORED;
use super::edges::{EdgeLengths, SharedEdges};
use super::geometry::Geometry;
use super::gluing::strips;
use super::measure::RowBends;
use super::obtuse::cells::{MarkedCells, RowAbove};
use super::obtuse::lists::ObtuseTriangles;
use super::obtuse::parts::SplitParts;
use super::obtuse::reach::of_updates;
use super::points::Row;
use super::precision::same;
use super::real::{LONGEST_EDGE, Real, SHORTEST_EDGE};
use super::{Surface, SurfaceError};

/// Number of rows measured together, so that the next row reuses each row's points and bends.
const BAND: usize = 32;
/// Smallest number of rows that are measured together, where there are many threads.
const LEAST_BAND: usize = 8;

impl<R: Real> EdgeLengths<R> {
    /// Measures the edges of a surface, in parallel over rows.
    ///
    /// In single precision, positions are taken relative to the middle of the surface, as on the device. The
    /// rounded points make an equally good surface, and both engines measure the same points.
    ///
    /// # Errors
    /// [`SurfaceError::EdgeLength`] if a length is neither zero (points that coincide, for example at a pole)
    /// nor between [`SHORTEST_EDGE`] and [`LONGEST_EDGE`]. [`SurfaceError::TooLarge`] if a height or
    /// coordinate at that edge exceeds [`LONGEST_EDGE`].
    pub fn new(surface: &Surface) -> Result<Self, SurfaceError> {
        Self::measured(surface, || Ok(()))
    }

    /// Measures the edges of a surface as [`Self::new`] does, as long as `go_on` does not fail.
    #[doc(hidden)]
    pub fn measured<E: From<SurfaceError> + Send>(
        surface: &Surface,
        go_on: impl Fn() -> Result<(), E> + Sync,
    ) -> Result<Self, E> {
        let failure = Mutex::new(None);
        let goes_on = || match go_on() {
            Ok(()) => true,
            Err(error) => {
                *failure.lock().expect("nothing panics while it is held") = Some(error);
                false
            }
        };
        let measured = Self::measured_from(surface, surface.origin(), &goes_on);
        measured.map_err(|error| match error {
            Some(error) => error.into(),
            None => {
                let failure = failure.into_inner().expect("nothing panics while it is held");
                failure.expect("only a failure ends the work")
            }
        })
    }

    /// Measures the edges of a surface as [`Self::measured`] does, with positions relative to `origin`. The error is
    /// `None` if `goes_on` returns false.
    pub(super) fn measured_from(
        surface: &Surface,
        origin: DVec3,
        goes_on: GoesOn,
    ) -> Result<Self, Option<SurfaceError>> {
        static MEASURED: (Measured<f32>, Measured<f64>) = (measured, measured);
        if size_of::<R>() == size_of::<f32>() {
            Ok(same(MEASURED.0(surface, origin, goes_on)?))
        } else {
            Ok(same(MEASURED.1(surface, origin, goes_on)?))
        }
    }
}

/// Whether to go on, asked before each band of rows.
type GoesOn<'a> = &'a (dyn Fn() -> bool + Sync);

type Measured<R> = fn(&Surface, DVec3, GoesOn) -> Result<EdgeLengths<R>, Option<SurfaceError>>;

/// Measures edges; see [`EdgeLengths::measured_from`].
fn measured<R: Real>(
    surface: &Surface,
    origin: DVec3,
    goes_on: GoesOn,
) -> Result<EdgeLengths<R>, Option<SurfaceError>> {
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
            if !goes_on() {
                return Err(None);
            }
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
            Ok(())
        })?;
    let strips = strips::measured(surface, |part| measured(part, origin, &|| true))?;
    strips::replace_lengths(&strips, chart, &mut lengths);
    let slowness = surface.bordered_slowness();
    // The marks of cells do not hold with a slowness, since they come from weighted lengths, nor on glued
    // surfaces, since lengths beside seams have changed after the marking.
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
        fans: OnceLock::new(),
        obtuse,
        parts: SplitParts::default(),
        copies: surface.copies().map(|groups| groups.mapped(|index| chart.bordered_point(index))),
        strips,
        of_glued: surface.is_glued(),
    };
    Ok(EdgeLengths { shared: Arc::new(shared), beside_a_source: false })
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
    /// triangle with one of these edges may be obtuse at a point that is updated from it, and then the distance from
    /// which updates read points ([`EdgeLengths::reach`]).
    #[doc(hidden)]
    pub fn write_edges(
        &self,
        rows: Range<usize>,
        origin: DVec3,
        texels: &mut [[f32; 4]],
    ) -> Result<Option<usize>, SurfaceError> {
        let cols = self.cols();
        // The bands are so small that all threads have work, although each band also reads the rows around
        // it.
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
            Ok(has_obtuse.then(|| of_updates(row_above.reach)))
        };
        let bands = texels.par_chunks_mut(band_rows * cols).enumerate().map(band_of);
        bands.try_reduce(|| None, |a, b| Ok(a.max(b)))
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
        // `points` holds the points of the row before, this row and the next two. `around` holds the bends of
        // the two rows before, this row and the next. For the first row, reading begins three rows before it.
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
    #[doc(hidden)]
    pub fn length_on_surface(&self, from: (usize, usize), to: (usize, usize)) -> f64 {
        let chart = self.chart();
        let sample = |(row, col)| self.geometry().sample(chart, row, col);
        sample(from).length_to(sample(to))
    }

    /// Returns the length of a step of rows and columns under the metric at a point, or `None` if the surface
    /// is not given by a metric.
    #[doc(hidden)]
    pub fn metric_length(&self, at: (usize, usize), step: [f64; 2]) -> Option<f64> {
        let Geometry::Metric(metric) = self.geometry() else { return None };
        Some(metric[self.chart().index(at.0, at.1)].length(step))
    }
}

impl Surface {
    /// Finds the value that makes an edge too long, if the value itself exceeds [`LONGEST_EDGE`]: often such
    /// a value stands for no data. Returns an error that names it, or else `error`.
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
    use super::*;
    use crate::{Chart, Spacing};

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
