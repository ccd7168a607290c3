//! Solves the surroundings of sources inside cells before the whole grid.
//!
//! A scan follows rays up to 45 degrees from its direction. The rays of a source at a grid point stay between
//! grid points of one scan. But a ray of a source inside a cell that runs close to a diagonal passes between two grid
//! points that different scans reach. Point after point, each of these scans then has to wait for the other's next
//! iteration. Some cells away from the source the times hardly change any more, but each change is passed on to the end
//! of the grid, so that maps would take two to three times as many iterations. So the source's surroundings are solved
//! first, as a small map in which iterations cost nothing. For a renderer's sources, which may be known on the device
//! only, `glsl/passes/surroundings.comp` does this.
//!
//! On a surface with obtuse triangles fronts are causal ([`geosweep_surface::Origins`]). A front that takes a
//! detour along an edge is a little late. Close to the source, where the front bends most, all later times
//! would inherit this error. But there the front cannot meet itself yet and need not be causal. So a lone
//! source has surroundings for this reason too, also at a grid point.

mod around;
mod clusters;
mod each_alone;
mod skewed;
mod straight;

use std::collections::BTreeMap;

use glam::DVec2;
use rayon::prelude::*;

use around::Surroundings;
use clusters::around_clusters;
use each_alone::each_alone;
use geosweep_surface::update::{Setting, Wavefront};
use geosweep_surface::{Direction, EdgeLengths, Real, Seed, Surface, with_diagonals};
use skewed::around_skewed_cells;
use straight::fronts_of_seeds;
pub use straight::{FirstArrival, StraightFronts, needed_straight_fronts, straight_parts};

/// Maximum number of rows and columns around a source's cell in its surroundings. With 8, maps from inside
/// cells take as many iterations as from grid points, or one more. With 4 they take one or two more.
const REACH: usize = 8;
/// Maximum number of rows and columns for a lone source among obtuse triangles. The mean error on peaks of
/// 1025 x 1025 points is 2.7e-6 with 8, 2.1e-6 with 12 and 2.0e-6 with 16. The last figure is also the error of fronts
/// that are not causal at all.
const REACH_AMONG_OBTUSE: usize = 16;
/// Minimum number of rows and columns. Fewer would gain little.
const LEAST_REACH: usize = 4;
/// Minimum number of grid points per point of all surroundings together. Solving one point of the
/// surroundings takes about as long as the surroundings save at `SHARE` grid points.
const SHARE: usize = 40;
/// Minimum number of grid points for surroundings among obtuse triangles. On smaller grids they would take
/// more than a twentieth of the time of the whole map, and few iterations are saved there.
const LEAST_AMONG_OBTUSE: usize = 1_000_000;
/// Maximum number of sources in long cells that get surroundings on any grid, also at grid points. In long cells, maps
/// of several sources are less accurate than maps of one source, since updates of several sources are causal
/// ([`geosweep_surface::Origins`]). Without surroundings the error is up to ten times as large, and a fifth of the
/// distance where long cells bend.
const MOST_IN_LONG_CELLS: usize = 8;
/// Maximum number of rows and columns of these surroundings. They reach as far across long cells as along them.
const MOST_ACROSS: usize = 64;
/// Number of rows and columns that the points that split triangles may be away without maps from grid points being late.
const NEAR: usize = 2;
/// Ratio of a cell's edges, or of its diagonals, above which the cell is long.
const LONG: f64 = 1.5;

/// Returns the seeds from which engines solve best with a wavefront. For sources inside cells it adds seeds
/// around the source, up to some cells away; for anchored fronts, the added seeds lie along the diagonals instead.
/// Without added seeds, maps are the same but take up to three times as many iterations. With anchored fronts they
/// would take about as many iterations as a diagonal has points.
///
/// On a large surface with obtuse triangles around a lone source, seeds around the source are added wherever it
/// lies. They make the map more accurate.
///
/// ```
/// use geosweep::{Sources, Wavefront, cpu::seeds_for, surface::builtin::Builtin};
/// let surface = Builtin::Sphere.surface(200, 200)?;
/// let seeds = Sources::point(60.3, 80.75).seeds(&surface)?;
/// assert_eq!(seeds.len(), 4);
/// assert!(seeds_for(Wavefront::Curved, &surface, seeds).len() > 200);
/// # Ok::<(), geosweep::Error>(())
/// ```
pub fn seeds_for(wavefront: Wavefront, surface: &Surface, seeds: Vec<Seed>) -> Vec<Seed> {
    match wavefront.or_curved(Setting::of_engine(surface.is_floor_plan())) {
        Wavefront::Planar | Wavefront::Rays => around_skewed_cells(surface, seeds),
        Wavefront::Anchored => with_diagonals(surface, seeds),
        wavefront @ (Wavefront::Circular | Wavefront::Curved) => {
            with_origins(wavefront, surface, around_skewed_cells(surface, seeds))
        }
    }
}

