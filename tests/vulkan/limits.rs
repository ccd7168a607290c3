//! Maps on a device that end at a radius or at targets: their distances are those of the whole map, and their
//! visits those of the area they reach.

use geosweep::cpu::twins::{Rounds, ScanOrder, scan_due, tile_rounds_within};
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{EdgeLengths, Seed};
use geosweep::vulkan::{HeadlessSolution, HeadlessSolver, Method, Schedule, SurfaceOnDevice};
use geosweep::{Engine, Options, Sources, Stop, Targets, Wavefront};

use crate::common::closed::flat;
use crate::common::parts::{assert_is_part, assert_targets_end_maps, farthest, reached};
use crate::common::*;
use crate::headless::{FEW_TILES, is_processor};
use crate::tile_lanes::problems;

fn method(wavefront: Wavefront, schedule: Schedule) -> Method {
    Method::new(wavefront, CONVERGED).with_schedule(schedule)
}

/// The radius is read from a buffer, so maps with a radius are recorded and compiled like maps without one. A radius
/// beyond the map changes no bit.
#[test]
fn distances_within_a_radius_are_those_of_the_whole_map() {
    let mut solver = vulkan_solver();
    for (number, problem) in problems().into_iter().enumerate() {
        let mut surface = solver.upload(&problem.surface).unwrap();
        for &wavefront in problem.wavefronts {
            for schedule in Schedule::ALL {
                let method = method(wavefront, schedule);
                let whole = solver.solve(&mut surface, &problem.seeds, method).unwrap();
                for share in [0.1, 0.4, 0.8] {
                    let radius = share * farthest(&whole.distances);
                    let near = method.with_radius(radius);
                    let near = solver.solve(&mut surface, &problem.seeds, near).unwrap();
                    let what = format!("{}, {wavefront}, {schedule}, {share}", problem.what);
                    assert_is_part(&near.distances, &whole.distances, radius, &what);
                }
                if number >= 3 {
                    continue;
                }
                let wide = method.with_radius(2.0 * farthest(&whole.distances));
                let wide = solver.solve(&mut surface, &problem.seeds, wide).unwrap();
                let what = format!("{}, {wavefront}, {schedule}", problem.what);
                assert!(wide.distances == whole.distances, "{what}");
                assert_eq!(wide.iterations, whole.iterations, "{what}");
            }
        }
    }
}

/// The maps are compared after one, two, five and nine iterations or rounds.
#[test]
fn maps_with_a_radius_are_those_of_the_twins() {
    let mut solver = vulkan_solver();
    let (tuning, exact) = (solver.tuning(), is_processor(&solver));
    let surface = Builtin::Peaks.surface(70, 83).unwrap();
    let edges = EdgeLengths::<f32>::new(&surface).unwrap();
    let seeds = Sources::point(30.0, 41.0).seeds(&surface).unwrap();
    let mut on_device = solver.upload(&surface).unwrap();
    let (tile, inner, few) =
        (tuning.tile as usize, tuning.inner, if exact { 0 } else { FEW_TILES });
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        let whole = solver.solve(&mut on_device, &seeds, method(wavefront, Schedule::Tiles));
        let radius = 0.3 * farthest(&whole.unwrap().distances);
        for stop in [1, 2, 5, 9].map(|count| Stop::within(1e-6).or_after(count)) {
            let mut on = |schedule| {
                let method = method(wavefront, schedule).with_stop(stop).with_radius(radius);
                solver.solve(&mut on_device, &seeds, method).unwrap()
            };
            let what = format!("{wavefront}, {stop:?}");
            let tiles = on(Schedule::Tiles);
            let recorded = stop.iterations;
            let rounds = Rounds { tile, inner, recorded, few: Some(few) };
            let (twin, visits) =
                tile_rounds_within(&edges, &seeds, wavefront, stop, rounds, radius);
            assert_is_part(&tiles.distances, &twin.distances(), radius, &what);
            // On GPUs, rounding may decide which tile waits.
            assert!(tiles.visits == visits || !exact, "{what}: {}, {visits}", tiles.visits);
            let raster = on(Schedule::Raster);
            let order = if tuning.scan_pairs { ScanOrder::InPairs } else { ScanOrder::InTurn };
            let blocks = (order, tuning.scan_lines as usize);
            let (twin, _) = scan_due(&edges, &seeds, wavefront, stop, blocks, radius);
            assert_is_part(&raster.distances, &twin.distances(), radius, &what);
            assert_eq!(raster.iterations, twin.iterations, "{what}");
        }
    }
}

