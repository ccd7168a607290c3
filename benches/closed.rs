//! Measures errors and times on closed surfaces: `cargo bench --bench closed`. `GEOSWEEP_BENCH_DEVICE` names the
//! Vulkan device. Words after `--` choose surfaces by parts of their names.
//!
//! The first table has the errors of both engines with curved fronts in single precision, on grids of about 160,000
//! points. "Largest" is the largest relative error; on spheres it leaves out points within 0.1 radians of the place
//! opposite to the source. The second table compares the time per iteration on a glued surface with that on the same
//! grid cut open, without the measuring of the surface; the two maps are computed in turn, and the medians of their
//! times are printed. The third table has the errors on the ellipsoid of the Earth in double precision (`-- Earth`
//! prints it alone); measuring them takes 2 GB of memory.

#[path = "../tests/common/earth.rs"]
mod earth;
#[path = "../tests/common/vincenty.rs"]
mod vincenty;

use std::f64::consts::{PI, TAU};
use std::time::{Duration, Instant};

use geosweep::cpu::RotatedScan;
use geosweep::surface::builtin::Closed;
use geosweep::surface::{EdgeLengths, Gluing, MetricTensor, Seed};
use geosweep::vulkan::keep_devices;
use geosweep::{
    DeviceChoice, DistanceMap, Engine, Options, Sources, Spacing, Stop, Surface, Wavefront,
    distance_map,
};

/// Number of pairs of runs, on the open and on the glued surface, from which the medians are taken.
const PAIRS: usize = 9;

/// The metric of the flat torus, in cells.
const FLAT: MetricTensor = MetricTensor { rr: 1.0, rc: 0.0, cc: 1.0 };

/// A closed surface, sources on it, and the exact distances from a source.
struct Case {
    name: &'static str,
    surface: Surface,
    sources: Vec<[f64; 2]>,
    exact: Box<dyn Fn([f64; 2]) -> Vec<f64>>,
}

fn case(closed: Closed, [rows, cols]: [usize; 2], sources: &[[f64; 2]]) -> Case {
    Case {
        name: closed.name(),
        surface: closed.surface(rows, cols).expect("the grid is large enough"),
        sources: sources.to_vec(),
        exact: Box::new(move |from| closed.distances(rows, cols, from)),
    }
}

fn glued(surface: Result<Surface, geosweep::surface::SurfaceError>, gluing: Gluing) -> Surface {
    surface.and_then(|surface| surface.with_gluing(gluing)).expect("opposite sides are alike")
}

/// Returns the distances from a source on a plane whose opposite sides are glued, in cells. `images` are the rows
/// and columns at which the source appears in the unrolled plane.
fn unrolled([rows, cols]: [usize; 2], images: &[[f64; 2]]) -> Vec<f64> {
    let places = (0..rows * cols).map(|index| [(index / cols) as f64, (index % cols) as f64]);
    let nearest = |[row, col]: [f64; 2]| {
        let lengths = images.iter().map(|from| (from[0] - row).hypot(from[1] - col));
        lengths.fold(f64::INFINITY, f64::min)
    };
    places.map(nearest).collect()
}

fn flat_torus() -> Case {
    let size @ [rows, cols] = [321, 501];
    let turns = || [-1.0, 0.0, 1.0].into_iter();
    Case {
        name: "flat torus",
        surface: glued(Surface::from_metric(rows, cols, vec![FLAT; rows * cols]), Gluing::both()),
        sources: vec![[100.0, 33.0], [320.0, 70.0]],
        exact: Box::new(move |[row, col]| {
            let image = |down, right| [row + 320.0 * down, col + 500.0 * right];
            let images: Vec<_> =
                turns().flat_map(|down| turns().map(move |right| image(down, right))).collect();
            unrolled(size, &images)
        }),
    }
}

fn flat_moebius_strip() -> Case {
    let size @ [rows, cols] = [321, 501];
    let step = TAU / 500.0;
    let spacing = Spacing { dx: step, dy: step };
    let plane = Surface::from_heights(rows, cols, vec![0.0; rows * cols], spacing);
    Case {
        name: "flat Moebius strip",
        surface: glued(plane, Gluing::flipped_columns()),
        sources: vec![[100.0, 33.0], [240.0, 0.0]],
        exact: Box::new(move |[row, col]| {
            let images = [[row, col], [320.0 - row, col + 500.0], [320.0 - row, col - 500.0]];
            unrolled(size, &images).into_iter().map(|cells| step * cells).collect()
        }),
    }
}

