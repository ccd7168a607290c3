//! Frames in sheared and skewed cells, with [`SurfaceInfo::has_skewed_cells`].

use geosweep::glam::{DVec2, DVec3};
use geosweep::surface::EdgeRule;
use geosweep::surface::Gluing;
use geosweep::vulkan::Schedule;
use geosweep::vulkan::embed::{Outcome, PointSource, SourceInput, SurfaceInfo};
use geosweep::{MetricTensor, Surface, Wavefront};

use crate::common::Random;
use crate::common::fibres::Fibres;
use crate::embed::stage::{Kept, Stage, numbers_of};

const PASSES: [(Schedule, Wavefront); 2] =
    [(Schedule::Raster, Wavefront::Curved), (Schedule::Tiles, Wavefront::Curved)];

/// Returns a metric whose axes have a ratio. The short one has an angle to the direction of increasing rows.
fn tensor(ratio: f64, angle: f64) -> MetricTensor {
    let axis = DVec2::from_angle(angle);
    let along = |a: f64, b: f64| a * b * (ratio * ratio - 1.0);
    MetricTensor {
        rr: 1.0 + along(axis.x, axis.x),
        rc: along(axis.x, axis.y),
        cc: 1.0 + along(axis.y, axis.y),
    }
}

fn stage_of(surface: &Surface, is_skewed: bool) -> Stage {
    let numbers = numbers_of(surface);
    Stage::on_changed(Kept::watched(), &PASSES, (surface, None), numbers, |info| {
        info.with_skewed_cells(is_skewed)
    })
}

/// Returns the relative errors of a map at all points whose distance is known, and its outcome.
fn errors(
    stage: &Stage,
    (schedule, wavefront): (Schedule, Wavefront),
    sources: &[DVec2],
    exact: impl Fn(DVec2) -> Option<f64>,
) -> (Vec<f64>, Outcome) {
    let iterations = if schedule == Schedule::Tiles { 300 } else { 12 };
    let plan = stage.plan(schedule, wavefront, iterations);
    let sources: Vec<_> =
        sources.iter().map(|at| PointSource::at(at.x as f32, at.y as f32)).collect();
    let map = stage.map(0, SourceInput::Inline(&sources), &plan);
    let chart = stage.surface.chart();
    let places = (0..chart.points()).map(|index| chart.position(index));
    let known = places.zip(map).filter_map(|((row, col), found)| {
        let exact = exact(DVec2::new(row as f64, col as f64))?;
        (exact > 0.0).then(|| f64::from(found) / exact - 1.0)
    });
    (known.collect(), stage.surface.outcome(0).unwrap())
}

fn mean(errors: &[f64]) -> f64 {
    errors.iter().map(|error| error.abs()).sum::<f64>() / errors.len() as f64
}

fn largest(errors: &[f64]) -> f64 {
    errors.iter().fold(0.0, |most, error| most.max(error.abs()))
}

/// Single precision keeps about seven digits of squares whose ratio is the square of that of the axes.
#[test]
fn constant_metrics_up_to_a_ratio_of_30_are_exact_from_anywhere() {
    let mut random = Random::new(91);
    for ratio in [5.0, 12.0, 20.0, 30.0] {
        let metric = tensor(ratio, 3.1 * random.next());
        let surface = Surface::from_metric(40, 50, vec![metric; 2000]).unwrap();
        let stage = stage_of(&surface, true);
        for passes in PASSES {
            let inside = DVec2::new(12.0 + 15.0 * random.next(), 14.0 + 20.0 * random.next());
            for from in [inside, inside.round()] {
                let exact = |at: DVec2| {
                    let step = at - from.as_vec2().as_dvec2();
                    let MetricTensor { rr, rc, cc } = metric;
                    let mixed = 2.0 * rc * step.x * step.y;
                    Some((rr * step.x * step.x + mixed + cc * step.y * step.y).sqrt())
                };
                let (errors, outcome) = errors(&stage, passes, &[from], exact);
                let worst = largest(&errors);
                assert!(worst < 1e-4, "{ratio} {metric:?} {passes:?} {from}: {worst:.1e}");
                assert!(mean(&errors) < 2e-6, "{ratio} {metric:?} {passes:?} {from}");
                assert!(outcome.converged && outcome.unresolved.is_none());
            }
        }
        stage.end([]);
    }
}

