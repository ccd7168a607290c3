//! What the commands on curves share: their arguments on surface, sources, solver and picture, and
//! what is done with those before their own work.

use std::error::Error;
use std::path::Path;

use geosweep::io::OutputFile;
use geosweep::{DistanceMap, Sources};

use super::{CurveFiles, PictureArgs, Scene, SolverArgs, SourceArgs, SurfaceArgs, inputs, solve};
use crate::output::check_outputs;
use crate::picture::Look;

#[derive(clap::Args)]
pub struct ProblemArgs {
    #[command(flatten)]
    sources: SourceArgs,
    #[command(flatten)]
    surface: SurfaceArgs,
    #[command(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    picture: PictureArgs,
}

/// A map, and where a picture of what is made of it goes.
pub struct Problem {
    pub scene: Scene,
    pub sources: Sources,
    pub map: DistanceMap,
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
        let sources = self.sources.sources()?;
        let map = solve(&scene, &sources, &options)?;
        Ok(Problem { scene, sources, map, picture: picture.zip(look) })
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
