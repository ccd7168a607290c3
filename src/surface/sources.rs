//! Sources: where the wavefront starts, and the initial values that this gives at grid points.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, DVec3};

use super::Surface;
use super::geometry::Sample;

/// One source. Rows and columns may be fractional and count from 0.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// A point, anywhere on the grid or inside a cell.
    Point {
        /// Row and column.
        at: DVec2,
        /// Arrival time at the source itself.
        initial: f64,
    },
    /// A polyline over the grid: every point of it is a source.
    Curve {
        /// Rows and columns of the vertices; the last may repeat the first.
        vertices: Vec<DVec2>,
        /// Arrival time along the curve.
        initial: f64,
    },
}

/// The sources of one distance map: the distance to the nearest of them, initial values
/// included, is what the map holds.
///
/// ```
/// use geosweep::Sources;
/// let sources = Sources::point(10.0, 20.5).and_point(3.0, 4.0, 7.5);
/// assert_eq!(sources.iter().count(), 2);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sources(Vec<Source>);

/// An initial value at a grid point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seed {
    /// Row of the point.
    pub row: usize,
    /// Column of the point.
    pub col: usize,
    /// Arrival time there.
    pub time: f64,
    /// Curvature of the front there, for the curved wavefront: 1 over the distance from a point
    /// source, [`Seed::AT_SOURCE`] at the source itself, 0 beside a straight curve.
    pub curvature: f64,
}

impl Seed {
    /// Curvature of a front at its point source: as good as infinite.
    pub const AT_SOURCE: f64 = crate::constants::SOURCE_CURVATURE;

    /// A point source at a grid point.
    pub fn at_source(row: usize, col: usize, time: f64) -> Self {
        Self { row, col, time, curvature: Self::AT_SOURCE }
    }
}

/// Why a source cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// No source was given.
    #[error("no source given; a distance map needs at least one")]
    None,
    /// The source lies off the grid.
    #[error(
        "source {row},{col} lies outside the grid: rows run from 0 to {last_row}, columns from 0 to {last_col}"
    )]
    Outside {
        /// Row of the source.
        row: f64,
        /// Column of the source.
        col: f64,
        /// The grid's last row.
        last_row: usize,
        /// The grid's last column.
        last_col: usize,
    },
    /// The source lies in a hole.
    #[error(
        "source {row},{col} lies in a hole of the surface (NaN or masked out); move it to a point of the surface"
    )]
    Hole {
        /// Row of the source.
        row: f64,
        /// Column of the source.
        col: f64,
    },
    /// No point is left near the source where only every second row and column is.
    #[error(
        "every second row and column has no point beside the source at row {row}, column {col}, only holes, so that its error cannot be estimated"
    )]
    NotOnCoarseGrid {
        /// Row of a point beside the source.
        row: usize,
        /// Column of that point.
        col: usize,
    },
    /// An initial value is NaN or infinite.
    #[error("the initial value {initial} of source {row},{col} is not finite")]
    Initial {
        /// Row of the source.
        row: f64,
        /// Column of the source.
        col: f64,
        /// The value.
        initial: f64,
    },
    /// A curve has no vertex.
    #[error("a source curve has no vertex; give at least one row and column")]
    EmptyCurve,
}

impl FromIterator<Source> for Sources {
    fn from_iter<T: IntoIterator<Item = Source>>(sources: T) -> Self {
        Self(sources.into_iter().collect())
    }
}

impl Sources {
    /// A single point source; row and column may be fractional.
    pub fn point(row: f64, col: f64) -> Self {
        Self::default().and_point(row, col, 0.0)
    }

    /// A single curve: rows and columns of a polyline's vertices.
    pub fn curve(vertices: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Self::default().and_curve(vertices, 0.0)
    }

    /// Adds a point source with an initial value.
    pub fn and_point(mut self, row: f64, col: f64, initial: f64) -> Self {
        self.0.push(Source::Point { at: DVec2::new(row, col), initial });
        self
    }