/// Returns two parts of a whole map: the points within a radius of a tenth of the farthest distance, as a part of all
/// reached points, and the visits of a map with that radius, as a part of all visits.
fn parts(
    solver: &mut HeadlessSolver,
    surface: &mut SurfaceOnDevice,
    (seeds, method): (&[Seed], Method),
) -> [f64; 2] {
    let whole = solver.solve(surface, seeds, method).unwrap();
    let radius = 0.1 * farthest(&whole.distances);
    let near = solver.solve(surface, seeds, method.with_radius(radius)).unwrap();
    let area = reached(&near.distances) as f64 / reached(&whole.distances) as f64;
    [area, near.visits as f64 / whole.visits as f64]
}

/// The radius is 40 to 50 points, which are few tiles.
#[test]
fn visits_are_those_of_the_area_within_the_radius() {
    let mut solver = vulkan_solver();
    for builtin in [Builtin::Plane, Builtin::Sphere, Builtin::Peaks] {
        let surface = builtin.surface(513, 513).unwrap();
        let seeds = Sources::point(205.0, 231.0).seeds(&surface).unwrap();
        let mut on_device = solver.upload(&surface).unwrap();
        for wavefront in [Wavefront::Planar, Wavefront::Curved] {
            for schedule in [Schedule::Tiles, Schedule::Raster] {
                let map = (&seeds[..], method(wavefront, schedule));
                let [area, visits] = parts(&mut solver, &mut on_device, map);
                let ratio = visits / area;
                let what = format!("{builtin} {wavefront} {schedule}");
                println!("{what}: area {area:.4}, visits {ratio:.2} times");
                match schedule {
                    Schedule::Tiles => assert!(ratio <= 2.2, "{what}: {ratio:.2} times"),
                    // A workgroup of a scan takes 116 points of a line, far more than the disc has.
                    _ => assert!(visits < 0.5, "{what}: {visits:.2} of all"),
                }
            }
        }
    }
}

#[test]
fn targets_cost_little_more_than_the_radius_that_they_need() {
    let mut solver = vulkan_solver();
    for builtin in [Builtin::Plane, Builtin::Peaks, Builtin::Maze] {
        let surface = builtin.surface(400, 400).unwrap();
        let seeds = Sources::point(160.0, 180.0).seeds(&surface).unwrap();
        let mut on_device = solver.upload(&surface).unwrap();
        for wavefront in [Wavefront::Planar, Wavefront::Curved] {
            let method = method(wavefront, Schedule::Tiles);
            let raster = method.with_schedule(Schedule::Raster);
            let whole = solver.solve(&mut on_device, &seeds, method).unwrap();
            let by_scans = solver.solve(&mut on_device, &seeds, raster).unwrap();
            for target in [[70, 130], [390, 50]] {
                let distance = whole.distances[surface.chart().index(target[0], target[1])];
                let radius = f64::from(distance);
                if distance.is_infinite() {
                    continue;
                }
                let needed = solver.solve(&mut on_device, &seeds, method.with_radius(radius));
                let targets = Targets::all([target]);
                let found = solver.solve_to(&mut on_device, &seeds, &targets, method).unwrap();
                let what = format!("{builtin} {wavefront} {target:?}");
                assert_is_part(&found.distances, &whole.distances, radius, &what);
                let scanned = solver.solve_to(&mut on_device, &seeds, &targets, raster).unwrap();
                let radius =
                    f64::from(by_scans.distances[surface.chart().index(target[0], target[1])]);
                assert_is_part(&scanned.distances, &by_scans.distances, radius, &what);
                let ratio = found.visits as f64 / needed.unwrap().visits as f64;
                println!("{what}: {ratio:.3} times the visits");
                assert!(ratio <= 1.3, "{what}: {ratio:.3} times the visits");
            }
        }
    }
}

