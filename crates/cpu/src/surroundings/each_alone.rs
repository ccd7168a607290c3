//! Solves the whole map of each source alone, on surfaces with skewed cells.
//!
//! The points that split obtuse triangles lie so far away there that the base between them has fronts of several sources
//! at its ends anywhere, and not just near the border between two regions. Maps of several sources would be up to 60 %
//! late and 20 % early, where those of each source alone are within a few ten-thousandths. Where cells are all alike and
//! no point is missing, straight lines are these maps.

use rayon::prelude::*;

use super::around::arrived;
use super::straight::origins;
use super::{NEAR, seeds_for};
use crate::fronts::for_triangle_kind;
use geosweep_surface::update::Wavefront;
use geosweep_surface::{EdgeLengths, Origin, Seed, Sources, Stop, Surface};

/// Maximum number of sources that are solved alone.
const MOST: usize = 32;
/// Maximum number of points of their maps together.
const MOST_POINTS: usize = 1 << 25;
/// A tenth of the tolerance of a map in single precision.
const STOP: Stop = Stop::within(1e-7).or_after(1000);

/// Returns exact seeds at all points that point sources reach, from their maps. The result is `None` where fronts are told
/// apart otherwise, for one source and for too many, and if some seeds come from no known origin.
pub(super) fn each_alone(
    wavefront: Wavefront,
    surface: &Surface,
    seeds: &[Seed],
) -> Option<Vec<Seed>> {
    let sources = origins(seeds);
    let are_known = seeds.iter().all(|seed| seed.origin.is_some());
    if sources.len() < 2 || !are_known || surface.is_glued() || !surface.has_skewed_cells(NEAR) {
        return None;
    }
    let points = sources.len() * surface.chart().points();
    let are_points = sources.iter().all(Origin::is_point);
    if !are_points || sources.len() > MOST || points > MOST_POINTS {
        return None;
    }
    let edges = EdgeLengths::<f64>::new(surface).ok()?;
    let map = |origin: &Origin| {
        let at = origin.ends[0];
        let own = Sources::default().and_point(at.x, at.y, origin.start);
        let own = seeds_for(wavefront, surface, own.seeds_with_origins(surface).ok()?);
        let places = surface.chart().places();
        Some(for_triangle_kind!(&edges, wavefront, kind => {
            arrived(&edges, kind, &own, STOP, places)
        }))
    };
    let maps: Vec<Vec<Seed>> = sources.par_iter().map(map).collect::<Option<_>>()?;
    let all = maps.into_iter().flatten().map(|seed| Seed { exact: true, ..seed });
    Some(Seed::earliest(all))
}
