//! Shared parts of the integration tests: maps by either engine, surfaces, and differences of maps.

#![allow(dead_code, reason = "each binary uses its part")]

pub mod bounds;
mod cases;
pub mod closed;
mod devices;
pub mod earth;
pub mod fibres;
mod irregular;
pub mod parts;
pub mod sheets;
pub mod vincenty;

use geosweep::Stop;
use geosweep::accuracy::Errors;
use geosweep::cpu::{self, Solution};
use geosweep::surface::{EdgeLengths, Real, Seed};
use geosweep::vulkan::{HeadlessSolver, Method};
use geosweep::{DistanceMap, Engine, Options, Sources, Spacing, Surface, Wavefront, distance_map};

#[allow(unused_imports, reason = "each binary uses its part")]
pub use cases::cases;
#[allow(unused_imports, reason = "each binary uses its part")]
pub use devices::{
    Lent, Pool, assert_nothing_said, device_choice, gpu_like_solver, tuned, vulkan_solver,
};

/// Stops when nothing changes beyond rounding, and never earlier.
pub const CONVERGED: Stop = Stop::within(1e-6).or_after(10_000);
/// Counterpart of [`CONVERGED`] for double precision.
pub const CONVERGED_F64: Stop = Stop::within(1e-13).or_after(10_000);

/// Computes a map with the CPU engine.
pub fn rotated<R: Real>(
    surface: &Surface,
    sources: &Sources,
    wavefront: Wavefront,
    stop: Stop,
) -> Solution<R> {
    let edges = EdgeLengths::new(surface).unwrap();
    cpu::rotated_scan(&edges, &sources.seeds(surface).unwrap(), wavefront, stop)
}

/// Computes a map with scans along the grid's own directions.
pub fn directed<R: Real>(
    surface: &Surface,
    sources: &Sources,
    wavefront: Wavefront,
    stop: Stop,
) -> Solution<R> {
    let edges = EdgeLengths::new(surface).unwrap();
    cpu::raster_scan(&edges, &sources.seeds(surface).unwrap(), wavefront, stop)
}

/// Computes a map in the order of arrival times.
pub fn marched<R: Real>(surface: &Surface, sources: &Sources, wavefront: Wavefront) -> Vec<R> {
    let edges = EdgeLengths::new(surface).unwrap();
    let mut solver = cpu::RotatedScan::in_order(&edges, wavefront, cpu::Order::Times);
    let convergence = solver.solve(&sources.seeds(surface).unwrap(), CONVERGED);
    assert_eq!((convergence.iterations, convergence.residual), (1, 0.0));
    solver.distances()
}

/// Returns the map of the CPU engine with its default options.
pub fn cpu_map(surface: &Surface, sources: &Sources) -> DistanceMap {
    let options = Options::default().with_engine(Engine::Cpu);
    distance_map(surface, sources, &options).unwrap()
}

/// Returns options for curved fronts on the CPU.
pub fn curved() -> Options {
    Options::default().with_engine(Engine::Cpu).with_wavefront(Wavefront::Curved)
}

/// Returns the map of the CPU engine.
pub fn on_cpu(surface: &Surface, seeds: &[Seed], wavefront: Wavefront, stop: Stop) -> Vec<f32> {
    let edges = EdgeLengths::<f32>::new(surface).unwrap();
    cpu::rotated_scan(&edges, seeds, wavefront, stop).distances()
}

/// Returns the map of the Vulkan engine.
pub fn on_vulkan(
    solver: &mut HeadlessSolver,
    surface: &Surface,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
) -> Vec<f32> {
    let mut on_device = solver.upload(surface).unwrap();
    let method = Method::new(wavefront, stop);
    solver.solve(&mut on_device, seeds, method).unwrap().distances
}

/// Returns the largest difference of two maps, relative to the largest distance. Asserts that both are free
/// of NaN and reach the same points.
pub fn difference<R: Real, S: Real>(a: &[R], b: &[S]) -> f64 {
    let b: Vec<f64> = b.iter().map(|x| x.wide()).collect();
    assert!(!b.iter().any(|x| x.is_nan()), "a distance is NaN");
    let errors = Errors::of(a, &b);
    assert_eq!(errors.reached_by_one, 0, "one map reaches points that the other does not");
    errors.max_of_largest
}

