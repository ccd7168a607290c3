//! Maps over fields of fibres, along which lengths are up to 30 times shorter than across: muscle, layered rock.

use geosweep::geometry::Voronoi;
use geosweep::glam::DVec2;
use geosweep::surface::{EdgeLengths, MetricTensor};
use geosweep::{
    Engine, Error, Options, Sources, Surface, Wavefront, distance_map, distance_map_f64,
    estimate_error,
};

use crate::common::Random;
use crate::common::fibres::Fibres;

/// Largest and mean relative error of a map, and the share of points that are late by more than a hundredth.
struct Errors {
    late: f64,
    early: f64,
    mean: f64,
    share: f64,
}

fn errors(fibres: Fibres, sources: &[DVec2], distances: &[f64]) -> Errors {
    let exact = fibres.places().map(|at| {
        let all: Option<Vec<f64>> = sources.iter().map(|&from| fibres.distance(from, at)).collect();
        all.map(|all| all.into_iter().fold(f64::INFINITY, f64::min))
    });
    let known = exact.zip(distances).filter_map(|(exact, found)| Some((exact?, *found)));
    let errors: Vec<_> =
        known.filter(|(exact, _)| *exact > 0.0).map(|(exact, found)| found / exact - 1.0).collect();
    assert!(errors.len() > 500, "{fibres:?}");
    let count = errors.len() as f64;
    Errors {
        late: errors.iter().copied().fold(0.0, f64::max),
        early: errors.iter().copied().fold(0.0, f64::min),
        mean: errors.iter().map(|error| error.abs()).sum::<f64>() / count,
        share: errors.iter().filter(|error| **error > 0.01).count() as f64 / count,
    }
}

/// Fields with ratios of 3 to 30, by rows and by columns, with fibres that bend by less than a cell in the distance at
/// which points split triangles.
fn fields() -> Vec<Fibres> {
    let mut random = Random::new(81);
    let mut all = Vec::new();
    for ratio in [3.0, 7.0, 12.0, 15.0, 21.0, 30.0] {
        for is_transposed in [false, true] {
            let cols = 70 + (60.0 * random.next()) as usize;
            let rows = 50 + (40.0 * random.next()) as usize;
            let amplitude = (0.03 + 0.07 * random.next()) * cols as f64;
            all.push(Fibres { rows, cols, ratio, amplitude, is_transposed });
        }
    }
    all
}

/// Returns a place well inside a field; a grid point if `is_point` is set.
fn place(fibres: Fibres, random: &mut Random, is_point: bool) -> DVec2 {
    let mut along = |points: usize| (0.3 + 0.4 * random.next()) * points as f64;
    let at = DVec2::new(along(fibres.rows), along(fibres.cols));
    let at = if fibres.is_transposed { DVec2::new(at.y, at.x) } else { at };
    if is_point { at.round() } else { at }
}

#[test]
fn fibres_that_turn_have_the_distances_of_the_plane_that_they_come_from() {
    let mut random = Random::new(82);
    for fibres in fields() {
        for (surface, is_point) in [(fibres.by_positions(), true), (fibres.by_metric(), false)] {
            let source = place(fibres, &mut random, is_point);
            let sources = Sources::point(source.x, source.y);
            let map = distance_map_f64(&surface, &sources, &Options::default()).unwrap();
            assert!(map.report.converged && map.report.unresolved.is_none());
            let Errors { late, early, mean, share } = errors(fibres, &[source], &map.distances);
            let told =
                format!("{fibres:?} {source}: {late:.1e} {early:.1e} {mean:.1e} {share:.1e}");
            // Beside the source, fibres that bend are not straight over the points that a ray passes between.
            let at_point = if fibres.ratio > 25.0 { 0.3 } else { 0.05 };
            let beside = if is_point { [-3e-3, at_point] } else { [-0.01, 0.6] };
            assert!(late < beside[1] && early > beside[0], "{told}");
            assert!(mean < 1.5e-3 && share < 0.03, "{told}");
        }
    }
}

