//! Formats the measurements as Markdown, which a terminal shows as it is, and as JSON.

use std::fmt::{self, Display, Formatter};

use serde_json::{Value, json};

use super::growth::Growth;
use super::measure::{Measurements, Timing};
use geosweep_cli::ceilings::{CpuCeilings, DeviceCeilings};
use geosweep_cli::columns::{Columns, digits, percent};

/// Returns all results as JSON.
pub fn summary(measured: &Measurements) -> Value {
    let device = measured
        .device
        .as_ref()
        .map(|(name, ceilings)| json!({"name": name, "ceilings": DeviceCeilings::from(*ceilings)}));
    json!({
        "cpu": measured.cpu.map(CpuCeilings::from),
        "cpu_patches": measured.patches.map(CpuCeilings::from),
        "device": device,
        "maps": measured.timings.iter().map(map).collect::<Vec<_>>(),
        "growth": Growth::of(&measured.timings),
    })
}

/// Returns a map as JSON.
fn map(timing: &Timing) -> Value {
    json!({
        "surface": timing.surface.to_string(),
        "rows": timing.rows,
        "cols": timing.cols,
        "points": timing.points,
        "wavefront": timing.wavefront.name(),
        "engine": timing.method.engine(),
        "schedule": timing.method.schedule(),
        "set_up_seconds": timing.set_up.as_secs_f64(),
        "median_seconds": timing.median(),
        "best_seconds": timing.best(),
        "runs": timing.times.len(),
        "iterations": timing.iterations,
        "converged": timing.converged,
        "points_per_second": timing.points as f64 / timing.median(),
        "bytes": timing.bytes,
        "work": timing.work,
        "shares": timing.shares,
    })
}

/// The contents of the report.
pub struct Report<'a> {
    pub measured: &'a Measurements,
    pub machine: Option<&'a str>,
}

impl Display for Report<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "# Time of converged maps\n")?;
        self.ceilings(f)?;
        let timings = &self.measured.timings;
        let growth = Growth::of(timings);
        for maps in timings.chunk_by(|a, b| a.surface == b.surface && a.wavefront == b.wavefront) {
            let (surface, wavefront) = (maps[0].surface.to_string(), maps[0].wavefront);
            writeln!(f, "\n## {surface}, {}\n", wavefront.name())?;
            table(f, maps)?;
            let of_maps: Vec<_> = growth
                .iter()
                .filter(|found| found.surface == surface && found.wavefront == wavefront.name())
                .map(|found| format!("{} {} {:.2}", found.engine, found.schedule, found.exponent))
                .collect();
            if !of_maps.is_empty() {
                writeln!(f, "\nTime grows with this power of the points: {}.", of_maps.join(", "))?;
            }
        }
        Ok(())
    }
}

impl Report<'_> {
    fn ceilings(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some(machine) = self.machine {
            writeln!(f, "Machine: {machine}.\n")?;
        }
        if let Some(ceilings) = self.measured.cpu {
            writeln!(
                f,
                "CPU ({}): {}.\n",
                geosweep::cpu::Instructions::best(),
                CpuCeilings::from(ceilings)
            )?;
        }
        if let Some(ceilings) = self.measured.patches {
            writeln!(f, "CPU, grids solved by patches: {}.\n", CpuCeilings::from(ceilings))?;
        }
        if let Some((name, ceilings)) = &self.measured.device {
            writeln!(f, "{name}: {}.", DeviceCeilings::from(*ceilings))?;
        }
        Ok(())
    }
}

/// Writes one line for each size and method, in aligned columns.
fn table(f: &mut Formatter<'_>, maps: &[Timing]) -> fmt::Result {
    let heads = [
        "points",
        "engine",
        "schedule",
        "iter.",
        "set-up ms",
        "best ms",
        "median ms",
        "M points/s",
        "B/point",
        "data",
        "arithmetic",
        "dispatches",
    ];
    let lines = maps.iter().map(line).collect();
    // The columns of engine and schedule hold text.
    write!(f, "{}", Columns { heads, texts: &[1, 2], lines })
}

fn line(map: &Timing) -> [String; 12] {
    let points = map.points as f64;
    [
        format!("{} x {}", map.rows, map.cols),
        map.method.engine().into(),
        map.method.schedule().into(),
        format!("{}{}", map.iterations, if map.converged { "" } else { "+" }),
        digits(1e3 * map.set_up.as_secs_f64()),
        digits(1e3 * map.best()),
        digits(1e3 * map.median()),
        digits(1e-6 * points / map.median()),
        map.bytes.map_or(String::new(), |bytes| digits(bytes as f64 / points)),
        percent(map.shares.data),
        percent(map.shares.arithmetic),
        percent(map.shares.dispatches),
    ]
}
