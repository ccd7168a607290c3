//! Holds what the commands on curves share: the arguments for surface, sources, solver and picture, and the
//! steps before their own work.

use std::error::Error;
use std::path::Path;

use geosweep::io::OutputFile;
use geosweep::{DistanceMap, Options, Sources};

use super::{
    CurveFiles, MapReport, PictureArgs, Scene, SolverArgs, SourceArgs, SurfaceArgs,
    default_precision, inputs, solve,
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
    /// Precision of the map. Results from it are computed on the map rounded to single precision (default: single;
    /// double with --geodetic, unless a Vulkan device is asked for)
    #[arg(long, value_enum, help_heading = "Accuracy")]
    precision: Option<Precision>,
    #[command(flatten)]
    picture: PictureArgs,
}

/// A map, and the output of a picture of what is computed from it.
pub struct Problem {
    pub scene: Scene,
    pub sources: Sources,
    /// The map in single precision, which may have been rounded.
    pub map: DistanceMap,
    /// The map in double precision, if it was computed so.
    double: Option<DistanceMap<f64>>,
    pub picture: Option<(OutputFile, Look)>,
}

impl ProblemArgs {
    /// Computes the map, after all checks that do not need it. The outputs are checked against the inputs.
    /// Outputs are the curves, the picture and possibly `output`; `input` is an additional input. `open` names what
    /// does not pass seams.
    pub fn solve(
        &self,
        curves: &CurveFiles,
        output: Option<&OutputFile>,
        input: Option<&Path>,
        open: Option<&str>,
    ) -> Result<Problem, Box<dyn Error>> {
        let options = self.solver.options()?;
        let picture = self.picture.output()?;
        let outputs: Vec<_> = output.into_iter().chain(curves.files()).chain(&picture).collect();
        check_outputs(&outputs, inputs(&self.surface, &self.sources).chain(input))?;
        let scene = self.surface.read()?;
        curves.check(&scene)?;
        open.map_or(Ok(()), |what| scene.refuse_round(what))?;
        let look = picture.as_ref().map(|_| self.picture.look(&scene)).transpose()?;
        let sources = self.sources.sources(&scene)?;
        let (map, double) = self.maps(&scene, &sources, &options)?;
        Ok(Problem { scene, sources, map, double, picture: picture.zip(look) })
    }

    fn maps(
        &self,
        scene: &Scene,
        sources: &Sources,
        options: &Options,
    ) -> Result<(DistanceMap, Option<DistanceMap<f64>>), geosweep::Error> {
        match self.precision.unwrap_or(default_precision(&self.surface, &self.solver)) {
            Precision::Single => Ok((solve::<f32>(scene, sources, options)?, None)),
            Precision::Double => {
                let map = solve::<f64>(scene, sources, options)?;
                Ok((map.to_single(), Some(map)))
            }
        }
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
    pub fn double_at(&self, [row, col]: [f64; 2]) -> Option<f64> {
        let map = self.double.as_ref()?;
        let is_point = row.fract() == 0.0 && col.fract() == 0.0;
        is_point.then(|| map.distance(row as usize, col as usize))
    }
}
