//! Writes the rows of the matrix within a radius as a sparse matrix.

use std::error::Error;
use std::process::ExitCode;

use geosweep::Options;
use geosweep::io::{OutputFile, write_sparse_npz};
use geosweep::pairwise::{SparseRows, pairs_within};

use super::{Args, Summary};
use crate::output::{Written, check_outputs, done, wanted_file};
use crate::problem::{Scene, convergence, seconds, warn_of_no_convergence};
use crate::terminal::{Outcome, Spinner, print_json};

/// Returns the output file, which is checked before the computation starts.
pub fn output(args: &Args) -> Result<Option<OutputFile>, Box<dyn Error>> {
    let others = [
        ("--upper", args.upper),
        ("--symmetrize", args.symmetrize),
        ("--from-symmetry", args.from_symmetry),
        ("--resume", args.resume),
        ("--labels", args.labels.is_some()),
        ("--numbers float16", args.numbers != geosweep::io::Element::Float32),
    ];
    if let Some((other, _)) = others.iter().find(|(_, is_given)| *is_given) {
        return Err(
            format!("{other} is for whole rows, not for --format csr; leave one out").into()
        );
    }
    if args.radius.is_none() {
        return Err("--format csr needs --radius, which says which pairs are stored".into());
    }
    let output = wanted_file(args.output.as_ref(), "a sparse matrix is", "npz")?;
    let files = args.sources.iter().filter_map(super::RowsOf::file);
    let inputs = args.surface.inputs().chain(files).map(AsRef::as_ref);
    check_outputs(&output.iter().collect::<Vec<_>>(), inputs)?;
    Ok(output)
}

/// Computes the rows of some points and writes them.
pub fn run(
    args: &Args,
    scene: &Scene,
    (sources, starts): (&[usize], &[f64]),
    options: &Options,
    output: Option<OutputFile>,
) -> Outcome {
    if starts.iter().any(|&start| start != 0.0) {
        return Err("start values are for whole rows, not for --format csr; leave them out".into());
    }
    let (mut rows, report) = {
        let _spinner = Spinner::new("computing distances");
        pairs_within(&scene.surface, sources, options)?
    };
    if let Some(kept) = scene.given_points() {
        crop(&mut rows, &kept);
    }
    let mut written = Written::default();
    if let Some(output) = output {
        let _spinner = Spinner::new("writing");
        let staged = output.stage(|mut writer| write_sparse_npz(&mut writer, &rows))?;
        written.add(staged.path());
        staged.commit()?;
    }
    if !report.converged() {
        warn_of_no_convergence(options, report.iterations, report.residual, report.tolerance);
    }
    let how = convergence(report.iterations, report.converged());
    let shape = format!("{} rows with {} distances", rows.rows(), rows.data.len());
    done(["CPU".into(), shape, format!("{how} in {}", seconds(report.solve_time))], &written);
    if args.json {
        let bytes = bytes(&rows);
        let stored = rows.data.len();
        let summary = Summary::new(scene, &report, 0, (bytes, bytes as u64), None);
        print_json("pairwise", &summary.with_stored(stored))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Keeps the columns of the points `kept`, whose indices are in ascending order.
fn crop(rows: &mut SparseRows, kept: &[usize]) {
    let cropped: Vec<Vec<(u32, f32)>> = (0..rows.rows())
        .map(|row| {
            let column =
                |(point, distance)| Some((kept.binary_search(&point).ok()? as u32, distance));
            rows.row(row).filter_map(column).collect()
        })
        .collect();
    let ends = cropped.iter().scan(0, |end, row| {
        *end += row.len();
        Some(*end)
    });
    rows.indptr = [0].into_iter().chain(ends).collect();
    (rows.indices, rows.data) = cropped.into_iter().flatten().unzip();
    rows.cols = kept.len();
}

/// Returns the number of bytes of the matrix in memory. It takes about as many on disk.
fn bytes(rows: &SparseRows) -> usize {
    std::mem::size_of_val(&rows.indices[..])
        + std::mem::size_of_val(&rows.data[..])
        + std::mem::size_of_val(&rows.indptr[..])
}