/// Returns a height field without symmetry. A simple hash makes about one point in `one_hole_in` a hole, or
/// none for 0.
pub fn rough(rows: usize, cols: usize, one_hole_in: u64) -> Surface {
    let hash = |index: usize| (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
    let heights = (0..rows * cols)
        .map(|index| {
            let (row, col) = ((index / cols) as f64, (index % cols) as f64);
            let hole = one_hole_in > 0 && hash(index).is_multiple_of(one_hole_in);
            if hole { f64::NAN } else { 2.0 * (0.31 * row).sin() * (0.23 * col + 0.1 * row).cos() }
        })
        .collect();
    Surface::from_heights(rows, cols, heights, Spacing { dx: 1.0, dy: 1.3 }).unwrap()
}

/// Returns the first point of a surface from the middle on.
pub fn some_point(surface: &Surface) -> (usize, usize) {
    let chart = surface.chart();
    let points = chart.points();
    let index = (0..points)
        .map(|offset| (points / 2 + offset) % points)
        .find(|&index| surface.present()[index])
        .expect("a surface has a point");
    chart.position(index)
}

/// Returns a source at the first point from the middle on.
pub fn middle(surface: &Surface) -> Sources {
    let (row, col) = some_point(surface);
    Sources::point(row as f64, col as f64)
}

/// Returns a height field with holes, which is slower beyond a column.
pub fn slowed(rows: usize, cols: usize, from_col: usize) -> Surface {
    let slowness = |index: usize| if index % cols < from_col { 1.0 } else { 2.5 };
    let slowness = (0..rows * cols).map(slowness).collect();
    rough(rows, cols, 9).with_slowness(slowness).unwrap()
}

/// Returns the seeds of a source at a grid point.
pub fn seeds_at(surface: &Surface, (row, col): (usize, usize)) -> Vec<Seed> {
    at([row as f64, col as f64]).seeds(surface).unwrap()
}

/// Returns a source at a grid point, off the middle and off every line of symmetry.
pub fn off_centre(rows: usize, cols: usize) -> [f64; 2] {
    [(0.3 * (rows - 1) as f64).round(), (0.4 * (cols - 1) as f64).round()]
}

pub fn at([row, col]: [f64; 2]) -> Sources {
    Sources::point(row, col)
}

/// Returns point sources that start at 0.
pub fn points(places: &[[f64; 2]]) -> Sources {
    places.iter().fold(Sources::default(), |all, &[row, col]| all.and_point(row, col, 0.0))
}

/// Returns the distance in cells from a place of a square grid to the line where a function is zero, from the
/// function's change over one cell.
pub fn cells_from_zero(points: usize, value: impl Fn([f64; 2]) -> f64, at: [f64; 2]) -> f64 {
    let change = |step: [f64; 2]| {
        let ahead = [0, 1].map(|k| (at[k] + step[k]).min((points - 1) as f64));
        value(ahead) - value([0, 1].map(|k| ahead[k] - step[k]))
    };
    value(at).abs() / change([1.0, 0.0]).hypot(change([0.0, 1.0]))
}

/// Returns a circular curve that runs counter-clockwise, and the distance of each point of a square grid from it, in
/// cells.
pub fn circle(points: usize, centre: [f64; 2], radius: f64) -> (Sources, Vec<f64>) {
    let vertex = |k: i32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k % 720) / 720.0).sin_cos();
        [centre[0] - radius * sin, centre[1] + radius * cos]
    };
    let exact = |index: usize| {
        let (row, col) = ((index / points) as f64, (index % points) as f64);
        ((row - centre[0]).hypot(col - centre[1]) - radius).abs()
    };
    (Sources::curve((0..=720).map(vertex)), (0..points * points).map(exact).collect())
}

/// Pseudo-random numbers (xorshift), which are the same on every machine.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self((seed + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    /// Returns a number that is uniform from 0 to 1.
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}
