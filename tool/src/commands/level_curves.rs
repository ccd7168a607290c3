//! Writes and reports curves at given distances.

use std::ops::Range;
use std::process::ExitCode;

use geosweep::geometry::{Contour, CurveError, Side, contours, join_over_seams};
use geosweep::io::{Attribute, Polyline};
use geosweep::shown::{exact, seven_digits};
use geosweep::surface::{Source, SourceError};
use geosweep::{DistanceMap, Sources, Surface};
use serde::Serialize;

use crate::output::{commit, stage_picture};
use crate::picture::{Canvas, Look, MapPicture, rgb, scale_of};
use crate::problem::{CurveFiles, Problem, done_with_map};
use crate::terminal::{List, Outcome};

/// Returns the contours of a map, joined over the seams of its surface.
pub fn contours_of(problem: &Problem, levels: &[f64]) -> Vec<Contour> {
    let surface = &problem.scene.surface;
    let over_seams =
        |Contour { level, curves }| Contour { level, curves: join_over_seams(curves, surface) };
    contours(&problem.map, &problem.sources, levels).into_iter().map(over_seams).collect()
}

/// The contours or offset curves of a map.
pub struct LevelCurves {
    pub command: &'static str,
    pub kind: &'static str,
    /// The side of the sources on which the curves lie, if it is a single one.
    pub side: Option<Side>,
    pub problem: Problem,
    pub found: Vec<Contour>,
}