fn cases() -> Vec<Case> {
    let octahedral =
        [[200.0, 200.0], [140.0, 255.0], [100.0, 100.0], [0.0, 200.0], [0.0, 100.0], [0.0, 0.0]];
    vec![
        case(Closed::Cylinder, [277, 577], &[[90.0, 5.0], [150.0, 0.0]]),
        flat_torus(),
        flat_moebius_strip(),
        case(Closed::Cone, [401, 401], &[[300.0, 5.0], [300.0, 0.0], [150.0, 5.0]]),
        case(Closed::Torus, [253, 633], &[[60.0, 20.0], [0.0, 0.0], [126.0, 30.0]]),
        case(
            Closed::Globe,
            [283, 565],
            &[[120.0, 200.0], [120.0, 0.0], [0.0, 17.0], [1.0, 160.0], [2.0, 564.0]],
        ),
        case(Closed::OctahedralSphere, [401, 401], &octahedral),
        case(Closed::EqualAreaSphere, [401, 401], &octahedral),
        case(
            Closed::CubeSphere,
            [327, 491],
            &[[81.0, 81.0], [30.0, 110.0], [0.0, 65.0], [0.0, 0.0], [1.0, 1.0]],
        ),
    ]
}

fn options(engine: &Engine) -> Options {
    Options::default().with_engine(engine.clone()).with_wavefront(Wavefront::Curved)
}

fn solve(surface: &Surface, [row, col]: [f64; 2], engine: &Engine) -> DistanceMap {
    distance_map(surface, &Sources::point(row, col), &options(engine)).expect("the map converges")
}

/// Returns the mean relative errors off seams and on seams, and the largest relative error. On spheres the largest
/// error leaves out points within 0.1 radians of the place opposite to the source.
fn errors(case: &Case, exact: &[f64], distances: &[f32]) -> [f64; 3] {
    let is_copy = {
        let mut is_copy = vec![false; exact.len()];
        let copies = case.surface.copies().expect("the surface is glued").members();
        copies.iter().for_each(|&copy| is_copy[copy as usize] = true);
        is_copy
    };
    let (mut sums, mut counts, mut largest) = ([0.0; 2], [0.0; 2], 0f64);
    for (index, (&exact, &distance)) in exact.iter().zip(distances).enumerate() {
        if !(exact > 1e-9 && exact.is_finite()) {
            continue;
        }
        let error = (f64::from(distance) - exact).abs() / exact;
        let on_seam = usize::from(is_copy[index]);
        sums[on_seam] += error;
        counts[on_seam] += 1.0;
        if exact < PI - 0.1 || !case.name.contains("sphere") && case.name != "globe" {
            largest = largest.max(error);
        }
    }
    [sums[0] / counts[0], sums[1] / counts[1], largest]
}

fn print_errors(cases: &[Case], engines: &[(&str, Engine)]) {
    println!("| surface | source | engine | mean off seams | on seams | largest | iterations |");
    println!("|---|---|---|---:|---:|---:|---:|");
    for case in cases {
        for &source in &case.sources {
            let exact = (case.exact)(source);
            for (engine_name, engine) in engines {
                let map = solve(&case.surface, source, engine);
                let [off, on, largest] = errors(case, &exact, &map.distances);
                let iterations = map.report.iterations;
                println!(
                    "| {} | {source:?} | {engine_name} | {off:.1e} | {on:.1e} | {largest:.1e} | {iterations} |",
                    case.name
                );
            }
        }
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The cost of a map: its time in milliseconds without the measuring of the surface, and its numbers of iterations and
/// of visits per point. The number of visits is known on the CPU only.
struct Cost {
    time: f64,
    iterations: f64,
    visits: f64,
}

/// Returns a function that computes the map of a source and returns its cost. The surface is measured once.
fn measured<'a>(
    surface: &'a Surface,
    source @ [row, col]: [f64; 2],
    engine: &'a Engine,
) -> Box<dyn Fn() -> Cost + 'a> {
    if !matches!(engine, Engine::Cpu) {
        return Box::new(move || {
            let report = solve(surface, source, engine).report;
            let iterations = f64::from(report.iterations);
            Cost { time: milliseconds(report.solve_time), iterations, visits: f64::NAN }
        });
    }
    let edges = EdgeLengths::<f32>::new(surface).expect("lengths are finite");
    let points = edges.chart().points() as f64;
    let seeds = [Seed::at_source(row as usize, col as usize, 0.0)];
    Box::new(move || {
        let mut solver = RotatedScan::new(&edges, Wavefront::Curved);
        let start = Instant::now();
        let convergence = solver.solve(&seeds, Stop::within(1e-6).or_after(1000));
        let time = milliseconds(start.elapsed());
        let visits = solver.visits() as f64 / points;
        Cost { time, iterations: f64::from(convergence.iterations), visits }
    })
}

