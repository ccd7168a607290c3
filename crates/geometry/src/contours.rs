//! Computes contours, curves of equal distance, by marching triangles in the parameter domain (paper, section
//! 6.3).

use rayon::prelude::*;

use super::Curve;
use super::arrivals::Arrivals;
use super::chains::{Segment, join};
use super::crest;
use geosweep_surface::shown::exact;
use geosweep_surface::{Chart, Edge, triangles};
use geosweep_surface::{DistanceMap, Sources};

/// The levels of contours.
#[derive(Clone, Debug, PartialEq)]
pub enum Levels {
    /// The given distances.
    List(Vec<f64>),
    /// The given number of levels, equally spaced between the smallest initial value of the sources and the largest
    /// distance.
    Count(usize),
    /// All multiples of the given distance beyond the smallest initial value of the sources.
    Spacing(f64),
}

/// The reason why levels are not usable.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LevelError {
    /// A level is NaN or infinite.
    #[error("contour level {0} is not finite")]
    NotFinite(f64),
    /// The spacing is zero, negative or not finite.
    #[error("contours {} apart cannot be drawn; the spacing must be positive and finite", exact(*.0))]
    Spacing(f64),
    /// There are too many levels.
    #[error("{} contour levels are too many; the limit is {MOST_LEVELS}", exact(.0.round()))]
    TooMany(f64),
}

/// The largest number of levels in one call.
pub const MOST_LEVELS: usize = 65_535;

impl Levels {
    /// Returns the levels on the map `map` of `sources`, in ascending order and without duplicates.
    ///
    /// # Errors
    /// If a level or the spacing is not usable, or there would be more than [`MOST_LEVELS`].
    pub fn on(&self, map: &DistanceMap, sources: &Sources) -> Result<Vec<f64>, LevelError> {
        let (low, high) = (sources.start(), map.report.max_distance);
        let too_many = |count: f64| {
            if count > MOST_LEVELS as f64 { Err(LevelError::TooMany(count)) } else { Ok(()) }
        };
        let mut levels = match self {
            Self::List(levels) => {
                if let Some(level) = levels.iter().find(|level| !level.is_finite()) {
                    return Err(LevelError::NotFinite(*level));
                }
                too_many(levels.len() as f64)?;
                levels.clone()
            }
            Self::Count(count) => {
                too_many(*count as f64)?;
                let step = (high - low) / (*count as f64 + 1.0);
                (1..=*count).map(|k| low + k as f64 * step).collect()
            }
            Self::Spacing(step) => {
                if !(*step > 0.0 && step.is_finite()) {
                    return Err(LevelError::Spacing(*step));
                }
                // The largest distance is included if it is a multiple up to rounding.
                let top = high + crest::rounding(low, high);
                let (first, last) = ((low / step).floor() + 1.0, (top / step).floor());
                too_many(last - first + 1.0)?;
                (first as i64..=last as i64).map(|k| k as f64 * step).collect()
            }
        };
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        Ok(levels)
    }
}

/// The contour of one level.
#[derive(Clone, Debug, PartialEq)]
pub struct Contour {
    /// The distance.
    pub level: f64,
    /// The curves of the contour. Each is either closed, or open with its ends at the surface's border, at a
    /// hole or at the limit of the map. On a closed surface, curves end on both sides of each seam;
    /// [`join_over_seams`](super::join_over_seams) joins them there.
    ///
    /// Nearer points lie to the left of each curve, as seen in a picture of the grid with rows downwards.
    /// Curves around the source run counter-clockwise.
    pub curves: Vec<Curve>,
}