impl LevelCurves {
    /// Writes all requested files and reports.
    pub fn write(mut self, files: CurveFiles, quantity: &str, json: bool) -> Outcome {
        let lengths = self.lengths()?;
        let picture = self.problem.picture.take();
        let Problem { scene, map, .. } = &self.problem;
        let mut staged = files.stage(scene, self.attributes(), self.polylines(&lengths)?)?;
        if let Some((output, look)) = picture {
            staged.push(stage_picture(output, || self.picture(look, quantity))?);
        }
        let written = commit(staged)?;
        done_with_map(scene, &map.report, &written);
        if json {
            let level = |(contour, lengths): (_, &Vec<f64>)| Level::new(contour, lengths);
            let levels: Vec<_> = self.found.iter().zip(&lengths).map(level).collect();
            self.problem.report().print(self.command, &List("levels", &levels))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Returns the lengths of all curves, grouped by level.
    fn lengths(&self) -> Result<Vec<Vec<f64>>, CurveError> {
        let surface = &self.problem.scene.surface;
        let of =
            |contour: &Contour| contour.curves.iter().map(|curve| curve.length(surface)).collect();
        self.found.iter().map(of).collect()
    }

    /// Returns the names of the attributes of polylines.
    fn attributes(&self) -> &'static [&'static str] {
        let all = &["level", "length", "side"];
        if self.side.is_some() { all } else { &all[..2] }
    }

    fn polylines(&self, lengths: &[Vec<f64>]) -> Result<Vec<Polyline>, CurveError> {
        let Problem { scene, sources, map, .. } = &self.problem;
        let scale = scale_of(map, sources);
        let mut polylines = Vec::new();
        for (contour, lengths) in self.found.iter().zip(lengths) {
            // The light end of the scale is hard to see on white.
            let color = rgb(scale.color(contour.level as f32).map(|channel| 0.85 * channel));
            for (curve, &length) in contour.curves.iter().zip(lengths) {
                let mut polyline = Polyline::new(self.kind, curve.clone(), scene.shape())?
                    .with("level", Attribute::Number(contour.level))
                    .with("length", Attribute::Number(length));
                if let Some(side) = self.side {
                    polyline = polyline.with("side", Attribute::Name(side.name()));
                }
                polylines.push(Polyline { color, ..polyline });
            }
        }
        Ok(polylines)
    }

    fn picture(&self, look: Look, quantity: &str) -> Canvas {
        let Problem { scene, sources, map, .. } = &self.problem;
        MapPicture {
            surface: &scene.surface,
            shape: scene.shape(),
            map,
            sources,
            contours: &self.found,
            plain: true,
            curves: Default::default(),
            quantity: Some(quantity),
        }
        .draw(look)
    }
}

#[derive(Serialize)]
struct Level {
    level: f64,
    curves: usize,
    closed: usize,
    vertices: usize,
    length: f64,
}

impl Level {
    fn new(contour: &Contour, lengths: &[f64]) -> Self {
        let curves = &contour.curves;
        Self {
            level: contour.level,
            curves: curves.len(),
            closed: curves.iter().filter(|curve| curve.closed).count(),
            vertices: curves.iter().map(|curve| curve.vertices.len()).sum(),
            // An empty sum is -0; adding 0.0 makes it 0.
            length: 0.0 + lengths.iter().sum::<f64>(),
        }
    }
}

/// Prints notes about the levels that have no curve, or whose curves may lack parts.
pub fn comment(found: &[Contour], problem: &Problem) -> Result<(), SourceError> {
    let Problem { scene, sources, map, .. } = problem;
    let levels = |which: &dyn Fn(&Contour) -> bool| {
        let levels = found.iter().filter(|contour| which(contour));
        levels.map(|contour| exact(contour.level)).collect::<Vec<_>>().join(", ")
    };
    let [low, high] = extent(map);
    let is_within = |contour: &Contour| {
        (f64::from(low)..=f64::from(high)).contains(&(contour.level as f32).into())
    };
    let outside = levels(&|contour| contour.curves.is_empty() && !is_within(contour));
    if !outside.is_empty() {
        note!("no curve at {outside}: {}", range(map));
    }
    let within = levels(&|contour| contour.curves.is_empty() && is_within(contour));
    if !within.is_empty() {
        let why = why_none(found.iter().filter(|contour| is_within(contour)), problem);
        note!("no curve at {within}: {why}");
    }
    let near = sources
        .iter()
        .map(|source| beside(source, &scene.surface))
        .collect::<Result<Vec<_>, _>>()?;
    let cut = levels(&|contour| {
        !contour.curves.is_empty() && near.iter().any(|near| near.contains(&contour.level))
    });
    if !cut.is_empty() {
        note!(
            "the curves at {cut} run between a source and the points of the grid beside it, \
                 closer than the grid's spacing there, and parts of them are missing; a finer grid \
                 has them whole"
        );
    }
    Ok(())
}

/// Returns the reason why levels within the map's range have no curve.
fn why_none<'a>(levels: impl Iterator<Item = &'a Contour>, problem: &Problem) -> String {
    let chart = problem.scene.surface.chart();
    let line = match (chart.rows, chart.cols) {
        (1, _) => "row",
        (_, 1) => "column",
        _ => {
            let [_, high] = extent(&problem.map);
            let mut empty = levels.filter(|contour| contour.curves.is_empty());
            return match empty.all(|contour| contour.level as f32 == high) {
                true => format!(
                    "{} is the largest distance, which no two neighbouring points of the grid have",
                    seven_digits(high.into())
                ),
                false => format!(
                    "{}, and no triangle of three neighbouring points has points on both sides of the \
                     level",
                    range(&problem.map)
                ),
            };
        }
    };
    format!(
        "a grid of one {line} has no triangles of neighbouring points, which curves run through; `geosweep \
         distance` has the distances along it"
    )
}

/// Describes the range of the distances.
pub fn range(map: &DistanceMap) -> String {
    let [low, high] = extent(map).map(|distance| seven_digits(distance.into()));
    format!("the distances on the grid run from {low} to {high}")
}

/// Returns the smallest and the largest distance on the grid.
fn extent(map: &DistanceMap) -> [f32; 2] {
    let reached = map.distances.iter().copied().filter(|distance| distance.is_finite());
    [reached.fold(f32::INFINITY, f32::min), map.report.max_distance as f32]
}

/// Returns the range of distances from a source to the grid points next to it.
fn beside(source: &Source, surface: &Surface) -> Result<Range<f64>, SourceError> {
    let seeds = Sources::from_iter([source.clone()]).seeds(surface)?;
    Ok(source.initial()..seeds.iter().map(|seed| seed.time).fold(source.initial(), f64::max))
}