/// Returns the seeds, and for each source inside a cell the fronts in its surroundings, as further seeds. Each point
/// has only its earliest seed. The order is row-major. `in_skewed_cells` tells whether a lone source in skewed cells has
/// surroundings on small grids too.
fn with_surroundings(
    wavefront: Wavefront,
    surface: &Surface,
    seeds: Vec<Seed>,
    in_skewed_cells: bool,
) -> Vec<Seed> {
    let among_obtuse = among_obtuse_triangles(wavefront, surface, &seeds, in_skewed_cells);
    let around: Vec<_> = if let Some(around) = among_obtuse {
        around
    } else {
        let by_source = by_source(&seeds);
        let Some(reach) = reach(surface, by_source.len()) else { return seeds };
        let around = by_source.into_par_iter().flat_map_iter(|(source, own)| {
            let surroundings = Surroundings::new(surface, source, [reach; 2]);
            surroundings.on_surface(surroundings.seeds(wavefront, &own))
        });
        around.collect()
    };
    Seed::earliest(seeds.iter().copied().chain(around))
}

/// Returns the seeds of [`with_surroundings`], given seeds with their origins. Around sources that lie close together
/// it adds exact seeds from maps of each source alone. Where all cells are alike and fronts meet, it adds exact seeds at
/// all points that straight lines reach.
fn with_origins(wavefront: Wavefront, surface: &Surface, mut seeds: Vec<Seed>) -> Vec<Seed> {
    let straight = if wavefront.is_curved() { fronts_of_seeds(surface, &seeds) } else { None };
    if let Some(fronts) = straight.as_ref().filter(|fronts| !fronts.has_holes()) {
        return fronts.seeds();
    }
    if let Some(exact) = each_alone(wavefront, surface, &seeds) {
        return exact;
    }
    let exact = match straight {
        Some(fronts) => fronts.seeds(),
        None => around_clusters(wavefront, surface, &seeds),
    };
    let in_long_cells = few_in_long_cells(wavefront, surface, &seeds);
    seeds.iter_mut().for_each(|seed| seed.origin = None);
    // Of two seeds that differ by rounding, the exact one is kept.
    let is_exact: BTreeMap<_, _> =
        exact.iter().map(|seed| ((seed.row, seed.col), seed.time)).collect();
    let mut all = match in_long_cells {
        Some(around) => Seed::earliest(seeds.into_iter().chain(around)),
        None => with_surroundings(wavefront, surface, seeds, true),
    };
    all.retain(|seed| {
        let time = is_exact.get(&(seed.row, seed.col));
        time.is_none_or(|time| seed.time < time - SAME_TIME * time.abs())
    });
    Seed::earliest(all.into_iter().chain(exact))
}

/// Relative difference below which times count as equal.
const SAME_TIME: f64 = 1e-7;

/// Returns the seeds that come from points inside cells, grouped by these points.
fn by_source(seeds: &[Seed]) -> Vec<(DVec2, Vec<Seed>)> {
    grouped(seeds.iter().filter_map(|seed| {
        // Around an end of a straight line, the front is that of the whole line.
        let is_of_line = seed.origin.is_some_and(|origin| !origin.is_point());
        seed.from.filter(|_| !is_of_line).map(|from| (from, *seed))
    }))
}

/// Returns seeds grouped by the positions given with them.
fn grouped(seeds: impl IntoIterator<Item = (DVec2, Seed)>) -> Vec<(DVec2, Vec<Seed>)> {
    let mut found = BTreeMap::<_, (DVec2, Vec<Seed>)>::new();
    for (from, seed) in seeds {
        let key = from.to_array().map(f64::to_bits);
        found.entry(key).or_insert((from, Vec::new())).1.push(seed);
    }
    found.into_values().collect()
}

