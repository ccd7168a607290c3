//! Closed surfaces on a device: fronts pass the seams where sides of the grid are glued.

use std::f64::consts::TAU;

use geosweep::cpu::twins::{self, ScanOrder};
use geosweep::surface::{EdgeLengths, Gluing};
use geosweep::vulkan::profile::{Detail, Grain, PassKind};
use geosweep::vulkan::{Method, Schedule, Tuning};
use geosweep::{Engine, Options, Sources, Surface, Wavefront, distance_map};

use crate::common::closed::*;
use crate::common::parts::{assert_is_part, farthest};
use crate::common::*;
use crate::headless::assert_schedule_twins;
use crate::profile::bench::profiling_solver;

/// Largest difference between the engines' converged maps, relative to the largest distance. Measured: 6.1e-7.
const AGREEMENT: f64 = 1e-6;

const WAVEFRONTS: [Wavefront; 3] = Wavefront::FOR_ANY_SURFACE;

/// Returns closed hills with holes and some obtuse triangles, and with an uneven slowness if they are `slowed`.
fn hills(slowed: bool) -> Surface {
    let (rows, cols) = (27, 37);
    let heights = (0..rows * cols).map(|index| {
        let (row, col) =
            ((index / cols) as f64, TAU * (index % cols % (cols - 1)) as f64 / (cols - 1) as f64);
        let hole = index % cols > 5 && index % cols < 30 && index % 11 == 3;
        if hole { f64::NAN } else { 3.0 * (2.0 * col).sin() * (0.2 * row).cos() }
    });
    let surface =
        Surface::from_heights(rows, cols, heights.collect(), geosweep::Spacing::square(1.0))
            .unwrap();
    let slowness =
        (0..rows * cols).map(|index| if index / cols < 12 { 1.0 } else { 1.7 }).collect();
    let surface = if slowed { surface.with_slowness(slowness).unwrap() } else { surface };
    surface.with_gluing(Gluing::columns()).unwrap()
}

/// Returns closed surfaces with a source on each, most of which lie on or beside a seam.
pub fn closed_surfaces() -> Vec<(&'static str, Surface, [f64; 2])> {
    let moebius = flat(21, 35).with_gluing(Gluing::flipped_columns()).unwrap();
    vec![
        ("tube", tube(33, 49), [12.0, 3.0]),
        ("torus", torus(25, 38), [0.0, 37.0]),
        ("flat torus", flat(20, 29).with_gluing(Gluing::both()).unwrap(), [19.0, 0.0]),
        ("Moebius strip", moebius, [16.0, 32.25]),
        ("globe", globe(31, 61), [10.0, 2.0]),
        ("globe from a pole", globe(22, 45), [0.0, 17.0]),
        ("octahedral map", octahedral(18), [0.0, 7.0]),
        ("equal-area map", equal_area(17), [9.0, 9.0]),
        ("cube", cube(13), [0.0, 0.0]),
        ("hills", hills(false), [7.5, 0.0]),
        ("slowed hills", hills(true), [13.0, 35.0]),
    ]
}

#[test]
fn engines_agree_on_closed_surfaces() {
    let mut solver = vulkan_solver();
    for (name, surface, [row, col]) in closed_surfaces() {
        let seeds = Sources::point(row, col).seeds(&surface).unwrap();
        let mut on_device = solver.upload(&surface).unwrap();
        for wavefront in WAVEFRONTS {
            let cpu = on_cpu(&surface, &seeds, wavefront, CONVERGED);
            for schedule in Schedule::ALL {
                let method = Method::new(wavefront, CONVERGED).with_schedule(schedule);
                let map = solver.solve(&mut on_device, &seeds, method).unwrap();
                let apart = difference(&cpu, &map.distances);
                println!(
                    "{name}, {wavefront}, {schedule}: {apart:.1e}, {} iterations",
                    map.iterations
                );
                assert!(apart < AGREEMENT, "{name}, {wavefront}, {schedule}: {apart:e}");
                for group in surface.copies().unwrap().iter() {
                    let distances = group.iter().map(|&copy| map.distances[copy as usize]);
                    let (least, most) = distances
                        .fold((f32::INFINITY, 0f32), |(a, b), next| (a.min(next), b.max(next)));
                    assert!(most - least <= 2e-6 * most, "{name}: copies {least} to {most}");
                }
            }
        }
    }
}

