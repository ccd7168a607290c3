//! Estimates the error of a map from maps of coarser grids, or over floor plans from the map of a finer one.
//!
//! A map's error grows in a known way with the distance h between grid points. Therefore the change from one
//! grid to a coarser one tells the error itself. The form of the error depends on the wavefront:
//!
//! - planar: h log(1/h) and h, from the singularity at a point source and away from it;
//! - circular: h and h^2, from the curvature that bends the front and from the chords;
//! - curved: h^2.
//!
//! Let d1 be the growth of a distance from the grid of all points to the grid of every second point, and d2
//! its growth from there to the grid of every fourth point. For these three forms the errors are 3 d1 - d2,
//! (5 d1 - d2) / 3 and d1 / 3. On rough surfaces a curved front is of a lower order, which |d2| / |d1| over
//! the whole map shows.

mod error_estimate;
mod floor_plan;

pub use error_estimate::ErrorEstimate;

use crate::Options;
use crate::solve::{Precision, Problem, in_precision};
use crate::surface::{
    Coarsened, Groups, Real, Seed, Source, SourceError, Sources, Surface, SurfaceError,
};
use crate::update::{Setting, Wavefront};
use crate::{DistanceMap, Error};

/// Computes a map as [`distance_map`](crate::distance_map) does, and estimates its error.
///
/// It solves again on every second and every fourth point, which takes a third more time. Over floor plans,
/// if fronts have anchors, it solves on a grid twice as fine instead, and the whole takes four to five times
/// as long as the map alone.
///
/// The estimate is for a converged map on grids that are fine enough for the surface. It cannot include what
/// no grid shows, such as a ridge between points, or the corners of a curve given as a polyline. The table
/// gives values measured with 65 to 257 points per side:
///
/// | surface, sources | mean estimate over mean error | errors below twice the estimate |
/// |---|---|---|
/// | sphere, cylinder, cone; one grid point | 1.0 to 1.4 | 99 % |
/// | the same; two grid points | 1.1 to 3.5 | 99 % |
/// | the same; a point between grid points | 1.1 to 1.7 | 91 to 100 % |
/// | rough terrain: planar front | 1.0 to 1.6 | 90 to 98 % |
/// | rough terrain: circular front | 4 to 5 | 100 % |
/// | rough terrain: curved front | 2 to 2.4 | 99.9 % |
/// | maze: planar, circular, curved front | 15 to 27, 33 to 51, 1000 | 98 to 100 % |
/// | floor plans, anchored front: rounding | 2.8 to 4.7 | 98.7 to 100 % |
/// | floor plans with single points missing, anchored front | 2.0 | 98.9 to 99.5 % |
///
/// Behind holes the estimate is far too large for other fronts than anchored ones if the outlines of the
/// holes are exact, as in the maze: it assumes that outlines are known only to within a grid step.
///
/// The extrapolated distances have a fraction of the map's error:
///
/// - Planar front: 3 to 15 % from sources at grid points, half from a source between them, and two thirds on
///   rough terrain.
/// - Circular front: 1 to 15 % on sphere, cylinder and cone, up to 70 % from two sources. On rough
///   terrain the error is doubled.
/// - Curved front: 0.1 to 18 % on sphere, cylinder and cone, up to 30 % from two sources. On rough terrain
///   half of the error is left.
/// - Anchored front: the distances are those of the finer grid. They are as accurate as the map's distances,
///   and where single points are missing they have 1 to 3 % of the map's error.
///
/// Extrapolated distances are worse than the map by far where paths bend around holes, and worse where the
/// map's error is rounding, as on a plane.
///
/// ```
/// use geosweep::{Engine, Options, Sources, Wavefront, estimate_error};
/// use geosweep::surface::builtin::Builtin;
///
/// let surface = Builtin::Sphere.surface(65, 65)?;
/// let options = Options::default().with_engine(Engine::Cpu).with_wavefront(Wavefront::Planar);
/// let estimate = estimate_error(&surface, &Sources::point(20.0, 30.0), &options)?;
/// let exact = Builtin::Sphere.exact_distance(65, 65, [20.0, 30.0], [64.0, 64.0]).unwrap() as f32;
/// let error = (estimate.map.distance(64, 64) - exact).abs();
/// let estimated = estimate.errors[64 * 65 + 64];
/// assert!(estimated > 0.5 * error && estimated < 2.0 * error);
/// assert!((estimate.extrapolated[64 * 65 + 64] - exact).abs() < 0.2 * error);
/// # Ok::<(), geosweep::Error>(())
/// ```
///
/// # Errors
/// The errors of [`distance_map`](crate::distance_map). Where coarser grids are compared, it is also an error
/// if cells are too skewed for updates ([`Surface::unresolved`]), if a side of the grid has two points or both sides have
/// one, if no point near a source is left on the
/// coarser grid, or if the seams of a glued surface do not meet on that grid ([`Surface::coarsened`]).
pub fn estimate_error(
    surface: &Surface,
    sources: &Sources,
    options: &Options,
) -> Result<ErrorEstimate, Error> {
    estimate(surface, sources, options)
}