/// Returns the fronts in the surroundings of a lone source, as seeds, if some triangles around the source are obtuse. On
/// small grids there are surroundings in skewed cells alone, if `in_skewed_cells` is set.
fn among_obtuse_triangles(
    wavefront: Wavefront,
    surface: &Surface,
    seeds: &[Seed],
    in_skewed_cells: bool,
) -> Option<Vec<Seed>> {
    let origin = |seed: &Seed| seed.from.unwrap_or(seed.place());
    let source = origin(seeds.first()?);
    let is_lone = seeds.iter().all(|seed| origin(seed) == source);
    if !is_lone {
        return None;
    }
    let is_large = surface.chart().points() >= LEAST_AMONG_OBTUSE;
    if !(is_large || in_skewed_cells && is_skewed(surface, source)) {
        return None;
    }
    let surroundings = Surroundings::new(surface, source, [REACH_AMONG_OBTUSE; 2]);
    if !surroundings.edges()?.has_obtuse_triangles() {
        return None;
    }
    let own: Vec<_> = seeds.iter().map(|seed| Seed { from: Some(source), ..*seed }).collect();
    Some(surroundings.on_surface(surroundings.seeds(wavefront, &own)))
}

/// Returns whether neighbours of a place are not the nearest points, so that points far away split triangles. On glued
/// surfaces, where they are not searched far away, the result is false.
fn is_skewed(surface: &Surface, place: DVec2) -> bool {
    !surface.is_glued() && surface.skew_around(place) > 1
}

/// Returns the reach of the surroundings of `sources` sources, or `None` if there are no sources or too many.
fn reach(surface: &Surface, sources: usize) -> Option<usize> {
    let points = surface.chart().points().checked_div(SHARE * sources)?;
    let reach = (points.isqrt() / 2).saturating_sub(1).min(REACH);
    (reach >= LEAST_REACH).then_some(reach)
}

/// Returns the fronts in the surroundings of a few point sources, as seeds, if any of the sources lies in long or skewed
/// cells.
fn few_in_long_cells(wavefront: Wavefront, surface: &Surface, seeds: &[Seed]) -> Option<Vec<Seed>> {
    let by_point = by_point(seeds)?;
    if !(2..=MOST_IN_LONG_CELLS).contains(&by_point.len()) {
        return None;
    }
    let reach = |at: DVec2| {
        let in_skewed_cells = || is_skewed(surface, at).then_some([REACH_AMONG_OBTUSE; 2]);
        reach_in_long_cells(surface, at).or_else(in_skewed_cells)
    };
    let reaches: Vec<_> = by_point.iter().map(|(at, _)| reach(*at)).collect();
    reaches.iter().any(Option::is_some).then(|| {
        let around =
            by_point.into_par_iter().zip(reaches).flat_map_iter(|((source, own), reach)| {
                let surroundings =
                    Surroundings::new(surface, source, reach.unwrap_or([LEAST_REACH; 2]));
                surroundings.on_surface(surroundings.seeds(wavefront, &own))
            });
        around.collect()
    })
}

/// Returns the seeds of point sources, grouped by these points, or `None` if some seeds come from no point.
fn by_point(seeds: &[Seed]) -> Option<Vec<(DVec2, Vec<Seed>)>> {
    let of_point = |seed: &Seed| {
        let from = seed.from.unwrap_or(seed.place());
        // Cells differ here, so straight lines of the chart are not straight on the surface.
        let unnamed = Seed { from: Some(from), origin: None, ..*seed };
        seed.origin?.is_point().then_some((from, unnamed))
    };
    Some(grouped(seeds.iter().map(of_point).collect::<Option<Vec<_>>>()?))
}

