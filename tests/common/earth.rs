//! Grids of the Earth by latitudes and longitudes, and the errors of distances on them.

use geosweep::surface::GeodeticGrid;
use geosweep::{Engine, Options, Sources, Surface, distance_map_f64};

use super::vincenty::vincenty;

/// Distance, in metres, beyond which points are nearly opposite and Vincenty's iteration may not converge.
const OPPOSITE: f64 = 1.9e7;

/// Longitudes and latitudes of sources: on the equator, in the north, on the date line, beside a pole and at one.
pub const SOURCES: [[f64; 2]; 5] =
    [[0.0, 0.0], [13.0, 52.0], [180.0, -40.0], [75.0, 89.0], [0.0, -90.0]];

/// Returns `count` numbers of degrees, from `first` on, in steps of `step`.
pub fn lines(count: usize, first: f64, step: f64) -> Vec<f64> {
    (0..count).map(|k| first + step * k as f64).collect()
}

/// A grid of the Earth, or of a part of it.
pub struct Earth {
    pub grid: GeodeticGrid,
    pub latitudes: Vec<f64>,
    pub longitudes: Vec<f64>,
    pub surface: Surface,
}

impl Earth {
    pub fn new(latitudes: Vec<f64>, longitudes: Vec<f64>) -> Self {
        let grid = GeodeticGrid::new(&latitudes, &longitudes).unwrap();
        let surface = grid.surface(&vec![0.0; latitudes.len() * longitudes.len()]).unwrap();
        Self { grid, latitudes, longitudes, surface }
    }

    /// Returns the whole Earth, with lines at this step in degrees.
    pub fn whole(step: f64) -> Self {
        let (rows, cols) = ((180.0 / step).round() as usize, (360.0 / step).round() as usize);
        Self::new(lines(rows + 1, 90.0, -step), lines(cols + 1, -180.0, step))
    }

    /// Returns the mean, weighted by area, and the largest relative error of distances at the given points. Points
    /// nearer than a metre and nearly opposite points are left out.
    pub fn errors(&self, source: [f64; 2], distances: &[f64]) -> [f64; 2] {
        let (mut sum, mut weights, mut largest) = (0.0, 0.0, 0f64);
        let found = self.grid.lines().crop(distances);
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

    /// Returns the distances from a place in double precision.
    pub fn map(&self, [longitude, latitude]: [f64; 2]) -> Vec<f64> {
        let [row, col] = self.grid.place([longitude, latitude]).unwrap();
        let options = Options::default().with_engine(Engine::Cpu);
        distance_map_f64(&self.surface, &Sources::point(row, col), &options).unwrap().distances
    }
}
