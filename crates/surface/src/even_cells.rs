//! Detects surfaces whose cells are all alike.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{Direction, EdgeLengths, EdgeRule, Real, Surface, kept};

/// Relative tolerance for the lengths of edges in one direction.
const EVEN: f64 = 5e-6;
/// Relative difference up to which the edges of a cell have one metric but for rounding.
const EXACT: f64 = 1e-9;
/// Relative difference up to which the edges of a cell have one metric. It allows for [`EVEN`] in each edge.
const LARGEST_MISMATCH: f64 = 4e-5;
/// Number of rows and columns around a cell on which the lengths of its edges depend.
const AROUND: usize = 6;

/// Directions of the edges around a cell.
const WAYS: [Direction; 4] =
    [Direction::East, Direction::SouthEast, Direction::South, Direction::SouthWest];

impl Surface {
    /// Returns whether all cells are alike, whatever their shape, and the slowness is the same everywhere.
    /// Then one metric holds everywhere. This is so for even grids in the plane, on cylinders and on cones, and for a
    /// constant metric. A glued surface repeats over its seams ([`Self::periods`]).
    #[doc(hidden)]
    pub fn has_even_cells(&self) -> bool {
        self.even_metric().is_some()
    }

    /// Returns the first fundamental form of cells that are all alike, weighted by the slowness: the entries for rows,
    /// for both, and for columns. They are 1 and 0 in directions that have no edges. The result is `None` if cells
    /// differ.
    #[doc(hidden)]
    pub fn even_metric(&self) -> Option<[f64; 3]> {
        *kept(&self.known.even_metric, || self.measure_even_metric())
    }

    fn measure_even_metric(&self) -> Option<[f64; 3]> {
        if self.is_slowed_unevenly() || self.periods().is_none() {
            return None;
        }
        // An even grid is fitted first: on large grids, rounded positions give lengths of edges that differ by more
        // than the tolerance.
        let metric = match self.even_grid() {
            Some(grid) => grid.metric(),
            None if self.has_even_edges() => {
                let EdgeMetric { metric, mismatch } = self.edge_metric()?;
                let of_helices = || if mismatch > EXACT { self.helical_metric() } else { None };
                let of_edges = || (mismatch <= LARGEST_MISMATCH).then_some(metric);
                of_helices().or_else(of_edges)?
            }
            None => return None,
        };
        let [rr, rc, cc] = metric;
        (rr * cc > rc * rc).then_some(metric)
    }

    /// Returns whether all edges in a direction have the same length.
    fn has_even_edges(&self) -> bool {
        let is_even = |row: usize| {
            WAYS.into_iter().zip(self.first_edges()).all(|(to, first)| {
                let of = |col: usize| self.edge_on_surface((row, col), to);
                let mut lengths = (0..self.chart.cols).filter_map(of);
                let first = first.unwrap_or(0.0);
                lengths.all(|length| (length - first).abs() <= EVEN * first)
            })
        };
        (0..self.chart.rows).into_par_iter().all(is_even)
    }

    /// Returns the lengths on the surface of the first edges in each of [`WAYS`].
    fn first_edges(&self) -> [Option<f64>; 4] {
        WAYS.map(|to| self.chart.places().find_map(|at| self.edge_on_surface(at, to)))
    }

    /// Returns the length on the surface of the edge from a point to a neighbour, if there is one.
    pub(super) fn edge_on_surface(&self, (row, col): (usize, usize), to: Direction) -> Option<f64> {
        let end = self.has_edge(row, col, to).then(|| self.chart.neighbour(row, col, to))??;
        Some(self.length_on_surface((row, col), end))
    }

    /// Returns the metric of the edges in the middle of the chart, as solvers measure them. Arcs at the sides of the
    /// chart differ from those in the middle. The result is `None` if edges are too long or too short.
    fn edge_metric(&self) -> Option<EdgeMetric> {
        let (row, col) = self.middle_cell()?;
        let sheet = self.sheet([row, row + 1], [col, col + 1], [AROUND; 2]);
        let edges = EdgeLengths::<f64>::new(sheet.part()).ok()?;
        let cell = sheet.local(DVec2::new(row as f64, col as f64));
        let from_cell = |&(row, col): &(usize, usize)| {
            DVec2::new(row as f64, col as f64).distance_squared(cell) as usize
        };
        let mut places: Vec<_> = edges.chart().places().collect();
        places.sort_by_key(from_cell);
        let square = |to| {
            let mut all = places.iter().map(|&(row, col)| edges.length(row, col, to));
            all.find(|length| *length < f64::FAR).map(|length| length * length)
        };
        Some(EdgeMetric::of(WAYS.map(square)))
    }

