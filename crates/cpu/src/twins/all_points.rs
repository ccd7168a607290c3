//! Updates all points at once from their eight triangles, repeatedly. The twin of
//! `glsl/passes/all_points.comp`.

use super::behind;
use crate::fronts::{PointKind, for_kind};
use crate::points::PointFronts;
use crate::{Progress, Solution};
use geosweep_surface::Stop;
use geosweep_surface::update::Wavefront;
use geosweep_surface::{EdgeLengths, Real, Seed};

/// Solves by updates of all points from the previous fronts. Each iteration consists of two such updates, and equals
/// that of the shader. A front advances by one point per update.
pub fn all_points<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
) -> Solution<R> {
    for_kind!(edges, wavefront, kind => solve(PointFronts::start(edges, kind, seeds), stop))
}

fn solve<R: Real, K: PointKind<R>>(mut old: PointFronts<R, K>, stop: Stop) -> Solution<R> {
    let chart = old.edges.chart();
    let scans = behind(chart);
    old.exchange(false, |_, _| ());
    let mut new = old.clone();
    let mut progress = Progress::new(stop);
    loop {
        let (mut change, renews) = (R::Bits::default(), progress.renews());
        for _ in 0..2 {
            for (row, col) in chart.places() {
                let point = chart.bordered(row, col);
                for (behind, scan) in scans.iter().zip(1..) {
                    new.accept(point, old.reach(point, behind), scan, renews);
                }
                change = change.max(new.change_from(&old, point));
            }
            change = change.max(new.exchange(renews, |_, _| ()));
            old.clone_from(&new);
        }
        if progress.is_done::<R>(change) {
            return new.finish(progress.iterations, progress.residual);
        }
    }
}
