//! Samples a surface at every second point, to compare two resolutions.

use std::collections::BTreeSet;

use glam::DVec2;

use super::{Chart, Direction, GluingError, Source, Sources, Surface, SurfaceError};

/// A surface on about every second row and column of a finer surface, with the numbers of these rows and
/// columns.
///
/// ```
/// use geosweep::{Surface, Spacing};
/// let surface = Surface::from_heights(6, 9, vec![0.0; 54], Spacing::square(1.0))?;
/// let coarse = surface.coarsened(&[[3, 4]])?;
/// assert_eq!(coarse.rows(), [0, 1, 3, 5]);
/// assert_eq!(coarse.cols(), [0, 2, 4, 6, 8]);
/// assert_eq!(coarse.surface().position(2, 2), surface.position(3, 4));
/// # Ok::<(), geosweep::surface::SurfaceError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Coarsened {
    surface: Surface,
    fine: Chart,
    rows: Vec<usize>,
    cols: Vec<usize>,
}

impl Surface {
    /// Returns the surface on every second row and column. The points `through` stay grid points, so that
    /// sources there are grid points of both surfaces. Where points of `through` are too close together for
    /// that, earlier ones take precedence. With a metric only the first one counts.
    ///
    /// The first and the last row and column stay too. Where the number of points requires it, there is a single step
    /// between two rows or columns, at an end or half-way between two points of `through`. A metric is given per step,
    /// so a surface with a metric leaves out ends instead. A side of one point stays one point. Slowness and positions
    /// are those of the points that stay. Holes stay holes. Where a wall would fall between two points that stay, one
    /// of them becomes a hole, so that any path on the coarse surface exists on the fine one.
    ///
    /// The coarse surface is glued as this one is. Of the copies of a point on a seam, either all stay or none, and
    /// points of `through` may get lost for that. Lines of holes between charts stay too.
    ///
    /// # Errors
    /// If a side has two points, or both sides have one, or only holes would be left;
    /// [`GluingError::Uneven`] if the seams would not meet.
    pub fn coarsened(&self, through: &[[usize; 2]]) -> Result<Coarsened, SurfaceError> {
        let fine = self.chart();
        let too_small = || SurfaceError::TooSmall { rows: fine.rows, cols: fine.cols };
        if fine.rows == 2 || fine.cols == 2 || fine.points() == 1 {
            return Err(too_small());
        }
        let [rows, cols] = self.coarse_lines(through)?;
        let kept: Vec<usize> = rows
            .iter()
            .flat_map(|&row| cols.iter().map(move |&col| fine.index(row, col)))
            .collect();
        let step = |points: usize| if points > 1 { 2.0 } else { 1.0 };
        let geometry = self.geometry().coarsened(fine, &kept, [step(fine.rows), step(fine.cols)]);
        let surface = Self::new(rows.len(), cols.len(), geometry);
        let mut present: Vec<bool> = kept.iter().map(|&index| self.present()[index]).collect();
        keep_walls(self, &rows, &cols, through, &mut present);
        let surface = surface.and_then(|surface| surface.with_mask(&present));
        let surface = match surface {
            Err(SurfaceError::NoPoint) => Err(too_small()),
            surface => surface,
        }?;
        let surface = surface.with_slowness_of(self, &kept).with_edge_rule(self.edge_rule());
        let surface = surface.glued_like(self, &kept)?;
        Ok(Coarsened { surface, fine, rows, cols })
    }

    /// Returns the rows and columns of the coarse grid.
    fn coarse_lines(&self, through: &[[usize; 2]]) -> Result<[Vec<usize>; 2], SurfaceError> {
        let Chart { rows, cols } = self.chart();
        let evenly = !self.geometry().has_positions();
        let ends = [[0, 0], [rows - 1, cols - 1]];
        // If seams would not meet, the second attempt ignores the points of `through`, and the third one counts in
        // steps of two from both ends.
        for through in [through, &[], &ends] {
            let lines = |points, axis: usize| {
                let through: Vec<usize> = through.iter().map(|point| point[axis]).collect();
                every_second(points, &through, evenly)
            };
            let lines = self.with_gaps([lines(rows, 0), lines(cols, 1)]);
            if self.seams_meet(&lines) {
                return Ok(lines);
            }
        }
        let size = |points: usize| (points - 1).next_multiple_of(4) + 1;
        Err(GluingError::Uneven { rows: size(rows), cols: size(cols) }.into())
    }