/// Returns the reach of surroundings in rows and columns if a cell beside a source is long. In space, the reach across
/// the cells equals that along them.
fn reach_in_long_cells(surface: &Surface, source: DVec2) -> Option<[usize; 2]> {
    let cells = surface.chart().around_place(source, 1);
    let cells = surface.window(cells.rows, cells.cols);
    let edges = EdgeLengths::<f64>::new(&cells).ok()?;
    let longest = |to: Direction| {
        let lengths = cells.chart().places().map(|(row, col)| edges.length(row, col, to));
        lengths.filter(|&length| length < f64::FAR).fold(0.0, f64::max)
    };
    let [col, row, rising, falling] =
        [Direction::East, Direction::North, Direction::NorthEast, Direction::NorthWest]
            .map(longest);
    let ratio = |a: f64, b: f64| if b > 0.0 { a / b } else { 1.0 };
    let pairs = [ratio(col, row), ratio(row, col), ratio(rising, falling), ratio(falling, rising)];
    let is_long = pairs.iter().any(|&ratio| ratio > LONG);
    let reach =
        |ratio: f64| ((LEAST_REACH as f64 * ratio) as usize).clamp(LEAST_REACH, MOST_ACROSS);
    is_long.then(|| [reach(pairs[0]), reach(pairs[1])])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotated::rotated_scan;
    use geosweep_surface::Stop;
    use geosweep_surface::builtin::Builtin;
    use geosweep_surface::{Sources, Spacing};

    const SINGLE: Stop = Stop::within(1e-6).or_after(1000);
    const DOUBLE: Stop = Stop::within(1e-13).or_after(1000);

    fn map(surface: &Surface, wavefront: Wavefront, seeds: &[Seed]) -> Vec<f64> {
        let edges = EdgeLengths::<f64>::new(surface).unwrap();
        rotated_scan(&edges, seeds, wavefront, DOUBLE).distances()
    }

    /// Asserts that the map with surroundings equals the map without them. Returns the number of seeds. For one source,
    /// the maps may differ by the tolerance to which the surroundings are solved. Maps of several sources are causal
    /// ([`geosweep_surface::Origins`]) except in the surroundings, which have one source each. Without surroundings, the
    /// first fronts in stretched cells are late by up to a tenth of a cell.
    fn assert_same_map(surface: &Surface, wavefront: Wavefront, sources: &Sources) -> usize {
        let tolerance = if sources.iter().count() > 1 { 1e-3 } else { 1e-8 };
        let own = sources.seeds(surface).unwrap();
        let seeds = seeds_for(wavefront, surface, own.clone());
        let [alone, with] = [&own, &seeds].map(|seeds| map(surface, wavefront, seeds));
        let largest = alone.iter().copied().filter(|d| d.is_finite()).fold(0.0, f64::max);
        for (index, (alone, with)) in alone.iter().zip(with).enumerate() {
            let same = alone.is_infinite() && with.is_infinite()
                || (alone - with).abs() < tolerance * largest;
            assert!(same, "{wavefront} {:?}: {alone} {with}", surface.chart().position(index));
        }
        seeds.len()
    }

    #[test]
    fn maps_from_inside_cells_take_about_as_many_iterations_as_from_grid_points() {
        for builtin in [Builtin::Plane, Builtin::Sphere, Builtin::Torus, Builtin::Peaks] {
            let surface = builtin.surface(300, 300).unwrap();
            let edges = EdgeLengths::<f32>::new(&surface).unwrap();
            let own = |row, col| Sources::point(row, col).seeds(&surface).unwrap();
            for wavefront in [Wavefront::Circular, Wavefront::Curved] {
                let iterations =
                    |seeds: &[Seed]| rotated_scan(&edges, seeds, wavefront, SINGLE).iterations;
                let at_point = iterations(&own(100.0, 125.0));
                let mut saved = 0;
                for (row, col) in [(100.0, 125.25), (100.3, 125.9), (100.75, 125.625)] {
                    let seeds = own(row, col);
                    let alone = iterations(&seeds);
                    let with = iterations(&seeds_for(wavefront, &surface, seeds));
                    // From a grid point one iteration is enough, and a second one confirms it.
                    let most = at_point.max(3) + 1;
                    assert!(with <= most, "{builtin} {wavefront} {row} {col}: {with}, {at_point}");
                    saved += alone - with;
                }
                assert!(saved >= 2, "{builtin} {wavefront}: {saved} of three maps");
            }
        }
    }

    #[test]
    fn maps_are_those_without_surroundings() {
        let mask: Vec<_> = (0..160 * 160).map(|k| k % 97 != 13 || k % 160 > 90).collect();
        for (builtin, masked) in
            [(Builtin::Sphere, false), (Builtin::Torus, false), (Builtin::Plane, true)]
        {
            let whole = builtin.surface(160, 160).unwrap();
            let surface = if masked { whole.with_mask(&mask).unwrap() } else { whole };
            for wavefront in [Wavefront::Circular, Wavefront::Curved] {
                // The sources lie in the middle of the grid, on a side of a cell, and beside the grid's corner.
                for (row, col) in [(80.3, 100.75), (81.0, 100.5), (0.25, 158.5)] {
                    let seeds = assert_same_map(&surface, wavefront, &Sources::point(row, col));
                    assert!(seeds > 80, "{builtin}: {seeds}");
                }
                let two = Sources::point(80.3, 100.75).and_point(84.5, 103.5, 0.02);
                assert_same_map(&surface, wavefront, &two);
            }
        }
    }

    /// Without surroundings, a causal front is late at a triangle eight cells from the source, and the mean error is
    /// 2.9e-6.
    #[test]
    fn a_lone_source_among_obtuse_triangles_has_surroundings_at_a_grid_point_too() {
        let peaks = Builtin::Peaks.surface(1025, 1025).unwrap();
        let seeds = |surface: &Surface, sources: Sources| {
            seeds_for(Wavefront::Curved, surface, sources.seeds(surface).unwrap())
        };
        let around = seeds(&peaks, Sources::point(320.0, 416.0));
        assert_eq!(around.len(), (2 * REACH_AMONG_OBTUSE + 1).pow(2));
        assert_eq!(seeds(&peaks, Sources::point(320.0, 416.0).and_point(5.0, 6.0, 0.0)).len(), 2);
        let sphere = Builtin::Sphere.surface(1025, 1025).unwrap();
        assert_eq!(seeds(&sphere, Sources::point(320.0, 416.0)).len(), 1);

        let edges = EdgeLengths::<f32>::new(&peaks).unwrap();
        let map = rotated_scan(&edges, &around, Wavefront::Curved, SINGLE).distances();
        let exact = Builtin::Peaks.reference_distances(1025, 1025, [320.0, 416.0]);
        let error = |(map, exact): (&f32, &f64)| (f64::from(*map) - exact).abs() / exact;
        let errors: Vec<_> = map.iter().zip(&exact).filter(|(_, d)| **d > 0.0).map(error).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!(mean < 2.2e-6, "{mean}");
    }

    /// Around a wall the front comes from outside the surroundings, earlier than by any path inside.
    #[test]
    fn fronts_from_outside_replace_those_of_the_surroundings() {
        let (rows, cols) = (130, 140);
        let fast = |k: usize| if k % cols > 80 { 0.01 } else { 1.0 };
        let plane = Surface::from_heights(rows, cols, vec![0.0; rows * cols], Spacing::square(1.0));
        let surface = plane.unwrap().with_slowness((0..rows * cols).map(fast).collect()).unwrap();
        // The wall reaches from the fast half past the source, which lies beside the wall.
        let wall = |k: usize| k / cols != 60 || k % cols < 66 || k % cols > 90;
        let surface = surface.with_mask(&(0..rows * cols).map(wall).collect::<Vec<_>>()).unwrap();
        for wavefront in [Wavefront::Circular, Wavefront::Curved] {
            assert!(assert_same_map(&surface, wavefront, &Sources::point(58.5, 73.25)) > 200);
        }
    }

    #[test]
    fn planar_fronts_grid_points_small_grids_and_crowds_have_none() {
        let surface = Builtin::Sphere.surface(150, 150).unwrap();
        let added = |wavefront: Wavefront, surface: &Surface, sources: &Sources| {
            let own = sources.seeds(surface).unwrap();
            let seeds = seeds_for(wavefront, surface, own.clone());
            assert!(own.iter().all(|seed| seeds.contains(seed)));
            seeds.len() - own.len()
        };
        let inside = Sources::point(60.3, 80.75);
        assert_eq!(added(Wavefront::Planar, &surface, &inside), 0);
        assert_eq!(added(Wavefront::Curved, &surface, &Sources::point(60.0, 80.0)), 0);
        let small = Builtin::Sphere.surface(40, 40).unwrap();
        assert_eq!(added(Wavefront::Curved, &small, &Sources::point(20.3, 20.75)), 0);
        let one = added(Wavefront::Curved, &surface, &inside);
        assert_eq!(one, 18 * 18 - 4);
        // On this surface, curved fronts replace anchored ones, so the same points are added.
        assert_eq!(added(Wavefront::Anchored, &surface, &inside), one);
        let crowd = |count: usize| {
            let place = |k: usize| (5.3 + 14.0 * (k / 10) as f64, 5.75 + 14.0 * (k % 10) as f64);
            let add = |all: Sources, (row, col)| all.and_point(row, col, 0.0);
            (0..count).map(place).fold(Sources::default(), add)
        };
        let five = added(Wavefront::Curved, &surface, &crowd(5));
        assert!((5 * 80..5 * 150).contains(&five), "{five}");
        assert_eq!(added(Wavefront::Curved, &surface, &crowd(50)), 0);
    }
}
