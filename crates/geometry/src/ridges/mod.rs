//! Finds ridges: the lines where wavefronts meet, which are the kinks of the map and the cut locus of its
//! sources.

mod fans;
mod kink;
mod rays;

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use rayon::prelude::*;

use super::chains::ways;
use super::{Curve, MapError};
use geosweep_surface::{Chart, Edge, EdgeLengths};
use kink::Segment;
use rays::ArrivingRays;

/// A line on which wavefronts from different directions meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Ridge {
    /// The line, which runs between free ends and junctions. Its direction has no meaning.
    pub curve: Curve,
    /// The angle between the wavefronts' directions at each vertex, in degrees. It is at most 180, where they
    /// meet head-on. At free ends it is at least `least_angle`; in between it may be somewhat less.
    pub angles: Vec<f64>,
}

/// The smallest angle at which a ridge continues, as a fraction of the least angle. The angles found on the
/// grid scatter, so a ridge whose angle is nearly constant would otherwise fall into pieces. Canny's edge
/// detector uses two thresholds in the same way.
const WEAK: f64 = 0.6;
/// The length, in cells, below which a line that stands alone or branches off is an artefact of the grid.
const SHORT: f64 = 4.0;

/// Computes the lines on which a converged map has a kink, since wavefronts meet there at an angle of at
/// least `least_angle` degrees.
///
/// Ridges are the borders between the regions of several sources and the cut locus of each source: behind holes
/// and hills, and between the parts of a curve. `edges` are the edge lengths of the surface.
///
/// The criterion is as follows. The direction at a grid point is that of the ray that arrives first across
/// the base of one of its triangles. Such a ray never crosses a kink. An edge has a kink if two conditions
/// hold for the directions at its two ends, in the metric between them: the angle between the directions is
/// at least the least angle, and the directions converge. If the ridge runs along the edge, it suffices that
/// the directions do not diverge. The kink lies where both wavefronts, continued straight from either end,
/// arrive at once.
///
/// Ridges run through triangles from one edge with a kink to another. If all three edges have a kink, the
/// ridges meet at the mean of the three places. Between places with the least angle, a ridge continues where
/// the angle is at least three fifths of it. Lines of less than four cells are left out.
///
/// Rays are those of circular wavefronts. At a distance of d cells beside a source curve, their directions
/// are off by up to 0.5 / d radians.
///
/// On a glued surface ridges pass seams. Such a ridge has two consecutive vertices that are the same place of the
/// surface ([`Curve::jumps`]). Directions are then compared in the triangles around the points, across seams and poles,
/// and not in the metric.
///
/// Below some 20 degrees discretisation errors begin to look like kinks, near sources first. Wavefronts that
/// meet at a single point, as in the middle of a circle, leave a star of a few cells.
///
/// # Errors
/// If the number of distances differs from the number of grid points, or the angle is not above 0 and up to 180 degrees.
///
/// ```
/// use geosweep::geometry::ridges;
/// use geosweep::surface::EdgeLengths;
/// use geosweep::{Options, Sources, Spacing, Surface, distance_map};
///
/// // Behind a wall, fronts meet that have come around it on both sides.
/// let mask: Vec<bool> = (0..61 * 61usize).map(|i| i / 61 != 20 || (i % 61).abs_diff(30) > 15).collect();
/// let surface = Surface::from_heights(61, 61, vec![0.0; 61 * 61], Spacing::square(1.0))?;
/// let surface = surface.with_mask(&mask)?;
/// let map = distance_map(&surface, &Sources::point(5.0, 30.0), &Options::default())?;
/// let ridges = ridges(&EdgeLengths::new(&surface)?, &map.distances, 30.0)?;
/// assert_eq!(ridges.len(), 1);
/// assert!(ridges[0].curve.vertices.iter().all(|at| at[0] > 20.0 && (at[1] - 30.0).abs() < 0.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn ridges(
    edges: &EdgeLengths<f32>,
    distances: &[f32],
    least_angle: f64,
) -> Result<Vec<Ridge>, MapError> {
    if !(least_angle > 0.0 && least_angle <= 180.0) {
        return Err(MapError::Angle(least_angle));
    }
    let chart = edges.chart();
    let rays = ArrivingRays::new(edges, distances)?;
    let cosine = (WEAK * least_angle).to_radians().cos();
    let rows = chart.rows_of_cells().into_par_iter();
    let found: Vec<Segment> = rows.flat_map_iter(|row| rays.march(row, cosine)).collect();
    let mut angles: BTreeMap<u64, f64> = BTreeMap::new();
    for (node, kink) in found.iter().flat_map(|(nodes, ends)| nodes.iter().zip(ends)) {
        // A node at a grid point belongs to several edges. It has the largest of their angles.
        let known = angles.entry(*node).or_insert(kink.angle);
        *known = known.max(kink.angle);
    }
    let places = places(&found);
    let segments = places.keys().copied().collect();
    let least = least_angle.to_radians();
    let segments = without_weak_ends(segments, |node| angles[&node] >= least);
    let length = |[a, b]: [u64; 2]| {
        let [from, to] = places[&[a.min(b), a.max(b)]];
        from.distance(to)
    };
    let ways = without_short_ways(segments, length);
    Ok(ways.into_iter().map(|way| ridge(chart, &way, &angles, &places)).collect())
}

/// The places of the two nodes of each segment. On a seam, a node has a place on each side.
type Places = BTreeMap<[u64; 2], [DVec2; 2]>;

