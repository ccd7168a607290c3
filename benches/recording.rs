//! Measures the cost of a frame: the time to record a map into a command buffer and to run it, by grid size
//! and schedule. It also measures contours, paths and regions on the map. Run it with
//! `cargo bench --bench recording`.

#[path = "../tests/common/host/mod.rs"]
mod host;

use std::time::{Duration, Instant};

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, criterion_group, criterion_main};
use geosweep::Stop;
use geosweep::Wavefront;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Access, ContourFrame, Frame, LevelInput, PathFrame, PathsInfo, PointSource, Points,
    Reader, RegionFrame, SourceInput, StartInput, SurfaceInfo,
};
use geosweep::vulkan::{Method, Schedule};

use host::Host;

fn record(criterion: &mut Criterion) {
    let mut host = Host::without_validation();
    let device = host.device.clone();
    let passes = [(Schedule::Raster, Wavefront::Curved), (Schedule::Tiles, Wavefront::Curved)];
    let solver = embed::Solver::new(&host.instance, host.physical_device, &device, &passes);
    let mut solver = solver.expect("the device meets the requirements");
    let mut group = criterion.benchmark_group("frame");
    group.sample_size(10);
    for side in [48, 256, 1024] {
        let chart = Chart { rows: side, cols: side };
        let positions: Vec<f32> = (0..chart.points())
            .flat_map(|index| {
                let (row, col) = chart.position(index);
                [
                    col as f32,
                    row as f32,
                    3.0 * (0.05 * col as f32).sin() * (0.04 * row as f32).cos(),
                ]
            })
            .collect();
        let points = host.buffer_of(&positions);
        let inputs = [Points::positions(points.handle, 12)];
        let info = SurfaceInfo::new(chart).with_points(&inputs);
        let surface = solver.surface(&device, host.allocator(), &info);
        let mut surface = surface.expect("there is memory");
        host.run(|commands| solver.record(&device, commands, &surface).prepare());
        // `iterations` is the number of iterations for scans, and the largest number of rounds for tiles.
        for ((schedule, wavefront), iterations) in passes.into_iter().zip([4, 64]) {
            let stop = Stop::within(1e-4).or_after(200);
            let method = Method::new(wavefront, stop).with_schedule(schedule);
            let plan = solver.plan(chart, method, iterations).expect("the passes are there");
            let commands = host.commands();
            let places = [PointSource::at(3.0, 4.5)];
            let frame = Frame::new(&plan, SourceInput::Inline(&places), Reader::COMPUTE)
                .with_before(Access::COMPUTE_WRITE)
                .with_points(0)
                .with_unreached(-1.0);
            group.bench_function(
                BenchmarkId::new(format!("{schedule}, record"), side),
                |bencher| {
                    bencher.iter_custom(|count| {
                        let mut time = Duration::ZERO;
                        for _ in 0..count {
                            host.begin(commands);
                            let begin = Instant::now();
                            let recording = solver.record(&device, commands, &surface);
                            recording.frame(&frame).expect("the frame is right");
                            time += begin.elapsed();
                        }
                        time
                    });
                },
            );
            // On lavapipe, large grids take minutes with tiles.
            if schedule == Schedule::Tiles && side > 256 {
                continue;
            }
            group.bench_function(BenchmarkId::new(format!("{schedule}, run"), side), |bencher| {
                bencher.iter(|| {
                    host.run(|commands| {
                        let recording = solver.record(&device, commands, &surface);
                        recording.frame(&frame).map(drop).expect("the frame is right");
                    });
                });
            });
        }
        curves(&mut group, &mut host, &solver, &surface);
        regions(&mut group, &mut host, &solver, &surface);
        surface.destroy(&device, host.allocator());
        host.free(points);
    }
    solver.destroy(&device);
}

/// Measures the regions of twenty sources, on a separate map.
fn regions(
    group: &mut BenchmarkGroup<WallTime>,
    host: &mut Host,
    solver: &embed::Solver,
    surface: &embed::FrameSurface,
) {
    let device = host.device.clone();
    let (chart, wavefront) = (surface.chart(), Wavefront::Curved);
    let sources: Vec<_> =
        spread(20, chart.rows).into_iter().map(|[row, col]| PointSource::at(row, col)).collect();
    let sources = SourceInput::Inline(&sources);
    let stop = Stop::within(1e-4).or_after(200);
    let method = Method::new(wavefront, stop).with_schedule(Schedule::Raster);
    let plan = solver.plan(chart, method, 4).expect("the passes are there");
    group.bench_function(BenchmarkId::new("map of 20 sources, run", chart.rows), |bencher| {
        bencher.iter(|| {
            host.run(|commands| {
                let recording = solver.record(&device, commands, surface);
                recording.begin(Access::NONE);
                recording.solve(sources, &plan).expect("the sources are right");
            });
        });
    });
    let made = solver.regions(&device, host.allocator(), surface, wavefront);
    let mut made = made.expect("there is memory");
    let frame = RegionFrame::new(sources, Access::VERTEX_READ);
    group.bench_function(BenchmarkId::new("20 regions, run", chart.rows), |bencher| {
        bencher.iter(|| {
            host.run(|commands| {
                let recording = solver.record(&device, commands, surface);
                recording.regions(&made, &frame).map(drop).expect("the sources are right");
            });
        });
    });
    made.destroy(&device, host.allocator());
}

/// Returns places spread over the grid by the golden ratio.
fn spread(count: u32, side: usize) -> Vec<[f32; 2]> {
    let place = |k: u32| {
        let share = |x: f32| (0.5 + x * k as f32).fract() * (side - 1) as f32;
        [share(0.618_034), share(0.381_966 * 0.618_034)]
    };
    (0..count).map(place).collect()
}

/// Measures 10 and 100 contours, one path and 1,000 paths, on the existing map.
fn curves(
    group: &mut BenchmarkGroup<WallTime>,
    host: &mut Host,
    solver: &embed::Solver,
    surface: &embed::FrameSurface,
) {
    let device = host.device.clone();
    let side = surface.chart().rows;
    let room = (400 * side) as u32;
    let contours = solver.contours(&device, host.allocator(), surface, room);
    let mut contours = contours.expect("there is memory");
    for count in [10, 100] {
        let step = 1.3 * side as f32 / count as f32;
        let levels = LevelInput::Spacing { step, count };
        let frame = ContourFrame::new(levels, Access::DRAW);
        group.bench_function(BenchmarkId::new(format!("{count} contours, run"), side), |bencher| {
            bencher.iter(|| {
                host.run(|commands| {
                    let recording = solver.record(&device, commands, surface);
                    recording.contours(&contours, &frame).map(drop).expect("the levels are right");
                });
            });
        });
    }
    for paths in [1u32, 1000] {
        let info = PathsInfo::new(paths, 3 * side as u32);
        let made = solver.paths(&device, host.allocator(), surface, info);
        let mut made = made.expect("there is memory");
        let starts = spread(paths, side);
        let places = [PointSource::at(3.0, 4.5)];
        let frame =
            PathFrame::new(StartInput::Inline(&starts), SourceInput::Inline(&places), Access::DRAW);
        group.bench_function(BenchmarkId::new(format!("{paths} paths, run"), side), |bencher| {
            bencher.iter(|| {
                host.run(|commands| {
                    let recording = solver.record(&device, commands, surface);
                    recording.paths(&made, &frame).map(drop).expect("the starts are right");
                });
            });
        });
        made.destroy(&device, host.allocator());
    }
    contours.destroy(&device, host.allocator());
}

criterion_group!(benches, record);
criterion_main!(benches);
