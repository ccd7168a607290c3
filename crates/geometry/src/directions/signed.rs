//! Gives distances from closed curves a sign: positive outside.
//!
//! The inside is where the curves wind around a point. The winding number is computed in the chart: along a row it
//! changes where a curve crosses the row. Curves on a glued surface may pass seams, and need not surround anything in
//! the chart. There a point lies inside if its shortest path meets the left side of the nearest curve.

use glam::DVec2;
use rayon::prelude::*;

use crate::MapError;
use crate::offset::Sides;
use geosweep_surface::{Chart, EdgeLengths, Real, Source, Sources, Surface, SurfaceError};

/// The reason why distances have no sign.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SignError {
    /// The surface has no edges.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The map does not belong to the surface and the sources.
    #[error(transparent)]
    Map(#[from] MapError),
    /// The number of distances or of entries of the mask differs from the number of grid points.
    #[error("{found} {what} do not fill a grid of {rows} x {cols} points")]
    Shape {
        /// The kind of the values: distances, or entries of the mask.
        what: &'static str,
        /// The number of the values.
        found: usize,
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        cols: usize,
    },
    /// A source is a point.
    #[error(
        "source {source_index} is a point, which has no inside; signed distances need closed curves, or a mask of the inside"
    )]
    Point {
        /// The index of the source, from 0.
        source_index: usize,
    },
    /// A curve is open.
    #[error(
        "source {source_index} is a curve from {},{} to {},{}; signed distances need closed curves, whose last vertex is the first, or a mask of the inside",
        ends[0][0], ends[0][1], ends[1][0], ends[1][1]
    )]
    Open {
        /// The index of the source, from 0.
        source_index: usize,
        /// Row and column of both ends.
        ends: [[f64; 2]; 2],
    },
    /// The curves do not agree on where the inside is.
    #[error(
        "the curves of sources {first} and {second} run in directions that contradict each other: by one, the inside of the other is outside; reverse one of them, or give a mask of the inside"
    )]
    Directions {
        /// The index of the first source, from 0.
        first: usize,
        /// The index of the second source.
        second: usize,
    },
    /// The curves do not divide a glued surface into an inside and an outside.
    #[error(
        "the curves do not divide the surface: their left and their right sides meet near row {row}, column {col}; reverse a curve, add one, or give a mask of the inside"
    )]
    Undivided {
        /// The row of a grid point beside which both sides meet.
        row: usize,
        /// The column of the point.
        col: usize,
    },
}

/// Returns the distances from closed curves with a sign, row-major: positive outside, negative inside. `distances` is
/// the map of these sources, as in [`geosweep_surface::DistanceMap::distances`]. At points that no source reaches, the
/// map and the result are +infinity.
///
/// The inside lies to the left of a curve, as seen in a picture of the grid with rows downwards: a curve that runs
/// counter-clockwise surrounds its inside. A clockwise curve within it is the border of a hole; a clockwise curve alone
/// surrounds the outside. Initial values stay included: only the sign changes.
///
/// On a glued surface curves may pass seams, and a curve that goes once around a tube is closed too. The inside is the
/// part of the surface on the left of the curves. They must divide the surface: one curve around a torus does not.
///
/// # Errors
/// If a source is a point or an open curve, the curves contradict one another or do not divide the surface, a source lies
/// off it, or the number of distances differs from the number of grid points.
///
/// ```
/// use geosweep::geometry::signed_distances;
/// use geosweep::{Options, Sources, Spacing, Surface, distance_map};
///
/// let surface = Surface::from_heights(21, 21, vec![0.0; 21 * 21], Spacing::square(1.0))?;
/// // Counter-clockwise: down, right, up, left.
/// let square = [[5.0, 5.0], [15.0, 5.0], [15.0, 15.0], [5.0, 15.0], [5.0, 5.0]];
/// let sources = Sources::curve(square);
/// let map = distance_map(&surface, &sources, &Options::default())?;
/// let signed = signed_distances(&surface, &sources, &map.distances)?;
/// assert!((signed[10 * 21 + 8] + 3.0).abs() < 1e-5);
/// assert!((signed[10 * 21 + 2] - 3.0).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn signed_distances<R: Real>(
    surface: &Surface,
    sources: &Sources,
    distances: &[R],
) -> Result<Vec<R>, SignError> {
    let chart = surface.chart();
    check(chart, "distances", distances.len())?;
    let curves = closed_curves(surface, sources)?;
    let inside = match surface.is_glued() {
        true => left_of_curves(surface, sources, distances)?,
        false => surrounded(chart, &curves, winding_outside(&curves)?),
    };
    Ok(signed(distances, &inside))
}

