//! Compares a profile with an earlier one.

use std::fmt::{self, Display, Formatter};
use std::fs;
use std::path::Path;

use geosweep::vulkan::profile::Grain;
use serde::{Deserialize, Serialize};

use super::file::{Setting, Summary};
use super::kinds::median;
use crate::columns::{Columns, digits};

/// The parts of an earlier profile that are used.
#[derive(Deserialize)]
pub struct Earlier {
    #[serde(flatten)]
    setting: Setting,
    kinds: Vec<EarlierKind>,
    total: EarlierTotal,
}

#[derive(Deserialize)]
struct EarlierKind {
    name: String,
    seconds: Vec<f64>,
}

#[derive(Deserialize)]
struct EarlierTotal {
    passes: Vec<f64>,
    host: Vec<f64>,
}

impl Earlier {
    /// Returns the grain of the timestamps, or `None` if this version of the tool does not know it.
    pub fn grain(&self) -> Option<Grain> {
        Grain::ALL.into_iter().find(|grain| grain.name() == self.setting.grain)
    }

    pub fn read(path: &Path) -> Result<Self, String> {
        let name = path.display();
        let text = fs::read(path).map_err(|error| format!("{name}: {error}"))?;
        serde_json::from_slice(&text).map_err(|error| {
            format!("{name}: this is not a profile as `geosweep profile --json` prints it: {error}")
        })
    }
}

/// The comparison of two profiles, kind by kind.
#[derive(Serialize)]
pub struct Comparison {
    /// Differences between the two profiled settings. If there are any, the comparison needs care.
    pub differences: Vec<String>,
    pub changes: Vec<Change>,
}

/// A profile and its comparison with an earlier one.
#[derive(Serialize)]
pub struct Whole<'a> {
    #[serde(flatten)]
    pub summary: &'a Summary,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against: Option<&'a Comparison>,
}

/// The change of the time of one kind of pass.
#[derive(Serialize)]
pub struct Change {
    pub name: String,
    /// The median times; `None` if there is no such pass or no time.
    pub before_seconds: Option<f64>,
    pub now_seconds: Option<f64>,
    /// The change, relative to the earlier time.
    pub change: Option<f64>,
    /// The largest deviation of a run from the median of its own profile, relative to that median.
    pub noise: Option<f64>,
    pub verdict: Verdict,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every new run took longer than every earlier run.
    Slower,
    /// Every new run took less time than every earlier run.
    Faster,
    /// The times of the runs overlap.
    WithinNoise,
    /// At least one of the profiles has a single run, so the noise is not known.
    OneRun,
    /// The kind exists only in the new profile.
    New,
    /// The kind exists only in the earlier profile.
    Gone,
    /// At least one of the profiles has no times.
    NoTimes,
}

impl Verdict {
    fn of(before: &[f64], now: &[f64]) -> Self {
        let range = |seconds: &[f64]| {
            seconds
                .iter()
                .fold((f64::INFINITY, 0.0f64), |(low, high), &one| (low.min(one), high.max(one)))
        };
        let (before_range, now_range) = (range(before), range(now));
        if before.is_empty() || now.is_empty() {
            Self::NoTimes
        } else if before.len() < 2 || now.len() < 2 {
            Self::OneRun
        } else if now_range.0 > before_range.1 {
            Self::Slower
        } else if now_range.1 < before_range.0 {
            Self::Faster
        } else {
            Self::WithinNoise
        }
    }

    fn text(self) -> &'static str {
        match self {
            Self::Slower => "slower",
            Self::Faster => "faster",
            Self::WithinNoise => "within the noise",
            Self::OneRun => "one run: noise unknown",
            Self::New => "new",
            Self::Gone => "gone",
            Self::NoTimes => "no times",
        }
    }
}

impl Comparison {
    pub fn new(earlier: &Earlier, now: &Summary) -> Self {
        let before_of = |name: &str| earlier.kinds.iter().find(|kind| kind.name == name);
        let totals = [
            ("all passes", &earlier.total.passes, &now.total.passes),
            ("all, host's clock", &earlier.total.host, &now.total.host),
        ];
        let mut changes: Vec<_> = totals
            .into_iter()
            .map(|(name, before, now)| Change::new(name, Some(before), Some(now)))
            .collect();
        for kind in &now.kinds {
            let before = before_of(kind.name).map(|kind| &kind.seconds);
            changes.push(Change::new(kind.name, before, Some(&kind.seconds)));
        }
        let is_gone = |name: &str| now.kinds.iter().all(|kind| kind.name != name);
        for kind in earlier.kinds.iter().filter(|kind| is_gone(&kind.name)) {
            changes.push(Change::new(&kind.name, Some(&kind.seconds), None));
        }
        Self { differences: differences(&earlier.setting, &now.setting), changes }
    }
}

