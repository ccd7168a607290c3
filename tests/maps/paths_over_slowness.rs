//! Paths over a slowness that jumps or changes within a few cells cost what the map says, and refract where it does.

use geosweep::geometry::PathTracer;
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{EdgeLengths, MetricTensor};
use geosweep::{Options, Sources, Spacing, Surface, Wavefront, distance_map};
use proptest::prelude::*;

use crate::common::{Random, cases};

fn plane(rows: usize, cols: usize, slowness: impl Fn(usize, usize) -> f64) -> Surface {
    let flat = Surface::from_heights(rows, cols, vec![0.0; rows * cols], Spacing::square(1.0));
    let slowness = (0..rows * cols).map(|k| slowness(k / cols, k % cols)).collect();
    flat.unwrap().with_slowness(slowness).unwrap()
}

/// Returns the value of the map at a place, the cost of the path from there, and the path's largest distance in rows from
/// the source's row.
fn path(surface: &Surface, from: [f64; 2], to: [f64; 2]) -> [f64; 3] {
    let sources = Sources::point(from[0], from[1]);
    let map = distance_map(surface, &sources, &Options::default()).unwrap();
    let edges = EdgeLengths::new(surface).unwrap();
    let tracer = PathTracer::new(surface, &edges, &sources, &map.distances).unwrap();
    let path = tracer.trace(to).unwrap();
    let beside = path.curve.vertices.iter().map(|at| (at[0] - from[0]).abs());
    [path.distance, path.length, beside.fold(0.0, f64::max)]
}

#[test]
fn paths_through_a_wall_run_straight_and_cost_its_slowness() {
    for wall in [2.0, 4.0, 10.0, 100.0, 1000.0] {
        let surface = plane(41, 61, |_, col| if col == 30 { wall } else { 1.0 });
        let [map, cost, beside] = path(&surface, [20.0, 5.0], [20.0, 55.0]);
        let exact = 49.0 + wall;
        assert!((map - exact).abs() < 1e-3 * exact, "{wall}: {map}");
        assert!((cost - exact).abs() < 2e-3 * exact && beside < 0.1, "{wall}: {cost} {beside}");
    }
    let thick = plane(41, 61, |_, col| if (30..40).contains(&col) { 100.0 } else { 1.0 });
    let [_, cost, _] = path(&thick, [20.0, 5.0], [20.0, 55.0]);
    assert!((cost - 1040.0).abs() < 2.0, "{cost}");
    let small = plane(2, 3, |_, col| if col == 1 { 100.0 } else { 1.0 });
    let [_, cost, _] = path(&small, [1.0, 0.0], [1.0, 2.0]);
    assert!((cost - 101.0).abs() < 0.1, "{cost}");
}

#[test]
fn paths_cost_what_the_map_says() {
    let mut random = Random::new(5);
    let classes: Vec<f64> =
        (0..100).map(|_| [1.0, 2.0, 5.0, 10.0][(4.0 * random.next()) as usize]).collect();
    let blocks = |row: usize, col: usize| classes[row / 9 * 10 + col / 9];
    let ridge = |_: usize, col: usize| 1.0 + 99.0 * (-(col as f64 / 2.0 - 15.0).powi(2)).exp();
    let smooth =
        |row: usize, col: usize| 1.5 + (0.1 * row as f64).sin() * (0.13 * col as f64).cos();
    let peaks = Builtin::Peaks.surface(61, 81).unwrap();
    let slowed: Vec<f64> = (0..61 * 81).map(|k| blocks(k / 81, k % 81)).collect();
    let cases = [
        ("blocks", plane(61, 81, blocks)),
        ("ridge", plane(61, 81, ridge)),
        ("smooth", plane(61, 81, smooth)),
        ("blocks on peaks", peaks.with_slowness(slowed).unwrap()),
    ];
    for (name, surface) in cases {
        let mut errors = Vec::new();
        for _ in 0..30 {
            let mut place = || [(61.0 * random.next()).floor(), (81.0 * random.next()).floor()];
            let [from, to] = [place(), place()];
            if from == to {
                continue;
            }
            let [map, cost, _] = path(&surface, from, to);
            errors.push((cost / map - 1.0).abs());
        }
        errors.sort_by(f64::total_cmp);
        let [median, largest] = [errors[errors.len() / 2], errors[errors.len() - 1]];
        println!("{name}: median {median:.1e}, largest {largest:.1e}");
        assert!(median < 8e-3 && largest < 3e-2, "{name}: {median:e} {largest:e}");
    }
}

