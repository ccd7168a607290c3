//! Groups the passes of all runs by kind.

use geosweep::vulkan::profile::{PassRecord, SolveProfile, Work as Needed};
use serde::Serialize;

use super::measure::Measured;
use crate::ceilings::{Shares, Work};

/// All passes of one kind, as in the JSON format.
#[derive(Clone, Debug, Serialize)]
pub struct Kind {
    pub name: &'static str,
    /// The number of records in one map.
    pub count: usize,
    /// The number of dispatches in one map.
    pub dispatches: u64,
    /// The seconds of each run, in the order of the runs. Empty without timestamps.
    pub seconds: Vec<f64>,
    pub median_seconds: Option<f64>,
    /// The median time of one pass.
    pub median_pass_seconds: Option<f64>,
    /// The share of the time of all passes.
    pub share: Option<f64>,
    /// The work of these passes in one map: this field and the next five.
    pub texels: Option<u64>,
    pub skipped: Option<u64>,
    pub bytes_read: Option<u64>,
    pub bytes_written: Option<u64>,
    pub triangles: Option<u64>,
    pub invocations: Option<u64>,
    /// The times that the work would take at the device's peak rates, as fractions of the time.
    pub shares: Shares,
}

impl Kind {
    /// Returns the bytes read and written.
    pub fn bytes(&self) -> Option<u64> {
        Some(self.bytes_read? + self.bytes_written?)
    }

    /// Returns the share of the texels that were not visited, thanks to bounds, lists and convergence.
    pub fn skipped_share(&self) -> Option<f64> {
        let (texels, skipped) = (self.texels? as f64, self.skipped? as f64);
        (texels + skipped > 0.0).then(|| skipped / (texels + skipped))
    }
}

/// The name for passes of any kind that visit nothing.
pub const IDLE: &str = "idle passes";

fn name(pass: &PassRecord) -> &'static str {
    if pass.is_idle() { IDLE } else { pass.kind.name() }
}

/// Returns the median of some numbers. For an even count it is the mean of the middle two.
pub fn median(numbers: &[f64]) -> Option<f64> {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (low, high) = (sorted.len().checked_sub(1)? / 2, sorted.len() / 2);
    Some(0.5 * (sorted[low] + sorted[high]))
}

/// Returns all kinds, sorted by time, the longest first. Without times they are in order of appearance. `all` is the
/// median time of all passes.
pub fn kinds(measured: &Measured, all: Option<f64>) -> Vec<Kind> {
    let mut names = Vec::new();
    for pass in measured.counted.passes() {
        if !names.contains(&name(pass)) {
            names.push(name(pass));
        }
    }
    let mut kinds: Vec<_> = names.into_iter().map(|name| kind(measured, name, all)).collect();
    let total = |kind: &Kind| kind.median_seconds.unwrap_or(0.0);
    kinds.sort_by(|a, b| total(b).total_cmp(&total(a)));
    kinds
}

fn kind(measured: &Measured, wanted: &'static str, all: Option<f64>) -> Kind {
    let of_kind = |run: &SolveProfile| -> Vec<PassRecord> {
        run.passes().filter(|pass| name(pass) == wanted).copied().collect()
    };
    let seconds = |pass: &PassRecord| pass.nanoseconds.map(|nanoseconds| 1e-9 * nanoseconds as f64);
    let runs: Vec<_> = measured.runs.iter().map(of_kind).collect();
    let passes = of_kind(&measured.counted);
    let dispatches = passes.iter().map(|pass| u64::from(pass.dispatches)).sum();
    let each: Vec<f64> = runs.iter().flatten().filter_map(seconds).collect();
    let of_runs: Vec<f64> = runs.iter().filter_map(|run| run.iter().map(seconds).sum()).collect();
    let median_seconds = median(&of_runs);
    let sum = |of: fn(&Needed) -> Option<u64>| passes.iter().map(|pass| of(&pass.work)).sum();
    let mut kind = Kind {
        name: wanted,
        count: runs.first().map_or(0, Vec::len),
        dispatches,
        seconds: of_runs,
        median_seconds,
        median_pass_seconds: median(&each),
        share: median_seconds.zip(all).map(|(seconds, all)| seconds / all),
        texels: sum(|work| work.texels),
        skipped: sum(|work| work.skipped),
        bytes_read: sum(|work| work.bytes_read),
        bytes_written: sum(|work| work.bytes_written),
        triangles: sum(|work| work.triangles),
        invocations: passes.iter().map(|pass| pass.invocations).sum(),
        shares: Shares::default(),
    };
    if let Some(total) = median_seconds.filter(|&total| total > 0.0) {
        let is_idle = wanted == IDLE;
        let work = Work {
            bytes: kind.bytes().filter(|&bytes| bytes > 0),
            triangles: kind.triangles.filter(|&triangles| triangles > 0),
            dispatches: if is_idle { 0 } else { dispatches },
            skipped_dispatches: if is_idle { dispatches } else { 0 },
            submissions: 0,
        };
        kind.shares = Shares::on_device(work, total, measured.wavefront, &measured.ceilings);
        kind.shares.dispatches = kind.shares.dispatches.filter(|_| dispatches > 0);
    }
    kind
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_lie_in_the_middle() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0]), Some(3.0));
        assert_eq!(median(&[5.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 9.0]), Some(3.0));
    }
}
