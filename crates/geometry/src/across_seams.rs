//! Joins curves over the seams of closed surfaces.

use std::collections::HashMap;

use glam::DVec2;

use super::Curve;
use geosweep_surface::Surface;

/// The distance, in cells, up to which ends of curves on two sides of a seam are the same place. The crossings of a
/// level are computed from values on both sides that may differ by rounding. On grids of 10,000 points a side, rounding
/// moves them by a thousandth of a cell.
const SAME: f64 = 2e-3;

/// One end of a curve: its index, and whether it is the last vertex.
type End = (usize, bool);

/// Joins open curves whose ends are the same place of a closed surface, such as contours, which end on both sides of
/// each seam. Curves that return to their start are closed. The other curves stay in order.
///
/// Each joined curve has the direction of its first part. On a one-sided surface, parts beyond a seam may be reversed.
///
/// ```
/// use std::f64::consts::TAU;
/// use geosweep::geometry::{contours, join_over_seams};
/// use geosweep::glam::DVec3;
/// use geosweep::surface::Gluing;
/// use geosweep::{Options, Sources, Surface, distance_map};
/// // A tube of radius 1. A circle around a source on its seam is closed, on the surface.
/// let angle = |index: usize| TAU * (index % 65) as f64 / 64.0;
/// let point = |index| DVec3::new(angle(index).cos(), angle(index).sin(), (index / 65) as f64 / 10.0);
/// let tube = Surface::from_positions(33, 65, (0..33 * 65).map(point).collect())?
///     .with_gluing(Gluing::columns())?;
/// let sources = Sources::point(16.0, 0.0);
/// let map = distance_map(&tube, &sources, &Options::default())?;
/// let halves = contours(&map, &sources, &[1.0]).remove(0).curves;
/// let whole = join_over_seams(halves.clone(), &tube);
/// assert_eq!((halves.len(), whole.len(), whole[0].closed), (2, 1, true));
/// assert!((whole[0].length(&tube)? - TAU).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn join_over_seams(curves: Vec<Curve>, surface: &Surface) -> Vec<Curve> {
    if !surface.is_glued() {
        return curves;
    }
    let partners = partners(&curves, surface);
    let mut taken = vec![false; curves.len()];
    let mut joined = Vec::new();
    let has_free_end = |index: usize| {
        let is_free = |end| !partners.contains_key(&(index, end));
        curves[index].closed || is_free(false) || is_free(true)
    };
    // Chains with free ends come first, since a chain that is entered in its middle would lose its beginning.
    let mut starts: Vec<usize> = (0..curves.len()).filter(|&index| has_free_end(index)).collect();
    starts.extend((0..curves.len()).filter(|&index| !has_free_end(index)));
    for start in starts {
        if taken[start] {
            continue;
        }
        // A chain begins at a free end, and follows the curve there forwards or backwards.
        let is_forward =
            !partners.contains_key(&(start, false)) || partners.contains_key(&(start, true));
        let (mut vertices, mut at) = (Vec::new(), (start, is_forward));
        let closed = loop {
            let (index, is_forward) = at;
            taken[index] = true;
            let part = curves[index].vertices.iter().copied();
            if is_forward {
                vertices.extend(part)
            } else {
                vertices.extend(part.rev())
            }
            match partners.get(&(index, is_forward)) {
                Some(&(next, _)) if next == start => break true,
                Some(&(next, is_last)) if !taken[next] => at = (next, !is_last),
                _ => break curves[start].closed,
            }
        };
        if !is_forward {
            vertices.reverse();
        }
        joined.push((start, Curve { vertices, closed }));
    }
    joined.sort_by_key(|(start, _)| *start);
    joined.into_iter().map(|(_, curve)| curve).collect()
}

/// Finds which ends of open curves are the same place.
fn partners(curves: &[Curve], surface: &Surface) -> HashMap<End, End> {
    let rounded = |at: DVec2| [at.x, at.y].map(|x| x.round() as i64);
    let mut ends: HashMap<[i64; 2], Vec<(End, DVec2)>> = HashMap::new();
    for (index, curve) in curves.iter().enumerate().filter(|(_, curve)| !curve.closed) {
        for (is_last, vertex) in [(false, curve.vertices.first()), (true, curve.vertices.last())] {
            let Some(&vertex) = vertex else { continue };
            let at = DVec2::from(vertex);
            ends.entry(rounded(at)).or_default().push(((index, is_last), at));
        }
    }
    let mut partners = HashMap::new();
    let mut all: Vec<(End, DVec2)> = ends.values().flatten().copied().collect();
    all.sort_by_key(|(end, _)| *end);
    for (end, at) in all {
        if partners.contains_key(&end) {
            continue;
        }
        let near = |copy: DVec2| {
            // A place halfway between two grid points may be rounded to either.
            let around = [DVec2::ZERO, DVec2::X, -DVec2::X, DVec2::Y, -DVec2::Y];
            let cells = around.map(|by| rounded(copy + 2.0 * SAME * by));
            let found = cells.into_iter().filter_map(|cell| ends.get(&cell)).flatten();
            found.map(move |(other, at)| (at.distance(copy), *other))
        };
        let copies = surface.copies_of(at).into_iter().filter(|copy| *copy != at);
        let is_free = |&(apart, other): &(f64, End)| {
            apart <= SAME && other != end && !partners.contains_key(&other)
        };
        let nearest = copies.flat_map(near).filter(is_free).min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, other)) = nearest {
            partners.insert(end, other);
            partners.insert(other, end);
        }
    }
    partners
}
