//! Computes the map of each source alone, on surfaces with skewed cells and around holes of planes.
//!
//! Where the points that split obtuse triangles are not neighbours, regions are narrower than cells, and the fronts of
//! several sources cannot be told apart point by point. Around the holes of a plane, a front followed from point to point
//! is that of a circle around its source, up to a quarter of a cell late beside the hole. The map of each source alone
//! tells its times exactly.

use rayon::prelude::*;

use super::known::NO_REGION;
use geosweep_cpu::{rotated_scan, seeds_for};
use geosweep_surface::update::{EngineKind, Setting, SourceKind, Wavefront};
use geosweep_surface::{EdgeLengths, Sources, Stop, Surface};

/// Maximum number of sources whose own maps are computed for the sake of holes alone.
const FEW: usize = 8;
/// Maximum number of times in all maps together; 256 MiB.
const MOST_TIMES: usize = 1 << 26;
/// The precision of a map by default.
const STOP: Stop = Stop::within(1e-6).or_after(1000);

/// The map of each source alone, row-major.
pub(super) struct OwnMaps(Vec<Vec<f32>>);

impl OwnMaps {
    /// Returns `None` where fronts can be followed from point to point, on glued surfaces, and if the maps would take
    /// too much memory. `is_even` tells whether all cells are alike.
    pub(super) fn new(
        surface: &Surface,
        edges: &EdgeLengths<f32>,
        sources: &Sources,
        is_even: bool,
    ) -> Option<Self> {
        let count = sources.iter().count();
        let is_small = count * surface.chart().points() <= MOST_TIMES;
        let is_needed = || is_even && count <= FEW || surface.has_skewed_cells(1);
        if surface.is_glued() || !is_small || !is_needed() {
            return None;
        }
        let all: Vec<_> =
            sources.iter().map(|source| Sources::from_iter([source.clone()])).collect();
        let map = |source: &Sources| {
            let setting = Setting::new(surface, SourceKind::of(source), EngineKind::Map);
            let wavefront = Wavefront::chosen(setting);
            let seeds = source.seeds_with_origins(surface).ok()?;
            let seeds = seeds_for(wavefront, surface, seeds);
            Some(rotated_scan(edges, &seeds, wavefront, STOP).distances())
        };
        Some(Self(all.par_iter().map(map).collect::<Option<_>>()?))
    }

    /// Returns the first source to reach each point of a map, row-major.
    pub(super) fn labels(&self, distances: &[f32]) -> Vec<u32> {
        let first = |(index, distance): (usize, &f32)| {
            let arrivals = self.0.iter().map(|map| map[index]).zip(0..);
            let first = arrivals.min_by(|a: &(f32, u32), b| a.0.total_cmp(&b.0));
            match first {
                Some((time, label)) if distance.is_finite() && time.is_finite() => label,
                _ => NO_REGION,
            }
        };
        distances.par_iter().enumerate().map(first).collect()
    }

    /// Returns the arrival time of a source's front at a grid point, if it arrives there.
    pub(super) fn time(&self, index: usize, label: u32) -> Option<f64> {
        let time = self.0[label as usize][index];
        time.is_finite().then_some(f64::from(time))
    }
}
