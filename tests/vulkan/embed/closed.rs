//! Glued surfaces in a renderer's frame: their maps are those of the headless solver and of the CPU.

use std::f64::consts::TAU;

use geosweep::ash::vk;
use geosweep::glam::DVec3;
use geosweep::surface::{Direction, Gluing, Run};
use geosweep::vulkan::embed::{
    Access, Frame, MapLimit, PointKind, PointMemory, Points, Reader, SourceInput, SurfaceFrame,
    SurfaceInfo, TargetPoint,
};
use geosweep::vulkan::{Method, Schedule};
use geosweep::{Sources, Stop, Surface, Wavefront};

use crate::common::closed::*;
use crate::common::parts::{assert_is_part, farthest};
use crate::common::{Lent, difference, on_cpu, vulkan_solver};
use crate::embed::stage::{Kept, STOP, Stage, numbers_of, source};
use crate::host::HostBuffer;

/// Largest difference between maps from the same points: rounding.
const SAME: f64 = 1e-5;

/// Largest difference between copies of a point, relative to the largest distance. Copies at which fronts arrive
/// together within rounding keep their own fronts.
const ROUNDING: f64 = 1e-6;

const WAVEFRONTS: [Wavefront; 3] = Wavefront::FOR_ANY_SURFACE;
const SCHEDULES: [Schedule; 2] = [Schedule::Raster, Schedule::Tiles];

fn all_passes() -> Vec<(Schedule, Wavefront)> {
    SCHEDULES.iter().flat_map(|&schedule| WAVEFRONTS.map(|front| (schedule, front))).collect()
}

fn points_in(buffer: &HostBuffer, kind: PointKind) -> [Points; 1] {
    let stride = if kind == PointKind::Positions { 12 } else { 4 };
    [Points { kind, ..Points::positions(buffer.handle, stride) }]
}

/// Returns a stage with a glued surface that has the points of `surface`.
pub fn stage_on(
    surface: &Surface,
    gluing: &Gluing,
    host: Lent<Kept>,
    passes: &[(Schedule, Wavefront)],
) -> Stage {
    Stage::on(host, passes, (surface, Some(gluing)), numbers_of(surface))
}

/// Returns a Moebius strip in space.
fn moebius(rows: usize, cols: usize) -> Surface {
    let strip = grid(rows, cols, |row, col| {
        let last = col == cols - 1;
        let row = if last { rows - 1 - row } else { row };
        let u = TAU * (col % (cols - 1)) as f64 / (cols - 1) as f64;
        let across = row as f64 / (rows - 1) as f64 - 0.5;
        let radius = 2.0 + across * (0.5 * u).cos();
        DVec3::new(radius * u.cos(), radius * u.sin(), across * (0.5 * u).sin())
    });
    strip.with_gluing(Gluing::flipped_columns()).unwrap()
}

/// Returns closed surfaces, their gluings, and a source on each, most of which lie on a seam.
fn closed_surfaces() -> Vec<(&'static str, Surface, Gluing, [usize; 2])> {
    let both = flat(20, 29).with_gluing(Gluing::both()).unwrap();
    vec![
        ("tube", tube(33, 49), Gluing::columns(), [12, 48]),
        ("torus", torus(25, 38), Gluing::both(), [0, 37]),
        ("flat torus", both, Gluing::both(), [19, 0]),
        ("Moebius strip", moebius(21, 70), Gluing::flipped_columns(), [16, 67]),
        ("globe", globe(31, 61), Gluing::globe(), [10, 0]),
        ("globe from a pole", globe(22, 45), Gluing::globe(), [0, 17]),
        ("octahedral map", octahedral(18), Gluing::Octahedral, [0, 7]),
    ]
}

#[test]
fn maps_of_frames_pass_seams() {
    let mut headless = vulkan_solver();
    for (name, surface, gluing, [row, col]) in closed_surfaces() {
        let stage = stage_on(&surface, &gluing, Kept::watched(), &all_passes());
        let seeds = Sources::point(row as f64, col as f64).seeds(&surface).unwrap();
        let mut on_device = headless.upload(&surface).unwrap();
        for (schedule, wavefront) in all_passes() {
            let method = Method::new(wavefront, STOP).with_schedule(schedule);
            let plan = stage.plan(schedule, wavefront, 12).over_seams();
            let map = stage.map(0, SourceInput::Inline(&source(row as f32, col as f32)), &plan);
            let rounding = (ROUNDING * farthest(&map)) as f32;
            for copies in surface.copies().unwrap().iter() {
                let values = copies.iter().map(|&copy| map[copy as usize]);
                let first = map[copies[0] as usize];
                let apart = values.map(|value| (value - first).abs()).fold(0.0, f32::max);
                assert!(apart <= rounding, "{name}, {wavefront}: {apart:e} {first} {copies:?}");
            }
            let alone = headless.solve(&mut on_device, &seeds, method).unwrap();
            let cpu = on_cpu(&surface, &seeds, wavefront, STOP);
            let apart = [difference(&alone.distances, &map), difference(&cpu, &map)];
            println!("{name}, {wavefront}, {schedule}: {:.1e} {:.1e}", apart[0], apart[1]);
            assert!(apart.iter().all(|&apart| apart < SAME), "{name}, {wavefront}, {schedule}");
        }
        stage.end([]);
    }
}

