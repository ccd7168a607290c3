//! Files that say of each point in which region it lies.

use std::error::Error;
use std::io::{self, Write};
use std::path::PathBuf;

use geosweep::geometry::{NO_REGION, Voronoi};
use geosweep::io::{OutputFile, write_npy};
use geosweep::surface::Chart;

use crate::output::wanted_file;

/// A file for labels, if one is wanted.
pub fn labels_output(path: Option<&PathBuf>) -> Result<Option<OutputFile>, Box<dyn Error>> {
    wanted_file(path, "regions are", "npy")
}

/// Writes labels as int32 (M, N), -1 where there is none.
pub fn write_labels(writer: &mut impl Write, chart: Chart, voronoi: &Voronoi) -> io::Result<()> {
    let label = |&label: &u32| if label == NO_REGION { -1 } else { label as i32 };
    let labels: Vec<i32> = voronoi.labels.iter().map(label).collect();
    write_npy(writer, &[chart.rows, chart.cols], &labels)
}
