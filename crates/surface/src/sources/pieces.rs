//! Cuts sources into pieces, one per cell, and computes, at grid points, the front that starts from these pieces.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, DVec3};

use super::Origin;
use super::course::{Segment, Vertex};
use super::error::SourceError;
use super::rise::Rise;
use super::seed::{Heading, Seed};
use crate::{Cell, Sample, Surface, corner_weights, grid_crossings};

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
    /// The growth of distances along the surface. Present for points only.
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
        Segment { ends, origin }: Segment,
    ) -> Result<(), SourceError> {
        let (from, to) = (ends[0].0, ends[1].0);
        check_inside(surface, from)?;
        check_inside(surface, to)?;
        let cuts = grid_crossings(from, to);
        for cut in cuts.windows(2) {
            let (a, b) = (from.lerp(to, cut[0]), from.lerp(to, cut[1]));
            // A piece lies in the cell that contains its middle.
            let middle = on_grid(0.5 * (a + b));
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

    /// Returns the corners of all cells that contain a piece.
    pub(super) fn corners(&self, surface: &Surface) -> BTreeSet<(usize, usize)> {
        let cells = self.by_cell.values().flatten().map(|piece| piece.cell);
        cells.flat_map(Cell::corners).filter(|&(row, col)| surface.has(row, col)).collect()
    }

    /// Returns the points at most one row and column away from the cells that contain a piece.
    pub(super) fn around(&self, surface: &Surface) -> BTreeSet<(usize, usize)> {
        let cells = self.by_cell.values().flatten().map(|piece| piece.cell);
        let around =
            |Cell { rows, cols }: Cell| surface.chart().around_span(rows, cols, [1, 1]).places();
        cells.flat_map(around).filter(|&(row, col)| surface.has(row, col)).collect()
    }

    /// Returns the initial value at a point, from the nearest piece of the cells around it. For pieces of curves, cells
    /// one step further count too, if there cannot be a hole between. The result is `None` if no piece is so near.
    pub(super) fn seed(
        &self,
        surface: &Surface,
        row: usize,
        col: usize,
        initial: f64,
    ) -> Option<Seed> {
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
    }
}

/// Distance from a line of the grid, in rows or columns, below which a place counts as on the line.
const ON_LINE: f64 = 1e-9;

/// Moves a place to the grid lines from which it differs only by rounding. Otherwise rounding would decide which cells
/// are touched by a curve that runs along a grid line or through a grid point.
fn on_grid(at: DVec2) -> DVec2 {
    let lines = at.round();
    let is_on = (at - lines).abs().cmple(DVec2::splat(ON_LINE));
    DVec2::select(is_on, lines, at)
}

pub(super) fn check_inside(surface: &Surface, at: DVec2) -> Result<(), SourceError> {
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
        // Perpendicular to the line at its end, the front is that of the line, not the circular one around the end.
        let is_beside = distance > 0.0 && (beyond - foot).abs() <= AT_END;
        let curvature = self.seed_curvature((row, col), distance, (place, is_beside), ends);
        let is_point = ends[0].0 == ends[1].0;
        let from = (is_point && distance > 0.0).then_some(ends[0].0);
        let origin = self.origin_of(piece, place, initial);
        let step = DVec2::new(row as f64, col as f64) - ends[0].0.lerp(ends[1].0, place);
        let heading = if curvature >= Seed::AT_SOURCE {
            Heading::Everywhere
        } else if step.abs().max_element() > ON_LINE {
            Heading::Along(step)
        } else if is_point {
            Heading::Everywhere
        } else {
            Heading::ToBothSides(ends[1].0 - ends[0].0)
        };
        let time = initial + distance;
        Seed { row, col, time, curvature, from, origin, exact: false, heading, source: 0 }
    }

    /// Returns the straight source whose front a piece emits at the place `foot` of its segment. The result
    /// is `None` if that place is a cut between pieces: the nearest place of the source then lies beyond the cut.
    fn origin_of(&self, piece: &Piece, foot: f64, initial: f64) -> Option<Origin> {
        let [start, end] = piece.ends;
        let at = start.0.lerp(end.0, foot);
        let is_same = |a: DVec2| a.distance(at) <= AT_END * (1.0 + at.length());
        let is_cut = foot <= piece.cut.0 + AT_END || foot >= piece.cut.1 - AT_END;
        if let Some(origin) = piece.origin {
            return (!is_cut || origin.ends.into_iter().any(is_same)).then_some(origin);
        }
        // The front is that around the end of a curve that bends before this end.
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
        // The front spreads on the outer side of the bend. At points of the curve itself it goes to both sides.
        // Rounding may move such a point off the curve.
        let away = point - place;
        let is_on_curve = away.length() * bend.length() <= AT_END;
        let side = if is_on_curve { 0.0 } else { away.normalize_or_zero().dot(bend) };
        -side / (1.0 - side * distance).max(0.1)
    }

    /// Returns whether a place, given as fractional row and column, is on the grid and not in a hole.
    #[doc(hidden)]
    pub fn contains(&self, at: DVec2) -> bool {
        if at.fract() == DVec2::ZERO && self.chart().holds(at) {
            return self.has(at.x as usize, at.y as usize);
        }
        self.place(at).is_some()
    }

    /// Returns the geometry between grid points, or `None` in a hole.
    #[doc(hidden)]
    pub fn place(&self, at: DVec2) -> Option<Sample> {
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

#[cfg(test)]
mod tests {
    use crate::{Sources, Spacing, Surface};

    /// The curves run along lines of the grid and through its points. Rounding moves the curves off these in some
    /// places.
    #[test]
    fn seeds_do_not_depend_on_where_a_curve_lies() {
        let plane = Surface::from_heights(60, 260, vec![0.0; 60 * 260], Spacing::square(1.0));
        let plane = plane.unwrap();
        let curves: [&[[f64; 2]]; 4] = [
            &[[42.5, 7.5], [40.0, 20.0], [35.0, 20.0], [25.0, 27.5]],
            &[[10.0, 3.0], [40.0, 24.0]],
            &[[7.3, 5.0], [33.1, 5.0], [33.1, 9.0]],
            &[[11.0, 2.1], [11.0, 13.7]],
        ];
        for curve in curves {
            let seeds = |right: usize| {
                let moved = curve.iter().map(|&[row, col]| [row, col + right as f64]);
                let seeds = Sources::curve(moved).seeds(&plane).unwrap();
                let mut seeds: Vec<_> =
                    seeds.iter().map(|seed| (seed.row, seed.col - right, seed.time)).collect();
                seeds.sort_by_key(|seed| (seed.0, seed.1));
                seeds
            };
            let first = seeds(0);
            for right in 1..=230 {
                let seeds = seeds(right);
                assert_eq!(seeds.len(), first.len(), "{curve:?} moved by {right}");
                for (seed, expected) in seeds.iter().zip(&first) {
                    assert_eq!((seed.0, seed.1), (expected.0, expected.1));
                    // Places have a rounding of 3e-14, which grows where a point lies next to the curve.
                    assert!((seed.2 - expected.2).abs() < 1e-10, "{seed:?} {expected:?}");
                }
            }
        }
    }
}
