//! Glues sides of the grid where the surface is closed.

use geosweep::surface::{Direction, Gluing, Run, Seam};
use pyo3::PyErr;
use pyo3::prelude::*;

use crate::errors;

/// The grid points along a line: row and column of the first and of the last point.
type Line = [(usize, usize); 2];

/// The gluing of a surface, as callers give it.
#[derive(FromPyObject)]
pub enum Glue {
    /// The name of a gluing.
    #[pyo3(transparent)]
    Name(String),
    /// Pairs of lines whose points coincide one by one.
    #[pyo3(transparent)]
    Lines(Vec<[Line; 2]>),
}

impl Glue {
    /// Returns the surface with its sides glued.
    pub fn apply(&self, surface: geosweep::Surface) -> PyResult<geosweep::Surface> {
        let gluing = match self {
            Self::Lines(pairs) => {
                let runs = |[a, b]: &[Line; 2]| Ok::<_, PyErr>([run(*a)?, run(*b)?]);
                Gluing::Runs(pairs.iter().map(runs).collect::<PyResult<_>>()?)
            }
            Self::Name(name) => match &**name {
                "auto" => Gluing::Seams(coinciding(&surface)?),
                "columns" => Gluing::columns(),
                "rows" => Gluing::rows(),
                "both" => Gluing::both(),
                "flipped-columns" => Gluing::flipped_columns(),
                "flipped-rows" => Gluing::flipped_rows(),
                "globe" => Gluing::globe(),
                "octahedral" => Gluing::Octahedral,
                "charts" => Gluing::Charts,
                _ => {
                    return Err(errors::value(format!(
                        "glue='{name}' is unknown; choose 'auto', 'columns', 'rows', 'both', \
                         'flipped-columns', 'flipped-rows', 'globe', 'octahedral' or 'charts', or give pairs \
                         of lines"
                    )));
                }
            },
        };
        surface.with_gluing(gluing).map_err(|error| errors::value(format!("glue: {error}")))
    }
}

/// Returns the seams whose points coincide.
fn coinciding(surface: &geosweep::Surface) -> PyResult<Vec<Seam>> {
    let seams = surface.seams();
    if let Some(seam) = seams.iter().find(|seam| matches!(seam, Seam::Neighbours { .. })) {
        return Err(errors::value(format!(
            "glue='auto': {seam}; append the first line again after the last one, so that both sides of the seam \
             hold its points"
        )));
    }
    if seams.is_empty() {
        return Err(errors::value(
            "glue='auto': no sides of the grid coincide; leave glue out, or name the sides",
        ));
    }
    Ok(seams)
}

/// Returns the run of points of a line along a row, a column or a diagonal.
fn run([from, end]: Line) -> PyResult<Run> {
    let (down, right) = (end.0 as isize - from.0 as isize, end.1 as isize - from.1 as isize);
    let to = Direction::ALL.into_iter().find(|to| to.step() == (down.signum(), right.signum()));
    match to.filter(|_| down == 0 || right == 0 || down.abs() == right.abs()) {
        Some(to) => Ok(Run { from, to, points: down.abs().max(right.abs()) as usize + 1 }),
        None => Err(errors::value(format!(
            "glue: {from:?} to {end:?} is no line along a row, a column or a diagonal of the grid"
        ))),
    }
}
