//! How far a map over a floor plan may be from the exact distances, from the map of a grid twice as fine.
//!
//! Fronts with anchors are exact but for rounding, and for corners that light less than a cell for long, as
//! many do among single missing points. On a coarser grid outlines would be others, and tell nothing of that;
//! on a finer one they are the same, and what such a corner lights is twice as many points wide.

use super::ErrorEstimate;
use crate::solve::{Options, Precision, in_precision};
use crate::surface::{Source, Sources, Surface};
use crate::{DistanceMap, Error};

/// Errors over differences of the two maps: on the finer grid up to half of an error is taken to be left.
const LEFT: f64 = 2.0;

/// The estimate of a map with anchors from that over `fine`, the same floor plan on a grid twice as fine.
pub(super) fn estimate<R: Precision>(
    map: DistanceMap<R>,
    fine: &Surface,
    sources: &Sources,
    options: &Options,
) -> Result<ErrorEstimate<R>, Error> {
    // One engine for both grids, whose difference is the estimate.
    let options = Options { engine: options.engine.as_for(&map.report), ..options.clone() };
    let finer = in_precision::<R>(fine, &on_fine_grid(sources), &options)?;
    let rounding = R::epsilon().wide();
    let known = |index| {
        let (row, col) = map.chart.position(index);
        let (distance, better) = (map.distances[index], finer.distance(2 * row, 2 * col));
        if distance.is_infinite() {
            return (R::infinity(), distance);
        }
        let off = LEFT * (distance - better).wide().abs();
        let length = distance.wide() - sources.start();
        (R::of(off + rounding * length), better)
    };
    let (errors, extrapolated) = (0..map.distances.len()).map(known).unzip();
    let (grids, further_solve_time) = (2, finer.report.solve_time);
    Ok(ErrorEstimate { map, errors, extrapolated, observed_order: None, grids, further_solve_time })
}

/// Point sources at the same places.
fn on_fine_grid(sources: &Sources) -> Sources {
    let moved = |source: &Source| match source.clone() {
        Source::Point { at, initial } => Source::Point { at: 2.0 * at, initial },
        curve => curve,
    };
    sources.iter().map(moved).collect()
}