/// Computes a map and its error in double precision, on the CPU, as
/// [`distance_map_f64`](crate::distance_map_f64) does. See [`estimate_error`].
///
/// # Errors
/// The errors of [`estimate_error`]. It is also an error to request a Vulkan device or a schedule.
pub fn estimate_error_f64(
    surface: &Surface,
    sources: &Sources,
    options: &Options,
) -> Result<ErrorEstimate<f64>, Error> {
    estimate(surface, sources, options)
}

fn estimate<R: Precision>(
    surface: &Surface,
    sources: &Sources,
    options: &Options,
) -> Result<ErrorEstimate<R>, Error> {
    if options.resolve_wavefront(surface, sources)? == Wavefront::Anchored
        && let Some(fine) = surface.halved_floor()
    {
        let map = in_precision::<R>(surface, sources, options, None)?;
        let options = options.clone().with_targets(None);
        return floor_plan::estimate(map, &fine, sources, &options);
    }
    // These checks come first, since a surface that is too small or too skewed needs no map.
    let coarse = surface.coarsened(&grid_points(surface, sources))?;
    if let Some(unresolved) = surface.unresolved() {
        return Err(Error::Unresolved(unresolved));
    }
    let map = in_precision::<R>(surface, sources, options, None)?;
    // All grids use one engine, since their differences are the estimate.
    // Targets are points of the finest grid, so the other grids are solved without targets.
    let engine = options.engine.as_for(&map.report);
    let options = &options.clone().with_engine(engine).with_targets(None);
    let first = Level::new(surface, coarse, sources, &map, options)?;
    let second = first.coarser(options)?;
    let weights = Weights::of(map.report.wavefront);
    let mut errors: Vec<_> = first.growth.iter().map(|d1| weights.two * d1).collect();
    if let (Some(second), Some([w1, w2])) = (&second, weights.three) {
        let d2 = second.coarse.spread(&second.growth);
        let terms = errors.iter_mut().zip(&first.growth).zip(&d2);
        let known = terms.filter(|(_, d2)| d2.is_finite());
        known.for_each(|((error, d1), d2)| *error = w1 * d1 + w2 * d2);
    }
    let observed_order = second.as_ref().and_then(|second| first.observed_order(second));
    let caution = match (weights.three, observed_order) {
        (None, Some(order)) => weights.caution(order),
        _ => 1.0,
    };
    let (errors, extrapolated) = first.on_the_fine_grid(&errors, caution, &map, sources.start());
    // A map with anchored fronts comes here only if its floor plan is too large for a finer grid. The growth
    // of its distances shows that corners have moved, not an error of the map.
    let is_exact = map.report.wavefront == Wavefront::Anchored;
    let extrapolated = if is_exact { map.distances.clone() } else { extrapolated };
    let levels = || [Some(&first), second.as_ref()].into_iter().flatten();
    let further_solve_time = levels().map(|level| level.map.report.solve_time).sum();
    let grids = 1 + levels().count() as u32;
    Ok(ErrorEstimate { map, errors, extrapolated, observed_order, grids, further_solve_time })
}

/// The weights with which the error follows from the growth of distances on coarser grids.
struct Weights {
    /// Weight of d1, for two grids.
    two: f64,
    /// Weights of d1 and d2, if a third grid improves the estimate.
    three: Option<[f64; 2]>,
}

