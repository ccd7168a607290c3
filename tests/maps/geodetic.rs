//! The Earth by latitudes and longitudes, against geodesics of the WGS84 ellipsoid.

use geosweep::surface::GeodeticGrid;
use geosweep::{Engine, Options, Sources, Surface, distance_map, distance_map_f64};

use crate::common::vincenty::{EQUATOR, vincenty};

/// Distance, in metres, from which on Vincenty's iteration may not converge: it is that of nearly opposite points.
const OPPOSITE: f64 = 1.9e7;

fn lines(count: usize, first: f64, step: f64) -> Vec<f64> {
    (0..count).map(|k| first + step * k as f64).collect()
}

/// The truth itself is checked: the quarter of a meridian, the equator, and a length from GeographicLib.
#[test]
fn vincenty_agrees_with_known_geodesics() {
    let quarter = vincenty([12.0, 0.0], [12.0, 90.0]).unwrap();
    assert!((quarter - 10_001_965.729).abs() < 1e-3, "{quarter}");
    let along_equator = vincenty([0.0, 0.0], [90.0, 0.0]).unwrap();
    assert!((along_equator - EQUATOR * std::f64::consts::FRAC_PI_2).abs() < 1e-3);
    // From JFK to LHR, in the documentation of GeographicLib.
    let near = vincenty([-73.8, 40.6], [-0.5, 51.6]).unwrap();
    assert!((near - 5_551_759.4).abs() < 0.1, "{near}");
}

/// A grid of the whole Earth.
struct Earth {
    grid: GeodeticGrid,
    latitudes: Vec<f64>,
    longitudes: Vec<f64>,
    surface: Surface,
}

impl Earth {
    fn new(latitudes: Vec<f64>, longitudes: Vec<f64>) -> Self {
        let grid = GeodeticGrid::new(&latitudes, &longitudes).unwrap();
        let surface = grid.surface(&vec![0.0; latitudes.len() * longitudes.len()]).unwrap();
        Self { grid, latitudes, longitudes, surface }
    }

    /// Returns the mean relative error of distances at the given points, by area, and the largest up to nearly
    /// opposite points.
    fn errors(&self, source: [f64; 2], distances: &[f64]) -> [f64; 2] {
        let (mut sum, mut weights, mut largest) = (0.0, 0.0, 0f64);
        let found = self.grid.crop(distances);
        for (row, &latitude) in self.latitudes.iter().enumerate() {
            for (col, &longitude) in self.longitudes.iter().enumerate() {
                let Some(exact) = vincenty(source, [longitude, latitude]) else { continue };
                if !(1.0..OPPOSITE).contains(&exact) {
                    continue;
                }
                let error = (found[row * self.longitudes.len() + col] - exact).abs() / exact;
                let weight = latitude.to_radians().cos();
                (sum, weights) = (sum + weight * error, weights + weight);
                largest = largest.max(error);
            }
        }
        [sum / weights, largest]
    }

    fn map(&self, [longitude, latitude]: [f64; 2]) -> Vec<f64> {
        let [row, col] = self.grid.place([longitude, latitude]).unwrap();
        let options = Options::default().with_engine(Engine::Cpu);
        distance_map_f64(&self.surface, &Sources::point(row, col), &options).unwrap().distances
    }
}

/// Checks maps of the whole Earth: from the equator, the north, the date line, beside a pole and from it.
fn check_whole_earth(step: f64, mean_bound: f64, largest_bound: f64) {
    let (rows, cols) = ((180.0 / step).round() as usize, (360.0 / step).round() as usize);
    let earth = Earth::new(lines(rows + 1, 90.0, -step), lines(cols + 1, -180.0, step));
    for source in [[0.0, 0.0], [13.0, 52.0], [180.0, -40.0], [75.0, 89.0], [0.0, -90.0]] {
        let [mean, largest] = earth.errors(source, &earth.map(source));
        println!("{step} degrees from {source:?}: mean {mean:.1e}, largest {largest:.1e}");
        assert!(mean < mean_bound && largest < largest_bound, "{source:?}: {mean:e} {largest:e}");
    }
}

#[test]
fn distances_on_the_earth_are_those_of_geodesics() {
    check_whole_earth(1.0, 6e-6, 1e-4);
    check_whole_earth(0.5, 2e-6, 5e-5);
}

/// `cargo test --release --test maps tenth_of_a_degree -- --ignored --nocapture`. Measured: means of 4e-9 to 5.0e-8; the
/// largest are 1.4e-6, and 4.7e-5 from a place beside a pole.
#[test]
#[ignore = "takes minutes and 2 GB"]
fn distances_at_a_tenth_of_a_degree_are_those_of_geodesics() {
    check_whole_earth(0.1, 1e-7, 1e-4);
}

/// Other grids of the Earth give equal maps: from south to north, from 0 to 359 degrees, at the middles of cells.
#[test]
fn grids_of_any_order_and_place_are_the_same_earth() {
    let step = 1.0;
    let grids = [
        ("southwards", lines(181, 90.0, -step), lines(361, -180.0, step)),
        ("northwards", lines(181, -90.0, step), lines(361, 0.0, step)),
        ("without a repeated column", lines(181, 90.0, -step), lines(360, 0.0, step)),
        ("westwards", lines(181, 90.0, -step), lines(360, 180.0, -step)),
        ("cells", lines(180, 89.5, -step), lines(360, 0.5, step)),
        ("without poles", lines(179, -89.0, step), lines(360, -179.5, step)),
    ];
    for (name, latitudes, longitudes) in grids {
        let earth = Earth::new(latitudes, longitudes);
        let on_lines = |lines: &[f64], wanted: f64| {
            let near = |a: &&f64, b: &&f64| (*a - wanted).abs().total_cmp(&(*b - wanted).abs());
            *lines.iter().min_by(near).unwrap()
        };
        let source = [on_lines(&earth.longitudes, 13.0), on_lines(&earth.latitudes, 52.0)];
        let [mean, largest] = earth.errors(source, &earth.map(source));
        println!("{name}: mean {mean:.1e}, largest {largest:.1e}");
        assert!(mean < 6e-6 && largest < 2e-4, "{name}: {mean:e} {largest:e}");
    }
}

/// Measured: mean 1.1e-6, and 6.9e-6 at most, where double precision has 1.0e-6 and 1.9e-6.
#[test]
fn single_precision_costs_few_digits_at_half_a_degree() {
    let earth = Earth::new(lines(361, 90.0, -0.5), lines(721, -180.0, 0.5));
    let source = [13.0, 52.0];
    let [row, col] = earth.grid.place(source).unwrap();
    let options = Options::default().with_engine(Engine::Cpu);
    let map = distance_map(&earth.surface, &Sources::point(row, col), &options).unwrap();
    let distances: Vec<_> = map.distances.iter().map(|&distance| f64::from(distance)).collect();
    let [mean, largest] = earth.errors(source, &distances);
    println!("single precision: mean {mean:.1e}, largest {largest:.1e}");
    assert!(mean < 3e-6 && largest < 5e-5, "{mean:e} {largest:e}");
}
