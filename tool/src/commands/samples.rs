//! Computes points that are far from one another.

use geosweep::geometry::{Farthest, FarthestPoints};
use geosweep::surface::EdgeLengths;
use geosweep::{Sources, Surface};
use serde::Serialize;

use crate::terminal::progress;

/// Computes `count` samples, or fewer if the surface has fewer points, and the map from them. All samples but the first
/// come from `candidates`, if given.
pub fn farthest_points<'a>(
    surface: &'a Surface,
    edges: &'a EdgeLengths<f32>,
    [row, col]: [f64; 2],
    candidates: Option<&[bool]>,
    count: usize,
) -> Result<(FarthestPoints<'a>, Vec<Sample>), geosweep::Error> {
    let mut points = FarthestPoints::new(surface, edges, &Sources::point(row, col))?;
    if let Some(candidates) = candidates {
        points = points.among(candidates);
    }
    let bar = progress(count).with_message("sampling");
    let farthest = points.by_ref().take(count - 1).inspect(|_| bar.inc(1));
    let samples: Vec<Sample> = std::iter::once(Sample { row, col, radius: None })
        .chain(farthest.map(Sample::of))
        .collect();
    bar.finish_and_clear();
    let found = samples.len();
    if found < count {
        note!("only {found} samples, not {count}: every point is a sample");
    }
    Ok((points, samples))
}

/// Returns the point nearest to the middle of the grid, among `candidates` if given.
pub fn middle(surface: &Surface, candidates: Option<&[bool]>) -> [f64; 2] {
    let chart = surface.chart();
    let from_middle = |&index: &usize| {
        let (row, col) = chart.position(index);
        (2 * row).abs_diff(chart.rows - 1).pow(2) + (2 * col).abs_diff(chart.cols - 1).pow(2)
    };
    let is_candidate = |index: usize| candidates.is_none_or(|candidates| candidates[index]);
    let present =
        (0..chart.points()).filter(|&index| surface.present()[index] && is_candidate(index));
    let (row, col) = chart.position(present.min_by_key(from_middle).unwrap_or_default());
    [row as f64, col as f64]
}

/// A sample, and its distance from all previous samples.
#[derive(Serialize)]
pub struct Sample {
    pub row: f64,
    pub col: f64,
    radius: Option<f32>,
}

impl Sample {
    fn of(farthest: Farthest) -> Self {
        let Farthest { row, col, distance } = farthest;
        let radius = distance.is_finite().then_some(distance);
        Self { row: row as f64, col: col as f64, radius }
    }
}
