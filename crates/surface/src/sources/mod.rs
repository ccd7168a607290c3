//! Defines sources, where the wavefront starts, and converts them to initial values at grid points.

mod course;
mod diagonals;
mod error;
mod origin;
mod part;
mod pieces;
mod rise;
mod seed;
mod source;

use glam::DVec2;

use super::Surface;
#[doc(hidden)]
pub use diagonals::with_diagonals;
use error::LARGEST_INITIAL;
pub use error::SourceError;
pub use origin::Origin;
use part::SourcePart;
#[doc(hidden)]
pub use seed::Origins;
pub use seed::{Heading, Seed};
pub use source::Source;

/// The sources of one distance map. The map holds the distance to the nearest source, initial values
/// included.
///
/// ```
/// use geosweep::Sources;
/// let sources = Sources::point(10.0, 20.5).and_point(3.0, 4.0, 7.5);
/// assert_eq!(sources.iter().count(), 2);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sources(Vec<Source>);

impl FromIterator<Source> for Sources {
    fn from_iter<T: IntoIterator<Item = Source>>(sources: T) -> Self {
        Self(sources.into_iter().collect())
    }
}

impl Sources {
    /// Makes a single point source. Row and column may be fractional.
    pub fn point(row: f64, col: f64) -> Self {
        Self::default().and_point(row, col, 0.0)
    }

    /// Makes a single curve from the rows and columns of a polyline's vertices.
    pub fn curve(vertices: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Self::default().and_curve(vertices, 0.0)
    }

    /// Adds a point source with an initial value.
    pub fn and_point(mut self, row: f64, col: f64, initial: f64) -> Self {
        self.0.push(Source::Point { at: DVec2::new(row, col), initial });
        self
    }

    /// Adds a curve with an initial value.
    ///
    /// On a closed surface, two successive vertices that are the same place at different rows and columns are a jump
    /// over a seam, as in `geosweep::geometry::Curve`, and the curve goes on from the second one.
    pub fn and_curve(mut self, vertices: impl IntoIterator<Item = [f64; 2]>, initial: f64) -> Self {
        let vertices = vertices.into_iter().map(DVec2::from_array).collect();
        self.0.push(Source::Curve { vertices, initial });
        self
    }

    /// Returns the sources in the order given.
    pub fn iter(&self) -> impl Iterator<Item = &Source> {
        self.0.iter()
    }

    /// Returns whether all sources are points, so that fronts are circular near them.
    pub fn are_points(&self) -> bool {
        self.iter().all(|source| match source {
            Source::Point { .. } => true,
            Source::Curve { vertices, .. } => vertices.iter().all(|v| *v == vertices[0]),
        })
    }

    /// Returns the number of sources that lie inside cells or on their sides, rather than at grid points. A curve
    /// counts by its first vertex.
    pub(crate) fn inside_cells(&self) -> usize {
        let is_inside = |source: &&Source| match source {
            Source::Point { at, .. } => at.fract() != DVec2::ZERO,
            Source::Curve { vertices, .. } => {
                vertices.first().is_some_and(|at| at.fract() != DVec2::ZERO)
            }
        };
        self.iter().filter(is_inside).count()
    }

    /// Returns the smallest initial value, or infinity if there is no source.
    pub fn start(&self) -> f64 {
        self.iter().map(Source::initial).fold(f64::INFINITY, f64::min)
    }

    /// Returns the initial values at grid points, in row-major order. Of several values at a point, the smallest
    /// counts.
    ///
    /// A source at a grid point seeds that point. A source elsewhere seeds the corners of the cells that it
    /// touches with the distances of these corners from the source. These distances are exact where the cell is flat.
    /// From point sources they follow the surface as its edges do. A curve seeds the corners of every cell through
    /// which it runs, so it has no gaps.
    pub fn seeds(&self, surface: &Surface) -> Result<Vec<Seed>, SourceError> {
        let mut seeds = self.seeds_with_origins(surface)?;
        seeds.iter_mut().for_each(|seed| seed.origin = None);
        Ok(seeds)
    }