    /// Returns the cell nearest to the middle of the chart of which no corner is missing, or a point where there is none.
    fn middle_cell(&self) -> Option<(usize, usize)> {
        let middle = 0.5 * DVec2::new(self.rows() as f64, self.cols() as f64);
        let is_whole = |&(row, col): &(usize, usize)| {
            (row..row + 2).all(|row| (col..col + 2).all(|col| self.has(row, col)))
        };
        let from_middle = |&(row, col): &(usize, usize)| {
            DVec2::new(row as f64 + 0.5, col as f64 + 0.5).distance_squared(middle) as usize
        };
        let cells = self.chart.places().filter(is_whole).min_by_key(from_middle);
        cells.or_else(|| self.chart.places().find(|&(row, col)| self.has(row, col)))
    }

    /// Returns the metric of a grid whose rows and columns are helices around one axis, as on a cylinder. Arcs are exact
    /// there, however coarse the grid is. The result is `None` if the chords of the grid are not those of such helices.
    fn helical_metric(&self) -> Option<[f64; 3]> {
        if self.edge_rule() != EdgeRule::Arc || self.is_weighted() {
            return None;
        }
        let [of_rows, of_cols] = [self.steps([1, 0])?, self.steps([0, 1])?];
        let turns = [of_rows, of_cols].map(turn_of);
        let axis = if turns[0].length() > turns[1].length() { turns[0] } else { turns[1] };
        let axis = axis.try_normalize()?;
        let [rows, cols] = [of_rows, of_cols].map(|steps| Screw::around(axis, steps));
        // Where one line does not turn, it runs along the axis.
        let radius = rows.radius().max(cols.radius());
        let square = |turn: f64, rise: f64| {
            let chord = 2.0 * radius * (0.5 * turn).sin();
            chord * chord + rise * rise
        };
        let are_helices = WAYS.into_iter().zip(self.first_edges()).all(|(to, edge)| {
            let [down, right] = <[isize; 2]>::from(to.step()).map(|by| by as f64);
            let turn = down * rows.turn + right * cols.turn;
            let chord = square(turn, down * rows.rise + right * cols.rise).sqrt();
            edge.is_some_and(|edge| (edge - chord).abs() <= EVEN * edge)
        });
        let [rows, cols] = [rows, cols].map(|screw| DVec2::new(radius * screw.turn, screw.rise));
        are_helices.then(|| [rows.dot(rows), rows.dot(cols), cols.dot(cols)])
    }

    /// Returns three successive steps along a grid line, if there are any.
    fn steps(&self, [down, right]: [usize; 2]) -> Option<[DVec3; 3]> {
        self.chart.places().find_map(|(row, col)| {
            let place = |count: usize| {
                let (row, col) = (row + count * down, col + count * right);
                if self.has(row, col) { self.position(row, col) } else { None }
            };
            let [a, b, c, d] = [place(0)?, place(1)?, place(2)?, place(3)?];
            Some([b - a, c - b, d - c])
        })
    }
}

/// The metric of a cell's edges.
struct EdgeMetric {
    metric: [f64; 3],
    /// The largest relative difference between the square of an edge and that under the metric.
    mismatch: f64,
}

impl EdgeMetric {
    /// Returns the metric from the squared lengths of the edges of [`WAYS`]. Of the two diagonals, the shorter one counts:
    /// its arc is the more accurate one, and the metric of long cells depends on it.
    fn of([east, falling, south, rising]: [Option<f64>; 4]) -> Self {
        let (rr, cc) = (south.unwrap_or(1.0), east.unwrap_or(1.0));
        let of_falling = falling.map(|square| 0.5 * (square - rr - cc));
        let of_rising = rising.map(|square| 0.5 * (rr + cc - square));
        let rc = if falling < rising { of_falling } else { of_rising.or(of_falling) };
        let mismatch = match (falling, rising) {
            (Some(falling), Some(rising)) => {
                (falling + rising - 2.0 * (rr + cc)).abs() / falling.max(rising)
            }
            _ => 0.0,
        };
        Self { metric: [rr, rc.unwrap_or(0.0), cc], mismatch }
    }
}

/// Returns the axis around which a grid line with these steps turns, times an angle.
fn turn_of(steps: [DVec3; 3]) -> DVec3 {
    let bends = [steps[1] - steps[0], steps[2] - steps[1]];
    let square = bends[0].length_squared();
    if square > 0.0 { bends[0].cross(bends[1]) / square } else { DVec3::ZERO }
}

/// The motion from a point of a helix to the next.
#[derive(Clone, Copy)]
struct Screw {
    /// Angle around the axis.
    turn: f64,
    /// Way along the axis.
    rise: f64,
    /// Chord across the axis.
    chord: f64,
}