    /// Adds a curve with an initial value.
    pub fn and_curve(mut self, vertices: impl IntoIterator<Item = [f64; 2]>, initial: f64) -> Self {
        let vertices = vertices.into_iter().map(DVec2::from_array).collect();
        self.0.push(Source::Curve { vertices, initial });
        self
    }

    /// The sources, in the order given.
    pub fn iter(&self) -> impl Iterator<Item = &Source> {
        self.0.iter()
    }

    /// Whether all sources are points, so that fronts are circular near them.
    pub fn are_points(&self) -> bool {
        self.iter().all(|source| match source {
            Source::Point { .. } => true,
            Source::Curve { vertices, .. } => vertices.iter().all(|v| *v == vertices[0]),
        })
    }

    /// Whether all sources have the same initial value.
    pub(crate) fn start_together(&self) -> bool {
        let start = self.start();
        self.iter().all(|source| match source {
            Source::Point { initial, .. } | Source::Curve { initial, .. } => *initial == start,
        })
    }

    /// The smallest initial value.
    pub fn start(&self) -> f64 {
        let initial = |source: &Source| match source {
            Source::Point { initial, .. } | Source::Curve { initial, .. } => *initial,
        };
        self.iter().map(initial).fold(f64::INFINITY, f64::min)
    }

    /// Initial values at grid points, in row-major order, the smallest where several meet.
    ///
    /// A source at a grid point seeds that point. A source elsewhere seeds the corners of the
    /// cells it touches with their distances to it, which is exact where the cell is flat. A
    /// curve seeds the corners of every cell it runs through, so it has no gaps.
    pub fn seeds(&self, surface: &Surface) -> Result<Vec<Seed>, SourceError> {
        let mut seeds = BTreeMap::new();
        for source in self.iter() {
            let mut pieces = Pieces::default();
            let initial = match source {
                Source::Point { at, initial } => {
                    pieces.add(surface, [(*at, Vertex::Corner); 2])?;
                    *initial
                }
                Source::Curve { vertices, initial } => {
                    let bends = bends(surface, vertices);
                    let vertices: Vec<_> = vertices.iter().copied().zip(bends).collect();
                    let first = *vertices.first().ok_or(SourceError::EmptyCurve)?;
                    let last = *vertices.last().unwrap_or(&first);
                    // An end on a side of a cell touches the cell beyond it too.
                    if vertices.len() == 1 || first.0 != last.0 {
                        pieces.add(surface, [first, first])?;
                        pieces.add(surface, [last, last])?;
                    }
                    for ends in vertices.windows(2) {
                        pieces.add(surface, [ends[0], ends[1]])?;
                    }
                    *initial
                }
            };
            if !initial.is_finite() {
                let at = pieces.first();
                return Err(SourceError::Initial { row: at.x, col: at.y, initial });
            }
            for (row, col) in pieces.corners(surface) {
                let seed = pieces.seed(surface, row, col, initial);
                let first = seeds.entry((row, col)).or_insert(seed);
                if seed.time < first.time {
                    *first = seed;
                }
            }
        }
        if seeds.is_empty() {
            return Err(SourceError::None);
        }
        Ok(seeds.into_values().collect())
    }
}

/// How a curve runs through one of its vertices.
#[derive(Clone, Copy, Debug)]
enum Vertex {
    /// It ends or turns sharply there: the front fans out as from a point.
    Corner,
    /// It bends gently: its curvature vector, towards the centre of the bend.
    Smooth(DVec3),
}

/// A curve that turns by less than 30 degrees at a vertex is taken for a smooth one.
const SMOOTH_TURN_COSINE: f64 = 0.866;

