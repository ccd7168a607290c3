//! Measures the time of edge lengths and of one converged map, for all engines and wavefronts: `cargo bench`.
//!
//! The measured time of a map does not include set-up: edge lengths, upload and shader compilation.

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use geosweep::Stop;
use geosweep::cpu;
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::vulkan::{HeadlessSolver, Method};
use geosweep::{DeviceChoice, Sources, Wavefront};

const STOP: Stop = Stop::within(1e-6).or_after(1000);

fn distance_map(c: &mut Criterion) {
    let mut solver = HeadlessSolver::new(&DeviceChoice::Any)
        .inspect_err(|error| eprintln!("without Vulkan: {error}"))
        .ok();
    for builtin in [Builtin::Sphere, Builtin::Peaks, Builtin::Maze] {
        for side in [150, 600, 1200] {
            let surface = builtin.surface(side, side).expect("built-in surfaces fit");
            let source = (side as f64 * 0.05).floor();
            let seeds = Sources::point(source, source).seeds(&surface).expect("the corner is open");
            let edges = EdgeLengths::<f32>::new(&surface).expect("built-in surfaces fit");
            let mut group = c.benchmark_group(format!("{}/{side}", builtin.name()));
            group.throughput(Throughput::Elements((side * side) as u64)).sample_size(10);
            for wavefront in [Wavefront::Planar, Wavefront::Circular] {
                group.bench_function(BenchmarkId::new("raster scan", wavefront), |b| {
                    b.iter(|| cpu::raster_scan(&edges, &seeds, wavefront, STOP));
                });
                group.bench_function(BenchmarkId::new("rotated scan", wavefront), |b| {
                    b.iter(|| cpu::rotated_scan(&edges, &seeds, wavefront, STOP));
                });
                group.bench_function(BenchmarkId::new("fast marching", wavefront), |b| {
                    b.iter(|| {
                        let order = cpu::Order::Times;
                        cpu::RotatedScan::in_order(&edges, wavefront, order).solve(&seeds, STOP)
                    });
                });
                let Some(solver) = &mut solver else { continue };
                let mut on_device = solver.upload(&surface).expect("the grid fits the device");
                let id = BenchmarkId::new(format!("Vulkan on {}", solver.device_name()), wavefront);
                let method = Method::new(wavefront, STOP);
                group.bench_function(id, |b| {
                    b.iter_custom(|runs| {
                        (0..runs)
                            .map(|_| solver.solve(&mut on_device, &seeds, method))
                            .map(|solution| solution.expect("the device works").time)
                            .sum::<Duration>()
                    });
                });
            }
        }
    }
}

/// Measures edge lengths, which are computed once per surface.
fn edge_lengths(c: &mut Criterion) {
    for builtin in [Builtin::Sphere, Builtin::Maze] {
        let mut group = c.benchmark_group(format!("edge lengths/{}", builtin.name()));
        for side in [150, 1200] {
            let surface = builtin.surface(side, side).expect("built-in surfaces fit");
            group.throughput(Throughput::Elements((side * side) as u64)).sample_size(10);
            group.bench_function(BenchmarkId::from_parameter(side), |b| {
                b.iter(|| EdgeLengths::<f32>::new(&surface));
            });
        }
    }
}

criterion_group!(benches, edge_lengths, distance_map);
criterion_main!(benches);
