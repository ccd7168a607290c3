//! Writes files that hold the region of each point.

use std::error::Error;
use std::path::{Path, PathBuf};

use geosweep::geometry::{NO_REGION, Voronoi};
use geosweep::io::{IoError, OutputFile, StagedFile, write_labels_tiff, write_npy};
use geosweep::surface::Chart;

use crate::problem::Scene;

/// Returns the output file for labels, if one is requested.
pub fn labels_output(path: Option<&PathBuf>) -> Result<Option<OutputFile>, Box<dyn Error>> {
    let output = |path: &PathBuf| {
        if !has_extension(path, &["npy", "tif", "tiff"]) {
            let name = path.display();
            return Err(
                format!("{name}: regions are written as .npy or .tif; choose such a name").into()
            );
        }
        Ok(OutputFile::new(path)?)
    };
    path.map(output).transpose()
}

/// Writes labels of the given points as int32 (M, N), with -1 where a point has no region. The file does not have its
/// final name yet.
pub fn stage_labels(
    output: OutputFile,
    scene: &Scene,
    voronoi: &Voronoi,
) -> Result<StagedFile, IoError> {
    let (Chart { rows, cols }, geo_tags) = (scene.chart(), scene.geo_tags.as_ref());
    let label = |&label: &u32| if label == NO_REGION { -1 } else { label as i32 };
    let labels: Vec<i32> = scene.crop(&voronoi.labels).iter().map(label).collect();
    let is_array = has_extension(output.path(), &["npy"]);
    output.stage(|writer| match is_array {
        true => write_npy(writer, &[rows, cols], &labels),
        false => write_labels_tiff(writer, rows, cols, &labels, geo_tags),
    })
}

pub fn has_extension(path: &Path, wanted: &[&str]) -> bool {
    let found = path.extension().unwrap_or_default();
    wanted.iter().any(|wanted| found.eq_ignore_ascii_case(wanted))
}