/// The kinds of drawn fields.
const KINDS: [&str; 5] = ["smooth", "strips", "blocks", "hills", "noise"];

/// Draws a number from 0 to 1 at each point, with features of the given kind.
fn field(kind: &str, [rows, cols]: [usize; 2], random: &mut Random) -> Vec<f64> {
    let mut up_to = |most: f64| most * random.next();
    let places = (0..rows * cols).map(|k| [k / cols, k % cols]);
    match kind {
        "smooth" => {
            let [a, b, c, d] = [up_to(0.4), up_to(0.4), up_to(6.0), up_to(6.0)];
            let wave =
                |[row, col]: [usize; 2]| (a * row as f64 + c).sin() + (b * col as f64 + d).cos();
            places.map(|at| 0.5 + 0.25 * wave(at)).collect()
        }
        "strips" => {
            let axis = usize::from(up_to(1.0) < 0.5);
            let mut across = vec![0.0; rows.max(cols)];
            for _ in 0..4 {
                let (first, width) = (up_to(across.len() as f64) as usize, 1 + up_to(5.0) as usize);
                let value = up_to(1.0);
                across.iter_mut().skip(first).take(width).for_each(|here| *here = value);
            }
            places.map(|at| across[at[axis]]).collect()
        }
        "blocks" => {
            let side = 2 + up_to(12.0) as usize;
            let values: Vec<f64> = (0..rows * cols).map(|_| up_to(1.0)).collect();
            places.map(|[row, col]| values[row / side * cols + col / side]).collect()
        }
        "hills" => {
            let [lengths, widths] = [rows, cols].map(|points| points as f64);
            let hills: [[f64; 3]; 4] =
                std::array::from_fn(|_| [up_to(lengths), up_to(widths), 1.0 + up_to(6.0)]);
            let height = |[row, col]: [usize; 2]| {
                let of = |[x, y, size]: [f64; 3]| {
                    (-(row as f64 - x).hypot(col as f64 - y).powi(2) / (size * size)).exp()
                };
                hills.map(of).into_iter().fold(0.0, f64::max)
            };
            places.map(height).collect()
        }
        _ => places.map(|_| up_to(1.0)).collect(),
    }
}

/// Returns the ratios of the costs of paths to the map's values at their starts. The source and the starts lie anywhere,
/// half of them at grid points.
fn ratios(surface: &Surface, random: &mut Random, paths: usize) -> Vec<f64> {
    let (last_row, last_col) = surface.chart().last();
    let mut place = || {
        let at = [last_row, last_col].map(|last| random.next() * last as f64);
        if random.next() < 0.5 { at.map(f64::round) } else { at }
    };
    let [row, col] = place();
    let sources = Sources::point(row, col);
    let map = distance_map(surface, &sources, &Options::default()).unwrap();
    let edges = EdgeLengths::new(surface).unwrap();
    let tracer = PathTracer::new(surface, &edges, &sources, &map.distances).unwrap();
    let starts = (0..paths).map(|_| place());
    // Closer than a cell, values between points are not those of the map.
    let starts = starts.filter(|at| (at[0] - row).hypot(at[1] - col) > 1.0);
    let ratio = |at: [f64; 2]| {
        let path = tracer.trace(at).unwrap();
        path.length / path.distance
    };
    starts.map(ratio).collect()
}

/// Where fields change within a cell, maps are of first order, and values between their points may be early.
#[test]
fn paths_over_drawn_fields_cost_what_the_map_says() {
    for kind in KINDS {
        for contrast in [2.0f64, 10.0, 100.0, 1000.0] {
            let mut random = Random::new(11);
            let mut errors = Vec::new();
            for _ in 0..20 {
                let shape @ [rows, cols] = [(); 2].map(|()| 20 + (50.0 * random.next()) as usize);
                let values = field(kind, shape, &mut random);
                let surface = plane(rows, cols, |row, col| contrast.powf(values[row * cols + col]));
                let found = ratios(&surface, &mut random, 15);
                errors.extend(found.into_iter().map(|ratio| (ratio - 1.0).abs()));
            }
            errors.sort_by(f64::total_cmp);
            let share = |share: f64| errors[((errors.len() - 1) as f64 * share) as usize];
            let [median, most, largest] = [share(0.5), share(0.8), share(1.0)];
            println!("{kind} {contrast}: {median:.1e}, four in five {most:.1e}, all {largest:.1e}");
            let (half, four_in_five) = if kind == "noise" { (6e-3, 1.2e-2) } else { (3e-3, 7e-3) };
            assert!(median < half && most < four_in_five && largest < 0.2, "{kind} {contrast}");
        }
    }
}