    /// Returns the seeds of [`Self::seeds`], with the straight source from which each seed's front comes
    /// ([`Seed::origin`]).
    ///
    /// From the origins, the crate finds straight lines and sources that lie close together. Solvers do not use them.
    ///
    /// ```
    /// use geosweep::cpu::{RotatedScan, seeds_for};
    /// use geosweep::surface::EdgeLengths;
    /// use geosweep::{Sources, Spacing, Stop, Surface, Wavefront};
    ///
    /// let surface = Surface::from_heights(9, 9, vec![0.0; 81], Spacing { dx: 1.0, dy: 2.0 })?;
    /// let sources = Sources::point(4.0, 4.0).and_point(5.0, 4.0, 0.0);
    /// let seeds = seeds_for(Wavefront::Curved, &surface, sources.seeds_with_origins(&surface)?);
    /// let edges = EdgeLengths::<f32>::new(&surface)?;
    /// let mut solver = RotatedScan::new(&edges, Wavefront::Curved);
    /// solver.solve(&seeds, Stop::within(1e-6).or_after(100));
    /// assert!((solver.distances()[4 * 9 + 6] - 2.0).abs() < 1e-6);
    /// # Ok::<(), geosweep::Error>(())
    /// ```
    pub fn seeds_with_origins(&self, surface: &Surface) -> Result<Vec<Seed>, SourceError> {
        let mut seeds = Vec::new();
        for (number, source) in (0..).zip(self.iter()) {
            let (parts, initial) = (SourcePart::all(surface, source), source.initial());
            let first = parts.first().ok_or(SourceError::EmptyCurve)?.first();
            let of_source = part::seeds(surface, &parts, initial)?;
            if initial.is_nan() || initial.abs() >= LARGEST_INITIAL {
                return Err(SourceError::Initial { row: first.x, col: first.y, initial });
            }
            seeds.extend(of_source.into_iter().map(|seed| Seed { source: number, ..seed }));
        }
        if seeds.is_empty() { Err(SourceError::None) } else { Ok(Seed::earliest(seeds)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MetricTensor, Spacing};

    fn flat(rows: usize, cols: usize) -> Surface {
        Surface::from_heights(rows, cols, vec![0.0; rows * cols], Spacing::square(1.0)).unwrap()
    }

    #[test]
    fn seeds_are_lost_where_the_map_is_later_by_more_than_rounding() {
        for time in [-5.0, 0.0, 3.0] {
            let seed = Seed::at_source(0, 0, time);
            let (rounded, later) = (time + time.abs() * 2e-7, time + 1e-5);
            for map in [time, rounded, time - 1.0] {
                assert!(!seed.is_lost(map as f32), "{time} {map}");
            }
            assert!(seed.is_lost(later as f32) && seed.is_lost(later), "{time}");
        }
    }

    #[test]
    fn points_have_one_origin_and_curves_several() {
        let origins = |sources: Sources| {
            let mut origins = Origins::default();
            sources.seeds(&flat(9, 9)).unwrap().iter().for_each(|seed| origins.add(seed));
            origins.are_causal()
        };
        assert!(!origins(Sources::point(3.0, 4.0)) && !origins(Sources::point(3.25, 4.5)));
        assert!(origins(Sources::point(3.25, 4.5).and_point(3.5, 4.5, 0.0)));
        assert!(origins(Sources::curve([[1.0, 3.5], [4.0, 3.5]])));
    }

    #[test]
    fn the_end_of_a_curve_reaches_the_cells_beyond_it() {
        let surface = Surface::from_heights(9, 9, vec![0.0; 81], Spacing::square(1.0)).unwrap();
        // The curve ends on the side between two cells, half-way between two points.
        let seeds = Sources::curve([[1.0, 3.5], [4.0, 3.5]]).seeds(&surface).unwrap();
        let at = |row, col| seeds.iter().find(|seed| (seed.row, seed.col) == (row, col));
        for col in [3, 4] {
            let beyond = at(5, col).expect("the cell below is touched");
            approx::assert_relative_eq!(beyond.time, 1f64.hypot(0.5), epsilon = 1e-12);
            assert!(at(0, col).is_some(), "and so is that above");
        }
    }

    #[test]
    fn a_source_at_a_grid_point_seeds_it_alone() {
        let seeds = Sources::point(2.0, 3.0).seeds(&flat(5, 6)).unwrap();
        assert_eq!(seeds, [Seed::at_source(2, 3, 0.0)]);
    }

    #[test]
    fn a_source_inside_a_cell_seeds_its_corners_exactly() {
        let seeds = Sources::point(1.25, 2.5).seeds(&flat(4, 5)).unwrap();
        assert_eq!(seeds.len(), 4);
        for seed in seeds {
            let exact = (seed.row as f64 - 1.25).hypot(seed.col as f64 - 2.5);
            approx::assert_relative_eq!(seed.time, exact, epsilon = 1e-15);
        }
    }

    #[test]
    fn a_source_on_an_edge_seeds_both_cells() {
        assert_eq!(Sources::point(1.0, 2.5).seeds(&flat(4, 5)).unwrap().len(), 6);
        assert_eq!(Sources::point(0.0, 2.5).seeds(&flat(4, 5)).unwrap().len(), 4);
        assert_eq!(Sources::point(0.0, 2.5).seeds(&flat(1, 5)).unwrap().len(), 2);
    }

    #[test]
    fn a_metric_measures_like_the_positions_it_came_from() {
        // A sheared cell: columns along (1, 0), rows along (0.5, 2).
        let metric = MetricTensor { rr: 4.25, rc: 0.5, cc: 1.0 };
        let surface = Surface::from_metric(2, 2, vec![metric; 4]).unwrap();
        for seed in Sources::point(0.25, 0.75).seeds(&surface).unwrap() {
            let (dr, dc) = (seed.row as f64 - 0.25, seed.col as f64 - 0.75);
            let exact = (dc + 0.5 * dr).hypot(2.0 * dr);
            approx::assert_relative_eq!(seed.time, exact, epsilon = 1e-14);
        }
    }

    #[test]
    fn curves_have_no_gaps() {
        let seeds = Sources::curve([[0.0, 0.0], [7.3, 11.9]]).seeds(&flat(9, 13)).unwrap();
        for row in 0..8 {
            let col = row as f64 * 11.9 / 7.3;
            for col in [col.floor() as usize, col.ceil() as usize] {
                assert!(seeds.iter().any(|s| (s.row, s.col) == (row, col)), "{row},{col}");
            }
        }
        // No seed is earlier than the exact distance to the line.
        let normal = DVec2::new(11.9, -7.3).normalize();
        for seed in &seeds {
            let exact = normal.dot(DVec2::new(seed.row as f64, seed.col as f64)).abs();
            assert!(seed.time >= exact - 1e-12, "{seed:?} {exact}");
        }
    }

    #[test]
    fn the_front_of_a_circle_has_its_curvature_on_either_side() {
        let (centre, radius) = (DVec2::new(20.0, 20.0), 12.3);
        let circle = (0..=200).map(|k| {
            let angle = std::f64::consts::TAU * f64::from(k % 200) / 200.0;
            (centre + radius * DVec2::from_angle(angle)).to_array()
        });
        for seed in Sources::curve(circle).seeds(&flat(41, 41)).unwrap() {
            let offset = DVec2::new(seed.row as f64, seed.col as f64).distance(centre) - radius;
            approx::assert_abs_diff_eq!(seed.time, offset.abs(), epsilon = 2e-3);
            if offset.abs() > 0.05 {
                let exact = offset.signum() / (radius + offset);
                approx::assert_relative_eq!(seed.curvature, exact, max_relative = 0.05);
            }
        }
    }

    /// Between vertices, places of the curve are off the grid points by rounding.
    #[test]
    fn a_front_goes_to_both_sides_of_a_curve_through_grid_points() {
        let sphere = crate::builtin::Builtin::Sphere.surface(65, 65).unwrap();
        for col in [7.0, 20.0, 41.0] {
            let line = Sources::curve([[5.0, col - 5.0], [15.0, col], [25.0, col], [48.0, col]]);
            let seeds = line.seeds(&sphere).unwrap();
            let on_curve = |seed: &&Seed| seed.col as f64 == col && (17..48).contains(&seed.row);
            let on_curve: Vec<_> = seeds.iter().filter(on_curve).collect();
            assert_eq!(on_curve.len(), 31);
            for seed in on_curve {
                assert!(seed.time < 1e-12 && seed.curvature == 0.0, "{seed:?}");
            }
        }
    }

    #[test]
    fn the_front_of_a_polyline_is_straight_but_for_its_corners() {
        let line = [[2.0, 2.5], [2.0, 6.5], [6.5, 6.5]];
        let seeds = Sources::curve(line).seeds(&flat(9, 9)).unwrap();
        let at = |row, col| seeds.iter().find(|s| (s.row, s.col) == (row, col)).unwrap();
        assert_eq!((at(1, 4).time, at(1, 4).curvature), (1.0, 0.0));
        let corner = at(1, 7);
        approx::assert_relative_eq!(corner.curvature, 1.0 / corner.time, max_relative = 1e-12);
    }

    #[test]
    fn half_a_cell_is_left_beside_a_missing_corner() {
        let mut mask = vec![true; 4];
        mask[0] = false;
        let surface = flat(2, 2).with_mask(&mask).unwrap();
        let seeds = Sources::point(0.75, 0.5).seeds(&surface).unwrap();
        assert_eq!(seeds.len(), 3);
        for seed in seeds {
            let exact = (seed.row as f64 - 0.75).hypot(seed.col as f64 - 0.5);
            approx::assert_relative_eq!(seed.time, exact, epsilon = 1e-15);
        }
        let hole = Sources::point(0.25, 0.25).seeds(&surface);
        assert!(matches!(hole, Err(SourceError::Hole { .. })));
    }

    #[test]
    fn sources_off_the_surface_are_errors() {
        let surface = flat(3, 4);
        for (row, col) in [(-0.1, 0.0), (0.0, 3.5), (f64::NAN, 0.0), (9.0, 0.0)] {
            let error = Sources::point(row, col).seeds(&surface).unwrap_err();
            assert!(matches!(error, SourceError::Outside { .. }), "{error}");
        }
        assert_eq!(Sources::default().seeds(&surface), Err(SourceError::None));
        let infinite = Sources::default().and_point(0.0, 0.0, f64::INFINITY).seeds(&surface);
        assert!(matches!(infinite, Err(SourceError::Initial { .. })));
    }

    #[test]
    fn initial_values_that_single_precision_lacks_are_refused() {
        for initial in [f64::NAN, f64::INFINITY, 1e39, -1e39, 1e30] {
            let point = Sources::default().and_point(1.0, 2.0, initial).seeds(&flat(5, 6));
            let Err(SourceError::Initial { row: 1.0, col: 2.0, .. }) = point else {
                panic!("{initial}: {point:?}")
            };
            let curve = Sources::default().and_curve([[1.0, 2.0], [3.0, 2.0]], initial);
            let curve = curve.seeds(&flat(5, 6)).unwrap_err().to_string();
            assert!(curve.contains("initial value") && curve.contains("5e29"), "{curve}");
        }
        assert!(Sources::default().and_point(1.0, 2.0, -1e29).seeds(&flat(5, 6)).is_ok());
    }
}