/// Edges and curvatures measured over seams, also across bands of rows, are those that the headless solver uploads. The
/// comparison uses the maps after one iteration.
#[test]
fn large_grids_are_measured_over_seams_in_bands() {
    let (rows, cols) = (90, 4001);
    let surface = torus(rows, cols);
    let passes = [(Schedule::Raster, Wavefront::Curved)];
    let stage = stage_on(&surface, &Gluing::both(), Kept::unwatched(), &passes);
    let method = Method::new(Wavefront::Curved, Stop::after(1)).with_schedule(Schedule::Raster);
    let plan = stage.solver.plan(surface.chart(), method, 1).unwrap().over_seams();
    let (row, col) = (1, 3999);
    stage.solve(SourceInput::Inline(&source(row as f32, col as f32)), &plan);
    let mut headless = vulkan_solver();
    let mut on_device = headless.upload(&surface).unwrap();
    let seeds = Sources::point(row as f64, col as f64).seeds(&surface).unwrap();
    let map = headless.solve(&mut on_device, &seeds, method).unwrap();
    let apart = difference(&map.distances, &stage.read());
    println!("{apart:.1e}");
    assert!(apart < SAME, "{apart:e}");
    stage.end([]);
}

/// The tube bends and twists, without obtuse triangles, and its seam stays closed. One of its points becomes a hole, on
/// one side of the seam only.
#[test]
fn a_moving_tube_stays_closed() {
    let (rows, cols) = (33, 49);
    let at = |time: f64| {
        move |row: usize, col: usize| {
            let step = TAU / (cols - 1) as f64;
            let (along, angle) =
                (step * row as f64, step * (col % (cols - 1)) as f64 + 0.03 * time * row as f64);
            let radius = 1.0 + 0.3 * (2.0 * along + time).sin() * (2.0 * angle).cos();
            let sway = 0.4 * time * (0.5 * along).sin();
            DVec3::new(radius * angle.cos() + sway, radius * angle.sin(), along)
        }
    };
    let frames = [0.0, 0.4, 0.8, 1.2];
    let mut host = Kept::watched();
    let mut buffers = Vec::new();
    let mut surfaces = Vec::new();
    for (number, time) in frames.into_iter().enumerate() {
        let open = grid(rows, cols, at(time));
        let (kind, mut numbers) = numbers_of(&open);
        let mut points: Vec<_> = (0..rows * cols).map(|k| at(time)(k / cols, k % cols)).collect();
        if number == 2 {
            let hole = 20 * cols + cols - 1;
            numbers[3 * hole] = f32::NAN;
            points[hole] = DVec3::NAN;
        }
        let surface = Surface::from_positions(rows, cols, points).unwrap();
        surfaces.push(surface.with_gluing(Gluing::columns()).unwrap());
        buffers.push((host.buffer_of(&numbers), kind));
    }
    let points: Vec<_> =
        buffers.iter().flat_map(|(buffer, kind)| points_in(buffer, *kind)).collect();
    let gluing = Gluing::columns();
    let info = SurfaceInfo::new(surfaces[0].chart()).with_points(&points).with_gluing(&gluing);
    let stage = Stage::new(host, &all_passes(), &info);
    for (number, surface) in surfaces.iter().enumerate() {
        let seeds = Sources::point(9.0, 1.0).seeds(surface).unwrap();
        for (schedule, wavefront) in all_passes() {
            let plan = stage.plan(schedule, wavefront, 12).over_seams();
            let map = stage.map(number, SourceInput::Inline(&source(9.0, 1.0)), &plan);
            let cpu = on_cpu(surface, &seeds, wavefront, STOP);
            let apart = difference(&cpu, &map);
            println!("frame {number}, {wavefront}, {schedule}: {apart:.1e}");
            assert!(apart < SAME, "frame {number}, {wavefront}, {schedule}: {apart:e}");
            let holes = stage.surface.outcome(0).unwrap().holes;
            assert_eq!(holes, if number == 2 { 2 } else { 0 });
        }
    }
    stage.end(buffers.into_iter().map(|(buffer, _)| buffer));
}

