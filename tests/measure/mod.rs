//! What the tests of accuracy share: solving with each engine, and errors against references.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::sync::Mutex;

use geosweep::Stop;
use geosweep::accuracy::Errors;
use geosweep::cpu::{self, Solution};
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::vulkan::{Method, Solver};
use geosweep::{DeviceChoice, Sources, Surface, Wavefront};

/// A way to compute a map; every accuracy test runs over all of [`ENGINES`].
pub struct Engine {
    pub name: &'static str,
    pub solve: fn(&Surface, &Sources, Wavefront, Stop) -> Vec<f32>,
}

/// The engines that are held to the bars.
pub const ENGINES: &[Engine] = &[
    Engine {
        name: "cpu",
        solve: |surface, sources, wavefront, stop| {
            rotated::<f32>(surface, sources, wavefront, stop).distances()
        },
    },
    Engine { name: "vulkan", solve: on_vulkan },
];

/// One device for all tests of a file, under the validation layers: a call that leaves a message
/// in their log fails.
static SOLVER: Mutex<Option<Solver>> = Mutex::new(None);

fn on_vulkan(surface: &Surface, sources: &Sources, wavefront: Wavefront, stop: Stop) -> Vec<f32> {
    let mut solver = SOLVER.lock().unwrap();
    let solver = solver.get_or_insert_with(|| {
        let device = std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default();
        Solver::with_validation(&DeviceChoice::Name(device)).unwrap()
    });
    let mut on_device = solver.upload(surface).unwrap();
    let seeds = sources.seeds(surface).unwrap();
    let method = Method { wavefront, schedule: None, stop };
    solver.solve(&mut on_device, &seeds, method).unwrap().distances
}

/// Stops when nothing changes beyond rounding, and never before.
pub const CONVERGED: Stop = Stop { tolerance: 1e-6, iterations: 10_000 };
/// The same for double precision.
pub const CONVERGED_F64: Stop = Stop { tolerance: 1e-13, iterations: 10_000 };

pub fn rotated<R: geosweep::surface::Real>(
    surface: &Surface,
    sources: &Sources,
    wavefront: Wavefront,
    stop: Stop,
) -> Solution<R> {
    let edges = EdgeLengths::new(surface).unwrap();
    cpu::rotated_scan(&edges, &sources.seeds(surface).unwrap(), wavefront, stop)
}

pub fn directed<R: geosweep::surface::Real>(
    surface: &Surface,
    sources: &Sources,
    wavefront: Wavefront,
    stop: Stop,
) -> Solution<R> {
    let edges = EdgeLengths::new(surface).unwrap();
    cpu::raster_scan(&edges, &sources.seeds(surface).unwrap(), wavefront, stop)
}

pub fn marched<R: geosweep::surface::Real>(
    surface: &Surface,
    sources: &Sources,
    wavefront: Wavefront,
) -> Solution<R> {
    let edges = EdgeLengths::new(surface).unwrap();
    cpu::fast_marching(&edges, &sources.seeds(surface).unwrap(), wavefront)
}

pub fn errors<R: geosweep::surface::Real>(map: &[R], exact: &[f64]) -> Errors {
    Errors::of(map, exact)
}

/// Largest difference between two maps over the largest distance; they must reach the same points.
pub fn difference<R: geosweep::surface::Real, S: geosweep::surface::Real>(a: &[R], b: &[S]) -> f64 {
    let b: Vec<f64> = b.iter().map(|x| x.wide()).collect();
    let errors = errors(a, &b);
    assert_eq!(errors.reached_by_one, 0, "one map reaches points that the other does not");
    errors.max_of_largest
}

/// A source off the middle and off every line of symmetry, at a grid point.
pub fn off_centre(rows: usize, cols: usize) -> [f64; 2] {
    [(0.3 * (rows - 1) as f64).round(), (0.4 * (cols - 1) as f64).round()]
}

pub fn at([row, col]: [f64; 2]) -> Sources {
    Sources::point(row, col)
}

/// Largest angle of the triangles of a surface at their updated corner, in degrees.
pub fn largest_angle(surface: &Surface) -> f64 {
    use geosweep::surface::Direction;
    let edges = EdgeLengths::<f64>::new(surface).unwrap();
    let far = <f64 as geosweep::surface::Real>::FAR;
    let mut largest = 0.0f64;
    for (row, col) in (0..surface.rows()).flat_map(|r| (0..surface.cols()).map(move |c| (r, c))) {
        for first in Direction::ALL {
            let (r, c) = (surface.chart().neighbour(row, col, first), first.next());
            let Some(((row1, col1), (row2, col2))) = r.zip(surface.chart().neighbour(row, col, c))
            else {
                continue;
            };
            let step = (row2 as isize - row1 as isize, col2 as isize - col1 as isize);
            let base = Direction::ALL.into_iter().find(|d| d.step() == step).unwrap();
            let (l1, l2) = (edges.length(row, col, first), edges.length(row, col, c));
            let base = edges.length(row1, col1, base);
            if l1.max(l2).max(base) < far {
                let cos = (l1 * l1 + l2 * l2 - base * base) / (2.0 * l1 * l2);
                largest = largest.max(cos.clamp(-1.0, 1.0).acos().to_degrees());
            }
        }
    }
    largest
}

/// Every built-in surface at a size, with its name.
pub fn builtins(points: usize) -> Vec<(String, Surface)> {
    Builtin::ALL.iter().map(|b| (b.to_string(), b.surface(points, points).unwrap())).collect()
}

/// Pseudo-random numbers (xorshift), the same on every machine.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self((seed + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    /// Uniform from 0 to 1.
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}