#[test]
fn fibres_that_turn_have_the_distances_of_the_plane_that_they_come_from() {
    let mut random = Random::new(92);
    for (ratio, is_transposed) in [(7.0, true), (15.0, false), (22.0, true), (30.0, false)] {
        let amplitude = 4.0 + 4.0 * random.next();
        let fibres = Fibres { rows: 70, cols: 90, ratio, amplitude, is_transposed };
        let surface = fibres.by_positions().with_edge_rule(EdgeRule::Chord);
        let stage = stage_of(&surface, true);
        for passes in PASSES {
            let inside = DVec2::new(30.0 + 10.0 * random.next(), 30.0 + 20.0 * random.next());
            for from in [inside, inside.round()] {
                let exact = |at: DVec2| fibres.distance(from, at);
                let (errors, outcome) = errors(&stage, passes, &[from], exact);
                let (worst, mean) = (largest(&errors), mean(&errors));
                let told = format!("{fibres:?} {passes:?} {from}: {worst:.1e} {mean:.1e}");
                // Beside a source inside a cell, straight lines of the chart are not quite straight.
                assert!(worst < if from == from.round() { 1e-3 } else { 0.06 }, "{told}");
                assert!(mean < 5e-4 && outcome.converged, "{told}");
                assert_eq!(outcome.unresolved, None, "{told}");
            }
        }
        stage.end([]);
    }
}

/// Sources are told apart in their surroundings alone, and fronts of both meet outside. There, maps are up to a few per
/// cent early or late.
#[test]
fn several_sources_in_skewed_cells_are_about_as_far_as_the_nearest() {
    let fibres = Fibres { rows: 70, cols: 90, ratio: 15.0, amplitude: 6.0, is_transposed: false };
    let surface = fibres.by_positions().with_edge_rule(EdgeRule::Chord);
    let stage = stage_of(&surface, true);
    let sources = [DVec2::new(25.4, 30.7), DVec2::new(44.0, 60.0), DVec2::new(33.8, 62.2)];
    let exact = |at: DVec2| {
        let all: Option<Vec<f64>> = sources.iter().map(|&from| fibres.distance(from, at)).collect();
        Some(all?.into_iter().fold(f64::INFINITY, f64::min))
    };
    for passes in PASSES {
        let (errors, outcome) = errors(&stage, passes, &sources, exact);
        let off = errors.iter().filter(|error| error.abs() > 0.02).count();
        let told = format!("{passes:?}: {:.1e}, {off} of {}", mean(&errors), errors.len());
        assert!(mean(&errors) < 5e-3 && off * 10 < errors.len() && outcome.converged, "{told}");
    }
    stage.end([]);
}

/// Returns a metric of axes with a ratio, the longer of which turns from point to point.
fn turning(rows: usize, cols: usize, ratio: f64) -> Surface {
    let tensor = |k: usize| tensor(ratio, 0.01 * (k % cols) as f64 + 0.002 * (k / cols) as f64);
    Surface::from_metric(rows, cols, (0..rows * cols).map(tensor).collect()).unwrap()
}

#[test]
fn outcomes_tell_the_place_that_updates_do_not_resolve() {
    let positions = |shear: f64| {
        let position = |k: usize| {
            let (row, col) = ((k / 60) as f64, (k % 60) as f64);
            let bump = if row > 60.0 { shear * (row - 60.0) } else { 0.0 };
            DVec3::new(col + bump, row, 0.0)
        };
        Surface::from_positions(90, 60, (0..90 * 60).map(position).collect()).unwrap()
    };
    let surfaces = [
        (turning(30, 40, 4.0), [false; 2]),
        (turning(120, 70, 18.0), [true, false]),
        (turning(90, 130, 200.0), [true; 2]),
        (positions(3.2), [false; 2]),
        (positions(9.3), [true, false]),
        (positions(-40.7), [true; 2]),
    ];
    for (surface, expected) in surfaces {
        let surface = surface.with_edge_rule(EdgeRule::Chord);
        for (is_skewed, is_told) in [false, true].into_iter().zip(expected) {
            let stage = stage_of(&surface, is_skewed);
            let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 1);
            // A second measurement starts anew.
            for _ in 0..2 {
                stage.solve(SourceInput::Inline(&[PointSource::at(3.0, 4.0)]), &plan);
            }
            let found = stage.surface.outcome(0).unwrap().unresolved;
            assert_eq!(found.is_some(), is_told, "{:?} {is_skewed}: {found:?}", surface.chart());
            // The CPU, which looks as far as frames in skewed cells, tells the same place.
            if is_skewed && !surface.has_even_cells() {
                assert_eq!(found, surface.unresolved(), "{:?}", surface.chart());
            }
            stage.end([]);
        }
    }
}

#[test]
fn skewed_cells_of_glued_grids_are_refused() {
    let chart = geosweep::surface::Chart { rows: 20, cols: 30 };
    let mut stage = Stage::new(Kept::watched(), &PASSES[..1], &SurfaceInfo::new(chart));
    let gluing = Gluing::both();
    let info = SurfaceInfo::new(chart).with_gluing(&gluing).with_skewed_cells(true);
    let device = stage.host.device.clone();
    let error = stage.solver.surface(&device, stage.host.allocator(), &info).unwrap_err();
    assert!(error.to_string().contains("skewed"), "{error}");
    stage.end([]);
}