/// How a curve runs through its vertices. Only positions tell a bend's size; on a surface known by
/// its metric, curves are as straight as their segments.
fn bends(surface: &Surface, vertices: &[DVec2]) -> Vec<Vertex> {
    let closed = vertices.len() > 2 && vertices.first() == vertices.last();
    let place = |at: DVec2| match surface.place(at) {
        Some(Sample::Position(position)) => Some(position),
        _ => None,
    };
    let last = vertices.len().saturating_sub(1);
    (0..vertices.len())
        .map(|index| {
            let (before, after) = match index {
                _ if index > 0 && index < last => (index - 1, index + 1),
                _ if closed => (last - 1, 1),
                _ => return Vertex::Corner,
            };
            let places = [before, index, after].map(|index| place(vertices[index]));
            let [Some(a), Some(b), Some(c)] = places else { return Vertex::Smooth(DVec3::ZERO) };
            let (Some(into), Some(out)) = ((b - a).try_normalize(), (c - b).try_normalize()) else {
                return Vertex::Smooth(DVec3::ZERO);
            };
            if into.dot(out) < SMOOTH_TURN_COSINE {
                return Vertex::Corner;
            }
            Vertex::Smooth((out - into) / (0.5 * (a.distance(b) + b.distance(c))))
        })
        .collect()
}

/// The part of a source that lies in one cell: a straight segment, or a point.
#[derive(Clone, Copy, Debug)]
struct Piece {
    cell: Cell,
    /// The geometry at its ends, and the place in its middle.
    a: Sample,
    b: Sample,
    middle: DVec2,
    /// From where to where on its segment it reaches, and that segment's ends.
    cut: (f64, f64),
    ends: [(DVec2, Vertex); 2],
}

/// A source cut at the grid's lines, by cell.
#[derive(Default)]
struct Pieces {
    by_cell: BTreeMap<(usize, usize), Vec<Piece>>,
}

impl Pieces {
    /// Cuts a straight segment of the chart into pieces.
    fn add(&mut self, surface: &Surface, ends: [(DVec2, Vertex); 2]) -> Result<(), SourceError> {
        let (from, to) = (ends[0].0, ends[1].0);
        check_inside(surface, from)?;
        check_inside(surface, to)?;
        let cuts = grid_crossings(from, to);
        for cut in cuts.windows(2) {
            let (a, b) = (from.lerp(to, cut[0]), from.lerp(to, cut[1]));
            // Both ends of a piece lie on the border of the cell that its middle is in.
            let middle = 0.5 * (a + b);
            let mut found = false;
            for cell in cells_around(surface, middle) {
                let ab = cell.sample(surface, a).zip(cell.sample(surface, b));
                let Some((a, b)) = ab else { continue };
                let piece = Piece { cell, a, b, middle, cut: (cut[0], cut[1]), ends };
                self.by_cell.entry((cell.rows.0, cell.cols.0)).or_default().push(piece);
                found = true;
            }
            if !found {
                return Err(SourceError::Hole { row: middle.x, col: middle.y });
            }
        }
        Ok(())
    }

    /// The first place of the source.
    fn first(&self) -> DVec2 {
        self.by_cell.values().flatten().map(|piece| piece.ends[0].0).next().unwrap_or_default()
    }

    /// The corners of all cells with a piece in them.
    fn corners(&self, surface: &Surface) -> BTreeSet<(usize, usize)> {
        let cells = self.by_cell.values().flatten().map(|piece| piece.cell);
        cells.flat_map(Cell::corners).filter(|&(row, col)| surface.has(row, col)).collect()
    }

    /// The initial value at a corner: from the nearest piece of the cells around it, and of those
    /// one further, where no hole can lie between.
    fn seed(&self, surface: &Surface, row: usize, col: usize, initial: f64) -> Seed {
        let rows = row.saturating_sub(2)..=row + 2;
        let cols = col.saturating_sub(2)..=col + 2;
        let whole = rows.clone().all(|r| {
            cols.clone().all(|c| r >= surface.rows() || c >= surface.cols() || surface.has(r, c))
        });
        let reach = if whole { 2 } else { 1 };
        let cells = (row.saturating_sub(reach)..row + reach)
            .flat_map(|r| (col.saturating_sub(reach)..col + reach).map(move |c| (r, c)));
        let pieces = cells.filter_map(|cell| self.by_cell.get(&cell)).flatten();
        let own = |piece: &&Piece| whole || piece.cell.corners().contains(&(row, col));
        pieces
            .filter(own)
            .map(|piece| surface.seed_from(row, col, initial, piece))
            .min_by(|a, b| a.time.total_cmp(&b.time))
            .expect("a corner belongs to a cell with a piece in it")
    }
}