    /// Adds the lines of holes between charts that would fall between two lines, if the surface is glued.
    fn with_gaps(&self, lines: [Vec<usize>; 2]) -> [Vec<usize>; 2] {
        if !self.is_glued() {
            return lines;
        }
        let Chart { rows, cols } = self.chart();
        let [of_rows, of_cols] = lines;
        let added = |kept: Vec<usize>, is_gap: &dyn Fn(usize) -> bool| -> Vec<usize> {
            let between = kept.windows(2).flat_map(|pair| pair[0] + 1..pair[1]);
            let gaps: Vec<usize> = between.filter(|&line| is_gap(line)).collect();
            let mut all = [kept, gaps].concat();
            all.sort_unstable();
            all
        };
        [
            added(of_rows, &|row| (0..cols).all(|col| !self.has(row, col))),
            added(of_cols, &|col| (0..rows).all(|row| !self.has(row, col))),
        ]
    }
}

/// Returns every second index of a side of `points` points. Indices in `through` are included where possible. The first
/// of them is always included if there are more than three points. Both ends are included, unless `evenly` asks for
/// even steps.
fn every_second(points: usize, through: &[usize], evenly: bool) -> Vec<usize> {
    // Three points make one step of two from end to end. With the middle point they would make two steps of one.
    let mut fixed = vec![if points > 3 { through.first().copied().unwrap_or(0) } else { 0 }];
    if !evenly && points > 3 {
        for &line in through {
            let fits = |other: usize| {
                let apart = line.abs_diff(other);
                apart.is_multiple_of(2) || apart >= BETWEEN_SINGLE_STEPS
            };
            if fixed.iter().all(|&other| other != line && fits(other)) {
                fixed.push(line);
            }
        }
        fixed.sort_unstable();
    }
    let (low, high) = (fixed[0], fixed[fixed.len() - 1]);
    let mut kept: Vec<usize> = (low % 2..low).step_by(2).collect();
    for pair in fixed.windows(2) {
        let length = pair[1] - pair[0];
        let middle = if length % 2 == 1 { pair[0] + length / 4 * 2 + 1 } else { pair[1] };
        kept.extend((pair[0]..middle).step_by(2).chain((middle..pair[1]).step_by(2)));
    }
    kept.extend((high..points).step_by(2));
    if !evenly && kept[0] > 0 {
        kept.insert(0, 0);
    }
    if !evenly && kept.last() != Some(&(points - 1)) {
        kept.push(points - 1);
    }
    kept
}

/// Minimum distance of two points with a single step between them. With closer points the grid would hardly be coarser.
const BETWEEN_SINGLE_STEPS: usize = 8;

/// Makes one of two neighbours a hole if there is a hole between them on the fine surface: the first, unless that is a
/// point of `through`. No diagonal passes through the wall either: a diagonal needs a third corner of the cell, and on
/// the two sides of the cell at that corner nothing is missing.
fn keep_walls(
    fine: &Surface,
    rows: &[usize],
    cols: &[usize],
    through: &[[usize; 2]],
    present: &mut [bool],
) {
    let chart = Chart { rows: rows.len(), cols: cols.len() };
    let through: BTreeSet<_> = through.iter().copied().collect();
    for index in 0..chart.points() {
        let (i, j) = chart.position(index);
        for to in [Direction::East, Direction::South] {
            let Some((k, l)) = chart.neighbour(i, j, to) else { continue };
            let other = chart.index(k, l);
            let between = (rows[i].midpoint(rows[k]), cols[j].midpoint(cols[l]));
            if present[index] && present[other] && !fine.has(between.0, between.1) {
                let lost = if through.contains(&[rows[i], cols[j]]) { other } else { index };
                present[lost] = false;
            }
        }
    }
}

impl Coarsened {
    /// Returns the coarse surface.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Returns the rows of the fine surface that are left, in order.
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Returns the columns of the fine surface that are left, in order.
    pub fn cols(&self) -> &[usize] {
        &self.cols
    }

    /// Returns the coarse points as indices into the fine surface's arrays, row-major.
    pub fn indices(&self) -> impl Iterator<Item = usize> {
        let fine = self.fine;
        self.rows.iter().flat_map(move |&row| self.cols.iter().map(move |&c| fine.index(row, c)))
    }

    /// Converts the fine surface's sources to coarse rows and columns.
    ///
    /// A curve gets an additional vertex wherever the steps between rows or columns change, since its segments would
    /// not stay straight there. Where the curve passes a seam, it gets no vertex between the two copies of the place.
    pub fn sources(&self, fine: &Sources) -> Sources {
        fine.iter().fold(Sources::default(), |sources, source| match source {
            Source::Point { at, initial } => {
                let at = self.place(*at);
                sources.and_point(at.x, at.y, *initial)
            }
            Source::Curve { vertices, initial } => {
                let mut places: Vec<DVec2> = vertices.first().copied().into_iter().collect();
                for ends in vertices.windows(2) {
                    if !self.surface.are_copies(self.place(ends[0]), self.place(ends[1])) {
                        places.extend(self.cuts(ends[0], ends[1]));
                    }
                    places.push(ends[1]);
                }
                let places = places.into_iter().map(|at| self.place(at).to_array());
                sources.and_curve(places, *initial)
            }
        })
    }

