//! Time of a canonical form: classical scaling alone, then with SMACOF to the default tolerance,
//! plain and extrapolated. The distances are computed outside the measured time.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use geosweep::Wavefront;
use geosweep::cpu::Stop;
use geosweep::geometry::canonical::{Distances, FormOptions, canonical_form, geodesic_distances};
use geosweep::surface::builtin::Builtin;

const STOP: Stop = Stop { tolerance: 1e-6, iterations: 1000 };

fn canonical(c: &mut Criterion) {
    for builtin in [Builtin::Sphere, Builtin::Torus, Builtin::Peaks] {
        for side in [32, 64] {
            let surface = builtin.surface(side, side).expect("built-in surfaces fit");
            let points: Vec<usize> = (0..side * side).collect();
            let matrix =
                geodesic_distances(&surface, &points, Wavefront::PointSource, STOP, |_| ())
                    .expect("built-in surfaces fit");
            let distances = Distances::new(points.len(), matrix).expect("all is reached");
            let mut group = c.benchmark_group(format!("{builtin}/{}", points.len()));
            group.sample_size(10);
            let full = FormOptions::default();
            let start = FormOptions { iterations: 0, ..FormOptions::default() };
            let plain = FormOptions { extrapolate: false, ..FormOptions::default() };
            for (name, options) in
                [("classical scaling", start), ("plain SMACOF", plain), ("SMACOF", full)]
            {
                group.bench_function(BenchmarkId::from_parameter(name), |b| {
                    b.iter(|| canonical_form(&distances, &options).expect("a form"));
                });
            }
        }
    }
}

criterion_group!(benches, canonical);
criterion_main!(benches);
