//! Draws which texels each scan has visited, or which tiles each round has visited.

use geosweep::Sources;
use geosweep::surface::Chart;
use geosweep::vulkan::TexelChart;
use geosweep::vulkan::profile::{PassKind, PassRecord, SolveProfile};

use super::measure::Measured;
use super::subject::Solved;
use crate::columns::digits;
use crate::picture::{Canvas, Color, Scale, Swatches, Visit, Visits};
use crate::problem::Scene;

/// The colour of points that were not visited.
const SKIPPED: Color = [0.80, 0.80, 0.81];
/// The colour of points visited in an earlier round, and not in this one.
const BEFORE: Color = [0.66, 0.80, 0.88];
/// The colour of points visited in this round.
const NOW: Color = [0.86, 0.42, 0.18];
/// The number of pictures side by side. `DOWN` is the number of rows of pictures.
const ACROSS: usize = 4;
const DOWN: usize = 4;

pub fn draw(
    measured: &Measured,
    visits: &SolveProfile,
    scene: &Scene,
    sources: &Sources,
) -> Canvas {
    let has_rounds = match measured.solved {
        Solved::Map(schedule) => schedule.has_rounds(),
        Solved::Pairwise { .. } => false,
    };
    let of_schedule = if has_rounds { rounds } else { scans };
    let (rows, key) = of_schedule(measured, visits);
    let (title, entries) = key;
    let (surface, shape) = (&scene.surface, scene.shape());
    let key = Swatches { title, entries: &entries };
    Visits { surface, shape, sources, rows: &rows, key }.draw()
}

