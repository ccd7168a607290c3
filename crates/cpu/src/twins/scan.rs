//! Implements rotated raster scans one after another, point by point. The twin of `glsl/passes/scan.comp`.

use super::behind;
use crate::fronts::{PointKind, for_kind};
use crate::points::PointFronts;
use crate::scan::Scan;
use crate::{Progress, Solution};
use geosweep_surface::Stop;
use geosweep_surface::update::Wavefront;
use geosweep_surface::{EdgeLengths, Real, Seed};

/// Solves by rotated raster scans (the paper's figure 3, second row): down, up, right and left, one after another.
/// After each iteration the fronts are those of the shader up to rounding, if its scans do not run in pairs.
/// [`crate::rotated_scan`] is many times faster and converges to the same map.
pub fn scan_in_turn<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
) -> Solution<R> {
    solve(edges, seeds, wavefront, stop, false)
}

/// Solves as [`scan_in_turn`] does, except that each scan of the first iteration visits only the lines ahead of the
/// seed that it would reach first. The pairwise engines do this: behind the source, other scans of the iteration
/// reach most points by shorter paths.
pub fn scan_outward<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
) -> Solution<R> {
    solve(edges, seeds, wavefront, stop, true)
}

/// Solves by scans one after another. With `outward`, the scans of the first iteration visit only lines ahead of a
/// seed.
fn solve<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
    outward: bool,
) -> Solution<R> {
    for_kind!(edges, wavefront, kind => {
        let mut fronts = PointFronts::start(edges, kind, seeds);
        let progress = scan(&mut fronts, seeds, stop, outward);
        fronts.finish(progress.iterations, progress.residual)
    })
}

/// Repeats the four scans until `stop`, starting from fronts that hold the seeds, and returns the progress.
pub(super) fn scan<R: Real, K: PointKind<R>>(
    fronts: &mut PointFronts<R, K>,
    seeds: &[Seed],
    stop: Stop,
    outward: bool,
) -> Progress {
    let chart = fronts.edges.chart();
    let (rows, cols) = (chart.rows, chart.cols);
    let behind = behind(chart);
    fronts.exchange(false, |_, _| ());
    let mut progress = Progress::new(stop);
    let ranges = |of: fn(&Seed) -> usize, lines: usize| {
        let places = || seeds.iter().map(of);
        let (first, last) = (places().min().unwrap_or(lines), places().max().unwrap_or(0));
        [first + 1..lines, 0..last]
    };
    let away = [ranges(|seed| seed.row, rows), ranges(|seed| seed.col, cols)];
    let whole = [[0..rows, 0..rows], [0..cols, 0..cols]];
    loop {
        let (mut change, renews) = (R::Bits::default(), progress.renews());
        let is_first = progress.iterations == 0;
        let [[down, up], [right, left]] = if outward && is_first { &away } else { &whole }.clone();
        for (scan, lines) in Scan::ALL.into_iter().zip([down, up, right, left]) {
            for line in scan.in_order(lines) {
                for along in 0..chart.by(scan.lines()).cols {
                    let (row, col) = scan.lines().place(line, along);
                    let point = chart.bordered(row, col);
                    let front = fronts.reach(point, &behind[usize::from(scan.0) - 1]);
                    change = change.max(fronts.accept(point, front, scan.0, renews));
                }
            }
            change = change.max(fronts.exchange(renews, |_, _| ()));
        }
        if progress.is_done::<R>(change) && (progress.is_last() || !fronts.restore(seeds)) {
            return progress;
        }
    }
}
