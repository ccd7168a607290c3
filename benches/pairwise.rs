//! Measures all distances of a surface of 64 x 64 points, for each instruction set:
//! `cargo bench --bench pairwise`. Coefficients are computed outside the measured time.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use geosweep::Stop;
use geosweep::Wavefront;
use geosweep::cpu::{Instructions, PairwiseScan};
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use rayon::prelude::*;

const SIDE: usize = 64;
const POINTS: usize = SIDE * SIDE;
const CONVERGED: Stop = Stop::within(1e-6).or_after(1000);

fn pairwise(c: &mut Criterion) {
    let surface = Builtin::Sphere.surface(SIDE, SIDE).expect("built-in surfaces fit");
    let edges = EdgeLengths::<f32>::new(&surface).expect("built-in surfaces fit");
    let mut matrix = vec![0.0; POINTS * POINTS];
    for (name, stop) in [("one iteration", Stop::after(1)), ("converged", CONVERGED)] {
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements((POINTS * POINTS) as u64)).sample_size(10);
        for wavefront in [Wavefront::Planar, Wavefront::Circular] {
            for instructions in Instructions::available() {
                let solver = PairwiseScan::new(&edges, wavefront).expect("fronts for lanes");
                let solver = solver.with_instructions(instructions);
                group.bench_function(BenchmarkId::new(wavefront.name(), instructions), |b| {
                    b.iter(|| {
                        let batches = matrix.par_chunks_mut(PairwiseScan::LANES * POINTS);
                        batches.enumerate().for_each(|(batch, rows)| {
                            let first = batch * PairwiseScan::LANES;
                            let sources: Vec<_> =
                                (first..first + PairwiseScan::LANES).map(Some).collect();
                            solver.solve(&sources, stop, rows);
                        });
                    });
                });
            }
        }
    }
}

criterion_group!(benches, pairwise);
criterion_main!(benches);
