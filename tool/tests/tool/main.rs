//! The tool as a user meets it: what it writes, from which arguments, and what it says.

mod bench;
mod canonical;
mod contours;
mod distance;
mod estimate;
mod figures;
mod formats;
mod offsets;
mod pairwise;
mod paths;
mod pictures;
mod profile;
mod refusals;
mod regions;
mod ridges;
mod samples;
mod workbench;

use std::fs;
use std::process::Output;

use workbench::{Workbench, stderr};

fn run(bench: &Workbench, line: &str) -> Output {
    bench.run(line.split_whitespace())
}

/// Runs a line that must succeed.
fn done(bench: &Workbench, line: &str) -> Output {
    let output = run(bench, line);
    assert!(output.status.success(), "{line}: {}", stderr(&output));
    output
}

/// The rows of a float64 array (K, 5), split where they are NaN.
fn curves(bytes: &[u8]) -> Vec<Vec<[f64; 5]>> {
    let length = u16::from_le_bytes([bytes[8], bytes[9]]) as usize;
    let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
    assert!(header.contains("'descr': '<f8'") && header.contains(", 5)"), "{header}");
    let values: Vec<f64> =
        bytes[10 + length..].as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let rows = values.as_chunks::<5>().0;
    rows.split(|row| row[0].is_nan()).map(<[_]>::to_vec).collect()
}

fn read(bench: &Workbench, name: &str) -> Vec<u8> {
    fs::read(bench.output(name)).unwrap()
}

fn text(bench: &Workbench, name: &str) -> String {
    String::from_utf8(read(bench, name)).unwrap()
}
