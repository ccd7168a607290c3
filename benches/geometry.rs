//! What is made of a distance map of 1200 x 1200 points, beside the time of the map itself:
//! `cargo bench --bench geometry`. Edge lengths are measured outside the measured time.

use criterion::{Criterion, criterion_group, criterion_main};
use geosweep::cpu::{RotatedScan, Stop};
use geosweep::geometry::{FarthestPoints, Levels, Side, Voronoi, contours, offset_curves, ridges};
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{Engine, Options, Sources, Wavefront, distance_map};

const SIDE: usize = 1200;
const STOP: Stop = Stop { tolerance: 1e-6, iterations: 1000 };

/// So many points along a spiral around the middle, none near another.
fn spiral(count: u32) -> Sources {
    let turn = std::f64::consts::PI * (3.0 - f64::sqrt(5.0));
    let place = |k: u32| {
        let radius = 0.45 * ((f64::from(k) + 0.5) / f64::from(count)).sqrt();
        let (sin, cos) = (turn * f64::from(k)).sin_cos();
        [sin, cos].map(|x| ((SIDE - 1) as f64 * (0.5 + radius * x)).round())
    };
    (0..count)
        .map(place)
        .fold(Sources::default(), |sources, at| sources.and_point(at[0], at[1], 0.0))
}

fn geometry(c: &mut Criterion) {
    for builtin in [Builtin::Sphere, Builtin::Peaks] {
        let surface = builtin.surface(SIDE, SIDE).expect("built-in surfaces fit");
        let edges = EdgeLengths::<f32>::new(&surface).expect("built-in surfaces fit");
        let mut group = c.benchmark_group(builtin.name());
        group.sample_size(10);
        let close = Sources::point(60.0, 60.0).and_point(64.0, 66.0, 0.0);
        let cases =
            [("2 sources", spiral(2)), ("2 close sources", close), ("50 sources", spiral(50))];
        for (name, sources) in &cases {
            let seeds = sources.seeds(&surface).expect("they lie on the surface");
            for wavefront in [Wavefront::PointSource, Wavefront::Curved] {
                let mut solver = RotatedScan::new(&edges, wavefront);
                group.bench_function(format!("map, {wavefront}, {name}"), |b| {
                    b.iter(|| solver.solve(&seeds, STOP));
                });
            }
            let options = Options { engine: Engine::Cpu, ..Options::default() };
            let map = distance_map(&surface, sources, &options).expect("the surface fits");
            group.bench_function(format!("Voronoi regions, {name}"), |b| {
                b.iter(|| Voronoi::new(&surface, &edges, sources, &map.distances));
            });
            group.bench_function(format!("10 contours, {name}"), |b| {
                let levels = Levels::Count(10).on(&map, sources).expect("ten are not too many");
                b.iter(|| contours(&map, sources, &levels));
            });
        }
        let middle = (SIDE / 2) as f64;
        let curve = Sources::curve([[middle, 0.3 * middle], [middle + 90.0, 1.6 * middle]]);
        let options = Options { engine: Engine::Cpu, ..Options::default() };
        let map = distance_map(&surface, &curve, &options).expect("the surface fits");
        let levels = Levels::Count(10).on(&map, &curve).expect("ten are not too many");
        group.bench_function("10 offset curves", |b| {
            b.iter(|| offset_curves(&surface, &edges, &curve, &map, &levels, Side::Left));
        });
        group.bench_function("ridges", |b| b.iter(|| ridges(&edges, &map.distances, 30.0)));
        group.bench_function("50 farthest points", |b| {
            b.iter(|| {
                let first = Sources::point(60.0, 60.0);
                let points = FarthestPoints::new(&surface, &edges, &first);
                points.expect("it lies on the surface").take(49).count()
            });
        });
    }
}

criterion_group!(benches, geometry);
criterion_main!(benches);
