//! Represents the precision of maps, as an argument and in reports.

use std::fmt;

use clap::ValueEnum;
use geosweep::io::MapValue;
use geosweep::surface::Real;
use geosweep::{
    DistanceMap, Error, ErrorEstimate, Options, Sources, Surface, distance_map, distance_map_f64,
    estimate_error, estimate_error_f64,
};
use serde::Serialize;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// Any engine; rounding errors grow with the grid, to some millionths at 1200 x 1200 points
    #[default]
    Single,
    /// The CPU only, in two to four times the time. The default on the Earth, where cells near the poles are thin
    Double,
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Single => "single",
            Self::Double => "double",
        })
    }
}

/// The number type of maps in a precision, and the library's functions for such maps.
pub trait Number: Real + MapValue + Serialize {
    const PRECISION: Precision;
    /// Computes a map.
    const MAP: Solve<DistanceMap<Self>>;
    /// Computes a map with estimated errors.
    const ESTIMATE: Solve<ErrorEstimate<Self>>;
}

type Solve<T> = fn(&Surface, &Sources, &Options) -> Result<T, Error>;

impl Number for f32 {
    const PRECISION: Precision = Precision::Single;
    const MAP: Solve<DistanceMap> = distance_map;
    const ESTIMATE: Solve<ErrorEstimate> = estimate_error;
}

impl Number for f64 {
    const PRECISION: Precision = Precision::Double;
    const MAP: Solve<DistanceMap<f64>> = distance_map_f64;
    const ESTIMATE: Solve<ErrorEstimate<f64>> = estimate_error_f64;
}

/// A task that runs in either precision.
pub trait InPrecision {
    type Result;

    fn run<R: Number>(self) -> Self::Result;
}

impl Precision {
    /// Runs a task in this precision. This is the only place where a precision becomes a type.
    pub fn run<T: InPrecision>(self, task: T) -> T::Result {
        match self {
            Self::Single => task.run::<f32>(),
            Self::Double => task.run::<f64>(),
        }
    }
}
