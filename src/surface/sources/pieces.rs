//! Cuts sources into pieces, one per cell, and computes the front that starts from them at grid points.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, DVec3};

use super::Origin;
use super::error::SourceError;
use super::rise::Rise;
use super::seed::Seed;
use crate::surface::{Cell, Sample, Surface, corner_weights, grid_crossings};

/// The course of a curve through one of its vertices.
#[derive(Clone, Copy, Debug)]
pub(super) enum Vertex {
    /// The curve ends or turns sharply: the front fans out as from a point.
    Corner,
    /// The curve bends gently. The value is its curvature vector, towards the centre of the bend.
    Smooth(DVec3),
}

/// Cosine of the largest turn at a smooth vertex, 30 degrees. One of both segments there must also be shorter
/// than [`SMOOTH_SEGMENT`].
const SMOOTH_TURN_COSINE: f64 = 0.866;
/// Length in cells below which a segment counts as a sample of a smooth curve. A curve of longer segments is
/// the polygon that is given.
const SMOOTH_SEGMENT: f64 = 2.0;

/// Determines the course of a curve through its vertices. Only positions give the size of a bend. On a
/// surface given by its metric, smooth vertices have a bend of zero, as straight as their segments.
pub(super) fn bends(surface: &Surface, vertices: &[DVec2]) -> Vec<Vertex> {
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
            let ends = [before, index, after].map(|index| vertices[index]);
            let [into, out] = [ends[1] - ends[0], ends[2] - ends[1]];
            let is_short = |step: DVec2| step.abs().max_element() < SMOOTH_SEGMENT;
            let places = ends.map(place);
            let [Some(a), Some(b), Some(c)] = places else {
                let cosine = turn_cosine(surface, ends[1], into, out);
                let is_smooth = cosine >= SMOOTH_TURN_COSINE && (is_short(into) || is_short(out));
                let bend =
                    if is_smooth || is_straight(into, out) { Some(DVec3::ZERO) } else { None };
                return bend.map_or(Vertex::Corner, Vertex::Smooth);
            };
            let is_fine = is_short(into) || is_short(out) || is_straight(into, out);
            let (Some(into), Some(out)) = ((b - a).try_normalize(), (c - b).try_normalize()) else {
                return Vertex::Smooth(DVec3::ZERO);
            };
            if into.dot(out) < SMOOTH_TURN_COSINE || !is_fine {
                return Vertex::Corner;
            }
            Vertex::Smooth((out - into) / (0.5 * (a.distance(b) + b.distance(c))))
        })
        .collect()
}

/// Returns whether a curve runs straight on in the chart from one step to the next.
fn is_straight(into: DVec2, out: DVec2) -> bool {
    let across = into.perp_dot(out).abs();
    into.dot(out) >= 0.0 && across <= 1e-9 * into.length() * out.length()
}

/// Returns the cosine of the angle by which a curve turns at a place of a surface given by its metric.
fn turn_cosine(surface: &Surface, at: DVec2, into: DVec2, out: DVec2) -> f64 {
    let Some(Sample::Metric { tensor, .. }) = surface.place(at) else { return 1.0 };
    let dot = |a: DVec2, b: DVec2| a.dot(tensor * b);
    let lengths = (dot(into, into) * dot(out, out)).sqrt();
    if lengths > 0.0 { dot(into, out) / lengths } else { 1.0 }
}

/// Returns, for each segment of a curve, the ends of the straight line of which it is a part. The result is
/// `None` unless the curve turns sharply or ends at both ends of that line.
pub(super) fn straight_runs(vertices: &[(DVec2, Vertex)]) -> Vec<Option<[DVec2; 2]>> {
    let step = |segment: usize| vertices[segment + 1].0 - vertices[segment].0;
    let segments = vertices.len().saturating_sub(1);
    let goes_on = |next: usize| {
        matches!(vertices[next].1, Vertex::Smooth(_)) && is_straight(step(next - 1), step(next))
    };
    let mut runs = Vec::with_capacity(segments);
    while runs.len() < segments {
        let first = runs.len();
        let end = (first + 1..segments).find(|&next| !goes_on(next)).unwrap_or(segments);
        let ends = [vertices[first], vertices[end]];
        let is_whole = ends.iter().all(|(_, vertex)| matches!(vertex, Vertex::Corner));
        let run = is_whole.then(|| ends.map(|(place, _)| place));
        runs.resize(end, run);
    }
    runs
}

