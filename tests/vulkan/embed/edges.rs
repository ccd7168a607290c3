//! Edges that shaders measure from a host's points, compared with those of the twin, which the headless
//! solver uploads. The comparison uses the maps after one iteration.

use geosweep::Stop;
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{Chart, EdgeRule, Geometry};
use geosweep::vulkan::embed::{
    Access, PointKind, PointMemory, Points, Reader, SourceInput, SurfaceInfo,
};
use geosweep::vulkan::{Method, Schedule};
use geosweep::{Sources, Spacing, Surface, Wavefront};

use crate::common::{difference, rough, some_point, vulkan_solver};
use crate::embed::stage::{Kept, RASTER, Stage, source};

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
        let (kind, numbers) = match surface.geometry() {
            Geometry::Heights { heights, spacing } => {
                (PointKind::Heights(*spacing), heights.iter().map(|&h| h as f32).collect())
            }
            Geometry::Positions(positions) => {
                let floats = positions.iter().flat_map(|at| at.as_vec3().to_array());
                (PointKind::Positions, floats.collect::<Vec<_>>())
            }
            Geometry::Metric(_) => unreachable!("no surface here has one"),
        };
        for edge_rule in [EdgeRule::Chord, EdgeRule::Arc] {
            let mut host = Kept::watched();
            let buffer = host.buffer_of(&numbers);
            let stride = 4 * (numbers.len() / chart.points()) as u64;
            let memory = PointMemory::Buffer { buffer: buffer.handle, offset: 0, stride };
            let points = [Points { memory, kind, slowness: None }];
            let info = SurfaceInfo::new(chart).with_points(&points).with_edge_rule(edge_rule);
            let stage = Stage::new(host, &RASTER, &info);
            for wavefront in Wavefront::FOR_ANY_SURFACE {
                let (stop, schedule) = (Stop::after(1), Some(Schedule::Raster));
                let method = Method::new(wavefront, stop).with_schedule(schedule);
                let mut on_device =
                    solver.upload(&surface.clone().with_edge_rule(edge_rule)).unwrap();
                let seeds = sources.seeds(&surface).unwrap();
                let map = solver.solve(&mut on_device, &seeds, method).unwrap();
                let plan = stage.solver.plan(chart, method, 1).unwrap();
                let own = SourceInput::Inline(&source(row as f32, col as f32));
                stage.run(|recording| {
                    recording.begin(Access::NONE);
                    recording.measure(0).unwrap();
                    recording.solve(own, &plan).unwrap();
                    recording.result(0, Reader::COPY, f32::INFINITY)
                });
                let difference = difference(&map.distances, &stage.read());
                assert!(difference < SAME, "{edge_rule:?}, {wavefront}: {difference}");
            }
            stage.end([buffer]);
        }
    }
}

/// The surface is given by heights, and has more rows than are measured at once. Every point has its own edges.
#[test]
fn all_rows_of_a_large_surface_are_measured() {
    let chart = Chart { rows: 141, cols: 8001 };
    let height = |index: usize| {
        let (row, col) = chart.position(index);
        (0.3 * row as f32).sin() * (0.2 * col as f32).cos()
    };
    let heights: Vec<_> = (0..chart.points()).map(height).collect();
    let spacing = Spacing { dx: 0.5, dy: 1.0 };
    let surface = {
        let heights = heights.iter().map(|&height| height.into()).collect();
        Surface::from_heights(chart.rows, chart.cols, heights, spacing).unwrap()
    };
    let mut host = Kept::watched();
    let points = host.buffer_of(&heights);
    let memory = PointMemory::Buffer { buffer: points.handle, offset: 0, stride: 4 };
    let kind = PointKind::Heights(spacing);
    let inputs = [Points { memory, kind, slowness: None }];
    let info = SurfaceInfo::new(chart).with_points(&inputs);
    let stage = Stage::new(host, &[(Schedule::Raster, Wavefront::Circular)], &info);
    let stop = Stop::after(1);
    let schedule = Some(Schedule::Raster);
    let method = Method::new(Wavefront::Circular, stop).with_schedule(schedule);
    let plan = stage.solver.plan(chart, method, 1).unwrap();
    stage.run(|recording| {
        recording.begin(Access::NONE);
        recording.measure(0).unwrap();
        recording.solve(SourceInput::Inline(&source(70.0, 4000.0)), &plan).unwrap();
        recording.result(0, Reader::COPY, f32::INFINITY)
    });
    let mut solver = vulkan_solver();
    let mut on_device = solver.upload(&surface).unwrap();
    let seeds = Sources::point(70.0, 4000.0).seeds(&surface).unwrap();
    let map = solver.solve(&mut on_device, &seeds, method).unwrap();
    let difference = difference(&map.distances, &stage.read());
    assert!(difference < SAME, "{difference}");
    stage.end([points]);
}
