//! Writes files with a value at each given point.

use std::error::Error;
use std::path::{Path, PathBuf};

use geosweep::geometry::{NO_REGION, Voronoi};
use geosweep::io::{
    IoError, OutputFile, StagedFile, write_bearings_tiff, write_labels_tiff, write_npy,
    write_vectors_tiff,
};
use geosweep::surface::Chart;

use crate::problem::Scene;

/// Values at all points of the surface's grid.
pub enum Values<'a> {
    /// Numbers of regions, sources or neighbours: int32, -1 where there is none.
    Labels(&'a [i32]),
    /// Angles in degrees: float32, negative where there is none.
    Bearings(&'a [f32]),
    /// Rows and columns of vectors: float32, NaN where there is none.
    Vectors(&'a [[f32; 2]]),
}

/// Returns the output file for values, checked before the computation starts. `what` is a noun and a verb for messages,
/// such as "regions are".
pub fn grid_output(path: &Path, what: &str) -> Result<OutputFile, Box<dyn Error>> {
    if !has_extension(path, &["npy", "tif", "tiff"]) {
        let name = path.display();
        return Err(format!("{name}: {what} written as .npy or .tif; choose such a name").into());
    }
    Ok(OutputFile::new(path)?)
}

/// Returns the output file for regions, if one is requested.
pub fn labels_output(path: Option<&PathBuf>) -> Result<Option<OutputFile>, Box<dyn Error>> {
    path.map(|path| grid_output(path, "regions are")).transpose()
}

/// Writes the values at the given points. The file does not have its final name yet.
pub fn stage_values(
    output: OutputFile,
    scene: &Scene,
    values: Values,
) -> Result<StagedFile, IoError> {
    let (Chart { rows, cols }, tags) = (scene.chart(), scene.geo_tags.as_ref());
    let is_array = has_extension(output.path(), &["npy"]);
    output.stage(|writer| match (values, is_array) {
        (Values::Labels(labels), true) => write_npy(writer, &[rows, cols], &scene.crop(labels)),
        (Values::Labels(labels), false) => {
            write_labels_tiff(writer, rows, cols, &scene.crop(labels), tags)
        }
        (Values::Bearings(angles), true) => write_npy(writer, &[rows, cols], &scene.crop(angles)),
        (Values::Bearings(angles), false) => {
            write_bearings_tiff(writer, rows, cols, &scene.crop(angles), tags)
        }
        (Values::Vectors(vectors), true) => {
            write_npy(writer, &[rows, cols, 2], scene.crop(vectors).as_flattened())
        }
        (Values::Vectors(vectors), false) => {
            write_vectors_tiff(writer, rows, cols, &scene.crop(vectors), tags)
        }
    })
}

/// Returns the number of each region, as its name.
pub fn numbers(voronoi: &Voronoi) -> Vec<i32> {
    (0..voronoi.regions() as i32).collect()
}

/// Writes the name of each given point's region.
pub fn stage_labels(
    output: OutputFile,
    scene: &Scene,
    voronoi: &Voronoi,
    names: &[i32],
) -> Result<StagedFile, IoError> {
    let label = |&label: &u32| if label == NO_REGION { -1 } else { names[label as usize] };
    let labels: Vec<i32> = voronoi.labels.iter().map(label).collect();
    stage_values(output, scene, Values::Labels(&labels))
}

fn has_extension(path: &Path, wanted: &[&str]) -> bool {
    let found = path.extension().unwrap_or_default();
    wanted.iter().any(|wanted| found.eq_ignore_ascii_case(wanted))
}
