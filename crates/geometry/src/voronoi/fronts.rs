//! Gives the arrival times of all sources' fronts around the borders between regions.

use super::known::NO_REGION;
use super::own_maps::OwnMaps;
use super::source_fronts::SourceFronts;
use crate::MapError;
use crate::order::bordered;
use geosweep_cpu::{StraightFronts, straight_parts};
use geosweep_surface::{Chart, EdgeLengths, Sources, Surface};

/// The fronts of several sources: along straight lines where these are shortest paths. Elsewhere they are those of each
/// source's own map in skewed cells, and followed from point to point in others.
pub(super) struct Fronts<'a> {
    chart: Chart,
    /// The earliest start.
    start: f64,
    straight: Option<StraightFronts>,
    around: Option<Around<'a>>,
}

/// Fronts that go around holes and over cells that differ.
enum Around<'a> {
    Own(OwnMaps),
    Followed(Box<SourceFronts<'a>>),
}

impl Around<'_> {
    fn labels(&self, distances: &[f32]) -> Vec<u32> {
        match self {
            Self::Own(maps) => maps.labels(distances),
            Self::Followed(fronts) => fronts.labels(),
        }
    }

    fn time(&self, index: usize, label: u32) -> Option<f64> {
        match self {
            Self::Own(maps) => maps.time(index, label),
            Self::Followed(fronts) => fronts.time(index, label),
        }
    }
}

impl<'a> Fronts<'a> {
    /// Returns the fronts, and the label of each point, row-major.
    pub(super) fn new(
        surface: &Surface,
        edges: &'a EdgeLengths<f32>,
        sources: &Sources,
        distances: &[f32],
    ) -> Result<(Self, Vec<u32>), MapError> {
        sources.seeds(surface)?;
        bordered(surface.chart(), distances)?;
        let parts: Vec<_> = sources.iter().map(|source| straight_parts(surface, source)).collect();
        let straight = StraightFronts::new(surface, &parts);
        let found = straight.as_ref().map(|straight| straight_labels(straight, distances));
        let is_left = |(label, time): (&u32, &f32)| *label == NO_REGION && time.is_finite();
        let are_left = |labels: &Vec<u32>| labels.iter().zip(distances).any(is_left);
        let (around, labels) = match found {
            Some(labels) if !are_left(&labels) => (None, labels),
            found => {
                let fronts = match OwnMaps::new(surface, edges, sources, straight.is_some()) {
                    Some(maps) => Around::Own(maps),
                    None => {
                        let fronts = SourceFronts::new(surface, edges, sources, distances)?;
                        Around::Followed(Box::new(fronts))
                    }
                };
                let mut labels = fronts.labels(distances);
                for (label, straight) in labels.iter_mut().zip(found.into_iter().flatten()) {
                    *label = if straight == NO_REGION { *label } else { straight };
                }
                (Some(fronts), labels)
            }
        };
        let fronts = Self { chart: surface.chart(), start: sources.start(), straight, around };
        Ok((fronts, labels))
    }

    pub(super) fn chart(&self) -> Chart {
        self.chart
    }

    /// Returns the squared time at which a wavefront arrives at a grid point, counted from the earliest
    /// start, if the wavefront is known there. Differences of squared times are linear in the plane.
    pub(super) fn squared(&self, index: usize, label: u32) -> Option<f64> {
        let straight = self.straight.as_ref().and_then(|fronts| fronts.time(index, label));
        let around = || self.around.as_ref()?.time(index, label);
        let time = straight.or_else(around)?;
        Some((time - self.start).powi(2))
    }

    /// Returns the position at which both wavefronts arrive at once on the edge between two points of different
    /// regions, from the first point (0) to the second (1).
    pub(super) fn meeting(&self, points: [usize; 2], labels: [u32; 2]) -> f64 {
        match points.map(|point| self.lead(point, labels)) {
            [Some(here), Some(there)] if here > there => (here / (here - there)).clamp(0.0, 1.0),
            _ => 0.5,
        }
    }

    /// Returns the squared time of the second wavefront minus that of the first at a grid point, if both are
    /// known there.
    fn lead(&self, index: usize, [first, second]: [u32; 2]) -> Option<f64> {
        Some(self.squared(index, second)? - self.squared(index, first)?)
    }
}

/// Returns the labels of points that straight lines lead to.
fn straight_labels(fronts: &StraightFronts, distances: &[f32]) -> Vec<u32> {
    let arrivals = fronts.first_arrivals(Some(distances));
    let reached = arrivals.into_iter().zip(distances).map(|(first, distance)| {
        first.filter(|_| distance.is_finite()).map_or(NO_REGION, |first| first.source)
    });
    reached.collect()
}
