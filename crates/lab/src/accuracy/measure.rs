//! Performs the measurements of accuracy.

use std::time::Duration;

use geosweep::accuracy::Errors;
use geosweep::surface::builtin::Builtin;
use geosweep::{Engine, Error, Options, Wavefront};
use serde_json::{Value, json};

use crate::reference::Reference;
use geosweep_cli::precision::Precision;
use geosweep_cli::terminal::progress;

/// The errors and the cost of one map.
pub struct Measurement {
    pub builtin: Builtin,
    pub wavefront: Wavefront,
    /// The number of points per side.
    pub points: usize,
    pub errors: Errors,
    /// The order of convergence of the mean error, from the previous size to this one.
    pub order: Option<f64>,
    pub iterations: u32,
    pub time: Duration,
    pub device: Option<String>,
    /// The order of updates.
    pub schedule: &'static str,
}

/// Measures each surface with each of its wavefronts at each size. Results are in this order.
pub fn all(
    cases: &[(Builtin, Vec<Wavefront>)],
    sizes: &[usize],
    engine: &Engine,
    precision: Precision,
) -> Result<Vec<Measurement>, Error> {
    let maps = cases.iter().map(|(_, wavefronts)| wavefronts.len()).sum::<usize>();
    let bar = progress(maps * sizes.len());
    let mut measured = Vec::new();
    for &(builtin, ref wavefronts) in cases {
        let mut of_surface: Vec<Vec<Measurement>> = wavefronts.iter().map(|_| Vec::new()).collect();
        for &points in sizes {
            bar.set_message(format!("{builtin} {points}"));
            let reference = Reference::new(builtin, points, source(builtin))?;
            for (&wavefront, row) in wavefronts.iter().zip(&mut of_surface) {
                let measurement =
                    Measurement::new(builtin, &reference, wavefront, engine, precision)?;
                let order = row.last().and_then(|coarser| measurement.order_from(coarser));
                row.push(Measurement { order, ..measurement });
                bar.inc(1);
            }
        }
        measured.extend(of_surface.into_iter().flatten());
    }
    bar.finish_and_clear();
    Ok(measured)
}

/// Returns the place of the source, as fractions of rows and columns. In the maze it is the corner where the
/// corridor begins. Elsewhere it lies off every line of symmetry, and on a point of every grid with 32 k + 1
/// points per side.
fn source(builtin: Builtin) -> [f64; 2] {
    match builtin {
        Builtin::Maze => [0.0, 0.0],
        _ => [0.3125, 0.40625],
    }
}

impl Measurement {
    fn new(
        builtin: Builtin,
        reference: &Reference,
        wavefront: Wavefront,
        engine: &Engine,
        precision: Precision,
    ) -> Result<Self, Error> {
        let options = Options::default().with_engine(engine.clone()).with_wavefront(wavefront);
        let sources = reference.point_source();
        let solve = || reference.solve(&sources, &options, precision);
        let (report, errors) = solve()?;
        Ok(Self {
            builtin,
            wavefront,
            points: reference.surface.rows(),
            errors,
            order: None,
            iterations: report.iterations,
            time: shortest(report.solve_time, || Ok(solve()?.0.solve_time))?,
            device: report.device,
            schedule: report.schedule,
        })
    }

    /// Returns the order of convergence: the power of the spacing with which the mean error decreases.
    fn order_from(&self, coarser: &Self) -> Option<f64> {
        let cells = |measurement: &Self| (measurement.points - 1) as f64;
        let order = (coarser.errors.mean_relative / self.errors.mean_relative).log2()
            / (cells(self) / cells(coarser)).log2();
        order.is_finite().then_some(order)
    }

    /// Returns the measurement as JSON.
    pub fn row(&self) -> Value {
        json!({
            "surface": self.builtin.to_string(),
            "wavefront": self.wavefront.name(),
            "side": self.points,
            "mean_relative_error": self.errors.mean_relative,
            "rms_relative_error": self.errors.rms_relative,
            "max_relative_error": self.errors.max_relative,
            "order": self.order,
            "iterations": self.iterations,
            "solve_seconds": self.time.as_secs_f64(),
        })
    }
}

/// Returns the shortest time of several solves. Short solves are repeated more often. Other work on the
/// machine can only add to a time.
fn shortest(
    first: Duration,
    mut again: impl FnMut() -> Result<Duration, Error>,
) -> Result<Duration, Error> {
    const FEWEST: usize = 3;
    const MOST: usize = 5;
    const ENOUGH: Duration = Duration::from_millis(300);
    let (mut shortest, mut sum) = (first, first);
    for solved in 1..MOST {
        if solved >= FEWEST && sum > ENOUGH {
            break;
        }
        let time = again()?;
        shortest = shortest.min(time);
        sum += time;
    }
    Ok(shortest)
}
