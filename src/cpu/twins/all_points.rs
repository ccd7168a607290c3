//! All points at once from their eight triangles, again and again. The twin of
//! `glsl/all_points.comp`.

use super::super::Progress;
use super::super::state::{Fronts, Solution};
use super::scan_triangles;
use crate::Stop;
use crate::surface::{EdgeLengths, Real, Seed};
use crate::update::Wavefront;

/// Solves by updates of all points from the fronts before, two an iteration: iteration by iteration
/// what the shader does. A front advances by one point an update.
pub fn all_points<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
) -> Solution<R> {
    let chart = edges.chart();
    let triangles = scan_triangles(chart);
    let mut old = Fronts::start(edges, seeds, wavefront);
    let mut new = old.clone();
    let mut progress = Progress::new(stop);
    loop {
        let (mut change, renews) = (R::Bits::default(), progress.renews());
        for _ in 0..2 {
            for (row, col) in (0..chart.points()).map(|index| chart.position(index)) {
                let point = chart.bordered(row, col);
                for (triangles, scan) in triangles.iter().zip(1..) {
                    new.accept(point, old.through(point, triangles), scan, renews);
                }
                change = change.max(new.change_from(&old, point));
            }
            old.clone_from(&new);
        }
        if progress.is_done::<R>(change) {
            return new.finish(progress.iterations, progress.residual);
        }
    }
}