fn check_inside(surface: &Surface, at: DVec2) -> Result<(), SourceError> {
    let (last_row, last_col) = (surface.rows() - 1, surface.cols() - 1);
    let inside = (0.0..=last_row as f64).contains(&at.x) && (0.0..=last_col as f64).contains(&at.y);
    if inside {
        Ok(())
    } else {
        Err(SourceError::Outside { row: at.x, col: at.y, last_row, last_col })
    }
}

/// Where a segment crosses the grid's rows and columns: parameters from 0 to 1, ends included.
pub(crate) fn grid_crossings(from: DVec2, to: DVec2) -> Vec<f64> {
    let mut cuts = vec![0.0, 1.0];
    for axis in 0..2 {
        let (a, b) = (from[axis], to[axis]);
        let (low, high) = (a.min(b), a.max(b));
        let mut line = low.floor() + 1.0;
        while line < high {
            cuts.push((line - a) / (b - a));
            line += 1.0;
        }
    }
    cuts.sort_by(f64::total_cmp);
    cuts
}

/// The part of the chart spanned by up to four neighbouring grid points: a cell, an edge or a
/// single point.
#[derive(Clone, Copy, Debug)]
struct Cell {
    rows: (usize, usize),
    cols: (usize, usize),
}

/// The cells that contain a place: one inside a cell, two on an edge. A place at a grid point
/// is a cell of its own, since its neighbours' first update is exact already.
fn cells_around(surface: &Surface, at: DVec2) -> Vec<Cell> {
    let at_point = at.x.fract() == 0.0 && at.y.fract() == 0.0;
    let spans = |x: f64, points: usize| -> Vec<(usize, usize)> {
        let low = x as usize;
        if x.fract() != 0.0 {
            return vec![(low, low + 1)];
        }
        if at_point || points == 1 {
            return vec![(low, low)];
        }
        [low.checked_sub(1), Some(low)]
            .into_iter()
            .flatten()
            .filter(|low| low + 1 < points)
            .map(|low| (low, low + 1))
            .collect()
    };
    let cols = spans(at.y, surface.cols());
    spans(at.x, surface.rows())
        .into_iter()
        .flat_map(|rows| cols.iter().map(move |&cols| Cell { rows, cols }))
        .collect()
}

impl Cell {
    fn corners(self) -> Vec<(usize, usize)> {
        let mut corners = vec![
            (self.rows.0, self.cols.0),
            (self.rows.0, self.cols.1),
            (self.rows.1, self.cols.0),
            (self.rows.1, self.cols.1),
        ];
        corners.dedup();
        corners.sort_unstable();
        corners.dedup();
        corners
    }

    /// The geometry at a place of the cell, interpolated between its corners; `None` in a hole.
    fn sample(self, surface: &Surface, at: DVec2) -> Option<Sample> {
        let corners = [
            (self.rows.0, self.cols.0),
            (self.rows.0, self.cols.1),
            (self.rows.1, self.cols.0),
            (self.rows.1, self.cols.1),
        ];
        let there = corners.map(|(row, col)| surface.has(row, col));
        let weights = corner_weights(there, at.x - self.rows.0 as f64, at.y - self.cols.0 as f64)?;
        let used = weights.into_iter().zip(corners).filter(|(weight, _)| *weight > 0.0);
        let sample =
            |(weight, (row, col))| (weight, surface.geometry().sample(surface.chart(), row, col));
        Some(Sample::interpolate(&used.map(sample).collect::<Vec<_>>()))
    }
}

