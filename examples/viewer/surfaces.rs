//! Surfaces of the viewer: the terrain, a sheet that deforms, and closed ones.

use std::path::Path;
use std::str::FromStr;

use geosweep::glam::{Vec2, Vec4};
use geosweep::io::SurfaceFile;
use geosweep::surface::builtin::Closed;
use geosweep::surface::{Chart, Geometry, Gluing};

use crate::Result;
use crate::camera::Camera;
use crate::closed::ClosedSurface;
use crate::mesh;

/// Surfaces by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Name {
    /// Elevation around the Jacksboro fault, with enlarged heights
    Terrain,
    /// A sheet in motion: a compute shader writes its points every frame
    Sheet,
    /// A closed surface, which does not move
    Closed(ClosedSurface),
}

/// Content of a stage.
pub struct Model {
    pub look: Look,
    /// Positions of the points, row-major; NaN at holes. Empty if a pass writes them every frame.
    pub positions: Vec<Vec4>,
    /// Normals, and how much of the sky each point sees. Empty if a pass computes them.
    pub normals: Vec<Vec4>,
    /// Indices of three points each.
    pub triangles: Vec<u32>,
    /// Gluing of the grid's sides, if the surface is closed.
    pub gluing: Option<Gluing>,
}

/// Look of a surface. Units are the surface's own.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    pub name: &'static str,
    pub chart: Chart,
    /// Ground below; `None` if the surface floats.
    pub ground: Option<Ground>,
    /// Distance between lines.
    pub spacing: f32,
    /// Whether the points are written every frame.
    pub deforms: bool,
    /// First row and column of the source.
    pub source: [f32; 2],
    pub camera: Camera,
}

/// Ground below a surface.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ground {
    /// Half the extents of the surface along x and z.
    pub half: Vec2,
    pub height: f32,
    /// Whether walls reach from the surface down to the ground.
    pub walls: bool,
    /// Softness of the shadow.
    pub softness: f32,
}

/// Kilometres between the points of the terrain, from east to west and from north to south; see
/// examples/data/README.md.
const SPACING: Vec2 = Vec2::new(0.074573, 0.092475);
/// Lowest pitch of the camera above the ground.
const LOWEST: f32 = 0.08;
/// Factor by which heights are enlarged, for drawing and for measuring. Enlarged heights show why lines bend.
const ENLARGED: f32 = 2.5;

impl Look {
    /// Checks that a row and a column are on the grid.
    pub fn check_source(&self, [row, col]: [f32; 2]) -> Result<()> {
        let Chart { rows, cols } = self.chart;
        let (last_row, last_col) = (rows - 1, cols - 1);
        let inside =
            (0.0..=last_row as f32).contains(&row) && (0.0..=last_col as f32).contains(&col);
        if inside {
            return Ok(());
        }
        Err(format!(
            "the source {row},{col} is not on the grid; its rows are 0 to {last_row}, its columns \
             0 to {last_col}"
        )
        .into())
    }
}

impl Model {
    /// Returns the content of a stage with an open surface, whose normals a pass computes.
    fn open(look: Look, positions: Vec<Vec4>) -> Self {
        let triangles = mesh::triangles(look.chart, |_| true);
        Self { look, positions, normals: Vec::new(), triangles, gluing: None }
    }
}

impl Name {
    /// Returns all surfaces in the order in which they are shown, beginning with this one.
    pub fn all_from_here(self) -> Vec<Self> {
        let closed = ClosedSurface::all().map(Self::Closed);
        let mut all: Vec<_> = [Self::Terrain, Self::Sheet].into_iter().chain(closed).collect();
        let is_this = |other: &Self| match (self, other) {
            (Self::Closed(this), Self::Closed(other)) => this.closed == other.closed,
            _ => self == *other,
        };
        let place = all.iter().position(is_this).unwrap_or(0);
        all.rotate_left(place);
        // The size of this surface may differ from the usual one.
        all[0] = self;
        all
    }

    /// Returns the help text of the option that takes a name.
    pub fn help() -> String {
        let closed = Closed::names();
        format!(
            "First surface: terrain (elevation around the Jacksboro fault, with enlarged heights), \
             sheet (in motion: a compute shader writes its points every frame), or a closed one, \
             builtin:NAME:ROWSxCOLS, such as builtin:globe:181x361. Names are {closed}"
        )
    }

    pub fn load(self) -> Result<Model> {
        match self {
            Self::Terrain => terrain(),
            Self::Sheet => Ok(sheet()),
            Self::Closed(closed) => closed.load(),
        }
    }

    pub fn is_closed(self) -> bool {
        matches!(self, Self::Closed(_))
    }
}

impl FromStr for Name {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match (text, text.strip_prefix("builtin:")) {
            ("terrain", _) => Ok(Self::Terrain),
            ("sheet", _) => Ok(Self::Sheet),
            (_, Some(closed)) => closed.parse().map(Self::Closed),
            _ => Err("give terrain, sheet or builtin:NAME:ROWSxCOLS".into()),
        }
    }
}

fn terrain() -> Result<Model> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/data/jacksboro.png");
    let surface = SurfaceFile::read(Path::new(path))?.into_surface(None)?;
    let Geometry::Heights { heights, .. } = surface.geometry() else {
        return Err(format!("{path} holds no heights").into());
    };
    let chart = surface.chart();
    let range = heights
        .iter()
        .fold((f64::MAX, f64::MIN), |(low, high), &height| (low.min(height), high.max(height)));
    let middle = 0.5 * (range.0 + range.1);
    let rise = |height: f64| ENLARGED * (height - middle) as f32 / 1000.0;
    let half = 0.5 * SPACING * Vec2::new(chart.cols as f32 - 1.0, chart.rows as f32 - 1.0);
    let point = |(index, &height): (usize, &f64)| {
        let cell = Vec2::new((index % chart.cols) as f32, (index / chart.cols) as f32);
        let at = cell * SPACING - half;
        Vec4::new(at.x, rise(height), at.y, 1.0)
    };
    let look = Look {
        name: "terrain",
        chart,
        ground: Some(Ground { half, height: rise(range.0) - 0.8, walls: true, softness: 3.0 }),
        spacing: 1.0,
        deforms: false,
        source: [297.0, 219.0],
        camera: Camera { turn: 0.36, pitch: 0.62, distance: 61.0, height: -2.6, lowest: LOWEST },
    };
    Ok(Model::open(look, heights.iter().enumerate().map(point).collect()))
}

fn sheet() -> Model {
    let look = Look {
        name: "sheet",
        chart: Chart { rows: 192, cols: 192 },
        ground: Some(Ground {
            half: Vec2::new(10.0, 10.0),
            height: -5.0,
            walls: false,
            softness: 4.0,
        }),
        spacing: 0.5,
        deforms: true,
        source: [120.0, 52.0],
        camera: Camera { turn: 0.6, pitch: 0.68, distance: 40.0, height: -1.5, lowest: LOWEST },
    };
    Model::open(look, Vec::new())
}