impl Weights {
    fn of(wavefront: Wavefront) -> Self {
        match wavefront {
            Wavefront::Planar => Self { two: 1.0, three: Some([3.0, -1.0]) },
            Wavefront::Circular => Self { two: 1.0, three: Some([5.0 / 3.0, -1.0 / 3.0]) },
            Wavefront::Curved | Wavefront::Anchored | Wavefront::Rays => {
                Self { two: 1.0 / 3.0, three: None }
            }
        }
    }

    /// Returns the correction factor for an estimate that assumes fourfold growth of errors from grid to grid, where
    /// less growth is observed. Growth counts as at least twofold, the first order.
    fn caution(&self, observed_order: f64) -> f64 {
        let growth = observed_order.clamp(1.0, 2.0).exp2();
        1.0 / (growth - 1.0) / self.two
    }
}

/// Returns the grid points nearest to the point sources, ordered by starting time. If these points are on all
/// grids, the singularity there is the same on all of them, except for its size.
fn grid_points(surface: &Surface, sources: &Sources) -> Vec<[usize; 2]> {
    let mut points: Vec<_> = sources
        .iter()
        .filter_map(|source| match source {
            Source::Point { at, initial } => Some((at, initial)),
            Source::Curve { .. } => None,
        })
        .collect();
    points.sort_by(|a, b| a.1.total_cmp(b.1));
    // Places off the grid, or NaN, are refused when seeds are made of them.
    let on = |x: f64, points: usize| (x.round().max(0.0) as usize).min(points - 1);
    points.iter().map(|(at, _)| [on(at.x, surface.rows()), on(at.y, surface.cols())]).collect()
}

/// A map on a coarser grid, with the comparison to the next finer one.
struct Level<R> {
    coarse: Coarsened,
    sources: Sources,
    map: DistanceMap<R>,
    /// Growth of the distance from the finer grid to this one. It is infinite where one of the two maps does
    /// not reach.
    growth: Vec<f64>,
}

impl<R: Precision> Level<R> {
    fn new(
        surface: &Surface,
        coarse: Coarsened,
        sources: &Sources,
        fine: &DistanceMap<R>,
        options: &Options,
    ) -> Result<Self, Error> {
        let seeds = coarse_seeds(surface, &coarse, sources, fine)?;
        let coarse_sources = coarse.sources(sources);
        // An even grid may become uneven when it is coarsened. Its fronts then have no anchors.
        let over = Setting::of_engine(coarse.surface().is_floor_plan());
        let wavefront = options.wavefront.map(|wavefront| wavefront.or_curved(over));
        let options = &options.clone().with_wavefront(wavefront);
        let problem = Problem::from_seeds::<R>(coarse.surface(), seeds, &coarse_sources, options)?;
        let map = R::solve(&problem, &options.engine)?;
        let pairs = coarse.indices().zip(&map.distances);
        let growth = pairs.map(|(index, &coarse)| {
            let growth = coarse.wide() - fine.distances[index].wide();
            if growth.is_finite() { growth } else { f64::INFINITY }
        });
        let growth = growth.collect();
        Ok(Self { coarse, sources: coarse_sources, map, growth })
    }

