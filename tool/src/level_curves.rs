//! Curves at some distances, as files, pictures and reports.

use std::process::ExitCode;

use geosweep::geometry::{Contour, CurveError};
use geosweep::io::{Attribute, Polyline, StagedFile};
use serde::Serialize;

use crate::picture::{
    Canvas, CurvePicture, Key, Look, Paint, contour_lines, mark_all, rgb, scale_of,
};
use crate::problem::{CurveFiles, MapSummary, Problem};
use crate::spinner::Spinner;
use crate::{Outcome, print};

/// Contours or offset curves of a map.
pub struct LevelCurves {
    pub kind: &'static str,
    /// On which side of the sources they are, if only there.
    pub side: Option<&'static str>,
    pub problem: Problem,
    pub found: Vec<Contour>,
}

impl LevelCurves {
    /// Writes and reports all that is wanted.
    pub fn write(mut self, files: CurveFiles, quantity: &str, json: bool) -> Outcome {
        let lengths = self.lengths()?;
        let picture = self.problem.picture.take();
        let Problem { scene, map, .. } = &self.problem;
        let mut staged = files.stage(scene, self.polylines(&lengths)?)?;
        if let Some((output, look)) = picture {
            let _spinner = Spinner::new("drawing");
            staged.push(output.stage(|writer| self.picture(look, quantity).write_png(writer))?);
        }
        staged.into_iter().try_for_each(StagedFile::commit)?;
        if json {
            let level = |(contour, lengths): (_, &Vec<f64>)| Level::new(contour, lengths);
            let summary = Summary {
                map: MapSummary::new(&scene.surface, map),
                levels: self.found.iter().zip(&lengths).map(level).collect(),
            };
            print(serde_json::to_string(&summary)?)?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// The lengths of all curves, level by level.
    fn lengths(&self) -> Result<Vec<Vec<f64>>, CurveError> {
        let surface = &self.problem.scene.surface;
        let of =
            |contour: &Contour| contour.curves.iter().map(|curve| curve.length(surface)).collect();
        self.found.iter().map(of).collect()
    }

    fn polylines(&self, lengths: &[Vec<f64>]) -> Result<Vec<Polyline>, CurveError> {
        let Problem { scene, sources, map, .. } = &self.problem;
        let scale = scale_of(map, sources);
        let mut polylines = Vec::new();
        for (contour, lengths) in self.found.iter().zip(lengths) {
            // The scale's light end is hard to see on white.
            let color = rgb(scale.color(contour.level as f32).map(|channel| 0.85 * channel));
            for (curve, &length) in contour.curves.iter().zip(lengths) {
                let mut polyline = Polyline::new(self.kind, curve.clone(), scene.shape())?
                    .with("level", Attribute::Number(contour.level))
                    .with("length", Attribute::Number(length));
                if let Some(side) = self.side {
                    polyline = polyline.with("side", Attribute::Name(side));
                }
                polylines.push(Polyline { color, ..polyline });
            }
        }
        Ok(polylines)
    }

    fn picture(&self, look: Look, quantity: &str) -> Canvas {
        let Self { problem: Problem { scene, sources, map, .. }, found, .. } = self;
        let scale = scale_of(map, sources);
        let (source_lines, marks) = mark_all(sources);
        let mut lines = contour_lines(found, &scale, true);
        lines.extend(source_lines);
        let levels: Vec<f64> = found.iter().map(|contour| contour.level).collect();
        CurvePicture {
            surface: &scene.surface,
            shape: scene.shape(),
            values: &map.distances,
            paint: Paint::Values(&scale, None),
            lines: &lines,
            marks: &marks,
            key: Key::Scale { quantity, scale: &scale, levels: &levels },
        }
        .draw(look)
    }
}

#[derive(Serialize)]
struct Summary<'a> {
    #[serde(flatten)]
    map: MapSummary<'a>,
    levels: Vec<Level>,
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
            // The sum of nothing is -0.
            length: 0.0 + lengths.iter().sum::<f64>(),
        }
    }
}