/// Weights of a cell's corners, north-west, north-east, south-west and south-east, some of which
/// may be missing, at a place so many rows and columns from the first; `None` in a hole.
///
/// With a corner missing, the half of the cell opposite to it still belongs to the surface.
pub(crate) fn corner_weights(there: [bool; 4], rows: f64, cols: f64) -> Option<[f64; 4]> {
    // A place on the cell's border may lie a rounding error outside.
    let (v, u) = (rows.clamp(0.0, 1.0), cols.clamp(0.0, 1.0));
    let mut weights = [(1.0 - v) * (1.0 - u), (1.0 - v) * u, v * (1.0 - u), v * u];
    let mut missing = (0..4).filter(|&corner| !there[corner]);
    if let (Some(hole), None) = (missing.next(), missing.next()) {
        // Weights over the triangle of the other three: the affine function with value one
        // at a corner beside the hole is one minus that corner's opposite coordinate.
        let (v, u) = (if hole < 2 { v } else { 1.0 - v }, if hole % 2 == 0 { u } else { 1.0 - u });
        weights[hole ^ 1] = 1.0 - v;
        weights[hole ^ 2] = 1.0 - u;
        weights[hole ^ 3] = v + u - 1.0;
        weights[hole] = 0.0;
    }
    let weights = weights.map(|weight| if weight.abs() > 1e-12 { weight } else { 0.0 });
    let usable = |(weight, there): (&f64, bool)| *weight == 0.0 || (*weight > 0.0 && there);
    weights.iter().zip(there).all(usable).then_some(weights)
}

impl Surface {
    /// The initial value at a grid point from a piece of a source.
    fn seed_from(&self, row: usize, col: usize, initial: f64, piece: &Piece) -> Seed {
        let Piece { a, b, middle, cut, ends, .. } = *piece;
        let corner = self.geometry().sample(self.chart(), row, col);
        let foot = corner.foot_on(a, b);
        let nearest = Sample::interpolate(&[(1.0 - foot, a), (foot, b)]);
        let weight = self.slowness().map_or(1.0, |slowness| {
            0.5 * (slowness[self.chart().index(row, col)] + self.slowness_near(slowness, middle))
        });
        let distance = weight * corner.length_to(nearest);
        let foot = cut.0 + foot * (cut.1 - cut.0);
        let curvature = self.seed_curvature((row, col), distance, foot, ends);
        Seed { row, col, time: initial + distance, curvature }
    }

    /// Curvature of the front at a grid point some distance from the place `foot` of a segment.
    fn seed_curvature(
        &self,
        (row, col): (usize, usize),
        distance: f64,
        foot: f64,
        [start, end]: [(DVec2, Vertex); 2],
    ) -> f64 {
        let as_from_point = if distance > 0.0 { 1.0 / distance } else { Seed::AT_SOURCE };
        let bend = match (start.1, end.1) {
            _ if start.0 == end.0 => return as_from_point,
            (Vertex::Corner, _) if foot <= 1e-12 && distance > 0.0 => return as_from_point,
            (_, Vertex::Corner) if foot >= 1.0 - 1e-12 && distance > 0.0 => return as_from_point,
            (Vertex::Smooth(a), Vertex::Smooth(b)) => a.lerp(b, foot),
            (Vertex::Smooth(bend), Vertex::Corner) | (Vertex::Corner, Vertex::Smooth(bend)) => bend,
            (Vertex::Corner, Vertex::Corner) => DVec3::ZERO,
        };
        let place = self.place(start.0.lerp(end.0, foot));
        let (Some(Sample::Position(place)), Some(point)) = (place, self.position(row, col)) else {
            return 0.0;
        };
        // The front spreads on the outer side of the bend. On the curve itself it goes both ways.
        let side = (point - place).normalize_or_zero().dot(bend);
        -side / (1.0 - side * distance).max(0.1)
    }