/// The part of a source that lies in one cell: a straight segment, or a point.
#[derive(Clone, Copy, Debug)]
struct Piece {
    cell: Cell,
    /// The geometry at both ends, and the place in the middle.
    a: Sample,
    b: Sample,
    middle: DVec2,
    /// The range of parameters of the piece on its segment, and that segment's ends.
    cut: (f64, f64),
    ends: [(DVec2, Vertex); 2],
    /// The straight source of which the piece is a part, if there is one.
    origin: Option<Origin>,
    /// Present for points only.
    rise: Option<Rise>,
}

impl Piece {
    fn is_point(&self) -> bool {
        self.ends[0].0 == self.ends[1].0
    }
}

/// A source cut at the grid's lines, by cell.
#[derive(Default)]
pub(super) struct Pieces {
    by_cell: BTreeMap<(usize, usize), Vec<Piece>>,
}

impl Pieces {
    /// Cuts a straight segment of the chart into pieces.
    pub(super) fn add(
        &mut self,
        surface: &Surface,
        ends: [(DVec2, Vertex); 2],
        origin: Option<Origin>,
    ) -> Result<(), SourceError> {
        let (from, to) = (ends[0].0, ends[1].0);
        check_inside(surface, from)?;
        check_inside(surface, to)?;
        let cuts = grid_crossings(from, to);
        for cut in cuts.windows(2) {
            let (a, b) = (from.lerp(to, cut[0]), from.lerp(to, cut[1]));
            // Both ends of a piece lie on the border of the cell that contains its middle.
            let middle = 0.5 * (a + b);
            let mut found = false;
            for cell in surface.chart().cells_around(middle) {
                let ab = surface.sample_in(cell, a).zip(surface.sample_in(cell, b));
                let Some((a, b)) = ab else { continue };
                let rise = if from == to { Rise::at(surface, cell, middle) } else { None };
                let cut = (cut[0], cut[1]);
                let piece = Piece { cell, a, b, middle, cut, ends, origin, rise };
                self.by_cell.entry(cell.north_west()).or_default().push(piece);
                found = true;
            }
            if !found {
                return Err(SourceError::Hole { row: middle.x, col: middle.y });
            }
        }
        Ok(())
    }

    /// Returns the first place of the source.
    pub(super) fn first(&self) -> DVec2 {
        self.by_cell.values().flatten().map(|piece| piece.ends[0].0).next().unwrap_or_default()
    }

    /// Returns the corners of all cells that contain a piece.
    pub(super) fn corners(&self, surface: &Surface) -> BTreeSet<(usize, usize)> {
        let cells = self.by_cell.values().flatten().map(|piece| piece.cell);
        cells.flat_map(Cell::corners).filter(|&(row, col)| surface.has(row, col)).collect()
    }

    /// Returns the initial value at a corner, from the nearest piece of the cells around it. Cells one step
    /// further count too, if there cannot be a hole between.
    pub(super) fn seed(&self, surface: &Surface, row: usize, col: usize, initial: f64) -> Seed {
        let around = surface.chart().around((row, col), 2);
        let whole = around.places().all(|(row, col)| surface.has(row, col));
        let reach = if whole { 2 } else { 1 };
        let cells = surface.chart().cells_near((row, col), reach);
        let pieces = cells.filter_map(|cell| self.by_cell.get(&cell)).flatten();
        let own = |piece: &&Piece| {
            whole && !piece.is_point() || piece.cell.corners().contains(&(row, col))
        };
        pieces
            .filter(own)
            .map(|piece| surface.seed_from(row, col, initial, piece))
            .min_by(|a, b| a.time.total_cmp(&b.time))
            .expect("a corner belongs to a cell with a piece in it")
    }
}

fn check_inside(surface: &Surface, at: DVec2) -> Result<(), SourceError> {
    let (last_row, last_col) = surface.chart().last();
    if surface.chart().holds(at) {
        Ok(())
    } else {
        Err(SourceError::Outside { row: at.x, col: at.y, last_row, last_col })
    }
}

/// Distance from an end of a segment, relative to the segment, below which a place counts as that end.
const AT_END: f64 = 1e-9;

