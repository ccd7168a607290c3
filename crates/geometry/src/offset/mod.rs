//! Computes offset curves: the points at a given distance on one side of a curve (paper, figure 7).

mod line;
mod sides;

use super::{Contour, Curve, MapError, contours, join_over_seams};
use geosweep_surface::{DistanceMap, Surface};
use geosweep_surface::{EdgeLengths, Source, Sources};
pub(super) use sides::Sides;

/// A side of a directed curve, as seen in a picture of the grid with rows downwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The left side: north of a curve that runs eastwards.
    Left,
    /// The right side: south of a curve that runs eastwards.
    Right,
}

impl Side {
    /// Returns the name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

impl std::fmt::Display for Side {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// The reason why offset curves cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OffsetError {
    /// The map does not belong to the surface and the sources.
    #[error(transparent)]
    Map(#[from] MapError),
    /// A source is a point and has no sides.
    #[error(
        "source {source_index} is a point, which has no left and right side; offsets on one side need curves"
    )]
    NoSides {
        /// The index of the source, from 0.
        source_index: usize,
    },
}

/// Computes the curves at the given distances on one side of the sources. The sources must be curves, open or
/// closed. The result is in the order of `levels`, which are values of the map.
///
/// `map` is the map of these sources on this surface, with converged values of any engine. The offset curves
/// are its [`contours`], cut where the side changes. For both sides, take the contours themselves.
///
/// A point is on the side on which its shortest path meets the nearest source. Around an open end the two
/// sides meet on the prolongation of the curve, so each side has a quarter of a circle there. Offsets less
/// than a cell away from the curve have gaps.
///
/// On a glued surface, offset curves go on over seams ([`join_over_seams`]). Where a seam turns the grid over, as on a
/// Moebius strip, the left side is defined at the curve's first vertex and followed along the curve.
///
/// # Errors
/// If a source is a point or lies off the surface, or the map has another size than
/// the surface.
///
/// # Panics
/// If `edges` belong to a surface of another size.
///
/// ```
/// use geosweep::geometry::{Side, offset_curves};
/// use geosweep::surface::EdgeLengths;
/// use geosweep::{Options, Sources, Spacing, Surface, distance_map};
///
/// let surface = Surface::from_heights(41, 61, vec![0.0; 41 * 61], Spacing::square(1.0))?;
/// // From west to east, so that north is on its left.
/// let sources = Sources::curve([[20.0, 15.0], [20.0, 45.0]]);
/// let map = distance_map(&surface, &sources, &Options::default())?;
/// let edges = EdgeLengths::new(&surface)?;
/// let offsets = offset_curves(&surface, &edges, &sources, &map, &[8.0], Side::Left)?;
/// let [curve] = &offsets[0].curves[..] else { panic!("one line between two quarters") };
/// let exact = 30.0 + std::f64::consts::PI * 8.0;
/// assert!((curve.length(&surface)? - exact).abs() < 0.02 * exact);
/// assert!(curve.vertices.iter().all(|at| at[0] < 20.1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn offset_curves(
    surface: &Surface,
    edges: &EdgeLengths<f32>,
    sources: &Sources,
    map: &DistanceMap,
    levels: &[f64],
    side: Side,
) -> Result<Vec<Contour>, OffsetError> {
    assert_eq!(edges.chart(), surface.chart(), "the edges are another surface's");
    let is_curve = |source: &Source| match source {
        Source::Point { .. } => false,
        Source::Curve { vertices, .. } => vertices.iter().any(|v| *v != vertices[0]),
    };
    if let Some(source_index) = sources.iter().position(|source| !is_curve(source)) {
        return Err(OffsetError::NoSides { source_index });
    }
    let sides = Sides::new(surface, edges, sources, &map.distances)?;
    let sign = if side == Side::Left { 1.0 } else { -1.0 };
    let cut = |contour: Contour| {
        let pieces = contour.curves.iter().flat_map(|curve| {
            let sides: Vec<f64> =
                curve.vertices.iter().map(|&at| sign * side_at(&sides, at)).collect();
            cut(curve, &sides)
        });
        Contour { level: contour.level, curves: join_over_seams(pieces.collect(), surface) }
    };
    Ok(contours(map, sources, levels).into_iter().map(cut).collect())
}

/// Returns the side at a vertex of a contour. The vertex lies on an edge between two grid points.
fn side_at(sides: &Sides, [row, col]: [f64; 2]) -> f64 {
    let (down, right) = (row.fract(), col.fract());
    let (row, col) = (row as usize, col as usize);
    let (next_row, next_col) = (row + usize::from(down > 0.0), col + usize::from(right > 0.0));
    // On a rising diagonal the fractions of row and column add up to one; on a falling diagonal they are
    // equal.
    if down > 0.0 && right > 0.0 && (down - right).abs() > (down + right - 1.0).abs() {
        return sides.on_edge([(row, next_col), (next_row, col)], down);
    }
    sides.on_edge([(row, col), (next_row, next_col)], down.max(right))
}

/// Returns the parts of a curve on which `side` is positive. Each part ends where `side`, linear between
/// vertices, becomes zero.
fn cut(curve: &Curve, side: &[f64]) -> Vec<Curve> {
    let count = curve.vertices.len();
    let on = |k: usize| side[k % count] > 0.0;
    if (0..count).all(on) {
        return vec![curve.clone()];
    }
    // A closed curve is opened at a vertex on the other side.
    let first = if curve.closed { (0..count).find(|&k| !on(k)).unwrap_or(0) } else { 0 };
    let last = if curve.closed { first + count } else { count - 1 };
    let place = |k: usize| curve.vertices[k % count];
    let crossing = |k: usize| {
        let (a, b) = (side[k % count], side[(k + 1) % count]);
        let share = if (a - b).is_normal() { a / (a - b) } else { 0.5 };
        let (from, to) = (place(k), place(k + 1));
        [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
    };
    let (mut pieces, mut vertices) = (Vec::new(), Vec::new());
    for k in first..=last {
        if on(k) {
            vertices.push(place(k));
        }
        if k < last && on(k) != on(k + 1) {
            vertices.push(crossing(k));
        }
        if !vertices.is_empty() && (k == last || !on(k + 1)) {
            pieces.push(Curve { vertices: std::mem::take(&mut vertices), closed: false });
        }
    }
    pieces.retain(|piece| piece.vertices.len() > 1);
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_cut_where_the_side_changes() {
        let vertices: Vec<_> = (0..4).map(|k| [f64::from(k), 0.0]).collect();
        let rows = |side: &[f64], closed| {
            let curve = Curve { vertices: vertices.clone(), closed };
            let pieces = cut(&curve, side);
            pieces.into_iter().map(|piece| piece.vertices.iter().map(|v| v[0]).collect()).collect()
        };
        let whole: Vec<Vec<f64>> = rows(&[1.0; 4], false);
        assert_eq!(whole, [[0.0, 1.0, 2.0, 3.0]]);
        assert_eq!(rows(&[-1.0; 4], true), Vec::<Vec<f64>>::new());
        assert_eq!(rows(&[1.0, -1.0, -1.0, 3.0], false), [[0.0, 0.5], [2.25, 3.0]]);
        assert_eq!(rows(&[1.0, -1.0, -1.0, 3.0], true), [[2.25, 3.0, 0.0, 0.5]]);
        assert_eq!(rows(&[-1.0, 1.0, -3.0, -1.0], true), [[0.5, 1.0, 1.25]]);
    }
}