/// The estimates of the targets' distance are right, a little too low, and far too low. With the right one, a map costs
/// little more than with the radius that the targets need. The distances are the same in all cases.
#[test]
fn scans_go_no_farther_than_an_estimate_of_the_targets_allows() {
    let surface = Builtin::Peaks.surface(400, 400).unwrap();
    let seeds = Sources::point(160.0, 180.0).seeds(&surface).unwrap();
    let mut solver = vulkan_solver();
    let mut on_device = solver.upload(&surface).unwrap();
    for wavefront in [Wavefront::Planar, Wavefront::Curved] {
        let method = method(wavefront, Schedule::Raster);
        let whole = solver.solve(&mut on_device, &seeds, method).unwrap();
        for target in [[130, 160], [70, 260]] {
            let needed = f64::from(whole.distances[surface.chart().index(target[0], target[1])]);
            let near = solver.solve(&mut on_device, &seeds, method.with_radius(needed)).unwrap();
            for (share, most) in [(1.0, 1.3), (0.9, 2.6), (0.1, f64::INFINITY)] {
                let targets = Targets::all([target, [160, 181]]);
                let estimate = share * needed;
                let found = solver
                    .solve_to_about(&mut on_device, &seeds, &targets, estimate, method)
                    .unwrap();
                let what = format!("{wavefront} {target:?} {share}");
                assert_is_part(&found.distances, &whole.distances, needed, &what);
                let ratio = found.visits as f64 / near.visits as f64;
                println!("{what}: {ratio:.3} times the visits");
                assert!(ratio <= most, "{what}: {ratio:.3} times the visits");
            }
        }
    }
}

/// Maps end at all, any and the two nearest of some targets, with every schedule.
#[test]
fn the_nearest_or_the_farthest_target_ends_the_map() {
    // Otherwise each map would open a device.
    geosweep::vulkan::keep_devices(true);
    for schedule in Schedule::ALL {
        let options =
            Options::default().with_engine(Engine::Vulkan(device_choice())).with_schedule(schedule);
        assert_targets_end_maps(&options);
    }
    geosweep::vulkan::keep_devices(false);
}

#[test]
fn a_target_that_cannot_be_reached_leaves_the_map_whole() {
    let mask: Vec<_> = (0..40 * 50).map(|index| index % 50 != 30).collect();
    let surface = flat(40, 50).with_mask(&mask).unwrap();
    let seeds = Sources::point(20.0, 20.0).seeds(&surface).unwrap();
    let mut solver = vulkan_solver();
    let mut on_device = solver.upload(&surface).unwrap();
    for schedule in Schedule::ALL {
        let method = method(Wavefront::Curved, schedule);
        let whole: HeadlessSolution = solver.solve(&mut on_device, &seeds, method).unwrap();
        let targets = Targets::all([[20, 22], [20, 45]]);
        let map = solver.solve_to(&mut on_device, &seeds, &targets, method).unwrap();
        assert!(map.distances == whole.distances, "{schedule}");
    }
}

/// A seed whose start time exceeds the radius starts nothing, and does not keep the map from converging.
#[test]
fn start_values_count_for_the_radius() {
    let surface = flat(30, 90);
    let sources = Sources::point(15.0, 10.0).and_point(15.0, 50.0, 4.0).and_point(15.0, 80.0, 20.0);
    let seeds = sources.seeds(&surface).unwrap();
    let mut solver = vulkan_solver();
    let mut on_device = solver.upload(&surface).unwrap();
    for schedule in Schedule::ALL {
        let method = method(Wavefront::Curved, schedule);
        let whole = solver.solve(&mut on_device, &seeds, method).unwrap();
        let near = solver.solve(&mut on_device, &seeds, method.with_radius(7.0)).unwrap();
        assert_is_part(&near.distances, &whole.distances, 7.0, schedule.name());
        assert!(near.distances[surface.chart().index(15, 80)].is_infinite());
        assert!(near.iterations < CONVERGED.iterations);
    }
}