/// Points come from an image, and have a slowness that continues over the seam.
#[test]
fn slow_points_in_an_image_pass_seams() {
    let surface = tube(33, 49);
    let chart = surface.chart();
    let slowness: Vec<f64> = (0..chart.points())
        .map(|index| {
            let (row, col) = chart.position(index);
            1.5 + 0.4 * (TAU * col as f64 / 48.0).cos() * (0.2 * row as f64).sin()
        })
        .collect();
    let (_, numbers) = numbers_of(&surface);
    let texels: Vec<_> = (numbers.chunks(3).zip(&slowness))
        .flat_map(|(at, &slow)| [at[0], at[1], at[2], slow as f32])
        .collect();
    let surface = surface.with_slowness(slowness).unwrap();
    let mut host = Kept::watched();
    let image = host.image_of(chart.cols as u32, chart.rows as u32, 4, &texels);
    let memory = PointMemory::Image { view: image.view, layout: vk::ImageLayout::GENERAL };
    let points = [Points { memory, kind: PointKind::Positions, slowness: Some(3) }];
    let gluing = Gluing::columns();
    let info = SurfaceInfo::new(chart).with_points(&points).with_gluing(&gluing);
    let mut stage = Stage::new(host, &all_passes(), &info);
    let seeds = Sources::point(12.0, 47.0).seeds(&surface).unwrap();
    for (schedule, wavefront) in all_passes() {
        let wavefront = match wavefront {
            Wavefront::Circular => Wavefront::Planar,
            other => other,
        };
        let plan = stage.plan(schedule, wavefront, 12).over_seams();
        let map = stage.map(0, SourceInput::Inline(&source(12.0, 47.0)), &plan);
        let apart = difference(&on_cpu(&surface, &seeds, wavefront, STOP), &map);
        println!("{wavefront}, {schedule}: {apart:.1e}");
        assert!(apart < SAME, "{wavefront}, {schedule}: {apart:e}");
    }
    stage.host.free_image(image);
    stage.end([]);
}

/// Maps end at a radius and at targets beyond the seam. Fronts of a source that is added to a map pass seams too.
#[test]
fn parts_of_maps_and_added_sources_pass_seams() {
    let surface = torus(25, 38);
    let stage = stage_on(&surface, &Gluing::both(), Kept::watched(), &all_passes());
    let own = source(6.0, 37.0);
    let start = SourceInput::Inline(&own);
    for (schedule, wavefront) in all_passes() {
        let what = format!("{wavefront}, {schedule}");
        let plan = stage.plan(schedule, wavefront, 12).over_seams();
        let whole = stage.map(0, start, &plan);
        let farthest = farthest(&whole);
        let target = [TargetPoint { row: 22, col: 3 }];
        let at_target = f64::from(whole[22 * 38 + 3]);
        let limits = [
            (MapLimit::NONE.with_radius(0.4 * farthest as f32), 0.4 * farthest),
            (MapLimit::to(&target), at_target),
        ];
        for (limit, reach) in limits {
            stage.run(|recording| {
                recording.frame(&Frame::new(&plan, start, Reader::COPY).with_limit(limit))
            });
            stage.finish(&plan);
            assert_is_part(&stage.read(), &whole, reach, &what);
        }
        // Circular fronts that meet can settle in more than one way.
        if wavefront == Wavefront::Circular {
            continue;
        }
        let second = source(24.0, 16.0);
        let second = SourceInput::Inline(&second);
        stage.map(0, start, &plan);
        let added = stage.add(second, &plan);
        let both = Sources::point(6.0, 37.0).and_point(24.0, 16.0, 0.0);
        let cpu = on_cpu(&surface, &both.seeds(&surface).unwrap(), wavefront, STOP);
        let apart = difference(&cpu, &added);
        assert!(apart < 1e-4, "{what}: {apart:e}");
    }
    stage.end([]);
}