proptest! {
    #![proptest_config(cases(100))]

    /// Where the slowness changes by a tenth or less along an edge, each path costs what the map says.
    #[test]
    fn paths_over_resolved_fields_cost_what_the_map_says(
        seed in any::<u64>(),
        power in 0.0..3.0,
        shape in prop::array::uniform2(20usize..70),
        waves in prop::array::uniform2(0.0..1.0),
        phases in prop::array::uniform2(0.0..6.3f64),
    ) {
        // The contrast of the waves, as a power of e, and their angle from point to point.
        let height: f64 = 0.5 * power * 10f64.ln();
        let angles: [f64; 2] = waves.map(|wave: f64| wave * f64::min(0.4, 0.04 / height));
        let [rows, cols] = shape;
        let surface = plane(rows, cols, |row, col| {
            let of = |axis: usize, at: usize| (angles[axis] * at as f64 + phases[axis]).sin();
            (height * (of(0, row) + of(1, col))).exp()
        });
        for ratio in ratios(&surface, &mut Random::new(seed), 10) {
            prop_assert!((ratio - 1.0).abs() < 5e-3, "{ratio}");
        }
    }
}

#[test]
fn paths_over_slowed_surfaces_cost_what_the_map_says() {
    let mut random = Random::new(5);
    for builtin in [Builtin::Peaks, Builtin::Sphere] {
        for kind in ["smooth", "blocks"] {
            let mut errors = Vec::new();
            for _ in 0..6 {
                let values = field(kind, [61, 81], &mut random);
                let slowness = values.iter().map(|value| 10f64.powf(*value)).collect();
                let surface = builtin.surface(61, 81).unwrap().with_slowness(slowness).unwrap();
                let found = ratios(&surface, &mut random, 10);
                errors.extend(found.into_iter().map(|ratio| (ratio - 1.0).abs()));
            }
            errors.sort_by(f64::total_cmp);
            let [median, largest] = [errors[errors.len() / 2], errors[errors.len() - 1]];
            println!("{builtin} {kind}: median {median:.1e}, largest {largest:.1e}");
            assert!(median < 6e-3 && largest < 5e-2, "{builtin} {kind}: {median:e} {largest:e}");
        }
    }
}

/// Beside a source inside a cell, no value exceeds the cost of a path by much: straight lines lead from the source to the
/// points around its cell. Without them values were late by up to a third. A metric whose scale jumps is a slowness too.
#[test]
fn points_beside_sources_inside_cells_are_not_late() {
    for wavefront in [Wavefront::Planar, Wavefront::Curved] {
        for is_metric in [false, true] {
            let mut random = Random::new(7);
            let mut late = Vec::new();
            for kind in ["blocks", "noise"].repeat(12) {
                let (rows, cols) = (24, 27);
                let values = field(kind, [rows, cols], &mut random);
                let slowness = |row: usize, col: usize| 10f64.powf(values[row * cols + col]);
                let square = |k: usize| slowness(k / cols, k % cols).powi(2);
                let metric = (0..rows * cols)
                    .map(|k| MetricTensor { rr: square(k), rc: 0.0, cc: square(k) })
                    .collect();
                let surface = match is_metric {
                    true => Surface::from_metric(rows, cols, metric).unwrap(),
                    false => plane(rows, cols, slowness),
                };
                let from = [11.0 + random.next(), 12.0 + random.next()];
                let sources = Sources::point(from[0], from[1]);
                let options = Options::default().with_wavefront(wavefront);
                let map = distance_map(&surface, &sources, &options).unwrap();
                let edges = EdgeLengths::new(&surface).unwrap();
                let tracer = PathTracer::new(&surface, &edges, &sources, &map.distances).unwrap();
                for (row, col) in (10..14).flat_map(|row| (11..15).map(move |col| (row, col))) {
                    let path = tracer.trace([row as f64, col as f64]).unwrap();
                    late.push(path.distance / path.length - 1.0);
                }
            }
            late.sort_by(f64::total_cmp);
            let [median, largest] = [late[late.len() / 2], late[late.len() - 1]];
            println!("{wavefront}, metric {is_metric}: median {median:.1e}, {largest:.1e} at most");
            assert!(median.abs() < 5e-3 && largest < 0.1, "{wavefront} {is_metric}: {largest}");
        }
    }
}