    /// Whether a place, as fractional row and column, is on the grid and in no hole.
    pub(crate) fn contains(&self, at: DVec2) -> bool {
        self.place(at).is_some()
    }

    /// The geometry between grid points; `None` in a hole.
    pub(crate) fn place(&self, at: DVec2) -> Option<Sample> {
        check_inside(self, at).ok()?;
        cells_around(self, at).into_iter().find_map(|cell| cell.sample(self, at))
    }

    /// The slowness between grid points, bilinear over those that are there.
    fn slowness_near(&self, slowness: &[f64], at: DVec2) -> f64 {
        let (row, col) = (at.x as usize, at.y as usize);
        let (v, u) = (at.x.fract(), at.y.fract());
        let corners = [
            ((1.0 - v) * (1.0 - u), row, col),
            ((1.0 - v) * u, row, col + 1),
            (v * (1.0 - u), row + 1, col),
            (v * u, row + 1, col + 1),
        ];
        let (sum, weights) = corners
            .into_iter()
            .filter(|&(weight, row, col)| weight > 0.0 && self.has(row, col))
            .fold((0.0, 0.0), |(sum, weights), (weight, row, col)| {
                (sum + weight * slowness[self.chart().index(row, col)], weights + weight)
            });
        sum / weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{MetricTensor, Spacing};

    fn flat(rows: usize, cols: usize) -> Surface {
        Surface::from_heights(rows, cols, vec![0.0; rows * cols], Spacing::square(1.0)).unwrap()
    }

    #[test]
    fn the_end_of_a_curve_reaches_the_cells_beyond_it() {
        let surface = Surface::from_heights(9, 9, vec![0.0; 81], Spacing::square(1.0)).unwrap();
        // It ends on the side between two cells, half-way between two points.
        let seeds = Sources::curve([[1.0, 3.5], [4.0, 3.5]]).seeds(&surface).unwrap();
        let at = |row, col| seeds.iter().find(|seed| (seed.row, seed.col) == (row, col));
        for col in [3, 4] {
            let beyond = at(5, col).expect("the cell below is touched");
            approx::assert_relative_eq!(beyond.time, 1f64.hypot(0.5), epsilon = 1e-12);
            assert!(at(0, col).is_some(), "and so is that above");
        }
    }

    #[test]
    fn a_source_at_a_grid_point_seeds_it_alone() {
        let seeds = Sources::point(2.0, 3.0).seeds(&flat(5, 6)).unwrap();
        assert_eq!(seeds, [Seed::at_source(2, 3, 0.0)]);
    }

    #[test]
    fn a_source_inside_a_cell_seeds_its_corners_exactly() {
        let seeds = Sources::point(1.25, 2.5).seeds(&flat(4, 5)).unwrap();
        assert_eq!(seeds.len(), 4);
        for seed in seeds {
            let exact = (seed.row as f64 - 1.25).hypot(seed.col as f64 - 2.5);
            approx::assert_relative_eq!(seed.time, exact, epsilon = 1e-15);
        }
    }

    #[test]
    fn a_source_on_an_edge_seeds_both_cells() {
        assert_eq!(Sources::point(1.0, 2.5).seeds(&flat(4, 5)).unwrap().len(), 6);
        assert_eq!(Sources::point(0.0, 2.5).seeds(&flat(4, 5)).unwrap().len(), 4);
        assert_eq!(Sources::point(0.0, 2.5).seeds(&flat(1, 5)).unwrap().len(), 2);
    }

    #[test]
    fn a_metric_measures_like_the_positions_it_came_from() {
        // Sheared cell: columns along (1, 0), rows along (0.5, 2).
        let metric = MetricTensor { rr: 4.25, rc: 0.5, cc: 1.0 };
        let surface = Surface::from_metric(2, 2, vec![metric; 4]).unwrap();
        for seed in Sources::point(0.25, 0.75).seeds(&surface).unwrap() {
            let (dr, dc) = (seed.row as f64 - 0.25, seed.col as f64 - 0.75);
            let exact = (dc + 0.5 * dr).hypot(2.0 * dr);
            approx::assert_relative_eq!(seed.time, exact, epsilon = 1e-14);
        }
    }

    #[test]
    fn curves_have_no_gaps() {
        let seeds = Sources::curve([[0.0, 0.0], [7.3, 11.9]]).seeds(&flat(9, 13)).unwrap();
        for row in 0..8 {
            let col = row as f64 * 11.9 / 7.3;
            for col in [col.floor() as usize, col.ceil() as usize] {
                assert!(seeds.iter().any(|s| (s.row, s.col) == (row, col)), "{row},{col}");
            }
        }
        // Exact distance to the line from every seeded point whose foot lies in its own cells.
        let normal = DVec2::new(11.9, -7.3).normalize();
        for seed in &seeds {
            let exact = normal.dot(DVec2::new(seed.row as f64, seed.col as f64)).abs();
            assert!(seed.time >= exact - 1e-12, "{seed:?} {exact}");
        }
    }

    #[test]
    fn the_front_of_a_circle_has_its_curvature_on_either_side() {
        let (centre, radius) = (DVec2::new(20.0, 20.0), 12.3);
        let circle = (0..=200).map(|k| {
            let angle = std::f64::consts::TAU * f64::from(k % 200) / 200.0;
            (centre + radius * DVec2::from_angle(angle)).to_array()
        });
        for seed in Sources::curve(circle).seeds(&flat(41, 41)).unwrap() {
            let offset = DVec2::new(seed.row as f64, seed.col as f64).distance(centre) - radius;
            approx::assert_abs_diff_eq!(seed.time, offset.abs(), epsilon = 2e-3);
            if offset.abs() > 0.05 {
                let exact = offset.signum() / (radius + offset);
                approx::assert_relative_eq!(seed.curvature, exact, max_relative = 0.05);
            }
        }
    }

    #[test]
    fn the_front_of_a_polyline_is_straight_but_for_its_corners() {
        let line = [[2.0, 2.5], [2.0, 6.5], [6.5, 6.5]];
        let seeds = Sources::curve(line).seeds(&flat(9, 9)).unwrap();
        let at = |row, col| seeds.iter().find(|s| (s.row, s.col) == (row, col)).unwrap();
        assert_eq!((at(1, 4).time, at(1, 4).curvature), (1.0, 0.0));
        let corner = at(1, 7);
        approx::assert_relative_eq!(corner.curvature, 1.0 / corner.time, max_relative = 1e-12);
    }

    #[test]
    fn half_a_cell_is_left_beside_a_missing_corner() {
        let mut mask = vec![true; 4];
        mask[0] = false;
        let surface = flat(2, 2).with_mask(&mask).unwrap();
        let seeds = Sources::point(0.75, 0.5).seeds(&surface).unwrap();
        assert_eq!(seeds.len(), 3);
        for seed in seeds {
            let exact = (seed.row as f64 - 0.75).hypot(seed.col as f64 - 0.5);
            approx::assert_relative_eq!(seed.time, exact, epsilon = 1e-15);
        }
        let hole = Sources::point(0.25, 0.25).seeds(&surface);
        assert!(matches!(hole, Err(SourceError::Hole { .. })));
    }

    #[test]
    fn sources_off_the_surface_are_errors() {
        let surface = flat(3, 4);
        for (row, col) in [(-0.1, 0.0), (0.0, 3.5), (f64::NAN, 0.0), (9.0, 0.0)] {
            let error = Sources::point(row, col).seeds(&surface).unwrap_err();
            assert!(matches!(error, SourceError::Outside { .. }), "{error}");
        }
        assert_eq!(Sources::default().seeds(&surface), Err(SourceError::None));
        let infinite = Sources::default().and_point(0.0, 0.0, f64::INFINITY).seeds(&surface);
        assert!(matches!(infinite, Err(SourceError::Initial { .. })));
    }
}
