//! Computes upper bounds on distances, which end geodesics that are no longer shortest paths.
//!
//! Behind a summit geodesics become chaotic, and following them would be most of the work.

use std::f64::consts::TAU;

use glam::{DVec2, USizeVec2};
use rayon::prelude::*;

use super::domain::{MARGIN, is_followed};
use super::ray::{Frame, Position, Ray};
use crate::builtin::jet::Jet;

/// Upper bounds of distances in each cell of the domain, including the margin in which geodesics are followed.
pub(super) struct Bounds {
    cells: Vec<f64>,
}

/// Number of cells along each side.
const CELLS: usize = 80;
/// Factor that covers the error in the lengths of the rays followed here, which take long steps.
const SLACK: f64 = 1.01;

impl Bounds {
    /// Computes the bounds from some of the rays. Wherever a ray reaches a cell, all places of the cell are
    /// at most the cell's diameter further.
    pub(super) fn new(
        position: &impl Position,
        ray: impl Fn(f64) -> Ray + Sync,
        longest: f64,
    ) -> Self {
        const RAYS: usize = 1024;
        const STEPS: usize = 128;
        let step = longest / STEPS as f64;
        let visits = |index: usize| {
            let mut ray = ray(TAU * index as f64 / RAYS as f64);
            let mut cells = Vec::new();
            while cells.len() < STEPS && is_followed(&ray) {
                cells.push(cell(ray.at));
                ray = ray.advance(ray.derivative(position), step, position);
            }
            cells
        };
        let visited: Vec<_> = (0..RAYS).into_par_iter().map(visits).collect();
        let mut first = vec![STEPS; CELLS * CELLS];
        for cells in visited {
            for (steps, cell) in cells.into_iter().enumerate() {
                first[cell] = first[cell].min(steps);
            }
        }
        let bound = |(cell, &steps): (usize, &usize)| {
            let length = if steps < STEPS { steps as f64 * step } else { longest };
            SLACK * (length + diameter(position, cell))
        };
        Self { cells: first.par_iter().enumerate().map(|pair| bound((pair.0, pair.1))).collect() }
    }

    /// Returns whether a ray is longer than the distance to its place.
    pub(super) fn exclude(&self, length: f64, at: DVec2) -> bool {
        length > self.cells[cell(at)]
    }
}

const WIDTH: f64 = (1.0 + 2.0 * MARGIN) / CELLS as f64;

/// Returns the cell of a place, or the nearest cell.
fn cell(at: DVec2) -> usize {
    let USizeVec2 { x, y } =
        ((at + MARGIN) / WIDTH).as_usizevec2().min(USizeVec2::splat(CELLS - 1));
    y * CELLS + x
}

/// Returns a bound on distances in a cell: twice the cell's size as measured at its middle.
fn diameter(position: &impl Position, cell: usize) -> f64 {
    let index = DVec2::new((cell % CELLS) as f64, (cell / CELLS) as f64);
    let middle = WIDTH * (index + 0.5) - MARGIN;
    let frame = Frame::new(position(Jet::variables(middle)));
    2.0 * WIDTH * (frame.length(DVec2::X) + frame.length(DVec2::Y))
}