impl Screw {
    fn around(axis: DVec3, [first, second, _]: [DVec3; 3]) -> Self {
        let rise = first.dot(axis);
        let (a, b) = (first - rise * axis, second - second.dot(axis) * axis);
        Self { turn: axis.dot(a.cross(b)).atan2(a.dot(b)), rise, chord: a.length() }
    }

    /// Returns the radius of the helix, or 0 if it does not turn.
    fn radius(&self) -> f64 {
        let sine = (0.5 * self.turn).sin().abs();
        if sine > 0.0 { 0.5 * self.chord / sine } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::Builtin;
    use crate::{MetricTensor, Spacing};

    /// Returns a surface of 11 x 13 points. `place` gives the position from row and column.
    fn surface(place: impl Fn(f64, f64) -> [f64; 3]) -> Surface {
        let positions = (0..11 * 13)
            .map(|index| DVec3::from_array(place((index / 13) as f64, (index % 13) as f64)));
        Surface::from_positions(11, 13, positions.collect()).unwrap()
    }

    #[test]
    fn sheared_and_rolled_grids_and_constant_metrics_have_even_cells() {
        let rolled = |turn: f64, along: f64| [8.0 * turn.sin(), along, 8.0 * turn.cos()];
        assert!(surface(|row, col| [3.0 * col + 0.7 * row, row, 0.5 * col]).has_even_cells());
        assert!(surface(|row, col| rolled(0.1 * col + 0.04 * row, row)).has_even_cells());
        let tensor = MetricTensor { rr: 4.0, rc: 0.5, cc: 1.0 };
        assert!(Surface::from_metric(4, 5, vec![tensor; 20]).unwrap().has_even_cells());
        // A relief of a thousandth of the spacing does not count.
        let mut heights = vec![0.0; 35];
        heights[0] = 1e-3;
        let hair = Surface::from_heights(5, 7, heights, Spacing::square(1.0)).unwrap();
        assert!(hair.has_even_cells());
        let mask: Vec<_> = (0..35).map(|index| index % 6 != 0).collect();
        assert!(hair.clone().with_mask(&mask).unwrap().has_even_cells());
        assert!(hair.clone().with_slowness(vec![2.0; 35]).unwrap().has_even_cells());
        let slowness = (0..35).map(|index| 1.0 + f64::from(index)).collect();
        assert!(!hair.with_slowness(slowness).unwrap().has_even_cells());
    }

    #[test]
    fn others_have_not() {
        assert!(!surface(|row, col| [1.01f64.powf(col), row, 0.0]).has_even_cells());
        assert!(!surface(|row, col| [col, row, 0.05 * col.sin()]).has_even_cells());
        // All edges along rows and columns have the same length here; the diagonals do not.
        let rhombs = |row: f64, col: f64| [col + 0.2 * (row % 2.0), row * 0.96f64.sqrt(), 0.0];
        assert!(!surface(rhombs).has_even_cells());
        assert!(!Builtin::Sphere.surface(12, 12).unwrap().has_even_cells());
    }

    /// On a coarse helical grid on a cylinder, the metric is that of the unrolled plane, where arcs alone are too short.
    #[test]
    fn helical_grids_have_the_metric_of_their_cylinder() {
        for (radius, shift, rise) in [(2.4, 2.4, 0.6), (5.0, -2.4, 1.0), (5.0, 0.0, 0.3)] {
            let at = |row: f64, col: f64| {
                let turn = (col + shift * row) / radius;
                [radius * turn.cos(), radius * turn.sin(), rise * row]
            };
            let expected = [shift * shift + rise * rise, shift, 1.0];
            let coarse = surface(at);
            for (found, expected) in coarse.even_metric().unwrap().into_iter().zip(expected) {
                approx::assert_abs_diff_eq!(found, expected, epsilon = 1e-9);
            }
            // A polyhedron with these corners is flat if its folds are rulings.
            let folded = coarse.with_edge_rule(EdgeRule::Chord);
            assert_eq!(folded.has_even_cells(), shift == 0.0, "{radius} {shift}");
        }
    }

    #[test]
    fn the_metric_includes_the_slowness() {
        let plane = surface(|row, col| [3.0 * col + 0.7 * row, row, 0.0]);
        for factor in [1.0, 2.5] {
            let slowed = plane.clone().with_slowness(vec![factor; 11 * 13]).unwrap();
            let expected = [1.49, 2.1, 9.0].map(|entry| entry * factor * factor);
            for (found, expected) in slowed.even_metric().unwrap().into_iter().zip(expected) {
                approx::assert_relative_eq!(found, expected, max_relative = 1e-9);
            }
        }
    }
}
