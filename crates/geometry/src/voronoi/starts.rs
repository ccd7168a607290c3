//! Determines where the wavefronts of sources start.

use super::known::NO_REGION;
use crate::MapError;
use crate::copies::Copies;
use crate::order::bordered;
use geosweep_surface::{Chart, Source, Sources, Surface};

/// The arrival of a source's wavefront at one of the source's seeds.
pub(super) struct Start {
    /// The index of the point in a bordered array. If the point has copies across a seam, it is the first of them.
    pub point: usize,
    /// The index of the source.
    pub label: u32,
    /// The arrival time at the point.
    pub time: f64,
}

/// Returns the starts of all sources. If two sources are the same, the second has none.
pub(super) fn starts(
    chart: Chart,
    copies: &Copies,
    surface: &Surface,
    sources: &Sources,
) -> Result<Vec<Start>, MapError> {
    let all: Vec<&Source> = sources.iter().collect();
    let mut starts = Vec::new();
    for (label, source) in all.iter().enumerate() {
        let seeds = Sources::from_iter([(*source).clone()]).seeds(surface)?;
        if !all[..label].contains(source) {
            starts.extend(seeds.into_iter().map(|seed| Start {
                point: copies.first(chart.bordered(seed.row, seed.col)),
                label: label as u32,
                time: seed.time,
            }));
        }
    }
    Ok(starts)
}

/// Returns the labels of a map of one source: all points that it reaches are its own. Returns `None` if there are several
/// sources.
pub(super) fn of_one_source(
    surface: &Surface,
    sources: &Sources,
    distances: &[f32],
) -> Result<Option<Vec<u32>>, MapError> {
    let mut others = sources.iter();
    let first = others.next();
    if others.any(|other| Some(other) != first) {
        return Ok(None);
    }
    sources.seeds(surface)?;
    bordered(surface.chart(), distances)?;
    let label = |distance: &f32| if distance.is_finite() { 0 } else { NO_REGION };
    Ok(Some(distances.iter().map(label).collect()))
}

/// Returns the points that have a start, each once, with the label of its earliest start. If several starts are equally
/// early, the smallest label counts.
pub(super) fn first_labels(starts: &[Start]) -> Vec<(usize, u32)> {
    let mut order: Vec<&Start> = starts.iter().collect();
    order.sort_by(|a, b| {
        a.point.cmp(&b.point).then(a.time.total_cmp(&b.time)).then(a.label.cmp(&b.label))
    });
    order.dedup_by_key(|start| start.point);
    order.into_iter().map(|start| (start.point, start.label)).collect()
}
