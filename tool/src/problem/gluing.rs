//! Glues sides of the surface, as the command line asks for it.

use std::error::Error;

use clap::ValueEnum;
use geosweep::Surface;
use geosweep::surface::{Gluing, Seam};

/// The sides of the grid that are the same line of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Glue {
    /// All sides that coincide, as the warning about closed surfaces lists them
    Auto,
    /// The last column is the first one: tubes and closed cones
    Columns,
    /// The last row is the first one
    Rows,
    /// Both: a torus
    Both,
    /// The last column is the first one in reverse order: a Moebius strip
    FlippedColumns,
    /// The last row is the first one in reverse order
    FlippedRows,
    /// Rows are latitudes with one row at each pole, and the last column is the first one
    Globe,
    /// An octahedral map: the halves of each side coincide
    Octahedral,
    /// Charts that holes keep apart, such as the six faces of a cube
    Charts,
}

impl Glue {
    /// Glues a surface. `seams` are its sides that coincide or are neighbours.
    pub fn apply(self, surface: Surface, seams: &[Seam]) -> Result<Surface, Box<dyn Error>> {
        let gluing = match self {
            Self::Auto => Gluing::Seams(coinciding(seams)?),
            Self::Columns => Gluing::columns(),
            Self::Rows => Gluing::rows(),
            Self::Both => Gluing::both(),
            Self::FlippedColumns => Gluing::flipped_columns(),
            Self::FlippedRows => Gluing::flipped_rows(),
            Self::Globe => Gluing::globe(),
            Self::Octahedral => Gluing::Octahedral,
            Self::Charts => Gluing::Charts,
        };
        let name = self.to_possible_value().map(|value| value.get_name().to_owned());
        let name = name.unwrap_or_default();
        Ok(surface.with_gluing(gluing).map_err(|error| format!("--glue {name}: {error}"))?)
    }
}

/// Returns the seams whose points coincide.
fn coinciding(seams: &[Seam]) -> Result<Vec<Seam>, Box<dyn Error>> {
    let is_apart = |seam: &&Seam| matches!(seam, Seam::Neighbours { .. });
    if let Some(seam) = seams.iter().find(is_apart) {
        return Err(format!(
            "--glue auto: {seam}. Both sides of a seam must hold its points: append the first line again \
             after the last one"
        )
        .into());
    }
    if seams.is_empty() {
        return Err(
            "--glue auto: no sides of the grid coincide; leave --glue out, or name the sides \
                    to see how far they are apart"
                .into(),
        );
    }
    Ok(seams.to_vec())
}