/// Returns the distances from the rings of polygons with a sign, row-major, as [`signed_distances`] does. A point lies
/// inside if any polygon holds it. Outer rings run counter-clockwise, and those of holes clockwise, as seen with rows
/// downwards. Polygons may adjoin, overlap or lie within one another.
///
/// # Errors
/// If a source is a point or an open curve, the rings do not divide a glued surface, a source lies off the surface, or the
/// number of distances differs from the number of grid points.
pub fn signed_distances_to_polygons<R: Real>(
    surface: &Surface,
    sources: &Sources,
    distances: &[R],
) -> Result<Vec<R>, SignError> {
    let chart = surface.chart();
    check(chart, "distances", distances.len())?;
    let curves = closed_curves(surface, sources)?;
    let inside = match surface.is_glued() {
        true => left_of_curves(surface, sources, distances)?,
        false => surrounded(chart, &curves, 0),
    };
    Ok(signed(distances, &inside))
}

/// Returns the vertices of each source, which must be a closed curve.
fn closed_curves<'a>(
    surface: &Surface,
    sources: &'a Sources,
) -> Result<Vec<&'a [DVec2]>, SignError> {
    let curve = |(source_index, source): (usize, &'a Source)| match source {
        Source::Point { .. } => Err(SignError::Point { source_index }),
        Source::Curve { vertices, .. } => match vertices[..] {
            [first, .., last] if !is_one_place(surface, vertices) => {
                let is_closed = match first == last {
                    true => vertices.len() >= 4 || surface.is_glued(),
                    false => surface.are_copies(first, last),
                };
                let ends = [first, last].map(|end| end.to_array());
                is_closed.then_some(&vertices[..]).ok_or(SignError::Open { source_index, ends })
            }
            _ => Err(SignError::Point { source_index }),
        },
    };
    sources.iter().enumerate().map(curve).collect()
}

/// Returns whether a curve has no more than one vertex, or only jumps from copy to copy of one place.
fn is_one_place(surface: &Surface, vertices: &[DVec2]) -> bool {
    let stays = |ends: &[DVec2]| surface.is_glued() && surface.are_copies(ends[0], ends[1]);
    vertices.windows(2).all(stays)
}

/// Returns whether the curves wind around each point of a chart more often than around the outside.
fn surrounded(chart: Chart, curves: &[&[DVec2]], outside: i32) -> Vec<bool> {
    let rows = (0..chart.rows).into_par_iter();
    let inside = rows.flat_map_iter(|row| {
        // Along a row, the winding number changes at the crossings to the left of a point.
        let mut crossings: Vec<(f64, i32)> =
            curves.iter().flat_map(|curve| crossings(curve, row as f64)).collect();
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut winding, mut next) = (0, 0);
        (0..chart.cols).map(move |col| {
            while let Some(&(_, change)) = crossings.get(next).filter(|(at, _)| *at < col as f64) {
                winding += change;
                next += 1;
            }
            winding > outside
        })
    });
    inside.collect()
}

