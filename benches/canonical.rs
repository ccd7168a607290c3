//! Measures the time of a canonical form: classical scaling alone, and with SMACOF to the default tolerance,
//! with and without extrapolation. The distances are computed outside the measured time.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use geosweep::geometry::canonical::{Distances, FormOptions, canonical_form};
use geosweep::pairwise::Pairwise;
use geosweep::surface::builtin::Builtin;
use geosweep::{Options, Wavefront};

fn canonical(c: &mut Criterion) {
    for builtin in [Builtin::Sphere, Builtin::Torus, Builtin::Peaks] {
        for side in [32, 64] {
            let surface = builtin.surface(side, side).expect("built-in surfaces fit");
            let options = Options::default().with_wavefront(Wavefront::Circular);
            let mut pairwise = Pairwise::new(&surface, &options).expect("built-in surfaces fit");
            let (matrix, _) = pairwise.matrix(|_| ()).expect("it fits memory");
            let distances = Distances::new(side * side, matrix).expect("all is reached");
            let mut group = c.benchmark_group(format!("{builtin}/{}", side * side));
            group.sample_size(10);
            let full = FormOptions::default();
            let start = FormOptions::default().with_iterations(0);
            let plain = FormOptions::default().with_extrapolation(false);
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
