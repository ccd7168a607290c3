//! Writes the passes of a map as a table, one line per pass.

use std::io::{self, Write};

use geosweep::vulkan::profile::{PassRecord, SolveProfile};
use serde::Serialize;

/// A line of the table. Empty cells are unknown values.
#[derive(Serialize)]
struct Line {
    submission: usize,
    pass: &'static str,
    iteration: Option<u32>,
    first_row: Option<u32>,
    rows: Option<u32>,
    first_col: Option<u32>,
    cols: Option<u32>,
    dispatches: u32,
    groups: Option<u32>,
    texels: Option<u64>,
    skipped: Option<u64>,
    bytes_read: Option<u64>,
    bytes_written: Option<u64>,
    triangles: Option<u64>,
    begin_ns: Option<u64>,
    nanoseconds: Option<u64>,
}

impl Line {
    fn new(submission: usize, pass: &PassRecord) -> Self {
        let length = |[first, end]: [u32; 2]| end - first;
        Self {
            submission,
            pass: pass.kind.name(),
            iteration: pass.iteration,
            first_row: pass.area.map(|area| area.rows[0]),
            rows: pass.area.map(|area| length(area.rows)),
            first_col: pass.area.map(|area| area.cols[0]),
            cols: pass.area.map(|area| length(area.cols)),
            dispatches: pass.dispatches,
            groups: pass.groups.map(|groups| groups.iter().product()),
            texels: pass.work.texels,
            skipped: pass.work.skipped,
            bytes_read: pass.work.bytes_read,
            bytes_written: pass.work.bytes_written,
            triangles: pass.work.triangles,
            begin_ns: pass.begin,
            nanoseconds: pass.nanoseconds,
        }
    }
}

pub fn write(writer: &mut impl Write, run: &SolveProfile) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(writer);
    for (submission, record) in run.submissions.iter().enumerate() {
        for pass in &record.passes {
            writer.serialize(Line::new(submission, pass))?;
        }
    }
    writer.flush()
}