    /// Converts a place on the fine grid to coarse rows and columns. A place off the grid stays off the grid.
    fn place(&self, fine: DVec2) -> DVec2 {
        DVec2::new(place_among(&self.rows, fine.x), place_among(&self.cols, fine.y))
    }

    /// Returns the points where a segment crosses a row or column at which the steps change.
    fn cuts(&self, from: DVec2, to: DVec2) -> Vec<DVec2> {
        let mut cuts = Vec::new();
        for (axis, lines) in [&self.rows, &self.cols].into_iter().enumerate() {
            let changes = lines.windows(3).filter(|w| w[1] - w[0] != w[2] - w[1]);
            cuts.extend(changes.map(|w| (w[1] as f64 - from[axis]) / (to[axis] - from[axis])));
        }
        cuts.retain(|t| *t > 0.0 && *t < 1.0);
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        cuts.into_iter().map(|t| from.lerp(to, t)).collect()
    }

    /// Spreads values at the coarse points over the fine points, linearly along both axes. Values that are
    /// not finite are left out. The result is +infinity where no corner has a finite value.
    #[doc(hidden)]
    pub fn spread(&self, coarse: &[f64]) -> Vec<f64> {
        let (rows, cols) =
            (corners(&self.rows, self.fine.rows), corners(&self.cols, self.fine.cols));
        let value = |row: &[(usize, f64); 2], col: &[(usize, f64); 2]| {
            let (mut sum, mut weights, mut plain, mut count) = (0.0, 0.0, 0.0, 0.0);
            for (i, v) in row {
                for (j, u) in col {
                    let value = coarse[i * self.cols.len() + j];
                    if value.is_finite() {
                        sum += u * v * value;
                        weights += u * v;
                        plain += value;
                        count += 1.0;
                    }
                }
            }
            match (weights > 0.0, count > 0.0) {
                (true, _) => sum / weights,
                // The point lies on a coarse point without a value, and a coarse point beside it has a value.
                (_, true) => plain / count,
                _ => f64::INFINITY,
            }
        };
        rows.iter().flat_map(|row| cols.iter().map(move |col| value(row, col))).collect()
    }
}

/// Converts a fine row or column to a coarse one. Beyond the ends the conversion continues in a straight
/// line.
fn place_among(lines: &[usize], fine: f64) -> f64 {
    if lines.len() == 1 {
        return fine - lines[0] as f64;
    }
    let next = lines.partition_point(|&line| line as f64 <= fine).clamp(1, lines.len() - 1);
    let (a, b) = (lines[next - 1] as f64, lines[next] as f64);
    (next - 1) as f64 + (fine - a) / (b - a)
}

