//! Formats a profile as Markdown, which a terminal shows as it is.

use std::fmt::{self, Display, Formatter};

use geosweep::vulkan::profile::Capability;

use super::against::Comparison;
use super::file::Summary;
use super::kinds::{Kind, median};
use super::measure::Measured;
use crate::columns::{Columns, digits, percent};

/// The contents of the report.
pub struct Report<'a> {
    pub measured: &'a Measured,
    pub summary: &'a Summary,
    pub comparison: Option<&'a Comparison>,
}

impl Display for Report<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { measured, summary, comparison } = self;
        let setting = &summary.setting;
        let plural = |count: usize| if count == 1 { "" } else { "s" };
        writeln!(
            f,
            "{}{} x {} points, {} schedule, {} fronts, {} iteration{}; {} run{}, warmed up, timed \
             by {}.\n",
            if setting.maps > 1 { format!("{} maps of ", setting.maps) } else { String::new() },
            setting.rows,
            setting.cols,
            setting.schedule,
            measured.wavefront.name(),
            summary.iterations,
            plural(summary.iterations as usize),
            summary.runs,
            plural(summary.runs),
            setting.grain
        )?;
        writeln!(f, "{} ({}): {}.\n", setting.device, setting.driver, summary.ceilings)?;
        table(f, summary)?;
        self.totals(f)?;
        self.executables(f)?;
        for capability in Capability::ALL {
            if let Some(reason) = measured.capabilities.reason(capability) {
                writeln!(f, "\n{}: {reason}.", what(capability))?;
            }
        }
        match comparison {
            Some(comparison) => write!(f, "\n{comparison}"),
            None => Ok(()),
        }
    }
}

fn what(capability: Capability) -> &'static str {
    match capability {
        Capability::Timestamps => "GPU time (timestamps)",
        Capability::Statistics => "Invocations (statistics)",
        Capability::Executables => "Registers, spills and subgroups of pipelines (executables)",
        Capability::Calibration => "GPU and CPU time on one clock (calibration)",
        Capability::Labels => "Labels and names for tools (labels)",
    }
}

fn table(f: &mut Formatter<'_>, summary: &Summary) -> fmt::Result {
    let heads = [
        "pass",
        "count",
        "dispatches",
        "total ms",
        "range",
        "median us",
        "share",
        "M texels/s",
        "GB/s",
        "data",
        "arithmetic",
        "launching",
        "skipped",
    ];
    let lines = summary.kinds.iter().map(line).collect();
    write!(f, "{}", Columns { heads, texts: &[0], lines })
}

fn line(kind: &Kind) -> [String; 13] {
    let scaled = |by: f64, number: Option<f64>| number.map_or(String::new(), |n| digits(by * n));
    let rate = |count: Option<u64>| {
        let count = count.filter(|&count| count > 0)?;
        kind.median_seconds.filter(|&seconds| seconds > 0.0).map(|seconds| count as f64 / seconds)
    };
    [
        kind.name.into(),
        kind.count.to_string(),
        kind.dispatches.to_string(),
        scaled(1e3, kind.median_seconds),
        range(&kind.seconds),
        scaled(1e6, kind.median_pass_seconds),
        percent(kind.share),
        scaled(1e-6, rate(kind.texels)),
        scaled(1e-9, rate(kind.bytes())),
        percent(kind.shares.data),
        percent(kind.shares.arithmetic),
        percent(kind.shares.dispatches),
        percent(kind.skipped_share()),
    ]
}

/// Formats the shortest and the longest run, in milliseconds.
fn range(seconds: &[f64]) -> String {
    let fold = |pick: fn(f64, f64) -> f64| seconds.iter().copied().reduce(pick);
    match fold(f64::min).zip(fold(f64::max)) {
        Some((low, high)) => format!("{}-{}", digits(1e3 * low), digits(1e3 * high)),
        None => String::new(),
    }
}

impl Report<'_> {
    fn totals(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let total = &self.summary.total;
        writeln!(f)?;
        if let Some((passes, share)) = median(&total.passes).zip(total.share_of_command_buffers) {
            writeln!(
                f,
                "On the device: passes {} ms, {:.1} % of the time of command buffers.",
                digits(1e3 * passes),
                100.0 * share
            )?;
        }
        // The best times are compared, since other work on the machine only adds to the host's times.
        let best = |seconds: &[f64]| seconds.iter().copied().reduce(f64::min);
        let found = best(&total.host).zip(best(&total.host_without_profiling));
        if let Some((watched, plain)) = found {
            writeln!(
                f,
                "On the host's clock: {} in {} ms at best; without profiling in {} ms ({:+.1} %).",
                if self.summary.setting.maps > 1 { "all maps" } else { "a map" },
                digits(1e3 * watched),
                digits(1e3 * plain),
                100.0 * (watched / plain - 1.0)
            )?;
        }
        if let Some(added) = self.measured.by_scans {
            writeln!(
                f,
                "With --grain scans, which shows each scan, timestamps would add about {:.0} % to \
                 a map's time.",
                100.0 * added
            )?;
        }
        Ok(())
    }

    fn executables(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let used = format!("{}, ", self.summary.setting.schedule);
        let is_used = |name: &str| name.starts_with(&used);
        for found in self.measured.executables.iter().filter(|found| is_used(&found.pipeline)) {
            write!(
                f,
                "\n{} ({}): subgroups of {}",
                found.pipeline, found.name, found.subgroup_size
            )?;
            for statistic in &found.statistics {
                write!(f, ", {} {}", statistic.name, statistic.value)?;
            }
            writeln!(f, ".")?;
        }
        Ok(())
    }
}