fn milliseconds(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}

/// Prints how much longer an iteration takes on a glued surface than on the same grid cut open, from the case's first
/// source and from the middle of the grid. From elsewhere than the middle, fronts that go round make iterations visit
/// more points than on the open grid, where engines skip what no front can change. For the CPU, further rows compare
/// the times per visit.
fn print_times(cases: &[Case], engines: &[(&str, Engine)]) {
    println!("\n| surface | source | engine and unit | open | glued | ratio |");
    println!("|---|---|---|---:|---:|---:|");
    // On the cube-sphere cut open, a source reaches only its own face, which is a sixth of the work.
    for case in cases.iter().filter(|case| case.name != "cube-sphere") {
        let open = opened(&case.surface);
        let middle = [open.rows() / 2, open.cols() / 2].map(|at| at as f64);
        for source in [case.sources[0], middle] {
            for (engine_name, engine) in engines {
                let maps = [&open, &case.surface].map(|surface| measured(surface, source, engine));
                let pairs: Vec<_> = (0..PAIRS).map(|_| maps.each_ref().map(|map| map())).collect();
                let print = |unit: &str, of: fn(&Cost) -> f64| {
                    let medians =
                        [0, 1].map(|k| median(pairs.iter().map(|pair| of(&pair[k])).collect()));
                    let ratios = pairs.iter().map(|[open, glued]| of(glued) / of(open));
                    println!(
                        "| {} | {source:?} | {engine_name}, {unit} | {:.2} | {:.2} | {:.2} |",
                        case.name,
                        medians[0],
                        medians[1],
                        median(ratios.collect())
                    );
                };
                print("ms an iteration", |cost| cost.time / cost.iterations);
                if matches!(engine, Engine::Cpu) {
                    print("ms for a visit of each point", |cost| cost.time / cost.visits);
                }
            }
        }
    }
}

/// Returns the grid of a surface without its gluing. Surfaces without positions are flat tori.
fn opened(surface: &Surface) -> Surface {
    let (rows, cols) = (surface.rows(), surface.cols());
    let position = |index| surface.position(index / cols, index % cols);
    match (0..rows * cols).map(position).collect() {
        Some(positions) => Surface::from_positions(rows, cols, positions),
        None => Surface::from_metric(rows, cols, vec![FLAT; rows * cols]),
    }
    .expect("the grid has points")
}

/// Prints errors against geodesics of the ellipsoid. Places nearly opposite to the source are left out.
fn print_earth() {
    println!("\n| degrees | longitude, latitude | mean | largest |");
    println!("|---:|---|---:|---:|");
    for step in [1.0, 0.5, 0.1] {
        let earth = earth::Earth::whole(step);
        for source in earth::SOURCES {
            let [mean, largest] = earth.errors(source, &earth.map(source));
            println!("| {step} | {source:?} | {mean:.1e} | {largest:.1e} |");
        }
    }
}

fn main() {
    keep_devices(true);
    let words: Vec<_> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let is_named =
        |name: &str| words.is_empty() || words.iter().any(|word| name.contains(word.as_str()));
    let device = std::env::var("GEOSWEEP_BENCH_DEVICE").unwrap_or_default();
    let engines = [("CPU", Engine::Cpu), ("Vulkan", Engine::Vulkan(DeviceChoice::Name(device)))];
    let cases: Vec<_> = cases().into_iter().filter(|case| is_named(case.name)).collect();
    if !cases.is_empty() {
        print_errors(&cases, &engines);
        print_times(&cases, &engines);
    }
    if is_named("Earth") {
        print_earth();
    }
}
