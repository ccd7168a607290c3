//! Edges that shaders measure from a host's points, compared with those of the twin, which the headless
//! solver uploads. The comparison uses the maps after one iteration.

use geosweep::Stop;
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{Chart, EdgeRule};
use geosweep::vulkan::embed::SourceInput;
use geosweep::vulkan::{Method, Schedule};
use geosweep::{Sources, Spacing, Surface, Wavefront};

use crate::common::{difference, rough, some_point, vulkan_solver};
use crate::embed::stage::{Kept, RASTER, Stage, numbers_of, source};

/// Largest difference between maps from the same points: rounding.
const SAME: f64 = 1e-5;

/// For chords, and for arcs around holes and across creases, the shader's lengths equal its twin's.
#[test]
fn both_rules_for_edges_are_those_of_the_twin() {
    let mut solver = vulkan_solver();
    let folded = (0..60 * 50).map(|i| f64::from(i % 50 - 20).abs().max(f64::from(i / 50).sqrt()));
    let spacing = Spacing { dx: 1.0, dy: 1.3 };
    let folded = Surface::from_heights(60, 50, folded.collect(), spacing).unwrap();
    let torus = Builtin::Torus.surface(61, 70).unwrap();
    for surface in [torus, rough(60, 50, 7), folded] {
        let (chart, (row, col)) = (surface.chart(), some_point(&surface));
        let sources = Sources::point(row as f64, col as f64);
        for edge_rule in [EdgeRule::Chord, EdgeRule::Arc] {
            let surface = surface.clone().with_edge_rule(edge_rule);
            let numbers = numbers_of(&surface);
            let stage = Stage::on(Kept::watched(), &RASTER, (&surface, None), numbers);
            for wavefront in Wavefront::FOR_ANY_SURFACE {
                let (stop, schedule) = (Stop::after(1), Some(Schedule::Raster));
                let method = Method::new(wavefront, stop).with_schedule(schedule);
                let mut on_device = solver.upload(&surface).unwrap();
                let seeds = sources.seeds(&surface).unwrap();
                let map = solver.solve(&mut on_device, &seeds, method).unwrap();
                let plan = stage.solver.plan(chart, method, 1).unwrap();
                stage.solve(SourceInput::Inline(&source(row as f32, col as f32)), &plan);
                let difference = difference(&map.distances, &stage.read());
                assert!(difference < SAME, "{edge_rule:?}, {wavefront}: {difference}");
            }
            stage.end([]);
        }
    }
}

/// The surface is given by heights, and has more rows than are measured at once. Every point has its own edges.
#[test]
fn all_rows_of_a_large_surface_are_measured() {
    let chart = Chart { rows: 141, cols: 8001 };
    let heights = (0..chart.points()).map(|index| {
        let (row, col) = chart.position(index);
        f64::from((0.3 * row as f32).sin() * (0.2 * col as f32).cos())
    });
    let spacing = Spacing { dx: 0.5, dy: 1.0 };
    let surface = Surface::from_heights(chart.rows, chart.cols, heights.collect(), spacing);
    let surface = surface.unwrap();
    let passes = [(Schedule::Raster, Wavefront::Circular)];
    let stage = Stage::on(Kept::watched(), &passes, (&surface, None), numbers_of(&surface));
    let stop = Stop::after(1);
    let schedule = Some(Schedule::Raster);
    let method = Method::new(Wavefront::Circular, stop).with_schedule(schedule);
    let plan = stage.solver.plan(chart, method, 1).unwrap();
    stage.solve(SourceInput::Inline(&source(70.0, 4000.0)), &plan);
    let mut solver = vulkan_solver();
    let mut on_device = solver.upload(&surface).unwrap();
    let seeds = Sources::point(70.0, 4000.0).seeds(&surface).unwrap();
    let map = solver.solve(&mut on_device, &seeds, method).unwrap();
    let difference = difference(&map.distances, &stage.read());
    assert!(difference < SAME, "{difference}");
    stage.end([]);
}