/// Frames of a glued and an open surface share barriers, and the glued surface has the map that it has alone.
#[test]
fn glued_and_open_surfaces_are_recorded_together() {
    let glued = tube(33, 49);
    let mut stage = stage_on(&glued, &Gluing::columns(), Kept::watched(), &all_passes());
    let device = stage.host.device.clone();
    let (kind, numbers) = numbers_of(&glued);
    let buffer = stage.host.buffer_of(&numbers);
    let points = points_in(&buffer, kind);
    let open_info = SurfaceInfo::new(glued.chart()).with_points(&points);
    let mut open = stage.solver.surface(&device, stage.host.allocator(), &open_info).unwrap();
    let own = source(12.0, 2.0);
    stage.host.run(|commands| stage.solver.record(&device, commands, &open).prepare());
    for (schedule, wavefront) in all_passes() {
        let open_plan = stage.plan(schedule, wavefront, 16);
        let plan = open_plan.clone().over_seams();
        let frame = |plan| Frame::new(plan, SourceInput::Inline(&own), Reader::COPY).with_points(0);
        stage.run(|recording| recording.frame(&frame(&plan)));
        let in_one_frame = stage.read();
        stage.host.run(|commands| {
            let frames = [
                SurfaceFrame::new(&stage.surface, frame(&plan)),
                SurfaceFrame::new(&open, frame(&open_plan)),
            ];
            stage.solver.record_frames(&device, commands, &frames).unwrap();
        });
        stage.run(|recording| {
            recording.begin(Access::NONE);
            recording.result(0, Reader::COPY, f32::INFINITY)
        });
        assert_eq!(stage.read(), in_one_frame, "{wavefront}, {schedule}");
    }
    open.destroy(&device, stage.host.allocator());
    stage.end([buffer]);
}

/// Log maps and some gluings are refused.
#[test]
fn what_does_not_fit_is_refused() {
    let surface = tube(33, 49);
    let (chart, gluing) = (surface.chart(), Gluing::columns());
    let passes = [(Schedule::Raster, Wavefront::Curved)];
    let mut stage = stage_on(&surface, &gluing, Kept::watched(), &passes);
    let (kind, numbers) = numbers_of(&surface);
    let buffer = stage.host.buffer_of(&numbers);
    let points = points_in(&buffer, kind);
    let open = stage.plan(Schedule::Raster, Wavefront::Curved, 12);
    let own = source(12.0, 2.0);
    let (device, start) = (stage.host.device.clone(), SourceInput::Inline(&own));
    stage.host.run(|commands| {
        let recording = stage.solver.record(&device, commands, &stage.surface);
        let refused = recording.frame(&Frame::new(&open, start, Reader::COPY).with_points(0));
        assert!(refused.unwrap_err().to_string().contains("Plan::over_seams"));
    });
    let Stage { host, solver, surface, .. } = &mut stage;
    let error = solver.log_map(&device, host.allocator(), surface).unwrap_err().to_string();
    assert!(error.contains("does not pass seams yet"), "{error}");
    let heights =
        [Points { kind: PointKind::Heights(geosweep::Spacing::square(1.0)), ..points[0] }];
    let runs = |points| {
        let run = |col| Run { from: (0, col), to: Direction::South, points };
        Gluing::Runs(vec![[run(0), run(48)]])
    };
    for (points, gluing, message) in [
        (&heights, Gluing::globe(), "a pole needs positions"),
        (&points, Gluing::Charts, "Gluing::Runs"),
        (&points, runs(34), "leaves the grid"),
        (&points, Gluing::Seams(vec![]), "nothing"),
    ] {
        let info = SurfaceInfo::new(chart).with_points(points).with_gluing(&gluing);
        let error = solver.surface(&device, host.allocator(), &info).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
    let error = surface.set_points(&device, solver, 0, &heights[0]);
    assert!(error.is_ok(), "heights can go on beyond columns: {error:?}");
    stage.end([buffer]);
}

/// A source between two points of a seam has a copy on the other side.
#[test]
fn sources_between_points_of_a_seam_are_on_both_sides() {
    let cases = [
        (tube(33, 49), Gluing::columns(), [12.25, 48.0]),
        (torus(25, 38), Gluing::both(), [0.0, 30.75]),
        (torus(25, 38), Gluing::both(), [7.25, 0.0]),
        (moebius(21, 70), Gluing::flipped_columns(), [3.5, 0.0]),
    ];
    for (surface, gluing, [row, col]) in cases {
        let stage = stage_on(&surface, &gluing, Kept::watched(), &all_passes());
        let seeds = Sources::point(row, col).seeds(&surface).unwrap();
        for (schedule, wavefront) in all_passes() {
            let plan = stage.plan(schedule, wavefront, 12).over_seams();
            let own = source(row as f32, col as f32);
            let map = stage.map(0, SourceInput::Inline(&own), &plan);
            assert_eq!(stage.surface.outcome(0).unwrap().passed_over, 0);
            let apart = difference(&on_cpu(&surface, &seeds, wavefront, STOP), &map);
            println!("{gluing:?}, {wavefront}, {schedule}: {apart:.1e}");
            assert!(apart < SAME, "{gluing:?}, {wavefront}, {schedule}: {apart:e}");
        }
        stage.end([]);
    }
}