/// Computes the contours of a map at the given levels, in the order of `levels`; see [`Levels::on`]. A level
/// below the smallest initial value of the sources or above the largest distance has no curves.
///
/// Vertices lie on the grid's lines and on diagonals of cells. Along an edge, the square of the distance since the
/// smallest initial value is interpolated by a cubic through four points in line. On circles in the plane this is
/// exact, however close to the source. Where wavefronts meet, the curve has a corner, and a straight segment inside a
/// triangle cuts this corner off.
///
/// A contour that passes between grid points without separating any of them is not found, for example around
/// a source inside a cell. Curves at the largest distance connect the grid points that have this distance up
/// to rounding, for example along a border that is equally far everywhere. A single such point makes no
/// curve.
///
/// ```
/// use geosweep::geometry::{Levels, contours};
/// use geosweep::{Options, Sources, Spacing, Surface, distance_map};
///
/// let surface = Surface::from_heights(65, 65, vec![0.0; 65 * 65], Spacing::square(1.0))?;
/// let sources = Sources::point(32.0, 32.0);
/// let map = distance_map(&surface, &sources, &Options::default())?;
/// let levels = Levels::Spacing(10.0).on(&map, &sources)?;
/// let circles = contours(&map, &sources, &levels);
/// assert_eq!((circles.len(), circles[1].level, circles[1].curves.len()), (4, 20.0, 1));
/// for vertex in &circles[1].curves[0].vertices {
///     assert!(((vertex[0] - 32.0).hypot(vertex[1] - 32.0) - 20.0).abs() < 1e-3);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn contours(map: &DistanceMap, sources: &Sources, levels: &[f64]) -> Vec<Contour> {
    let mut ascending = levels.to_vec();
    ascending.sort_by(f64::total_cmp);
    ascending.dedup();
    let arrivals = Arrivals::new(map, sources.start());
    let time = |index| f64::from(arrivals.time(index));
    let segments = march(map.chart, time, &ascending);
    let curves = join(segments, |level, node| {
        let (first, to) = Edge::from_number(node).ends(map.chart);
        let s = arrivals.crossing(first, to, ascending[level as usize]);
        let step = to.vector();
        [first.0 as f64 + s * step.x, first.1 as f64 + s * step.y]
    });
    let mut by_level = vec![Vec::new(); ascending.len()];
    for (level, curve) in curves {
        by_level[level as usize].push(curve);
    }
    let largest = map.report.max_distance;
    let rounding = crest::rounding(sources.start(), largest);
    for (level, found) in ascending.iter().zip(&mut by_level) {
        if (level - largest).abs() <= rounding {
            let crest = crest::curves(&arrivals, largest - rounding);
            if !crest.is_empty() {
                *found = crest;
            }
        }
    }
    let of_level = |&level: &f64| {
        let found = ascending.binary_search_by(|other| other.total_cmp(&level));
        let curves = found.map(|index| by_level[index].clone()).unwrap_or_default();
        Contour { level, curves }
    };
    levels.iter().map(of_level).collect()
}

/// Returns the segments of all levels in all triangles, given the value at each grid point. Keys are the indices of the
/// levels. Points whose value is not finite are missing.
pub(super) fn march(
    chart: Chart,
    value: impl Fn(usize) -> f64 + Sync,
    levels: &[f64],
) -> Vec<Segment<u32>> {
    const MISSING: u32 = u32::MAX;
    // The number of levels that are at most the value at the point.
    let passed = |index: usize| {
        let value = value(index);
        if !value.is_finite() {
            return MISSING;
        }
        levels.partition_point(|&level| level <= value) as u32
    };
    let passed: Vec<u32> =
        (0..chart.points()).into_par_iter().with_min_len(4096).map(passed).collect();
    let row_of_cells = |row: usize| {
        let mut segments = Vec::new();
        for cell in chart.cells_of_row(row) {
            let corners = cell.indices(chart);
            let counts = corners.map(|index| passed[index]);
            if counts == [counts[0]; 4] {
                continue;
            }
            let there = counts.map(|count| count != MISSING);
            let values = corners.map(&value);
            // The cell is split along the diagonal with the larger change of the values, so that curves cross the
            // diagonal.
            let falling = (values[0] - values[3]).abs() >= (values[1] - values[2]).abs();
            for triangle in triangles(there, falling) {
                march_triangle(triangle, &counts, |level, out, back| {
                    let edge =
                        |[a, b]: [usize; 2]| Edge::between(chart, corners[a], corners[b]).number();
                    segments.push(Segment { key: level, from: edge(out), to: edge(back) });
                });
            }
        }
        segments
    };
    chart.rows_of_cells().into_par_iter().flat_map_iter(row_of_cells).collect()
}

/// Calls `found` for each level whose contour crosses the triangle, with the index of the level and two edges. Along
/// the boundary, in the order of the corners, the first edge leaves the part nearer than the level, and the second edge
/// returns to this part.
fn march_triangle(
    triangle: &[usize; 3],
    counts: &[u32; 4],
    mut found: impl FnMut(u32, [usize; 2], [usize; 2]),
) {
    let [a, b, c] = triangle.map(|corner| counts[corner]);
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    for level in low..high {
        let nearer = |corner: usize| counts[corner] <= level;
        let edges = [0, 1, 2].map(|k| [triangle[k], triangle[(k + 1) % 3]]);
        let find =
            |from: bool| edges.into_iter().find(|[p, q]| nearer(*p) == from && nearer(*q) != from);
        if let (Some(out), Some(back)) = (find(true), find(false)) {
            found(level, out, back);
        }
    }
}
