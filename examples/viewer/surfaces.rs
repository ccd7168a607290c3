//! Surfaces of the viewer: the terrain, and a sheet that deforms.

use std::path::Path;

use clap::ValueEnum;
use geosweep::glam::{Vec2, Vec4};
use geosweep::io::SurfaceFile;
use geosweep::surface::{Chart, Geometry};

use crate::Result;
use crate::camera::Camera;

/// Surfaces by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Name {
    /// Elevation around the Jacksboro fault, with enlarged heights
    Terrain,
    /// A sheet in motion: a compute shader writes its points every frame
    Sheet,
}

/// Look of a surface. Units are the surface's own.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    pub name: &'static str,
    pub chart: Chart,
    /// Half the extents along x and z.
    pub half: Vec2,
    /// Height of the ground below.
    pub ground: f32,
    /// Whether walls reach down to the ground.
    pub walls: bool,
    /// Softness of the shadow on the ground.
    pub softness: f32,
    /// Distance between lines.
    pub spacing: f32,
    /// Whether the points are written every frame.
    pub deforms: bool,
    /// First row and column of the source.
    pub source: [f32; 2],
    pub camera: Camera,
}

/// Kilometres between the points of the terrain, from east to west and from north to south; see
/// examples/data/README.md.
const SPACING: Vec2 = Vec2::new(0.074573, 0.092475);
/// Factor by which heights are enlarged, for drawing and for measuring. It shows why lines bend.
const ENLARGED: f32 = 2.5;

impl Name {
    pub const ALL: [Self; 2] = [Self::Terrain, Self::Sheet];

    /// Returns the points, if they do not move, and the surface's look.
    pub fn load(self) -> Result<(Vec<Vec4>, Look)> {
        match self {
            Self::Terrain => terrain(),
            Self::Sheet => Ok((Vec::new(), sheet())),
        }
    }

    /// Checks that a row and a column are on the grid.
    pub fn check_source(self, [row, col]: [f32; 2]) -> Result<()> {
        let Chart { rows, cols } = self.load()?.1.chart;
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

fn terrain() -> Result<(Vec<Vec4>, Look)> {
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
        half,
        ground: rise(range.0) - 0.8,
        walls: true,
        softness: 3.0,
        spacing: 1.0,
        deforms: false,
        source: [297.0, 219.0],
        camera: Camera { turn: 0.36, pitch: 0.62, distance: 61.0, height: -2.6 },
    };
    Ok((heights.iter().enumerate().map(point).collect(), look))
}

fn sheet() -> Look {
    Look {
        name: "sheet",
        chart: Chart { rows: 192, cols: 192 },
        half: Vec2::new(10.0, 10.0),
        ground: -5.0,
        walls: false,
        softness: 4.0,
        spacing: 0.5,
        deforms: true,
        source: [120.0, 52.0],
        camera: Camera { turn: 0.6, pitch: 0.68, distance: 40.0, height: -1.5 },
    }
}
