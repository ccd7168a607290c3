//! Defines the options that limit a map to a part of the surface.

use std::error::Error;
use std::path::PathBuf;

use clap::ValueEnum;
use geosweep::io::PlaceFile;
use geosweep::shown::exact;
use geosweep::surface::Real;
use geosweep::{DistanceMap, Options, Targets};

use super::{Scene, remark};
use crate::numbers::numbers;

#[derive(clap::Args)]
pub struct LimitArgs {
    /// Largest distance of the map, in its unit. Points that are farther are not reached. The CPU does only
    /// the work of the area within the radius
    #[arg(long, value_name = "R", allow_hyphen_values = true, help_heading = "Part of the map")]
    radius: Option<f64>,
    /// Target, a grid point: row and column; repeatable. The map ends when the targets have their distances,
    /// and points that are farther are not reached
    #[arg(long, value_name = "R,C", value_parser = grid_point, allow_hyphen_values = true)]
    #[arg(help_heading = "Part of the map")]
    target: Vec<[usize; 2]>,
    /// File of targets, as for --source-points of `geosweep distance`; repeatable
    #[arg(long, value_name = "FILE", help_heading = "Part of the map")]
    targets: Vec<PathBuf>,
    /// Targets that the map must reach before it ends
    #[arg(long, value_enum, default_value_t, help_heading = "Part of the map")]
    target_mode: TargetMode,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum TargetMode {
    /// All of them
    #[default]
    All,
    /// The nearest one
    Any,
}

fn grid_point(text: &str) -> Result<[usize; 2], String> {
    let point: Option<[f64; 2]> = numbers(text)?.try_into().ok();
    let is_whole = |at: &f64| *at >= 0.0 && at.fract() == 0.0;
    let point = point.filter(|point| point.iter().all(is_whole));
    let point = point.ok_or("a target is a row and a column of the grid, whole numbers: R,C")?;
    Ok(point.map(|at| at as usize))
}

impl LimitArgs {
    /// Returns the options of the solver with these limits.
    pub fn options(&self, options: Options, scene: &Scene) -> Result<Options, Box<dyn Error>> {
        let frame = &scene.frame();
        let whole = |point: &[usize; 2]| point.map(|at| at as f64);
        let mut given: Vec<_> = self.target.iter().map(whole).collect();
        for path in &self.targets {
            let file = PlaceFile::read(path)?;
            given.extend(file.grid_points(frame)?.iter().map(|point| point.at));
            remark(path, &file, frame);
        }
        let options = options.with_radius(self.radius);
        if given.is_empty() {
            return Ok(options);
        }
        let on_surface = |&place: &[f64; 2]| on_surface(scene, place);
        let points = given.iter().map(on_surface).collect::<Result<Vec<_>, _>>()?;
        Ok(options.with_targets(match self.target_mode {
            TargetMode::All => Targets::all(points),
            TargetMode::Any => Targets::any(points),
        }))
    }

    /// Returns the files that targets are read from.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.targets.iter()
    }
}

/// Returns a target on the surface's grid.
fn on_surface(scene: &Scene, given: [f64; 2]) -> Result<[usize; 2], String> {
    let place = scene.place(given).map_err(|why| format!("the target {why}"))?;
    let [row, col] = place.map(|at| at.round() as usize);
    if scene.has_own_grid() && !scene.surface.has(row, col) {
        let [row, col] = given.map(exact);
        return Err(format!("the target {row},{col} is in a hole; choose a point of the surface"));
    }
    Ok([row, col])
}

/// Prints which targets were not reached.
pub fn comment_on_targets<R: Real>(scene: &Scene, map: &DistanceMap<R>, options: &Options) {
    let Some(targets) = &options.targets else { return };
    let is_missed = |&&[row, col]: &&[usize; 2]| !map.distance(row, col).is_finite();
    let missed: Vec<_> = targets.points().iter().filter(is_missed).collect();
    let reached = targets.points().len() - missed.len();
    let Some(first) = missed.first().filter(|_| reached < targets.needed()) else { return };
    let [row, col] = scene.given(first.map(|at| at as f64));
    let others = match missed.len() {
        1 => String::new(),
        more => format!(" and {} others", more - 1),
    };
    let why = match options.radius {
        Some(radius) if radius.is_finite() => "within the radius",
        _ => "by any path; the map is whole",
    };
    note!("the target {row},{col}{others} is not reached {why}");
}
