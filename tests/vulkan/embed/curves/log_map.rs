//! Log maps in the host's frames.

use geosweep::Surface;
use geosweep::geometry;
use geosweep::surface::builtin::Builtin;
use geosweep::vulkan::embed::{self, LogMapFrame, PointSource, Reader, SourceInput};

use super::Scene;
use crate::common::closed::flat;
use crate::embed::stage::{Kept, on_cpu, sources_at as at};

fn read(scene: &mut Scene, log_map: &embed::LogMapImage, frame: &LogMapFrame) -> Vec<[f32; 2]> {
    let bytes = scene.copy_of(8, |recording| recording.log_map(log_map, frame).unwrap());
    let float = |bytes: &[u8]| f32::from_ne_bytes(bytes.try_into().unwrap());
    bytes.chunks_exact(8).map(|of| [float(&of[..4]), float(&of[4..])]).collect()
}

fn new_log_map(scene: &mut Scene) -> embed::LogMapImage {
    let stage = &mut scene.stage;
    let device = stage.host.device.clone();
    let new = stage.solver.log_map(&device, stage.host.allocator(), &stage.surface).unwrap();
    let stated = stage.solver.bytes_for_log_map(&device, stage.surface.chart());
    assert_eq!(stated.unwrap(), new.bytes());
    new
}

/// Compares a log map with the CPU's. Returns the mean and the median error relative to the farthest distance,
/// and the share of points off by more than a tenth of this distance.
fn compare(name: &str, surface: &Surface, sources: &[PointSource]) -> [f64; 3] {
    let mut scene = Scene::new(Kept::watched_but_for_shaders(), surface, sources);
    let mut log_map = new_log_map(&mut scene);
    let frame = LogMapFrame::new(SourceInput::Inline(sources), Reader::COPY);
    let found = read(&mut scene, &log_map, &frame);
    // A second recording gives the same coordinates.
    let again = read(&mut scene, &log_map, &frame);
    assert!(
        bytemuck::cast_slice::<_, u8>(&again) == bytemuck::cast_slice::<_, u8>(&found),
        "{name}"
    );
    let exact = geometry::LogMap::new(surface, &on_cpu(sources)).unwrap();
    let farthest = scene.map.report.max_distance;
    let mut errors = Vec::new();
    for (index, (found, exact)) in found.iter().zip(&exact.coordinates).enumerate() {
        let time = scene.map.distances[index];
        let place = surface.chart().position(index);
        assert_eq!(found[0].is_finite(), time.is_finite(), "{name}: {found:?} at {place:?}");
        if !time.is_finite() || exact[0].is_nan() {
            continue;
        }
        let [u, v] = [0, 1].map(|k| f64::from(found[k] - exact[k]));
        errors.push(u.hypot(v) / farthest);
    }
    errors.sort_by(f64::total_cmp);
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let median = errors[errors.len() / 2];
    let off = errors.iter().filter(|error| **error > 0.1).count() as f64 / errors.len() as f64;
    let largest = errors[errors.len() - 1];
    println!("{name}: mean {mean:.1e}, median {median:.1e}, largest {largest:.1e}, off {off:.1e}");
    scene.end_with(|device, allocator| log_map.destroy(device, allocator));
    [mean, median, off]
}

/// Errors are relative to the farthest distance. Rounding gives 1e-5. On curved surfaces the metric at the source is
/// accurate to second order, and ways between grid points are means of the ways at the points around.
#[test]
fn coordinates_are_those_of_the_cpu() {
    let mut later = at(&[[10.5, 12.25], [40.0, 50.75]]);
    later[0].time = 10.0;
    let builtin = |of: Builtin| of.surface(129, 129).unwrap();
    let cases = [
        ("plane", flat(129, 129), at(&[[64.0, 64.0]]), [1e-4; 2]),
        ("plane, between points", flat(129, 129), at(&[[30.3, 40.6]]), [1e-4; 2]),
        ("plane, two", flat(65, 81), at(&[[15.0, 17.0], [47.0, 60.5]]), [1e-4; 2]),
        ("plane, one later", flat(65, 81), later, [1e-4; 2]),
        ("cylinder", builtin(Builtin::Cylinder), at(&[[64.0, 64.0]]), [1e-4; 2]),
        ("sphere", builtin(Builtin::Sphere), at(&[[64.0, 64.0]]), [3e-4; 2]),
        ("sphere, between points", builtin(Builtin::Sphere), at(&[[30.3, 40.6]]), [3e-4; 2]),
        ("torus", builtin(Builtin::Torus), at(&[[30.3, 40.6]]), [2e-3; 2]),
        // Paths spread so strongly that their directions at the source are hard to tell.
        ("peaks", builtin(Builtin::Peaks), at(&[[64.0, 64.0]]), [2e-2, 1e-2]),
        ("maze", Builtin::Maze.surface(101, 101).unwrap(), at(&[[1.0, 2.0]]), [2e-2, 1e-2]),
    ];
    for (name, surface, sources, within) in &cases {
        let [mean, median, off] = compare(name, surface, sources);
        assert!(mean < within[0] && median < within[1], "{name}: {mean} {median} {off}");
    }
}

/// Inside the radius, coordinates are those of the whole log map, to the bit.
#[test]
fn beyond_the_radius_there_are_no_coordinates() {
    let surface = Builtin::Sphere.surface(65, 65).unwrap();
    let sources = at(&[[20.25, 30.5]]);
    let mut scene = Scene::new(Kept::watched_but_for_shaders(), &surface, &sources);
    let mut log_map = new_log_map(&mut scene);
    let frame = LogMapFrame::new(SourceInput::Inline(&sources), Reader::COPY).with_unreached(-7.0);
    let whole = read(&mut scene, &log_map, &frame);
    let radius = 0.4 * scene.map.report.max_distance as f32;
    let within = read(&mut scene, &log_map, &frame.with_radius(radius));
    let cell = 0.05;
    for ((found, whole), time) in within.iter().zip(&whole).zip(&scene.map.distances) {
        if *time > radius {
            assert_eq!(*found, [-7.0; 2]);
        } else if *time < radius - 2.0 * cell {
            assert_eq!(found, whole);
        }
    }
    let refused = |radius: f32| {
        let stage = &scene.stage;
        stage.host.run(|commands| {
            let recording = stage.solver.record(&stage.host.device, commands, &stage.surface);
            recording.log_map(&log_map, &frame.with_radius(radius)).unwrap_err().to_string()
        })
    };
    for radius in [0.0, -1.0, f32::NAN] {
        let error = refused(radius);
        assert!(error.contains("radius") && error.contains("not positive"), "{error}");
    }
    scene.end_with(|device, allocator| log_map.destroy(device, allocator));
}
