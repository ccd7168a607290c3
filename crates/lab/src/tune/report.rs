//! Formats the measurements as Markdown, which a terminal shows as it is, and as JSON.

use std::fmt::{self, Display, Formatter};

use geosweep::vulkan::{Schedule, Tuning};
use serde_json::{Value, json};

use super::results::{Knob, Map, Swept};
use super::suggest::{Choice, together};
use super::sweep::SCHEDULES;
use geosweep_cli::columns::digits;

/// Returns all results as JSON.
pub fn summary(swept: &Swept) -> Value {
    let rows = swept.rows.iter().map(|row| {
        json!({
            "schedule": row.schedule.name(),
            "knob": row.knob.name(),
            "value": row.value,
            "ratio": row.ratio,
            "refused": row.refused,
            "maps": row.maps.iter().map(|found| map(swept, found)).collect::<Vec<_>>(),
        })
    });
    let schedules = Choice::of(swept).into_iter().map(|choice| {
        let task = &swept.tasks[choice.task];
        json!({
            "surface": task.name,
            "rows": task.surface.rows(),
            "cols": task.surface.cols(),
            "raster_seconds": choice.raster,
            "tiles_seconds": choice.tiles,
            "best": choice.winner().map(Schedule::name),
        })
    });
    json!({
        "device": swept.device,
        "wavefront": swept.wavefront.name(),
        "untuned": portions(swept.untuned),
        "suggested": portions(swept.suggested),
        "rows": rows.collect::<Vec<_>>(),
        "schedules": schedules.collect::<Vec<_>>(),
        "left_out": swept.left_out,
    })
}

fn portions(tuning: Tuning) -> Value {
    let Tuning { scan_width, scan_lines, tile, inner, together, .. } = tuning;
    json!({
        "scan_width": scan_width,
        "scan_lines": scan_lines,
        "tile": tile,
        "inner": inner,
        "together": together,
    })
}

fn map(swept: &Swept, map: &Map) -> Value {
    let task = &swept.tasks[map.task];
    json!({
        "surface": task.name,
        "rows": task.surface.rows(),
        "cols": task.surface.cols(),
        "best_seconds": map.best.as_secs_f64(),
        "untuned_seconds": map.untuned.as_secs_f64(),
        "iterations": map.iterations,
        // Null if one map reaches a point and the other does not.
        "difference": Some(map.difference).filter(|found| found.is_finite()),
    })
}

/// The contents of the report.
pub struct Report<'a>(pub &'a Swept);

impl Display for Report<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let swept = self.0;
        let Tuning { scan_width, scan_lines, tile, inner, .. } = swept.untuned;
        writeln!(
            f,
            "# Tuning\n\n{}, {} fronts. Untuned: {scan_lines} lines a block, {scan_width} invocations \
             a group, tiles of {tile} points a side, {inner} iterations in a tile. Times of the \
             column `time` are relative to the untuned maps that were timed in turn, not to the first line.",
            swept.device,
            swept.wavefront.name()
        )?;
        for schedule in SCHEDULES {
            self.rows(f, schedule)?;
        }
        self.schedules(f)?;
        self.suggestion(f)?;
        if !swept.left_out.is_empty() {
            writeln!(f, "\nLeft out:\n")?;
            swept.left_out.iter().try_for_each(|what| writeln!(f, "- {what}"))?;
        }
        Ok(())
    }
}

impl Report<'_> {
    /// Writes the rows of a schedule, with one column for each task.
    fn rows(&self, f: &mut Formatter<'_>, schedule: Schedule) -> fmt::Result {
        let Swept { tasks, rows, .. } = self.0;
        let of_schedule: Vec<_> = rows.iter().filter(|row| row.schedule == schedule).collect();
        let used: Vec<_> = (0..tasks.len())
            .filter(|&task| {
                of_schedule.iter().flat_map(|row| &row.maps).any(|map| map.task == task)
            })
            .collect();
        writeln!(f, "\n## {schedule}\n")?;
        if used.is_empty() {
            return writeln!(f, "Nothing was measured.");
        }
        write!(f, "| what | value | time |")?;
        for &task in &used {
            let task = &tasks[task];
            write!(f, " {} {} x {} ms |", task.name, task.surface.rows(), task.surface.cols())?;
        }
        writeln!(f, " largest difference |")?;
        writeln!(f, "|---|---:|---:|{}---:|", "---:|".repeat(used.len()))?;
        for row in of_schedule {
            let value = match row.knob {
                Knob::Untuned | Knob::Suggested => String::new(),
                _ => row.value.to_string(),
            };
            write!(f, "| {} | {value} |", row.knob.name())?;
            if let Some(reason) = &row.refused {
                writeln!(f, " refused: {reason} |{} |", " |".repeat(used.len()))?;
                continue;
            }
            write!(f, " {} |", row.ratio.map_or(String::new(), digits))?;
            for &task in &used {
                let map = row.maps.iter().find(|map| map.task == task);
                let time = map.map(|map| digits(1e3 * map.best.as_secs_f64()));
                write!(f, " {} |", time.unwrap_or_default())?;
            }
            let largest = row.maps.iter().map(|map| map.difference).fold(0.0, f64::max);
            let mark = if row.differs() { "**" } else { "" };
            writeln!(f, " {mark}{largest:.1e}{mark} |")?;
        }
        Ok(())
    }

    fn schedules(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "\n## Schedule by size\n\n| surface | points | raster ms | tiles ms | best |")?;
        writeln!(f, "|---|---:|---:|---:|---|")?;
        for choice in Choice::of(self.0) {
            let task = &self.0.tasks[choice.task];
            let time = |seconds: Option<f64>| seconds.map_or(String::new(), |s| digits(1e3 * s));
            writeln!(
                f,
                "| {} | {} x {} | {} | {} | {} |",
                task.name,
                task.surface.rows(),
                task.surface.cols(),
                time(choice.raster),
                time(choice.tiles),
                choice.winner().map_or("not measured", Schedule::name)
            )?;
        }
        Ok(())
    }

    fn suggestion(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Swept { untuned, suggested, rows, .. } = self.0;
        writeln!(f, "\n## Suggested\n\n| what | untuned | suggested |\n|---|---:|---:|")?;
        for (knob, get) in [
            (Knob::Lines, (|t: &Tuning| t.scan_lines) as fn(&Tuning) -> u32),
            (Knob::Width, |t| t.scan_width),
            (Knob::Tile, |t| t.tile),
            (Knob::Inner, |t| t.inner),
        ] {
            writeln!(f, "| {} | {} | {} |", knob.name(), get(untuned), get(suggested))?;
        }
        for schedule in SCHEDULES {
            let name = Knob::Together.name();
            let best = match together(rows, schedule) {
                Some((value, ratio)) => format!("{value} ({} of the time)", digits(ratio)),
                None => "as it is".into(),
            };
            writeln!(f, "| {name}, {schedule} | by size | {best} |")?;
        }
        let Tuning { scan_width, scan_lines, tile, inner, .. } = suggested;
        writeln!(f, "\n    geosweep-lab bench --tuning {scan_width},{scan_lines},{tile},{inner}")
    }
}