/// The radius ends fronts that have passed seams too. On each surface, each schedule has another wavefront. From
/// surface to surface, a schedule has all three wavefronts in turn.
#[test]
fn parts_of_closed_surfaces_are_those_of_the_whole_map() {
    let mut solver = gpu_like_solver();
    let surfaces = closed_surfaces().into_iter().step_by(2).enumerate();
    for (number, (name, surface, [row, col])) in surfaces {
        let seeds = Sources::point(row, col).seeds(&surface).unwrap();
        let mut on_device = solver.upload(&surface).unwrap();
        for (turn, schedule) in Schedule::ALL.into_iter().enumerate() {
            let wavefront = WAVEFRONTS[(number + turn) % WAVEFRONTS.len()];
            let method = Method::new(wavefront, CONVERGED).with_schedule(schedule);
            let whole = solver.solve(&mut on_device, &seeds, method).unwrap();
            let radius = 0.4 * farthest(&whole.distances);
            let near = solver.solve(&mut on_device, &seeds, method.with_radius(radius)).unwrap();
            let what = format!("{name}, {wavefront}, {schedule}");
            assert_is_part(&near.distances, &whole.distances, radius, &what);
        }
    }
}

/// The exchange of the seeds is a part of seeding.
#[test]
fn profiles_of_closed_surfaces_have_all_exchanges() {
    let mut solver = profiling_solver();
    let (surface, seeds) = (globe(31, 61), Sources::point(10.0, 2.0));
    let seeds = seeds.seeds(&surface).unwrap();
    let mut on_device = solver.upload(&surface).unwrap();
    for schedule in Schedule::ALL {
        let method = Method::new(Wavefront::Curved, CONVERGED).with_schedule(schedule);
        let detail = Detail { grain: Grain::Scans, ..Detail::default() };
        let (map, profile) = solver.profile(&mut on_device, &seeds, method, detail).unwrap();
        let count =
            |is: fn(PassKind) -> bool| profile.passes().filter(|pass| is(pass.kind)).count();
        let exchanges = count(|kind| kind == PassKind::Exchange);
        match schedule {
            Schedule::Raster => {
                let scans = count(|kind| matches!(kind, PassKind::Scan(_)));
                assert!(exchanges > 1 && exchanges <= scans, "{exchanges} of {scans} scans");
            }
            Schedule::Tiles => {
                assert_eq!(exchanges, 0);
                let of_tiles = count(|kind| kind == PassKind::ExchangeOfTiles);
                assert_eq!(of_tiles, count(|kind| kind == PassKind::Tiles));
            }
        }
        let alone = solver.solve(&mut on_device, &seeds, method).unwrap();
        assert_eq!(map.distances, alone.distances, "{schedule}");
    }
}

/// Some rounds are in a second recording.
#[test]
fn every_exchange_is_one_of_its_twin() {
    let mut solver = vulkan_solver();
    for (name, surface, [row, col]) in closed_surfaces() {
        println!("{name}");
        let source = (row as usize, col as usize);
        let solver = &mut solver;
        assert_schedule_twins(solver, &surface, source, Schedule::Raster, [1, 2, 3, 6]);
        assert_schedule_twins(solver, &surface, source, Schedule::Tiles, [1, 2, 3, 9, 40]);
    }
}