impl Change {
    fn new(name: &str, before: Option<&Vec<f64>>, now: Option<&Vec<f64>>) -> Self {
        let verdict = match (before, now) {
            (Some(before), Some(now)) => Verdict::of(before, now),
            (None, _) => Verdict::New,
            (_, None) => Verdict::Gone,
        };
        let [before_seconds, now_seconds] =
            [before, now].map(|runs| runs.and_then(|runs| median(runs)));
        let noises = [before, now].into_iter().flatten().filter_map(|runs| noise(runs));
        Self {
            name: name.into(),
            before_seconds,
            now_seconds,
            change: before_seconds
                .zip(now_seconds)
                .filter(|(before, _)| *before > 0.0)
                .map(|(before, now)| now / before - 1.0),
            noise: noises.reduce(f64::max),
            verdict,
        }
    }
}

/// Returns the largest deviation of a run from the median, relative to the median. Returns `None` for
/// fewer than two runs or a median of zero.
fn noise(runs: &[f64]) -> Option<f64> {
    let middle = median(runs).filter(|&middle| middle > 0.0 && runs.len() > 1)?;
    Some(runs.iter().map(|run| (run - middle).abs()).fold(0.0, f64::max) / middle)
}

fn differences(before: &Setting, now: &Setting) -> Vec<String> {
    let size = |setting: &Setting| format!("{} x {} points", setting.rows, setting.cols);
    let maps = |Setting { maps, .. }: &Setting| {
        if *maps == 1 { "one map".to_owned() } else { format!("{maps} maps at once") }
    };
    [
        (before.device.clone(), now.device.clone()),
        (before.driver.clone(), now.driver.clone()),
        (size(before), size(now)),
        (maps(before), maps(now)),
        (before.schedule.clone(), now.schedule.clone()),
        (before.wavefront.clone(), now.wavefront.clone()),
        (before.grain.clone(), now.grain.clone()),
    ]
    .into_iter()
    .filter(|(before, now)| before != now)
    .map(|(before, now)| format!("{before} before, {now} now"))
    .collect()
}

impl Display for Comparison {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for difference in &self.differences {
            writeln!(f, "The profiles differ: {difference}.\n")?;
        }
        let milliseconds =
            |seconds: Option<f64>| seconds.map_or(String::new(), |s| digits(1e3 * s));
        let line = |change: &Change| {
            [
                change.name.clone(),
                milliseconds(change.before_seconds),
                milliseconds(change.now_seconds),
                change.change.map_or(String::new(), |by| format!("{:+.1} %", 100.0 * by)),
                change.noise.map_or(String::new(), |by| format!("{:.1} %", 100.0 * by)),
                change.verdict.text().into(),
            ]
        };
        let heads = ["pass", "before ms", "now ms", "change", "noise", ""];
        let lines = self.changes.iter().map(line).collect();
        write!(f, "{}", Columns { heads, texts: &[0, 5], lines })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_that_overlap_tell_nothing() {
        let verdict = |before: &[f64], now: &[f64]| Verdict::of(before, now);
        assert_eq!(verdict(&[1.0, 1.1], &[1.2, 1.3]), Verdict::Slower);
        assert_eq!(verdict(&[1.0, 1.1], &[0.8, 0.9]), Verdict::Faster);
        assert_eq!(verdict(&[1.0, 1.2], &[1.1, 1.3]), Verdict::WithinNoise);
        assert_eq!(verdict(&[1.0], &[2.0, 2.1]), Verdict::OneRun);
        assert_eq!(verdict(&[], &[2.0]), Verdict::NoTimes);
        assert_eq!(Change::new("a", None, Some(&vec![1.0])).verdict, Verdict::New);
        let gone = Change::new("a", Some(&vec![1.0, 1.5, 1.25]), None);
        assert_eq!((gone.verdict, gone.before_seconds), (Verdict::Gone, Some(1.25)));
        assert_eq!((gone.change, gone.noise), (None, Some(0.2)));
    }
}
