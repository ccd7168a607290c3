//! Writes files of curves.

use std::error::Error;
use std::path::PathBuf;

use geosweep::io::{CurveFormat, Drawing, IoError, OutputFile, Polyline, StagedFile};
use geosweep::surface::Geometry;

use super::Scene;

/// The files to which the same curves are written, each in the format that its extension names.
pub struct CurveFiles(Vec<(OutputFile, CurveFormat)>);

/// The reason why GeoJSON cannot be written for some files.
const UNNAMED: &str = "the surface's file names no coordinate reference system by an EPSG code; gdal_translate \
                       -a_srs EPSG:CODE writes a GeoTIFF with one";

impl CurveFiles {
    /// Checks the names and folders of the files before the computation starts.
    pub fn new(paths: &[PathBuf]) -> Result<Self, IoError> {
        let file = |path: &PathBuf| {
            let format = CurveFormat::of(path)?;
            Ok((OutputFile::new(path)?, format))
        };
        paths.iter().map(file).collect::<Result<_, _>>().map(Self)
    }

    pub fn files(&self) -> impl Iterator<Item = &OutputFile> {
        self.0.iter().map(|(file, _)| file)
    }

    /// Rejects formats that the surface does not support, before anything is computed.
    pub fn check(&self, scene: &Scene) -> Result<(), String> {
        let bare = matches!(scene.shape().geometry(), Geometry::Metric(_));
        for (file, format) in &self.0 {
            let name = file.path().display();
            let georeference = scene.georeference.as_ref().map_err(String::as_str);
            let system = georeference.and_then(|found| found.system.ok_or(UNNAMED));
            if let (CurveFormat::GeoJson, Err(reason)) = (format, system) {
                return Err(format!("{name}: GeoJSON needs a georeferenced surface; {reason}"));
            }
            if format.needs_positions() && bare {
                return Err(format!(
                    "{name}: the surface is known only by its metric, so that curves have no \
                     places in space; write .npy, .csv or .svg"
                ));
            }
        }
        Ok(())
    }

    /// Writes the curves with their attributes to all files. The files do not have their final names yet.
    pub fn stage(
        self,
        scene: &Scene,
        attributes: &[&'static str],
        mut polylines: Vec<Polyline>,
    ) -> Result<Vec<StagedFile>, Box<dyn Error>> {
        for vertex in polylines.iter_mut().flat_map(|line| &mut line.curve.vertices) {
            *vertex = scene.given(*vertex);
        }
        let drawing = Drawing {
            chart: scene.chart(),
            georeference: scene.georeference.as_ref().ok().copied(),
            // On the Earth, positions are relative to its centre, so z is not a height.
            has_heights: !scene.is_on_earth(),
            attributes: attributes.to_vec(),
            polylines,
        };
        let stage = |(file, format): (OutputFile, CurveFormat)| {
            Ok(file.stage(|writer| format.write(writer, &drawing))?)
        };
        self.0.into_iter().map(stage).collect()
    }
}