/// Returns, for each fine point of a side, the coarse points on either side of it, with their weights.
fn corners(lines: &[usize], points: usize) -> Vec<[(usize, f64); 2]> {
    let last = (lines.len() - 1) as f64;
    (0..points)
        .map(|point| {
            let place = place_among(lines, point as f64).clamp(0.0, last);
            let low = (place as usize).min(lines.len().saturating_sub(2));
            let weight = place - low as f64;
            [(low, 1.0 - weight), ((low + 1).min(lines.len() - 1), weight)]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Spacing;
    use crate::{Geometry, MetricTensor};

    fn flat(rows: usize, cols: usize) -> Surface {
        Surface::from_heights(rows, cols, vec![0.0; rows * cols], Spacing { dx: 2.0, dy: 3.0 })
            .unwrap()
    }

    #[test]
    fn both_ends_and_the_asked_for_line_stay() {
        assert_eq!(every_second(9, &[4], false), [0, 2, 4, 6, 8]);
        assert_eq!(every_second(9, &[5], false), [0, 1, 3, 5, 7, 8]);
        assert_eq!(every_second(8, &[4], false), [0, 2, 4, 6, 7]);
        assert_eq!(every_second(8, &[5], true), [1, 3, 5, 7]);
        assert_eq!(every_second(3, &[1], false), [0, 2]);
        assert_eq!(every_second(1, &[0], false), [0]);
    }

    #[test]
    fn a_single_step_lies_between_sources_that_want_other_lines() {
        let kept = [0, 2, 4, 6, 8, 9, 11, 13, 15, 16];
        assert_eq!(every_second(17, &[13, 4, 4], false), kept);
        assert_eq!(every_second(17, &[4, 5, 13], false), kept);
        assert_eq!(every_second(9, &[2, 5, 8], false), [0, 2, 4, 6, 8]);
        assert_eq!(every_second(17, &[5, 4], true), [1, 3, 5, 7, 9, 11, 13, 15]);
    }

    #[test]
    fn sides_of_two_points_cannot_be_halved_and_of_one_need_not() {
        for (rows, cols) in [(2, 9), (9, 2), (1, 1), (1, 2), (2, 2)] {
            let error = flat(rows, cols).coarsened(&[[0, 0]]).unwrap_err();
            assert_eq!(error, SurfaceError::TooSmall { rows, cols });
        }
        let line = flat(1, 9).coarsened(&[[0, 4]]).unwrap();
        assert_eq!((line.surface().rows(), line.surface().cols()), (1, 5));
        let holes = flat(3, 3).with_mask(&std::array::from_fn::<_, 9, _>(|index| index == 4));
        assert!(holes.unwrap().coarsened(&[[0, 0]]).is_err());
    }

    #[test]
    fn a_metric_is_per_step_of_two() {
        let tensor = MetricTensor { rr: 4.0, rc: 1.0, cc: 9.0 };
        let surface = Surface::from_metric(6, 5, vec![tensor; 30]).unwrap();
        let coarse = surface.coarsened(&[[1, 0]]).unwrap();
        assert_eq!((coarse.rows(), coarse.cols()), (&[1, 3, 5][..], &[0, 2, 4][..]));
        let edge = |surface: &Surface, row, col, to| {
            crate::EdgeLengths::<f64>::new(surface).unwrap().length(row, col, to)
        };
        for to in crate::Direction::ALL {
            approx::assert_relative_eq!(
                edge(coarse.surface(), 1, 1, to),
                2.0 * edge(&surface, 3, 2, to),
                max_relative = 1e-12
            );
        }
        let line =
            Surface::from_metric(1, 5, vec![tensor; 5]).unwrap().coarsened(&[[0, 0]]).unwrap();
        let Geometry::Metric(metric) = line.surface().geometry() else { panic!("a metric") };
        assert_eq!(metric[0], MetricTensor { rr: 4.0, rc: 2.0, cc: 36.0 });
    }

    #[test]
    fn slowness_and_positions_are_those_of_the_points_that_stay() {
        let slowness = (0..63).map(|index| 1.0 + f64::from(index)).collect();
        let surface = flat(7, 9).with_slowness(slowness).unwrap();
        let coarse = surface.coarsened(&[[3, 2]]).unwrap();
        for (index, fine) in coarse.indices().enumerate() {
            let (row, col) = surface.chart().position(fine);
            let (i, j) = coarse.surface().chart().position(index);
            assert_eq!(coarse.surface().position(i, j), surface.position(row, col));
            assert_eq!(coarse.surface().slowness().unwrap()[index], 1.0 + fine as f64);
        }
    }

    #[test]
    fn sources_keep_their_places() {
        let coarse = flat(10, 11).coarsened(&[[3, 4]]).unwrap();
        assert_eq!(coarse.rows(), [0, 1, 3, 5, 7, 9]);
        let sources = Sources::point(3.0, 4.0).and_point(0.5, 1.0, 2.0);
        let expected = Sources::point(2.0, 2.0).and_point(0.5, 0.5, 2.0);
        assert_eq!(coarse.sources(&sources), expected);
        // The curve is straight on either side of row 1, where the steps change.
        let curve = coarse.sources(&Sources::curve([[0.0, 0.0], [9.0, 9.0]]));
        assert_eq!(curve, Sources::curve([[0.0, 0.0], [1.0, 0.5], [5.0, 4.5]]));
        let outside = coarse.sources(&Sources::point(-1.0, 12.0));
        assert_eq!(outside, Sources::point(-1.0, 6.0));
    }

    #[test]
    fn linear_values_are_spread_exactly_and_missing_ones_left_out() {
        let coarse = flat(6, 9).coarsened(&[[3, 4]]).unwrap();
        let linear = |index: usize| 2.0 * (index / 9) as f64 - (index % 9) as f64;
        let values: Vec<_> = coarse.indices().map(linear).collect();
        for (index, value) in coarse.spread(&values).into_iter().enumerate() {
            approx::assert_relative_eq!(value, linear(index), epsilon = 1e-12);
        }
        let mut ones = vec![1.0; values.len()];
        ones[7] = f64::INFINITY;
        assert!(coarse.spread(&ones).iter().all(|&value| value == 1.0));
        ones.fill(f64::INFINITY);
        assert!(coarse.spread(&ones).iter().all(|value| value.is_infinite()));
    }
}