type Key = (&'static str, Vec<(Color, String)>);

/// Returns up to `wanted` of the numbers below `count`, evenly spaced from the first to the last.
fn spread(count: usize, wanted: usize) -> Vec<usize> {
    match count.min(wanted) {
        shown @ (0 | 1) => (0..shown).collect(),
        shown => (0..shown).map(|k| k * (count - 1) / (shown - 1)).collect(),
    }
}

/// Returns the title of a picture: what the passes are, the share of the texels that they visited, and their
/// time. The time is from `run`, in which visits were not recorded.
fn title(what: String, passes: &[PassRecord], run: &SolveProfile) -> String {
    let sum = |of: fn(&PassRecord) -> Option<u64>| passes.iter().map(of).sum::<Option<u64>>();
    let counts = sum(|pass| pass.work.texels).zip(sum(|pass| pass.work.skipped));
    let share =
        counts.filter(|(visited, skipped)| visited + skipped > 0).map(|(visited, skipped)| {
            format!(", {:.0} %", 100.0 * visited as f64 / (visited + skipped) as f64)
        });
    let same =
        |pass: &&PassRecord| (pass.kind, pass.iteration) == (passes[0].kind, passes[0].iteration);
    let taken: Vec<_> = run.passes().filter(same).map(|pass| pass.nanoseconds).collect();
    // Records of a coarser grain have no time of a scan.
    let taken = taken.into_iter().reduce(|a, b| Some(a? + b?)).flatten();
    let taken = taken.map(|nanoseconds| format!(", {} ms", digits(1e-6 * nanoseconds as f64)));
    format!("{what}{}{}", share.unwrap_or_default(), taken.unwrap_or_default())
}

/// Returns one row of pictures for the first iteration and one for the last iteration that visits anything.
/// Each row shows the scans, coloured by the order of blocks.
fn scans(measured: &Measured, visits: &SolveProfile) -> (Vec<Vec<Visit>>, Key) {
    // Passes that count points do not visit any.
    let is_scan = |pass: &&PassRecord| pass.kind.is_step() && pass.area.is_some();
    let scans: Vec<PassRecord> = visits.passes().filter(is_scan).copied().collect();
    let iterations: Vec<&[PassRecord]> = scans
        .chunk_by(|a, b| a.iteration == b.iteration)
        .filter(|passes| passes.iter().any(|pass| !pass.is_idle()))
        .collect();
    let run = measured.median_run();
    let scale = Scale::over([0.0, 1.0].into_iter());
    let row = |number: usize| {
        let scans = iterations[number].chunk_by(|a, b| a.kind == b.kind);
        let visit = |passes: &[PassRecord]| {
            let name = passes[0].kind.name().trim_start_matches("scan ");
            let name = format!("iteration {}, {name}", number + 1);
            Visit {
                title: title(name, passes, run),
                colors: in_order(measured.chart, passes, &scale),
            }
        };
        scans.map(visit).collect()
    };
    let last = iterations.len().saturating_sub(1);
    let mut shown = vec![0, last];
    shown.dedup();
    let rows = shown.into_iter().map(row).collect();
    let entries = [(0.0, "first"), (0.5, "half-way"), (1.0, "last")]
        .map(|(at, name)| (scale.color(at), name.to_owned()));
    let key = entries.into_iter().chain([(SKIPPED, "skipped".into())]).collect();
    (rows, ("order of visits", key))
}

fn in_order(chart: Chart, passes: &[PassRecord], scale: &Scale) -> Vec<Color> {
    let last = (passes.len() - 1).max(1) as f32;
    let mut colors = vec![SKIPPED; chart.points()];
    let visits = passes.iter().enumerate().filter(|(_, pass)| !pass.is_idle());
    for (number, area) in visits.filter_map(|(k, pass)| Some((k, pass.area?))) {
        let color = scale.color(number as f32 / last);
        // A texel has two rows and two columns of points. The image has a border of one texel.
        let points = |[first, end]: [u32; 2], most: usize| {
            let point = |texel: u32| (2 * (texel as usize - 1)).min(most);
            point(first)..point(end)
        };
        for row in points(area.rows, chart.rows) {
            for col in points(area.cols, chart.cols) {
                colors[chart.index(row, col)] = color;
            }
        }
    }
    colors
}

/// Returns some of the rounds, evenly spaced from the first to the last.
fn rounds(measured: &Measured, visits: &SolveProfile) -> (Vec<Vec<Visit>>, Key) {
    let chart = measured.chart;
    let texels = TexelChart::new(chart).expect("it was on the device");
    let tile = measured.tuning.on_grid(texels).tile as usize;
    let across = (2 * texels.inner_cols().len()).div_ceil(tile);
    let lists = visits.submissions.iter().flat_map(|found| &found.tiles);
    let passes = visits.passes().filter(|pass| pass.kind == PassKind::Tiles);
    let rounds: Vec<(&Vec<u32>, &PassRecord)> =
        lists.zip(passes).filter(|(list, _)| !list.is_empty()).collect();
    let shown = spread(rounds.len(), ACROSS * DOWN);
    let paint = |colors: &mut [Color], list: &[u32], color: Color| {
        for number in list.iter().map(|&number| number as usize) {
            let (row, col) = (number / across * tile, number % across * tile);
            for row in row..(row + tile).min(chart.rows) {
                for col in col..(col + tile).min(chart.cols) {
                    colors[chart.index(row, col)] = color;
                }
            }
        }
    };
    let mut colors = vec![SKIPPED; chart.points()];
    let mut visits = Vec::new();
    for (number, (list, pass)) in rounds.iter().enumerate() {
        paint(&mut colors, list, NOW);
        if shown.contains(&number) {
            let run = measured.median_run();
            let s = if list.len() == 1 { "" } else { "s" };
            let what = format!("round {}, {} tile{s}", number + 1, list.len());
            let title = title(what, &[**pass], run);
            visits.push(Visit { title, colors: colors.clone() });
        }
        paint(&mut colors, list, BEFORE);
    }
    let mut rows: Vec<Vec<Visit>> = Vec::new();
    for visit in visits {
        match rows.last_mut().filter(|row| row.len() < ACROSS) {
            Some(row) => row.push(visit),
            None => rows.push(vec![visit]),
        }
    }
    let key = [(NOW, "in this round"), (BEFORE, "before"), (SKIPPED, "not yet")];
    (rows, ("tiles visited", key.map(|(color, name)| (color, name.to_owned())).into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_selection_has_the_first_and_the_last() {
        assert_eq!(spread(1, 4), [0]);
        assert_eq!(spread(3, 4), [0, 1, 2]);
        assert_eq!(spread(10, 4), [0, 3, 6, 9]);
    }
}