/// Returns the places of all segments. A segment between two grid points is found twice, since there is a triangle on
/// either side. On a seam these are two different places, and the first is taken, so that a ridge along the seam stays
/// on one side.
fn places(found: &[Segment]) -> Places {
    let mut places = Places::new();
    for ([a, b], kinks) in found {
        let [from, to] = kinks.map(|kink| kink.place);
        let (nodes, ends) = if a <= b { ([*a, *b], [from, to]) } else { ([*b, *a], [to, from]) };
        let known = places.entry(nodes).or_insert(ends);
        let order = |ends: &[DVec2; 2]| ends.map(|end| end.to_array());
        if order(&ends) < order(known) {
            *known = ends;
        }
    }
    places
}

/// Returns the ridge along a polyline, given by its nodes.
fn ridge(chart: Chart, way: &[u64], angles: &BTreeMap<u64, f64>, places: &Places) -> Ridge {
    let closed = way.len() > 3 && way[0] == way[way.len() - 1];
    let (first, last) = (way[usize::from(closed)], way[way.len() - 1]);
    // If one of three ridges at the middle of a triangle has been removed, the other two are connected directly.
    let is_vertex = |node: u64| node == first || node == last || !is_of_triangle(chart, node);
    let mut ridge = Ridge { curve: Curve { vertices: Vec::new(), closed }, angles: Vec::new() };
    for pair in way.windows(2) {
        let [low, high] = places[&[pair[0].min(pair[1]), pair[0].max(pair[1])]];
        let ends = if pair[0] <= pair[1] { [low, high] } else { [high, low] };
        for (node, place) in pair.iter().zip(ends) {
            let (vertices, place) = (&mut ridge.curve.vertices, place.to_array());
            if is_vertex(*node) && vertices.last() != Some(&place) {
                vertices.push(place);
                ridge.angles.push(angles[node].to_degrees());
            }
        }
    }
    if closed && ridge.curve.vertices.first() == ridge.curve.vertices.last() {
        ridge.curve.vertices.remove(0);
        ridge.angles.remove(0);
    }
    ridge
}

/// The nodes at the other ends of the segments at each node.
type Neighbours = BTreeMap<u64, BTreeSet<u64>>;

fn neighbours(segments: &BTreeSet<[u64; 2]>) -> Neighbours {
    let mut neighbours = Neighbours::new();
    for &[a, b] in segments {
        neighbours.entry(a).or_default().insert(b);
        neighbours.entry(b).or_default().insert(a);
    }
    neighbours
}

/// Removes segments from free ends up to the first strong node, and components without a strong node.
fn without_weak_ends(
    mut segments: BTreeSet<[u64; 2]>,
    is_strong: impl Fn(u64) -> bool,
) -> BTreeSet<[u64; 2]> {
    let mut beside = neighbours(&segments);
    let is_weak_end = |beside: &Neighbours, node| beside[&node].len() == 1 && !is_strong(node);
    let mut ends: Vec<u64> =
        beside.keys().copied().filter(|&node| is_weak_end(&beside, node)).collect();
    while let Some(end) = ends.pop() {
        // If both ends of a segment are weak, the segment has been removed from its other end.
        let Some(inward) = beside.get_mut(&end).and_then(BTreeSet::pop_first) else { continue };
        segments.remove(&[end.min(inward), end.max(inward)]);
        beside.get_mut(&inward).expect("segments have two ends").remove(&end);
        if is_weak_end(&beside, inward) {
            ends.push(inward);
        }
    }
    let mut reached: BTreeSet<u64> = BTreeSet::new();
    let mut open: Vec<u64> = beside.keys().copied().filter(|&node| is_strong(node)).collect();
    while let Some(node) = open.pop() {
        if reached.insert(node) {
            open.extend(&beside[&node]);
        }
    }
    segments.retain(|[node, _]| reached.contains(node));
    segments
}

/// Joins segments into polylines and removes short ones. These are polylines with a free end, loops, and the
/// longer of two short polylines between the same nodes. The remaining polylines are joined. `of_segment` is the
/// length of a segment, in cells.
fn without_short_ways(
    mut segments: BTreeSet<[u64; 2]>,
    of_segment: impl Fn([u64; 2]) -> f64,
) -> Vec<Vec<u64>> {
    let length =
        |way: &[u64]| -> f64 { way.windows(2).map(|pair| of_segment([pair[0], pair[1]])).sum() };
    loop {
        let beside = neighbours(&segments);
        let mut found: Vec<_> = ways(&segments.iter().copied().collect::<Vec<_>>())
            .into_iter()
            .map(|way| (length(&way), way))
            .collect();
        found.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        // The pairs of nodes that short polylines connect, visited in order of length.
        let mut connected = BTreeSet::new();
        // At each node only one polyline is removed per pass, since two others may then join into a long one.
        let mut changed = BTreeSet::new();
        let count = segments.len();
        for (length, way) in &found {
            let (first, last) = (way[0], way[way.len() - 1]);
            let is_free = [first, last].iter().any(|end| beside[end].len() == 1);
            let is_short = if first == last {
                *length < 2.0 * SHORT
            } else {
                *length < SHORT
                    && (is_free || !connected.insert([first.min(last), first.max(last)]))
            };
            if is_short && !changed.contains(&first) && !changed.contains(&last) {
                changed.extend([first, last]);
                for pair in way.windows(2) {
                    segments.remove(&[pair[0].min(pair[1]), pair[0].max(pair[1])]);
                }
            }
        }
        if segments.len() == count {
            return ways(&segments.into_iter().collect::<Vec<_>>());
        }
    }
}

/// Returns whether a node is the middle of a triangle, and not on an edge or at a grid point.
fn is_of_triangle(chart: Chart, node: u64) -> bool {
    node.checked_sub(Edge::end(chart)).is_some_and(|number| number % 3 > 0)
}