    /// Returns the level of the next coarser grid, if there is such a grid and its map can start from each
    /// source.
    fn coarser(&self, options: &Options) -> Result<Option<Self>, Error> {
        let surface = self.coarse.surface();
        let coarse = match surface.coarsened(&grid_points(surface, &self.sources)) {
            Ok(coarse) => coarse,
            Err(SurfaceError::TooSmall { .. } | SurfaceError::Gluing(_)) => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        match Self::new(surface, coarse, &self.sources, &self.map, options) {
            Ok(level) => Ok(Some(level)),
            Err(Error::Source(_)) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Returns the order with which distances grow from this grid to the next coarser one.
    fn observed_order(&self, coarser: &Self) -> Option<f64> {
        let pairs = coarser.coarse.indices().map(|index| self.growth[index]).zip(&coarser.growth);
        let (sum1, sum2) = pairs
            .filter(|(d1, d2)| d1.is_finite() && d2.is_finite())
            .fold((0.0, 0.0), |(sum1, sum2), (d1, d2)| (sum1 + d1.abs(), sum2 + d2.abs()));
        (sum1 > 0.0 && sum2 > 0.0).then(|| f64::log2(sum2 / sum1))
    }

    /// Converts the errors at this grid's points to estimates for the finer grid, multiplied by `caution`. Also returns
    /// the finer grid's distances minus the errors.
    fn on_the_fine_grid(
        &self,
        errors: &[f64],
        caution: f64,
        map: &DistanceMap<R>,
        start: f64,
    ) -> (Vec<R>, Vec<R>) {
        let signed = self.coarse.spread(errors).into_iter();
        let bounds = self.coarse.spread(&self.largest_around(errors));
        let points = map.distances.iter().zip(signed).zip(bounds);
        points
            .map(|((&distance, error), bound)| {
                let rounding = R::epsilon().wide() * (distance.wide() - start);
                match distance.is_finite() {
                    true if error.is_finite() => {
                        let extrapolated = (distance.wide() - error).max(start);
                        (R::of(caution * bound + rounding), R::of(extrapolated))
                    }
                    _ => (R::infinity(), distance),
                }
            })
            .unzip()
    }

    /// Returns the largest error of each point and its neighbours. Where the sign of `errors` changes, the
    /// values pass through zero, although the true error need not be small there. The error also jumps at the
    /// lines where fronts meet.
    fn largest_around(&self, errors: &[f64]) -> Vec<f64> {
        let chart = self.map.chart;
        let around = |index: usize| {
            let places = chart.around(chart.position(index), 1).places();
            places.map(move |(row, col)| chart.index(row, col))
        };
        let mut largest: Vec<f64> = (0..errors.len())
            .map(|index| {
                if errors[index].is_infinite() {
                    return f64::INFINITY;
                }
                let known = around(index).map(|k| errors[k].abs()).filter(|e| e.is_finite());
                known.fold(0.0, f64::max)
            })
            .collect();
        // A point of a seam has neighbours beside all of its copies.
        for group in self.coarse.surface().copies().into_iter().flat_map(Groups::iter) {
            let copies = || group.iter().map(|&copy| copy as usize);
            let error = copies().map(|copy| largest[copy]).fold(0.0, f64::max);
            copies().for_each(|copy| largest[copy] = error);
        }
        largest
    }
}

/// Returns the sources as seeds of the coarse grid. A source in a cell that has become a hole, or beyond the
/// last remaining row or column, starts from the finer map's distances at the points beside it.
fn coarse_seeds<R: Real>(
    surface: &Surface,
    coarse: &Coarsened,
    sources: &Sources,
    fine: &DistanceMap<R>,
) -> Result<Vec<Seed>, SourceError> {
    let mut all = Vec::new();
    for source in sources.iter() {
        let source: Sources = [source.clone()].into_iter().collect();
        let seeds = match coarse.sources(&source).seeds_with_origins(coarse.surface()) {
            Err(SourceError::Hole { .. } | SourceError::Outside { .. }) => {
                seeds_beside(coarse, &source.seeds(surface)?, fine)?
            }
            seeds => seeds?,
        };
        all.extend(seeds);
    }
    Ok(Seed::earliest(all))
}

/// Returns seeds at the coarse points that are at most a fine step from fine seeds.
fn seeds_beside<R: Real>(
    coarse: &Coarsened,
    fine_seeds: &[Seed],
    fine: &DistanceMap<R>,
) -> Result<Vec<Seed>, SourceError> {
    let mut seeds = Vec::new();
    for seed in fine_seeds {
        let beside = |lines: &[usize], line: usize| {
            let first = lines.partition_point(|&found| found + 1 < line);
            first..lines.partition_point(|&found| found <= line + 1)
        };
        for row in beside(coarse.rows(), seed.row) {
            for col in beside(coarse.cols(), seed.col) {
                let time = fine.distance(coarse.rows()[row], coarse.cols()[col]).wide();
                if coarse.surface().has(row, col) && time.is_finite() {
                    // The radius of the front grows as it advances.
                    let step = (time - seed.time).max(0.0);
                    let curvature = seed.curvature / (1.0 + seed.curvature * step);
                    seeds.push(Seed {
                        row,
                        col,
                        time,
                        curvature,
                        from: None,
                        origin: None,
                        exact: false,
                        heading: geosweep_surface::Heading::Everywhere,
                        source: 0,
                    });
                }
            }
        }
    }
    match fine_seeds.first() {
        Some(seed) if seeds.is_empty() => {
            Err(SourceError::NotOnCoarseGrid { row: seed.row, col: seed.col })
        }
        _ => Ok(seeds),
    }
}
