//! What a frame costs the program: the time to record a map into a command buffer, by size of the
//! grid and schedule.
//!
//! `cargo bench --bench recording`

#[path = "../tests/embed/host.rs"]
mod host;

use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use geosweep::Wavefront;
use geosweep::cpu::Stop;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Access, Frame, PointSource, Points, Reader, SourceInput, SurfaceInfo,
};
use geosweep::vulkan::{Method, Schedule};

use host::Host;

fn record(criterion: &mut Criterion) {
    let mut host = Host::without_validation();
    let device = host.device.clone();
    let passes = [(Schedule::Raster, Wavefront::Curved), (Schedule::Tiles, Wavefront::Curved)];
    let solver = embed::Solver::new(&host.instance, host.physical_device, &device, &passes);
    let mut solver = solver.expect("the device meets the requirements");
    let mut group = criterion.benchmark_group("record");
    for side in [48, 256, 1024] {
        let chart = Chart { rows: side, cols: side };
        let points = host.buffer(12 * chart.points() as u64, false);
        let inputs = [Points::positions(points.handle, 12)];
        let info = SurfaceInfo { points: &inputs, ..SurfaceInfo::new(chart) };
        let surface = solver.surface(&device, host.allocator(), &info);
        let mut surface = surface.expect("there is memory");
        // Four iterations of scans, or as many rounds as lead across the grid.
        for ((schedule, wavefront), iterations) in passes.into_iter().zip([4, 128]) {
            let stop = Stop { tolerance: 1e-4, iterations: 200 };
            let method = Method { wavefront, schedule: Some(schedule), stop };
            let plan = solver.plan(chart, method, iterations).expect("the passes are there");
            let commands = host.commands();
            let frame = Frame {
                before: Access::COMPUTE_WRITE,
                points: Some(0),
                sources: SourceInput::Inline(&[PointSource::at(3.0, 4.5)]),
                plan: &plan,
                slot: 0,
                reader: Reader::COMPUTE,
                unreached: -1.0,
            };
            group.bench_function(BenchmarkId::new(schedule.name(), side), |bencher| {
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
            });
        }
        surface.destroy(&device, host.allocator());
        host.free(points);
    }
    solver.destroy(&device);
}

criterion_group!(benches, record);
criterion_main!(benches);
