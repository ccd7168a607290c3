//! Formats the measurements as Markdown, which a terminal shows as it is, and as JSON.

use std::fmt::{self, Display, Formatter};
use std::time::Duration;

use serde_json::{Value, json};

use super::measure::{Measured, Timing};
use geosweep_cli::columns::{Columns, digits};

/// Returns all results as JSON.
pub fn summary(measured: &Measured) -> Value {
    let frames = measured.timings.iter().map(|timing| {
        json!({
            "rows": timing.chart.rows,
            "cols": timing.chart.cols,
            "schedule": timing.schedule.name(),
            "wavefront": timing.wavefront.name(),
            "frames": timing.frames,
            "converged": timing.converged,
            "iterations": timing.iterations,
            "device_seconds": timing.device.map(|time| time.as_secs_f64()),
            "host_seconds": timing.host.as_secs_f64(),
            "worst_seconds": timing.worst.as_secs_f64(),
            "record_seconds": timing.record.as_secs_f64(),
            "bytes": timing.bytes,
        })
    });
    json!({"device": measured.device, "frames": frames.collect::<Vec<_>>()})
}

/// The contents of the report.
pub struct Report<'a>(pub &'a Measured);

impl Display for Report<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Measured { device, timings } = self.0;
        let front = timings.first().map_or("", |timing| timing.wavefront.name());
        writeln!(f, "# Frames\n\n{device}, {front} fronts; medians in milliseconds.\n")?;
        let heads = [
            "points",
            "schedule",
            "frames",
            "converged",
            "iter.",
            "device ms",
            "host ms",
            "worst ms",
            "record ms",
            "MB",
        ];
        let ms = |time: Duration| digits(1e3 * time.as_secs_f64());
        let line = |timing: &Timing| {
            [
                format!("{} x {}", timing.chart.rows, timing.chart.cols),
                timing.schedule.name().into(),
                timing.frames.to_string(),
                timing.converged.to_string(),
                timing.iterations.to_string(),
                timing.device.map_or(String::new(), ms),
                ms(timing.host),
                ms(timing.worst),
                ms(timing.record),
                digits(1e-6 * timing.bytes as f64),
            ]
        };
        write!(f, "{}", Columns { heads, texts: &[1], lines: timings.iter().map(line).collect() })
    }
}