/// Returns whether the shortest path of each point of a glued surface meets the left side of the nearest curve.
fn left_of_curves<R: Real>(
    surface: &Surface,
    sources: &Sources,
    distances: &[R],
) -> Result<Vec<bool>, SignError> {
    let edges = EdgeLengths::new(surface)?;
    let distances: Vec<f32> = distances.iter().map(|&distance| distance.wide() as f32).collect();
    let sides = Sides::new(surface, &edges, sources, &distances)?;
    match sides.meeting() {
        Some((row, col)) => Err(SignError::Undivided { row, col }),
        None => Ok(sides.are_left()),
    }
}

/// Returns distances with the sign of a mask, row-major: negative where `inside` is true, else positive. Points
/// that no source reaches are +infinity.
///
/// # Errors
/// If the number of distances or of entries of the mask differs from the number of grid points.
pub fn signed_distances_by_mask<R: Real>(
    chart: Chart,
    distances: &[R],
    inside: &[bool],
) -> Result<Vec<R>, SignError> {
    check(chart, "distances", distances.len())?;
    check(chart, "entries of the mask", inside.len())?;
    Ok(signed(distances, inside))
}

fn check(chart: Chart, what: &'static str, found: usize) -> Result<(), SignError> {
    let Chart { rows, cols } = chart;
    if found == chart.points() { Ok(()) } else { Err(SignError::Shape { what, found, rows, cols }) }
}

fn signed<R: Real>(distances: &[R], inside: &[bool]) -> Vec<R> {
    let sign = |(&distance, &inside): (&R, &bool)| match inside {
        true if distance.is_finite() && distance != R::zero() => -distance,
        _ => distance,
    };
    distances.iter().zip(inside).map(sign).collect()
}

/// Returns the crossings of a curve with the line just below a row, and the changes of the winding number there from
/// left to right: 1 where the curve runs downwards.
fn crossings(curve: &[DVec2], row: f64) -> impl Iterator<Item = (f64, i32)> {
    curve.windows(2).filter_map(move |ends| {
        let [a, b] = [ends[0], ends[1]];
        let is_below = |end: DVec2| end.x > row;
        (is_below(a) != is_below(b)).then(|| {
            let share = (row - a.x) / (b.x - a.x);
            (a.y + share * (b.y - a.y), if is_below(b) { 1 } else { -1 })
        })
    })
}

/// Returns the winding number at a place.
fn winding(curve: &[DVec2], at: DVec2) -> i32 {
    crossings(curve, at.x).filter(|(col, _)| *col < at.y).map(|(_, change)| change).sum()
}

/// Returns the winding number on the right side of all curves.
fn winding_outside(curves: &[&[DVec2]]) -> Result<i32, SignError> {
    let mut found: Option<(usize, i32)> = None;
    for (index, curve) in curves.iter().enumerate() {
        let others = curves.iter().enumerate().filter(|(other, _)| *other != index);
        let around: i32 = others.map(|(_, other)| winding(other, curve[0])).sum();
        // A clockwise curve has winding number -1 on its right side, which it surrounds.
        let right = around - i32::from(area(curve) < 0.0);
        match found {
            Some((first, outside)) if outside != right => {
                return Err(SignError::Directions { first, second: index });
            }
            _ => found = found.or(Some((index, right))),
        }
    }
    Ok(found.map_or(0, |(_, outside)| outside))
}

