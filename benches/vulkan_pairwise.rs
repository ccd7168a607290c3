//! Measures distances from many sources on a Vulkan device and on the CPU engine, on grids of 32 x 32 and 64
//! x 64 points: `cargo bench --bench vulkan_pairwise`. `GEOSWEEP_BENCH_DEVICE` names the device. The measured
//! time does not include what is computed once per surface.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use geosweep::Stop;
use geosweep::pairwise::Pairwise;
use geosweep::surface::builtin::Builtin;
use geosweep::vulkan::{HeadlessSolver, PairwiseSchedule};
use geosweep::{DeviceChoice, Engine, Error, Options, Wavefront};

const CONVERGED: Stop = Stop::within(1e-6).or_after(1000);

fn vulkan_pairwise(c: &mut Criterion) {
    let device = std::env::var("GEOSWEEP_BENCH_DEVICE").unwrap_or_default();
    let solver =
        HeadlessSolver::new(&DeviceChoice::Name(device)).expect("a Vulkan device to measure");
    println!("{}", solver.device_name());
    for side in [32, 64] {
        let points = side * side;
        let surface = Builtin::Sphere.surface(side, side).expect("built-in surfaces fit");
        let on_device = solver.upload(&surface).expect("small surfaces fit");
        // The sources are an eighth of all grid points, in runs of 64 neighbours.
        let sources: Vec<_> = (0..points).filter(|i| i / 64 % 8 == 0).map(Some).collect();
        let mut rows = vec![0.0; sources.len() * points];
        for (name, stop) in [("one iteration", Stop::after(1)), ("converged", CONVERGED)] {
            let mut group = c.benchmark_group(format!("{side} x {side}, {name}"));
            group.throughput(Throughput::Elements(rows.len() as u64)).sample_size(10);
            for wavefront in Wavefront::FOR_ANY_SURFACE {
                let options = Options::default()
                    .with_engine(Engine::Cpu)
                    .with_wavefront(wavefront)
                    .with_tolerance(stop.tolerance)
                    .with_iterations(stop.iterations);
                let mut on_cpu = Pairwise::new(&surface, &options).expect("built-in surfaces fit");
                let points: Vec<_> = sources.iter().flatten().copied().collect();
                group.bench_function(BenchmarkId::new(wavefront.name(), "CPU engine"), |b| {
                    b.iter(|| on_cpu.rows(&points, |_| Ok::<_, Error>(())).expect("it runs"));
                });
                for schedule in PairwiseSchedule::ALL {
                    let pairwise = solver.pairwise(&on_device, wavefront, Some(schedule));
                    let Ok(mut pairwise) = pairwise else { continue };
                    group.bench_function(BenchmarkId::new(wavefront.name(), schedule), |b| {
                        b.iter(|| {
                            pairwise
                                .solve(&solver, &on_device, &sources, stop, &mut rows)
                                .expect("it runs")
                        });
                    });
                }
            }
        }
    }
}

criterion_group!(benches, vulkan_pairwise);
criterion_main!(benches);
