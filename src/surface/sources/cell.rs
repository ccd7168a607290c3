//! The cells of the grid around a place.

use glam::DVec2;

use crate::surface::{Sample, Surface};

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
pub(super) struct Cell {
    pub(super) rows: (usize, usize),
    pub(super) cols: (usize, usize),
}

/// The cells that contain a place: one inside a cell, two on an edge. A place at a grid point
/// is a cell of its own, since its neighbours' first update is exact already.
pub(super) fn cells_around(surface: &Surface, at: DVec2) -> Vec<Cell> {
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
    /// North-west, north-east, south-west and south-east; some are the same on an edge.
    pub(super) fn all_corners(self) -> [(usize, usize); 4] {
        let Self { rows, cols } = self;
        [(rows.0, cols.0), (rows.0, cols.1), (rows.1, cols.0), (rows.1, cols.1)]
    }

    pub(super) fn corners(self) -> Vec<(usize, usize)> {
        let mut corners = self.all_corners().to_vec();
        corners.sort_unstable();
        corners.dedup();
        corners
    }

    /// The geometry at a place of the cell, interpolated between its corners; `None` in a hole.
    pub(super) fn sample(self, surface: &Surface, at: DVec2) -> Option<Sample> {
        let corners = self.all_corners();
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