/// Returns the area that a curve surrounds, positive if it runs counter-clockwise as seen with rows downwards.
fn area(curve: &[DVec2]) -> f64 {
    curve.windows(2).map(|ends| 0.5 * ends[0].perp_dot(ends[1])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geosweep_surface::Spacing;

    const CHART: Chart = Chart { rows: 11, cols: 11 };

    fn plane() -> Surface {
        Surface::from_heights(11, 11, vec![0.0; 121], Spacing::square(1.0)).unwrap()
    }

    fn square(low: f64, high: f64, clockwise: bool) -> Vec<[f64; 2]> {
        let mut square = vec![[low, low], [high, low], [high, high], [low, high], [low, low]];
        if clockwise {
            square.reverse();
        }
        square
    }

    fn inside(curves: &[Vec<[f64; 2]>]) -> Result<Vec<bool>, SignError> {
        let curve = |curve: &Vec<[f64; 2]>| Source::Curve {
            vertices: curve.iter().map(|&at| at.into()).collect(),
            initial: 0.0,
        };
        let sources: Sources = curves.iter().map(curve).collect();
        let signed = signed_distances(&plane(), &sources, &[1.0f32; 121])?;
        Ok(signed.into_iter().map(|distance| distance < 0.0).collect())
    }

    fn count(inside: &[bool]) -> usize {
        inside.iter().filter(|inside| **inside).count()
    }

    #[test]
    fn a_counter_clockwise_curve_surrounds_its_inside_and_a_clockwise_one_its_outside() {
        let (left, right) = (square(2.5, 7.5, false), square(2.5, 7.5, true));
        let within = inside(&[left]).unwrap();
        assert!(within[5 * 11 + 5] && !within[0] && !within[5 * 11 + 9]);
        assert_eq!(count(&within), 25);
        let without = inside(&[right]).unwrap();
        assert!(within.iter().zip(&without).all(|(a, b)| a != b));
    }

    #[test]
    fn a_clockwise_curve_within_is_a_hole() {
        let ring = inside(&[square(1.5, 8.5, false), square(3.5, 6.5, true)]).unwrap();
        assert_eq!(count(&ring), 49 - 9);
        // A curve between grid points surrounds none of them, whatever its direction.
        assert_eq!(count(&inside(&[square(2.2, 2.8, false)]).unwrap()), 0);
        assert_eq!(count(&inside(&[square(2.2, 2.8, true)]).unwrap()), 121);
    }

    #[test]
    fn polygons_may_adjoin_overlap_and_lie_within_one_another() {
        let inside = |curves: &[Vec<[f64; 2]>]| {
            let curve = |curve: &Vec<[f64; 2]>| Source::Curve {
                vertices: curve.iter().map(|&at| at.into()).collect(),
                initial: 0.0,
            };
            let sources: Sources = curves.iter().map(curve).collect();
            let signed = signed_distances_to_polygons(&plane(), &sources, &[1.0f32; 121]).unwrap();
            signed.into_iter().map(|distance| distance < 0.0).collect::<Vec<_>>()
        };
        let (whole, within) = (square(1.5, 8.5, false), square(3.5, 6.5, false));
        assert_eq!(count(&inside(&[whole.clone(), within.clone()])), 49);
        assert_eq!(count(&inside(&[whole.clone(), square(3.5, 6.5, true), within])), 49);
        let beside: Vec<_> = square(1.5, 8.5, false).iter().map(|[r, c]| [*r, c + 1.0]).collect();
        assert_eq!(count(&inside(&[whole, beside])), 7 * 8);
    }

    #[test]
    fn contradictions_and_open_curves_are_refused() {
        let both = [square(1.5, 8.5, false), square(3.5, 6.5, false)];
        assert_eq!(inside(&both), Err(SignError::Directions { first: 0, second: 1 }));
        let open = vec![[1.0, 1.0], [5.0, 1.0], [5.0, 5.0], [1.0, 5.0]];
        let ends = [[1.0, 1.0], [1.0, 5.0]];
        assert_eq!(inside(&[open]), Err(SignError::Open { source_index: 0, ends }));
        let point = Sources::point(1.0, 1.0);
        let found = signed_distances(&plane(), &point, &[1.0f32; 121]);
        assert_eq!(found, Err(SignError::Point { source_index: 0 }));
        assert!(signed_distances(&plane(), &point, &[1.0f32; 12]).is_err());
        assert!(signed_distances_by_mask(CHART, &[1.0f32; 121], &[true; 12]).is_err());
    }
}
