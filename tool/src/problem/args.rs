//! Defines the common parts of commands on curves: the arguments for surface, sources, solver and picture, and the
//! steps before a command's own work.

use std::error::Error;
use std::path::Path;

use geosweep::DistanceMap;
use geosweep::io::OutputFile;

use super::{
    CurveFiles, GivenSources, MapReport, PictureArgs, Scene, SolverArgs, SourceArgs, SurfaceArgs,
    default_precision, double_at, inputs, solve_in,
};
use crate::output::check_outputs;
use crate::picture::Look;
use crate::precision::Precision;

#[derive(clap::Args)]
pub struct ProblemArgs {
    #[command(flatten)]
    sources: SourceArgs,
    #[command(flatten)]
    surface: SurfaceArgs,
    #[command(flatten)]
    solver: SolverArgs,
    /// Precision of the map. Results are computed from the map rounded to single precision (default: single; double
    /// with --geodetic, unless a Vulkan device is asked for)
    #[arg(long, value_enum, help_heading = "Accuracy")]
    precision: Option<Precision>,
    #[command(flatten)]
    picture: PictureArgs,
}

/// A map, and the picture to write of the results that are computed from it.
pub struct Problem {
    pub scene: Scene,
    pub sources: GivenSources,
    /// The map in single precision, which may have been rounded.
    pub map: DistanceMap,
    /// The map in double precision, if it was computed so.
    double: Option<DistanceMap<f64>>,
    pub picture: Option<(OutputFile, Look)>,
}

impl ProblemArgs {
    /// Computes the map, after all checks that do not need it. The outputs are checked against the inputs.
    /// Outputs are the curves, the picture and possibly `output`; `input` is an additional input. `check` refuses
    /// surfaces that the command does not support.
    pub fn solve(
        &self,
        curves: &CurveFiles,
        output: Option<&OutputFile>,
        input: Option<&Path>,
        check: impl FnOnce(&Scene) -> Result<(), String>,
    ) -> Result<Problem, Box<dyn Error>> {
        let options = self.solver.options()?;
        let picture = self.picture.output()?;
        let outputs: Vec<_> = output.into_iter().chain(curves.files()).chain(&picture).collect();
        check_outputs(&outputs, inputs(&self.surface, &self.sources).chain(input))?;
        let scene = self.surface.read()?;
        curves.check(&scene)?;
        check(&scene)?;
        let look = picture.as_ref().map(|_| self.picture.look(&scene)).transpose()?;
        let sources = self.sources.sources(&scene)?;
        let precision = default_precision(&self.surface, &self.solver);
        let precision = self.precision.unwrap_or(precision);
        let (map, double) = solve_in(precision, &scene, &sources, &options)?;
        Ok(Problem { scene, sources, map, double, picture: picture.zip(look) })
    }

    /// Returns the quantity and unit of the map's values.
    pub fn quantity(&self, scene: &Scene) -> String {
        self.picture.quantity(scene)
    }

    /// Returns the unit of lengths, if it is known.
    pub fn unit<'a>(&'a self, scene: &Scene) -> Option<&'a str> {
        self.picture.unit(scene)
    }
}

impl Problem {
    /// Returns the JSON report of the map.
    pub fn report(&self) -> MapReport<'_> {
        MapReport::new(&self.scene, &self.map, self.double.as_ref())
    }

    /// Returns the map's value at a place on the surface's grid, if the place is a grid point and the map is in double
    /// precision.
    pub fn double_at(&self, place: [f64; 2]) -> Option<f64> {
        double_at(self.double.as_ref(), place)
    }
}
