//! Finds the sources that a level set describes: the curves along which a function is zero.

use geosweep_surface::{Chart, Direction, Edge, Sources};

use super::Curve;
use super::arrivals::solve;
use super::chains::join;
use super::contours::march;

/// The reason why a level set has no sources.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LevelSetError {
    /// The number of values is not that of the grid's points.
    #[error("the level set has {values} values, and the grid {rows} x {cols} points")]
    Shape {
        /// Number of values.
        values: usize,
        /// The grid's rows.
        rows: usize,
        /// The grid's columns.
        cols: usize,
    },
    /// No value is zero, and all have one sign.
    #[error(
        "the level set is {} everywhere, so nothing starts; it must be zero somewhere or change its sign",
        if *.are_negative { "negative" } else { "positive" }
    )]
    NoZero {
        /// Whether the values are negative.
        are_negative: bool,
    },
    /// All values are missing.
    #[error("all values of the level set are missing (NaN)")]
    Empty,
}

/// Returns sources along the zero of a function that is given at grid points, row-major. Fronts start there at time 0, to
/// both sides. Points whose value is NaN or infinite are missing. Glued sides do not count: a curve ends at them.
///
/// Where the function is smooth, its zero on an edge is that of a cubic through four points in line, so that distances
/// are of second order: the curve is a chain of straight segments. Where the function bends sharply, for example if it is
/// -1 inside and 1 outside, it is linear along edges. A grid point at which the function is zero without a change of
/// sign beside it is a point source.
///
/// ```
/// use geosweep::geometry::level_set;
/// use geosweep::{Options, Spacing, Surface, distance_map};
///
/// // A circle of radius 20.
/// let phi: Vec<f64> =
///     (0..65 * 65).map(|k| ((k / 65) as f64 - 32.0).hypot((k % 65) as f64 - 32.0) - 20.0).collect();
/// let surface = Surface::from_heights(65, 65, vec![0.0; 65 * 65], Spacing::square(1.0))?;
/// let sources = level_set(surface.chart(), &phi)?;
/// let map = distance_map(&surface, &sources, &Options::default())?;
/// assert!((map.distance(32, 42) - 10.0).abs() < 0.01 && (map.distance(32, 62) - 10.0).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the function is zero nowhere, or the number of values is wrong.
pub fn level_set(chart: Chart, values: &[f64]) -> Result<Sources, LevelSetError> {
    let Chart { rows, cols } = chart;
    if values.len() != chart.points() {
        return Err(LevelSetError::Shape { values: values.len(), rows, cols });
    }
    let function = Function { chart, values };
    let segments = march(chart, |index| values[index], &[0.0]);
    let curves = join(segments, |_, node| {
        let (from, to) = Edge::from_number(node).ends(chart);
        let (s, step) = (function.zero(from, to), to.vector());
        [from.0 as f64 + s * step.x, from.1 as f64 + s * step.y]
    });
    let mut sources = Sources::default();
    for (_, curve) in curves {
        sources = sources.and_curve(spread(curve), 0.0);
    }
    for point in (0..values.len()).filter(|&index| function.touches(index)) {
        let (row, col) = chart.position(point);
        sources = sources.and_point(row as f64, col as f64, 0.0);
    }
    if sources.iter().next().is_some() {
        return Ok(sources);
    }
    let first = values.iter().find(|value| value.is_finite());
    Err(first
        .map_or(LevelSetError::Empty, |&first| LevelSetError::NoZero { are_negative: first < 0.0 }))
}

/// A function that is given at grid points.
struct Function<'a> {
    chart: Chart,
    values: &'a [f64],
}

impl Function<'_> {
    fn along(&self, from: (usize, usize), to: Direction, steps: isize) -> Option<f64> {
        let (row, col) = self.chart.along(from, to, steps)?;
        Some(self.values[self.chart.index(row, col)]).filter(|value| value.is_finite())
    }

    /// Returns the place of the zero on the edge from a point (0) to its neighbour (1), between which the sign changes.
    fn zero(&self, from: (usize, usize), to: Direction) -> f64 {
        let at = |steps| self.along(from, to, steps);
        let (Some(a), Some(b)) = (at(0), at(1)) else { return 0.5 };
        let bends =
            [at(-1).map(|before| before - 2.0 * a + b), at(2).map(|after| a - 2.0 * b + after)];
        let (p, q) = match bends {
            [Some(p), Some(q)] if (p - q).abs() <= SMOOTH * (p.abs() + q.abs()) => (p, q),
            // Beside a hole or the border, one side of the edge is known.
            [Some(p), None] | [None, Some(p)] if p.abs() <= SMOOTH * (a - b).abs() => (p, p),
            _ => (0.0, 0.0),
        };
        solve(0.0, |s| {
            let bend = ((2.0 - s) * p + (1.0 + s) * q) / 3.0;
            a + s * (b - a) - 0.5 * s * (1.0 - s) * bend
        })
    }

    /// Returns whether the function is zero at a point, with one sign at all its neighbours.
    fn touches(&self, index: usize) -> bool {
        if self.values[index] != 0.0 {
            return false;
        }
        let (row, col) = self.chart.position(index);
        let around = || Direction::ALL.into_iter().filter_map(|to| self.along((row, col), to, 1));
        around().all(|value| value >= 0.0) || around().all(|value| value <= 0.0)
    }
}