impl Surface {
    /// Returns the initial value at a grid point from a piece of a source.
    fn seed_from(&self, row: usize, col: usize, initial: f64, piece: &Piece) -> Seed {
        let Piece { a, b, middle, cut, ends, rise, .. } = *piece;
        let corner = self.geometry().sample(self.chart(), row, col);
        let beyond = corner.foot_on(a, b);
        let foot = beyond.clamp(0.0, 1.0);
        let nearest = Sample::interpolate(&[(1.0 - foot, a), (foot, b)]);
        let weight = self.weight_between((row, col), middle);
        let chord = corner.length_to(nearest);
        let distance = weight
            * rise.map_or(chord, |rise| (chord * chord + rise.from((row, col))).max(0.0).sqrt());
        let place = cut.0 + foot * (cut.1 - cut.0);
        // Straight across from an end, the front is that of the line, not the one around the end.
        let is_beside = distance > 0.0 && (beyond - foot).abs() <= AT_END;
        let curvature = self.seed_curvature((row, col), distance, (place, is_beside), ends);
        let is_point = ends[0].0 == ends[1].0;
        let from = (is_point && distance > 0.0).then_some(ends[0].0);
        let origin = self.origin_of(piece, place, initial);
        Seed { row, col, time: initial + distance, curvature, from, origin, exact: false }
    }

    /// Returns the straight source whose front a piece emits at the place `foot` of its segment. The result
    /// is `None` if that place is a cut between pieces: the nearest place of the source then lies beyond it.
    fn origin_of(&self, piece: &Piece, foot: f64, initial: f64) -> Option<Origin> {
        let [start, end] = piece.ends;
        let at = start.0.lerp(end.0, foot);
        let is_same = |a: DVec2| a.distance(at) <= AT_END * (1.0 + at.length());
        let is_cut = foot <= piece.cut.0 + AT_END || foot >= piece.cut.1 - AT_END;
        if let Some(origin) = piece.origin {
            return (!is_cut || origin.ends.into_iter().any(is_same)).then_some(origin);
        }
        // The front around the end of a curve that is bent before it.
        let is_end =
            |(place, vertex): (DVec2, Vertex)| matches!(vertex, Vertex::Corner) && is_same(place);
        piece
            .ends
            .into_iter()
            .find(|&end| is_end(end))
            .map(|(place, _)| Origin::point(place, initial))
    }

    /// Returns the curvature of the front at a grid point at `distance` from the place `foot` of a segment.
    fn seed_curvature(
        &self,
        (row, col): (usize, usize),
        distance: f64,
        (foot, is_beside): (f64, bool),
        [start, end]: [(DVec2, Vertex); 2],
    ) -> f64 {
        let as_from_point = if distance > 0.0 { 1.0 / distance } else { Seed::AT_SOURCE };
        let bend = match (start.1, end.1) {
            _ if start.0 == end.0 => return as_from_point,
            (Vertex::Corner, _) if foot <= AT_END && !is_beside => return as_from_point,
            (_, Vertex::Corner) if foot >= 1.0 - AT_END && !is_beside => return as_from_point,
            (Vertex::Smooth(a), Vertex::Smooth(b)) => a.lerp(b, foot),
            (Vertex::Smooth(bend), Vertex::Corner) | (Vertex::Corner, Vertex::Smooth(bend)) => bend,
            (Vertex::Corner, Vertex::Corner) => DVec3::ZERO,
        };
        let place = self.place(start.0.lerp(end.0, foot));
        let (Some(Sample::Position(place)), Some(point)) = (place, self.position(row, col)) else {
            return 0.0;
        };
        // The front spreads on the outer side of the bend. From the curve itself it goes to both sides.
        let side = (point - place).normalize_or_zero().dot(bend);
        -side / (1.0 - side * distance).max(0.1)
    }

    /// Returns whether a place, given as fractional row and column, is on the grid and not in a hole.
    pub(crate) fn contains(&self, at: DVec2) -> bool {
        self.place(at).is_some()
    }

    /// Returns the geometry between grid points, or `None` in a hole.
    pub(crate) fn place(&self, at: DVec2) -> Option<Sample> {
        check_inside(self, at).ok()?;
        self.chart().cells_around(at).into_iter().find_map(|cell| self.sample_in(cell, at))
    }

    /// Returns the geometry at a place of a cell, interpolated between the cell's corners, or `None` in a
    /// hole.
    fn sample_in(&self, cell: Cell, at: DVec2) -> Option<Sample> {
        let corners = cell.corners();
        let there = corners.map(|(row, col)| self.has(row, col));
        let weights = corner_weights(there, cell.inside(at))?;
        let used = weights.into_iter().zip(corners).filter(|(weight, _)| *weight > 0.0);
        let sample =
            |(weight, (row, col))| (weight, self.geometry().sample(self.chart(), row, col));
        Some(Sample::interpolate(&used.map(sample).collect::<Vec<_>>()))
    }
}