/// Lines fit a workgroup of 64 texels, which takes blocks in turn. They do not fit a workgroup of 16 texels.
#[test]
fn seams_are_passed_in_blocks_of_any_size_and_in_pairs() {
    let forms = [(16, 1, true), (16, 3, false)].map(|(scan_width, scan_lines, scan_pairs)| {
        tuned(|old| Tuning { scan_width, scan_lines, scan_pairs, ..old }).into()
    });
    let forms = [gpu_like_solver()].into_iter().chain(forms);
    for (form, mut solver) in forms.enumerate() {
        // A torus, a strip, a pole and holes with obtuse triangles.
        let surfaces = closed_surfaces().into_iter().skip(1).step_by(2);
        for (number, (name, surface, [row, col])) in surfaces.enumerate() {
            let source = (row as usize, col as usize);
            assert_schedule_twins(&mut solver, &surface, source, Schedule::Raster, [1, 2, 5]);
            let seeds = Sources::point(row, col).seeds(&surface).unwrap();
            let mut on_device = solver.upload(&surface).unwrap();
            // The comparison with the twin is for all wavefronts. The converged map is compared for one of them, which
            // differs from form to form.
            let wavefront = WAVEFRONTS[(form + number) % WAVEFRONTS.len()];
            let method = Method::new(wavefront, CONVERGED).with_schedule(Schedule::Raster);
            let cpu = on_cpu(&surface, &seeds, wavefront, CONVERGED);
            let map = solver.solve(&mut on_device, &seeds, method).unwrap();
            let apart = difference(&cpu, &map.distances);
            assert!(apart < AGREEMENT, "{name}, {wavefront}: {apart:e}");
            let again = solver.solve(&mut on_device, &seeds, method).unwrap();
            assert_eq!(map.distances, again.distances, "{name}, {wavefront}");
        }
        assert_nothing_said(&solver);
    }
}

/// Blocks that are not due have nothing to do, also where changes come over seams.
#[test]
fn blocks_are_due_beside_seams() {
    for (name, surface, [row, col]) in closed_surfaces() {
        let seeds = Sources::point(row, col).seeds(&surface).unwrap();
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        for wavefront in WAVEFRONTS {
            let all = twins::scan_in_turn(&edges, &seeds, wavefront, CONVERGED);
            let order = (ScanOrder::InTurn, 3);
            let (due, visits) =
                twins::scan_due(&edges, &seeds, wavefront, CONVERGED, order, f64::INFINITY);
            assert_eq!(all.distances(), due.distances(), "{name}, {wavefront}");
            let visited = visits.iter().flatten().flatten().filter(|&&visited| visited).count();
            let blocks = visits.iter().flatten().map(Vec::len).sum::<usize>();
            assert!(visited < blocks, "{name}, {wavefront}: {visited} of {blocks}");
        }
    }
}

#[test]
fn sources_are_added_to_maps_of_closed_surfaces() {
    let mut solver = vulkan_solver();
    let surface = torus(25, 38);
    let both = Sources::point(6.0, 37.0).and_point(24.0, 16.0, 0.5);
    let [first, second] = [(6.0, 37.0, 0.0), (24.0, 16.0, 0.5)].map(|(row, col, start)| {
        Sources::default().and_point(row, col, start).seeds(&surface).unwrap()
    });
    let mut on_device = solver.upload(&surface).unwrap();
    for schedule in Schedule::ALL {
        for wavefront in [Wavefront::Planar, Wavefront::Curved] {
            let method = Method::new(wavefront, CONVERGED).with_schedule(schedule);
            solver.solve(&mut on_device, &first, method).unwrap();
            let added = solver.add(&mut on_device, &second, method).unwrap();
            let cpu = on_cpu(&surface, &both.seeds(&surface).unwrap(), wavefront, CONVERGED);
            let apart = difference(&cpu, &added.distances);
            assert!(apart < 1e-4, "{schedule}, {wavefront}: {apart:e}");
        }
    }
}

#[test]
fn one_call_solves_a_closed_surface() {
    let surface = tube(33, 65);
    let sources = Sources::point(16.0, 2.0);
    let map =
        |engine| distance_map(&surface, &sources, &Options::default().with_engine(engine)).unwrap();
    let (vulkan, cpu) = (map(Engine::Vulkan(device_choice())), map(Engine::Cpu));
    assert!(difference(&vulkan.distances, &cpu.distances) < AGREEMENT);
    assert!((f64::from(vulkan.distance(16, 62)) - TAU * 4.0 / 64.0).abs() < 1e-5);
}
