//! Adds seeds along the grid's diagonals for sources inside cells of a floor plan.
//!
//! A scan follows rays up to 45 degrees from its direction. A ray from a source at a grid point always passes
//! between two points that the same scan reaches. A ray from a source inside a cell that runs close to a
//! diagonal passes between two points that different scans reach. At each next point, one scan would have to
//! wait for the other's next iteration. Therefore the points beside the diagonals are seeds as well.

use glam::DVec2;

use super::seed::{Heading, Seed};
use crate::Surface;

/// Returns the seeds of a floor plan, each followed by the points beside the diagonal through its source, if
/// the source lies inside a cell. The points end at the first hole. In total there are at most as many
/// additional seeds as the surface has points. On other surfaces the seeds are returned unchanged.
pub fn with_diagonals(surface: &Surface, seeds: Vec<Seed>) -> Vec<Seed> {
    let Some(grid) = surface.floor() else { return seeds };
    let most = surface.points() / seeds.len().max(1);
    let mut all = Vec::with_capacity(seeds.len());
    for seed in seeds {
        all.push(seed);
        let Some(from) = seed.from else { continue };
        let start = seed.time - grid.length(seed.place() - from);
        let points = Diagonal::through(&seed, from).into_iter().flat_map(|it| it.points(surface));
        all.extend(points.take(most).map(|(row, col)| {
            let ahead = grid.length(DVec2::new(row as f64, col as f64) - from);
            Seed {
                row,
                col,
                time: start + ahead,
                curvature: 1.0 / ahead,
                from: Some(from),
                origin: seed.origin,
                exact: false,
                heading: Heading::Everywhere,
                source: 0,
            }
        }));
    }
    all
}

/// Two lines of points on either side of a diagonal. The front reaches each point from between the two points
/// before it, one on each line.
struct Diagonal {
    /// The first point on each line.
    first: [[isize; 2]; 2],
    /// The step from a point to the next on its line.
    step: [isize; 2],
}

impl Diagonal {
    /// Returns the diagonal from the source at `from` past the corner of its cell at which `seed` lies. The
    /// result is `None` if the seed lies on the row or column of the source, or more than one row or column
    /// away from it, or if the diagonal runs through grid points.
    fn through(seed: &Seed, from: DVec2) -> Option<Self> {
        let way = seed.place() - from;
        let [rows, cols] = way.abs().to_array();
        let is_beside = rows > 0.0 && cols > 0.0 && rows <= 1.0 && cols <= 1.0 && rows != cols;
        let step = way.to_array().map(|part| part.signum() as isize);
        let corner = [seed.row as isize, seed.col as isize];
        let back = if rows > cols { [step[0], 0] } else { [0, step[1]] };
        let other = [corner[0] - back[0], corner[1] - back[1]];
        is_beside.then_some(Self { first: [other, corner], step })
    }

    /// Returns the row and column of each point after the first ones, up to the first hole or the border.
    fn points(self, surface: &Surface) -> impl Iterator<Item = (usize, usize)> {
        let there = |[row, col]: [isize; 2]| {
            surface.chart().at(row, col).filter(|&(row, col)| surface.has(row, col))
        };
        let Self { first: [mut before, mut last], step } = self;
        let mut starts = there(before).is_some() && there(last).is_some();
        std::iter::from_fn(move || {
            starts.then_some(())?;
            (before, last) = (last, [before[0] + step[0], before[1] + step[1]]);
            let next = there(last);
            starts = next.is_some();
            next
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Chart, Sources, Spacing};

    fn plan(rows: usize, cols: usize, holes: &[(usize, usize)]) -> Surface {
        let plane = Surface::from_heights(rows, cols, vec![0.0; rows * cols], Spacing::square(1.0));
        let chart = Chart { rows, cols };
        let floor: Vec<_> = chart.places().map(|place| !holes.contains(&place)).collect();
        plane.unwrap().with_mask(&floor).unwrap()
    }

    fn added(surface: &Surface, sources: &Sources) -> Vec<Seed> {
        let own = sources.seeds(surface).unwrap();
        let mut all = with_diagonals(surface, own.clone());
        all.retain(|seed| !own.contains(seed));
        all
    }

    #[test]
    fn seeds_lie_within_a_cell_of_a_diagonal_at_their_distance_from_the_source() {
        let surface = plan(20, 30, &[]);
        for (row, col) in [(8.25, 11.5), (8.5, 11.25), (8.0, 11.5), (8.25, 11.0), (18.75, 0.125)] {
            let found = added(&surface, &Sources::point(row, col));
            let of = |seed: &Seed| [seed.row as f64 - row, seed.col as f64 - col].map(f64::abs);
            for seed in &found {
                let [rows, cols] = of(seed);
                assert!((rows - cols).abs() < 1.0, "{seed:?}");
                approx::assert_relative_eq!(seed.time, rows.hypot(cols), max_relative = 1e-14);
                assert_eq!(seed.from, Some(DVec2::new(row, col)));
            }
            // All grid points within a cell of a diagonal, except the corners of the source's own cells.
            let all = (0..600)
                .map(|index| Seed::at_source(index / 30, index % 30, 0.0))
                .filter(|seed| {
                    let [rows, cols] = of(seed);
                    (rows - cols).abs() < 1.0 && rows.max(cols) > 1.0
                })
                .count();
            assert_eq!(found.len(), all, "{row} {col}");
        }
    }

    #[test]
    fn sources_whose_diagonals_run_through_points_need_none() {
        let surface = plan(20, 30, &[]);
        assert_eq!(added(&surface, &Sources::point(8.0, 11.0)).len(), 0);
        assert_eq!(added(&surface, &Sources::point(8.5, 11.5)).len(), 0);
    }

    #[test]
    fn diagonals_end_at_holes() {
        let found = added(&plan(20, 30, &[(12, 15)]), &Sources::point(8.25, 11.5));
        let ahead = |seed: &&Seed| seed.row > 9 && seed.col > 12;
        let places: Vec<_> = found.iter().filter(ahead).map(|seed| (seed.row, seed.col)).collect();
        assert_eq!(places, [(10, 13), (10, 14), (11, 14), (11, 15)]);
    }

    #[test]
    fn many_sources_have_no_more_seeds_than_there_are_points() {
        let surface = plan(40, 40, &[]);
        let places = (0..1000).map(|k| (f64::from(k % 37) + 0.3, f64::from(k / 37) + 0.6));
        let sources = places.fold(Sources::default(), |all, (r, c)| all.and_point(r, c, 0.0));
        let found = added(&surface, &sources);
        assert!(!found.is_empty() && found.len() <= 1600, "{}", found.len());
    }
}
