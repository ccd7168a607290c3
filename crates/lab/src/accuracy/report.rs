//! Formats the measurements as Markdown.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use geosweep::Wavefront;
use geosweep::surface::builtin::Builtin;

use super::measure::Measurement;
use super::peers::Peer;
use super::{Args, plots};
use geosweep_cli::precision::Precision;

/// The contents of the report.
pub struct Report<'a> {
    pub args: &'a Args,
    /// The folder of the plots, relative to the report.
    pub plots: Option<PathBuf>,
    /// The measurements, sorted by surface, then wavefront, then size.
    pub measured: &'a [Measurement],
    /// The results of other solvers, sorted by solver, then surface, then size.
    pub peers: &'a [Peer],
}

/// Returns the error below which only rounding remains. Rounding has no order of convergence.
fn rounding(precision: Precision) -> f64 {
    match precision {
        Precision::Single => 1e-6,
        Precision::Double => 1e-13,
    }
}

impl Display for Report<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "# Accuracy\n")?;
        self.introduction(f)?;
        self.pictures(f)?;
        self.summary(f)?;
        self.peers(f)?;
        let by_surface = self.measured.chunk_by(|a, b| a.builtin == b.builtin);
        let rounding = rounding(self.args.precision);
        by_surface.into_iter().try_for_each(|of_surface| table(f, of_surface, rounding))
    }
}

impl Report<'_> {
    fn introduction(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let device = self.measured.iter().find_map(|m| m.device.as_deref());
        let engine = device.map_or("the CPU".into(), |device| format!("Vulkan ({device})"));
        let schedule = self.measured.first().map_or("", |m| m.schedule).replace('-', " ");
        let machine = match &self.args.machine {
            Some(machine) => format!(" (a {machine})"),
            None => String::new(),
        };
        let (precision, rounding) = (self.args.precision, rounding(self.args.precision));
        writeln!(
            f,
            "\
Converged distance maps of the built-in surfaces, computed in {precision} precision on
{engine} by {schedule}s, against exact distances: closed forms, in the maze the
shortest polygonal path, and on torus and peaks geodesics shot from the source in double
precision (relative error below 1e-9).

Errors are relative to the exact distance, over all points but the source, which lies near
row 0.31, column 0.41 of the grid (in the maze, at the corner where its corridor begins).

The order is the power of the spacing with which the mean error falls, from the size before;
it is left out where the error is below {rounding:e}, which is rounding.

Times are those of the solve alone, the shortest of up to five, and indicative only: the
machine{machine} does other work too.

To reproduce: `{}`. In a
clone of the repository, `ci/figures` writes this report and draws all figures anew.\n",
            self.command()
        )
    }

    fn command(&self) -> String {
        let list = |names: Vec<String>| names.join(",");
        let sizes = list(self.args.sizes.iter().map(usize::to_string).collect());
        let engine = &self.args.engine;
        let mut command = format!("geosweep-lab accuracy --sizes {sizes} --engine {engine}");
        if !self.args.surfaces.is_empty() {
            let surfaces = list(self.args.surfaces.iter().map(Builtin::to_string).collect());
            command += &format!(" --surfaces {surfaces}");
        }
        if !self.args.wavefronts.is_empty() {
            let wavefronts = list(self.args.wavefronts.iter().map(Wavefront::to_string).collect());
            command += &format!(" --wavefronts {wavefronts}");
        }
        if self.args.precision != Precision::default() {
            command += &format!(" --precision {}", self.args.precision);
        }
        let Args { output, plots, peers, .. } = self.args;
        for (flag, path) in [("-o", output), ("--plots", plots), ("--peers", peers)] {
            if let Some(path) = path {
                command += &format!(" {flag} {}", path.display());
            }
        }
        command
    }

    fn pictures(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Some(folder) = &self.plots else { return Ok(()) };
        let texts = ["Error against size", "Error against solve time"];
        for (text, file) in texts.into_iter().zip(plots::FILES) {
            writeln!(f, "![{text}]({})\n", folder.join(file).display())?;
        }
        Ok(())
    }

    /// Writes an overview of the largest size.
    fn summary(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Some(largest) = self.measured.iter().map(|m| m.points).max() else { return Ok(()) };
        writeln!(f, "## At {largest} x {largest} points\n")?;
        writeln!(f, "| surface | wavefront | mean | RMS | largest | iterations | time, ms |")?;
        writeln!(f, "|---|---|---:|---:|---:|---:|---:|")?;
        for m in self.measured.iter().filter(|m| m.points == largest) {
            let Measurement { builtin, wavefront, errors, iterations, .. } = m;
            writeln!(
                f,
                "| {builtin} | {wavefront} | {:.1e} | {:.1e} | {:.1e} | {iterations} | {} |",
                errors.mean_relative,
                errors.rms_relative,
                errors.max_relative,
                milliseconds(m.time.as_secs_f64())
            )?;
        }
        Ok(())
    }

    /// Writes the results of other solvers on the same surfaces.
    fn peers(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if self.peers.is_empty() {
            return Ok(());
        }
        writeln!(f, "\n## Other solvers\n")?;
        writeln!(f, "Measured apart, on the same points from the same source.\n")?;
        writeln!(f, "| surface | solver | points a side | mean | time, ms |")?;
        writeln!(f, "|---|---|---:|---:|---:|")?;
        for Peer { builtin, points, solver, seconds, mean } in self.peers {
            let time = milliseconds(*seconds);
            writeln!(f, "| {builtin} | {solver} | {points} | {mean:.2e} | {time} |")?;
        }
        Ok(())
    }
}

fn table(f: &mut Formatter<'_>, of_surface: &[Measurement], rounding: f64) -> fmt::Result {
    writeln!(f, "\n## {}\n", of_surface[0].builtin)?;
    writeln!(
        f,
        "| wavefront | points a side | mean | RMS | largest | order | iterations | time, ms |"
    )?;
    writeln!(f, "|---|---:|---:|---:|---:|---:|---:|---:|")?;
    for m in of_surface {
        let Measurement { wavefront, points, errors, iterations, .. } = m;
        let order = match m.order {
            Some(order) if errors.mean_relative >= rounding => format!("{order:.2}"),
            _ => String::new(),
        };
        writeln!(
            f,
            "| {wavefront} | {points} | {:.2e} | {:.2e} | {:.2e} | {order} | {iterations} | {} |",
            errors.mean_relative,
            errors.rms_relative,
            errors.max_relative,
            milliseconds(m.time.as_secs_f64())
        )?;
    }
    Ok(())
}

/// Formats a time in milliseconds with up to two decimals.
fn milliseconds(seconds: f64) -> String {
    let milliseconds = 1e3 * seconds;
    let decimals = if milliseconds < 1.0 { 2 } else { usize::from(milliseconds < 10.0) };
    format!("{milliseconds:.decimals$}")
}
