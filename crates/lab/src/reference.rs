//! Provides built-in surfaces with reference distances.

use geosweep::accuracy::Errors;
use geosweep::surface::SurfaceError;
use geosweep::surface::builtin::Builtin;
use geosweep::{Error, Options, Report, Sources, Surface};

use geosweep_cli::precision::{InPrecision, Number, Precision};

/// A square grid on a built-in surface, with a source and the distances from it.
pub struct Reference {
    pub surface: Surface,
    pub source: [f64; 2],
    pub distances: Vec<f64>,
}

impl Reference {
    /// Creates the grid and computes its distances. `source` is given as fractions of the rows and columns,
    /// and moved to the nearest point.
    pub fn new(builtin: Builtin, points: usize, source: [f64; 2]) -> Result<Self, SurfaceError> {
        let surface = builtin.surface(points, points)?;
        let source = source.map(|fraction| (fraction * (points - 1) as f64).round());
        let distances = builtin.reference_distances(points, points, source);
        Ok(Self { surface, source, distances })
    }

    pub fn point_source(&self) -> Sources {
        Sources::point(self.source[0], self.source[1])
    }

    /// Computes the map from some sources. Returns the report and the errors relative to the reference.
    pub fn solve(
        &self,
        sources: &Sources,
        options: &Options,
        precision: Precision,
    ) -> Result<(Report, Errors), Error> {
        precision.run(Measured { reference: self, sources, options })
    }
}

/// A map whose errors are measured.
struct Measured<'a> {
    reference: &'a Reference,
    sources: &'a Sources,
    options: &'a Options,
}

impl InPrecision for Measured<'_> {
    type Result = Result<(Report, Errors), Error>;

    fn run<R: Number>(self) -> Self::Result {
        let map = R::MAP(&self.reference.surface, self.sources, self.options)?;
        Ok((map.report, Errors::of(&map.distances, &self.reference.distances)))
    }
}
