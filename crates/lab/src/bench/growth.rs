//! Measures how the time grows with the number of points.

use serde::Serialize;

use super::measure::Timing;

/// The growth over the sizes of one surface, wavefront and method.
#[derive(Serialize)]
pub struct Growth {
    pub surface: String,
    pub wavefront: &'static str,
    pub engine: &'static str,
    pub schedule: &'static str,
    /// The numbers of points of the smallest and the largest map.
    pub from: usize,
    pub to: usize,
    /// The exponent: time is proportional to this power of the number of points. It is the slope of the
    /// least-squares line through the logarithms of points and median times.
    pub exponent: f64,
}

/// The smallest number of sizes. With fewer the exponent says little.
const FEWEST_SIZES: usize = 3;

impl Growth {
    /// Computes the growth of everything that was timed at enough sizes. Timings of the same surface and
    /// wavefront must be consecutive.
    pub fn of(timings: &[Timing]) -> Vec<Self> {
        let mut found = Vec::new();
        for maps in timings.chunk_by(|a, b| a.surface == b.surface && a.wavefront == b.wavefront) {
            let mut methods = Vec::new();
            for timing in maps {
                if !methods.contains(&timing.method) {
                    methods.push(timing.method);
                }
            }
            for method in methods {
                let of_method: Vec<_> = maps.iter().filter(|map| map.method == method).collect();
                if of_method.len() < FEWEST_SIZES {
                    continue;
                }
                let sizes = || of_method.iter().map(|map| map.points);
                found.push(Self {
                    surface: of_method[0].surface.to_string(),
                    wavefront: of_method[0].wavefront.name(),
                    engine: method.engine(),
                    schedule: method.schedule(),
                    from: sizes().min().unwrap_or(0),
                    to: sizes().max().unwrap_or(0),
                    exponent: slope(of_method.iter().map(|m| [m.points as f64, m.median()])),
                });
            }
        }
        found
    }
}

/// Returns the slope of the least-squares line through the logarithms of points.
fn slope(points: impl Iterator<Item = [f64; 2]>) -> f64 {
    let points: Vec<_> = points.map(|point| point.map(f64::ln)).collect();
    let mean = |k: usize| points.iter().map(|point| point[k]).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let products: f64 = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    let squares: f64 = points.iter().map(|point| (point[0] - x).powi(2)).sum();
    products / squares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_of_a_power_is_its_exponent() {
        let powers = [10.0, 50.0, 300.0].map(|x: f64| [x, 7.0 * x.powf(1.5)]);
        approx::assert_relative_eq!(slope(powers.into_iter()), 1.5, max_relative = 1e-12);
    }
}
