//! Chooses pictures of curves on a surface.

use std::error::Error;
use std::path::PathBuf;

use clap::ValueEnum;
use geosweep::glam::DVec3;
use geosweep::io::{Orientation, OutputFile};
use geosweep::surface::Geometry;

use super::Scene;
use crate::numbers::numbers;
use crate::output::wanted_png;
use crate::picture::Look;

/// The longer side of a shaded picture, in pixels.
const LONG_SIDE: usize = 1200;

#[derive(clap::Args)]
pub struct PictureArgs {
    /// Draw the result on the surface
    #[arg(long, value_name = "FILE.png", help_heading = "Picture")]
    pub picture: Option<PathBuf>,
    /// View of the surface
    #[arg(long, value_enum, default_value_t, help_heading = "Picture")]
    view: ViewArg,
    /// Direction from which the surface is seen, in its coordinates with z up; implies --view shaded. For
    /// heights, x increases with the column and y with the row; on a map, x points to the east and y to the
    /// south, however rows run (default: terrain from the south, other surfaces from the side to which they
    /// bulge)
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true)]
    #[arg(help_heading = "Picture")]
    toward: Option<DVec3>,
    /// Unit of lengths, for the legend (default: the unit of a projected GeoTIFF, otherwise none)
    #[arg(long, value_name = "NAME", help_heading = "Picture")]
    unit: Option<String>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum ViewArg {
    /// A map for heights, and a shaded view for positions; `geosweep distance` shades only closed surfaces
    #[default]
    Auto,
    /// The parameter domain as a map, with relief
    Map,
    /// A shaded view in space
    Shaded,
}

fn direction(text: &str) -> Result<DVec3, String> {
    let direction = numbers(text)?.try_into().map(DVec3::from_array).ok();
    let direction = direction.filter(|direction| direction.length() > 0.0);
    direction.ok_or_else(|| "a direction is three numbers, not all 0: X,Y,Z".into())
}

impl PictureArgs {
    /// Returns the picture to write, if one is requested.
    pub fn output(&self) -> Result<Option<OutputFile>, Box<dyn Error>> {
        wanted_png(self.picture.as_ref())
    }

    /// Returns the view of a surface. Positions are shaded by default.
    pub fn look(&self, scene: &Scene) -> Result<Look, String> {
        self.look_with(scene, true)
    }

    /// Returns the view of a surface. Closed surfaces with positions are shaded by default.
    pub fn look_at_map(&self, scene: &Scene) -> Result<Look, String> {
        self.look_with(scene, scene.surface.is_glued())
    }

    fn look_with(&self, scene: &Scene, shades_positions: bool) -> Result<Look, String> {
        let bare = matches!(scene.shape().geometry(), Geometry::Metric(_));
        let shaded = match self.view {
            _ if self.toward.is_some() => true,
            ViewArg::Auto => {
                shades_positions && matches!(scene.shape().geometry(), Geometry::Positions(_))
            }
            ViewArg::Map => false,
            ViewArg::Shaded => true,
        };
        match (shaded, bare) {
            (true, true) => Err("the surface is known only by its metric and has no shape in \
                                 space; choose --view map"
                .into()),
            (true, false) => {
                let orientation = self.orientation(scene)?;
                Ok(Look::Space { toward: self.toward, orientation, long_side: LONG_SIDE })
            }
            (false, _) => Ok(Look::Map),
        }
    }

    /// Returns the orientation of terrain on its map, if it has one.
    fn orientation(&self, scene: &Scene) -> Result<Option<Orientation>, String> {
        if !matches!(scene.shape().geometry(), Geometry::Heights { .. }) {
            return Ok(None);
        }
        match (scene.orientation(), self.toward) {
            (Err(why), Some(_)) => Err(format!("--toward: {why}")),
            (found, _) => Ok(found.unwrap_or_default()),
        }
    }

    /// Returns the quantity and unit of the map's values.
    pub fn quantity(&self, scene: &Scene) -> String {
        scene.quantity(self.unit(scene))
    }

    pub fn unit<'a>(&'a self, scene: &Scene) -> Option<&'a str> {
        self.unit.as_deref().or(scene.unit)
    }
}
