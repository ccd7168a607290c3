//! Estimates the error of a map over a floor plan, from the map of a grid twice as fine.
//!
//! Fronts with anchors are exact except for rounding, and except behind corners beyond which a region stays narrower
//! than a cell over a long distance. Many corners among single missing points are such. On a coarser grid outlines
//! would change, and such corners would not show. On a finer grid outlines stay the same, and such a region is twice as
//! many points wide.

use super::error_estimate::ErrorEstimate;
use crate::Options;
use crate::solve::{Precision, in_precision};
use crate::surface::{Source, Sources, Surface};
use crate::{DistanceMap, Error};

/// Ratio of the error to the difference of the two maps: up to half of an error is assumed to remain on the
/// finer grid.
const ERROR_PER_DIFFERENCE: f64 = 2.0;

/// Estimates the error of a map with anchors from the map over `fine`, the same floor plan on a grid twice as
/// fine.
pub(super) fn estimate<R: Precision>(
    map: DistanceMap<R>,
    fine: &Surface,
    sources: &Sources,
    options: &Options,
) -> Result<ErrorEstimate<R>, Error> {
    // Both grids use one engine, since their difference is the estimate.
    let options = options.clone().with_engine(options.engine.as_for(&map.report));
    let finer = in_precision::<R>(fine, &on_fine_grid(sources), &options, None)?;
    let rounding = R::epsilon().wide();
    let known = |index| {
        let (row, col) = map.chart.position(index);
        let (distance, better) = (map.distances[index], finer.distance(2 * row, 2 * col));
        if distance.is_infinite() {
            return (R::infinity(), distance);
        }
        let off = ERROR_PER_DIFFERENCE * (distance - better).wide().abs();
        let length = distance.wide() - sources.start();
        (R::of(off + rounding * length), better)
    };
    let (errors, extrapolated) = (0..map.distances.len()).map(known).unzip();
    let (grids, further_solve_time) = (2, finer.report.solve_time);
    Ok(ErrorEstimate { map, errors, extrapolated, observed_order: None, grids, further_solve_time })
}

/// Returns point sources at the same places on the fine grid.
fn on_fine_grid(sources: &Sources) -> Sources {
    let moved = |source: &Source| match source.clone() {
        Source::Point { at, initial } => Source::Point { at: 2.0 * at, initial },
        curve => curve,
    };
    sources.iter().map(moved).collect()
}