#[test]
fn regions_of_several_sources_in_sheared_cells_belong_to_the_nearest_one() {
    let mut random = Random::new(83);
    for fibres in fields() {
        let surface = fibres.by_positions();
        let at = [true, true, false].map(|is_point| place(fibres, &mut random, is_point));
        if at.iter().any(|a| at.iter().any(|b| a != b && a.distance(*b) < 8.0)) {
            continue;
        }
        let sources = at[1..].iter().fold(Sources::point(at[0].x, at[0].y), |sources, at| {
            sources.and_point(at.x, at.y, 0.0)
        });
        let options = Options::default().with_engine(Engine::Cpu);
        let map = distance_map(&surface, &sources, &options).unwrap();
        let wide: Vec<f64> = map.distances.iter().map(|&d| d.into()).collect();
        let Errors { mean, share, .. } = errors(fibres, &at, &wide);
        assert!(mean < 4e-3 && share < 0.1, "{fibres:?} {at:?}: {mean:.1e} {share:.1e}");
        let edges = EdgeLengths::new(&surface).unwrap();
        let regions = Voronoi::new(&surface, &edges, &sources, &map.distances).unwrap();
        let mut wrong = 0;
        for (place, &label) in fibres.places().zip(&regions.labels) {
            assert!((label as usize) < at.len(), "{fibres:?} {place}");
            let all = at.map(|from| fibres.distance(from, place));
            let Some(own) = all[label as usize] else { continue };
            let first = all.into_iter().flatten().fold(own, f64::min);
            wrong += usize::from(own > 1.03 * first + 1.0);
        }
        assert!(wrong * 200 < regions.labels.len(), "{fibres:?} {at:?}: {wrong}");
    }
}

#[test]
fn every_point_that_a_single_source_reaches_is_its_own() {
    use geosweep::surface::builtin::Builtin;
    for degrees in [45.0, 59.0, 70.0, 85.0] {
        let surface = Builtin::ShearedPlane { degrees }.surface(11, 23).unwrap();
        let sources = Sources::point(3.0, 3.0);
        let map = distance_map(&surface, &sources, &Options::default()).unwrap();
        let edges = EdgeLengths::new(&surface).unwrap();
        let regions = Voronoi::new(&surface, &edges, &sources, &map.distances).unwrap();
        assert!(regions.labels.iter().all(|&label| label == 0));
        assert!((regions.areas(&surface)[0] - geosweep::geometry::area(&surface)).abs() < 1e-9);
    }
}

/// Returns a metric whose long axis turns from point to point.
fn turning(ratio: f64) -> Surface {
    let tensor = |k: usize| {
        let axis = DVec2::from_angle(0.01 * (k % 40) as f64 + 0.4);
        let along = |a: f64, b: f64| a * b * (ratio * ratio - 1.0);
        MetricTensor {
            rr: 1.0 + along(axis.x, axis.x),
            rc: along(axis.x, axis.y),
            cc: 1.0 + along(axis.y, axis.y),
        }
    };
    Surface::from_metric(30, 40, (0..1200).map(tensor).collect()).unwrap()
}

#[test]
fn fields_that_updates_do_not_resolve_are_told_and_have_no_estimate() {
    for engine in [Engine::Cpu, Engine::FastMarching] {
        let options = Options::default().with_engine(engine).with_wavefront(Wavefront::Planar);
        let source = Sources::point(15.0, 20.0);
        let report = |ratio| distance_map(&turning(ratio), &source, &options).unwrap().report;
        assert_eq!(report(15.0).unresolved, None);
        let found = report(200.0).unresolved.unwrap();
        assert!(found.needed > found.seen && found.row < 30 && found.col < 40);
        let error = estimate_error(&turning(200.0), &source, &options).unwrap_err();
        assert!(matches!(error, Error::Unresolved(told) if told == found), "{error}");
    }
}
