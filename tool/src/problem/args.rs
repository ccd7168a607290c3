//! What the commands on curves share: their arguments on surface, sources, solver and picture, and
//! what is done with those before their own work.

use std::error::Error;
use std::path::Path;

use geosweep::io::OutputFile;
use geosweep::{DistanceMap, Options, Sources};

use super::{
    CurveFiles, MapReport, PictureArgs, Scene, SolverArgs, SourceArgs, SurfaceArgs, inputs, solve,
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
    /// Compute the map in this precision; what is drawn on it is found in the map rounded to single
    /// precision
    #[arg(long, value_enum, default_value_t, help_heading = "Accuracy")]
    precision: Precision,
    #[command(flatten)]
    picture: PictureArgs,
}

/// A map, and where a picture of what is made of it goes.
pub struct Problem {
    pub scene: Scene,
    pub sources: Sources,
    /// In single precision, perhaps rounded.
    pub map: DistanceMap,
    /// In double precision, if it was computed so.
    double: Option<DistanceMap<f64>>,
    pub picture: Option<(OutputFile, Look)>,
}

impl ProblemArgs {
    /// Solves, after all checks that need no solution: of the outputs, which are curves and the
    /// picture and perhaps one of another kind, against the inputs, of which `input` is another.
    pub fn solve(
        &self,
        curves: &CurveFiles,
        output: Option<&OutputFile>,
        input: Option<&Path>,
    ) -> Result<Problem, Box<dyn Error>> {
        let options = self.solver.options()?;
        let picture = self.picture.output()?;
        let outputs: Vec<_> = output.into_iter().chain(curves.files()).chain(&picture).collect();
        check_outputs(&outputs, inputs(&self.surface, &self.sources).chain(input))?;
        let scene = self.surface.read()?;
        curves.check(&scene)?;
        let look = picture.as_ref().map(|_| self.picture.look(&scene)).transpose()?;
        let sources = self.sources.sources(&scene.frame())?;
        let (map, double) = self.maps(&scene, &sources, &options)?;
        Ok(Problem { scene, sources, map, double, picture: picture.zip(look) })
    }

    fn maps(
        &self,
        scene: &Scene,
        sources: &Sources,
        options: &Options,
    ) -> Result<(DistanceMap, Option<DistanceMap<f64>>), geosweep::Error> {
        match self.precision {
            Precision::Single => Ok((solve::<f32>(scene, sources, options)?, None)),
            Precision::Double => {
                let map = solve::<f64>(scene, sources, options)?;
                Ok((map.to_single(), Some(map)))
            }
        }
    }

    /// What a map's values are, with their unit.
    pub fn quantity(&self, scene: &Scene) -> String {
        self.picture.quantity(scene)
    }

    /// The unit of lengths, if it is known.
    pub fn unit<'a>(&'a self, scene: &Scene) -> Option<&'a str> {
        self.picture.unit(scene)
    }
}

impl Problem {
    /// What the JSON says of the map.
    pub fn report(&self) -> MapReport<'_> {
        MapReport::new(&self.scene.surface, &self.map, self.double.as_ref())
    }

    /// The map's value at a place, if that is a grid point and the map is in double precision.
    pub fn double_at(&self, [row, col]: [f64; 2]) -> Option<f64> {
        let map = self.double.as_ref()?;
        let is_point = row.fract() == 0.0 && col.fract() == 0.0;
        is_point.then(|| map.distance(row as usize, col as usize))
    }
}