/// Largest difference of two second differences of a smooth function, relative to their sum, and largest second
/// difference relative to the first.
const SMOOTH: f64 = 0.5;

/// Least distance of vertices, in cells. Over shorter segments, errors of the vertices would bend a smooth curve.
const APART: f64 = 0.25;

/// Returns a curve's vertices without those that are close to the one before. A closed curve ends with its first vertex.
fn spread(Curve { vertices, closed }: Curve) -> Vec<[f64; 2]> {
    let is_near = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < APART;
    let last = if closed { vertices[0] } else { vertices[vertices.len() - 1] };
    let mut kept: Vec<[f64; 2]> = Vec::with_capacity(vertices.len() + 1);
    for vertex in vertices {
        if kept.last().is_none_or(|before| !is_near(before, &vertex)) {
            kept.push(vertex);
        }
    }
    while kept.len() > 1 && is_near(&kept[kept.len() - 1], &last) {
        kept.pop();
    }
    kept.push(last);
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use geosweep_surface::Source;

    /// Returns the number of curves and of points.
    fn counts(sources: &Sources) -> (usize, usize) {
        let curves = sources.iter().filter(|source| matches!(source, Source::Curve { .. }));
        let curves = curves.count();
        (curves, sources.iter().count() - curves)
    }

    fn values(chart: Chart, function: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        chart.places().map(|(row, col)| function(row as f64, col as f64)).collect()
    }

    /// Along edges, zeros of smooth functions are of third order at least.
    #[test]
    fn vertices_lie_on_the_zero_of_a_smooth_function() {
        let mut errors = Vec::new();
        for n in [17, 33, 65] {
            let chart = Chart { rows: n, cols: n };
            let (middle, radius) = (0.47 * n as f64, 0.3 * n as f64);
            let distance = |row: f64, col: f64| (row - middle).hypot(col - middle) - radius;
            let sources = level_set(chart, &values(chart, distance)).unwrap();
            assert_eq!(counts(&sources), (1, 0));
            let Some(Source::Curve { vertices, .. }) = sources.iter().next() else { panic!() };
            assert_eq!(vertices[0], vertices[vertices.len() - 1]);
            let error = |at: &glam::DVec2| distance(at.x, at.y).abs();
            errors.push(vertices.iter().map(error).fold(0.0, f64::max) / n as f64);
            for pair in vertices.windows(2) {
                assert!((0.2..1.5).contains(&pair[0].distance(pair[1])), "{pair:?}");
            }
        }
        println!("{errors:?}");
        assert!(errors[1] < errors[0] / 6.0 && errors[2] < errors[1] / 6.0, "{errors:?}");
    }

    #[test]
    fn signs_alone_have_their_zero_half_way() {
        let chart = Chart { rows: 7, cols: 9 };
        let signs = values(chart, |_, col| if col < 4.0 { -1.0 } else { 1.0 });
        let sources = level_set(chart, &signs).unwrap();
        let Some(Source::Curve { vertices, .. }) = sources.iter().next() else { panic!() };
        assert!(vertices.iter().all(|at| at.y == 3.5), "{vertices:?}");
        assert_eq!(counts(&sources), (1, 0));
    }

    #[test]
    fn zeros_at_points_are_sources_once() {
        let chart = Chart { rows: 9, cols: 9 };
        // A line through grid points with both signs, and the distance from a point.
        let line = level_set(chart, &values(chart, |row, _| row - 4.0)).unwrap();
        assert_eq!(counts(&line), (1, 0));
        let cone = level_set(chart, &values(chart, |row, col| (row - 4.0).hypot(col - 3.0)));
        assert_eq!(cone.unwrap(), Sources::point(4.0, 3.0));
        let inside = level_set(chart, &values(chart, |row, col| -(row - 4.0).hypot(col - 3.0)));
        assert_eq!(inside.unwrap(), Sources::point(4.0, 3.0));
    }

    #[test]
    fn missing_values_cut_curves_off() {
        let chart = Chart { rows: 12, cols: 12 };
        let hole =
            |row: f64, col: f64| if (4.0..7.0).contains(&col) { f64::NAN } else { row - 5.3 };
        assert_eq!(counts(&level_set(chart, &values(chart, hole)).unwrap()), (2, 0));
    }

    #[test]
    fn functions_without_a_zero_are_refused() {
        let chart = Chart { rows: 3, cols: 4 };
        let of = |value: f64| level_set(chart, &[value; 12]).unwrap_err();
        assert_eq!(of(1.0), LevelSetError::NoZero { are_negative: false });
        assert_eq!(of(-2.0), LevelSetError::NoZero { are_negative: true });
        assert_eq!(of(f64::NAN), LevelSetError::Empty);
        let wrong = level_set(chart, &[0.0; 11]).unwrap_err();
        assert!(wrong.to_string().contains("11 values, and the grid 3 x 4"), "{wrong}");
        assert!(of(1.0).to_string().contains("positive everywhere"));
    }
}
