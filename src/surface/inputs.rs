//! What is given at each grid point: a geometry, whether the surface is there, and a slowness.
//!
//! What makes edges of it reads a point's four numbers ([`Surface::point`]) and knows of no input.

use std::sync::OnceLock;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::chart::{Block, Cell, Chart, Direction, bilinear};
use super::geometry::{Geometry, MetricTensor, Point};
use super::jump::JUMPS;
use super::real::Real;
use super::tag::Tagged;
use super::{Surface, SurfaceError, check_shape};
use crate::constants::{EVEN_SLOWNESS, ROUGH_SLOWNESS as ROUGH};

/// What is given at each grid point, row-major.
#[derive(Clone, Debug)]
pub(super) struct Inputs {
    pub geometry: Geometry,
    pub slowness: Option<Vec<f64>>,
    pub present: Vec<bool>,
    /// Whether the geometry is a metric that jumps, so that its scale is a slowness to the updates
    /// ([`super::metric_scale`]).
    pub is_scaled: bool,
}

impl Inputs {
    /// Those of the points of a block.
    pub(super) fn cut(&self, chart: Chart, block: &Block) -> Self {
        Self {
            geometry: self.geometry.cut(chart, block),
            slowness: self.slowness.as_deref().map(|slowness| block.cut(chart, slowness)),
            present: block.cut(chart, &self.present),
            is_scaled: self.is_scaled,
        }
    }
}

impl Surface {
    /// Weights lengths by a slowness (reciprocal speed) at each point, row-major, so that
    /// distances become travel times. The slowness is linear along each edge, whose length is multiplied by the mean
    /// of both ends.
    ///
    /// Nothing passes where it is infinite or NaN: such points are holes. Where it is 0, travel is free but for a
    /// millionth of the least positive slowness (of 1 if there is none), as edges have a length. Values at holes are
    /// not looked at.
    ///
    /// # Errors
    /// If a value is negative, no point is left, or there are not rows x columns of them.
    pub fn with_slowness(mut self, mut slowness: Vec<f64>) -> Result<Self, SurfaceError> {
        check_shape("slowness", slowness.len(), self.chart)?;
        let (mut least, mut has_free) = (f64::INFINITY, false);
        for (index, &value) in slowness.iter().enumerate() {
            let present = &mut self.inputs.present[index];
            if *present && value < 0.0 {
                let (row, col) = self.chart.position(index);
                return Err(SurfaceError::Slowness { value, row, col });
            }
            *present &= value.is_finite();
            has_free |= *present && value == 0.0;
            if *present && value > 0.0 {
                least = least.min(value);
            }
        }
        if has_free {
            let free = FREE * if least.is_finite() { least } else { 1.0 };
            // Were it no number of this precision, an edge would have no length.
            let free = free.max(f64::MIN_POSITIVE);
            slowness.iter_mut().filter(|value| **value == 0.0).for_each(|value| *value = free);
        }
        self.inputs.slowness = Some(slowness);
        self.floor = OnceLock::new();
        self.non_empty()
    }

    /// Makes holes where the mask, row-major, is false.
    pub fn with_mask(mut self, mask: &[bool]) -> Result<Self, SurfaceError> {
        check_shape("mask", mask.len(), self.chart)?;
        self.inputs.present.iter_mut().zip(mask).for_each(|(present, &keep)| *present &= keep);
        self.floor = OnceLock::new();
        self.non_empty()
    }

    /// The slowness, if lengths are weighted.
    pub fn slowness(&self) -> Option<&[f64]> {
        self.inputs.slowness.as_deref()
    }

    /// Whether its slowness differs from point to point, so that a front may meet itself.
    pub(crate) fn is_slowed_unevenly(&self) -> bool {
        if self.inputs.is_scaled {
            return true;
        }
        let Some(slowness) = self.slowness() else { return false };
        let mut there =
            slowness.iter().zip(&self.inputs.present).filter(|(_, there)| **there).map(|(s, _)| s);
        let first = there.next();
        there.any(|here| Some(here) != first)
    }

    /// Whether it is given by a metric whose scale is a slowness to the updates.
    pub(super) fn is_scaled(&self) -> bool {
        self.inputs.is_scaled
    }

    /// The slowness that the updates know of a point: the one that is given, times a metric's own where that jumps.
    fn slowness_to_updates(&self, index: usize) -> f64 {
        match self.geometry() {
            Geometry::Metric(metric) if self.inputs.is_scaled => {
                self.slowness_of(index) * metric[index].scale()
            }
            _ => self.slowness_of(index),
        }
    }

    /// The slowness as a bordered array, tagged where it jumps, 1 where no point is, if it is uneven.
    pub(super) fn bordered_slowness<R: Real>(&self) -> Option<Vec<R>> {
        if !self.is_slowed_unevenly() {
            return None;
        }
        let mut bordered = vec![R::one(); self.chart.bordered_points()];
        self.chart.rows_mut(&mut bordered).enumerate().for_each(|(row, line)| {
            for (col, here) in line.iter_mut().enumerate().filter(|&(col, _)| self.has(row, col)) {
                let slowness_here = held::<R>(self.slowness_to_updates(self.chart.index(row, col)));
                *here = slowness_here.with_tag(self.jumps_at((row, col)));
            }
        });
        Some(bordered)
    }

    /// [`JUMPS`] if the slowness jumps at a point that is there: to a neighbour by more than a quarter, or if its second
    /// difference along a line of points says so. A slowness that changes smoothly has small ones.
    fn jumps_at(&self, (row, col): (usize, usize)) -> u8 {
        let own = self.slowness_to_updates(self.chart.index(row, col));
        let neighbour = |to: Direction| {
            let (row, col) = self.chart.neighbour(row, col, to)?;
            self.has(row, col).then(|| self.slowness_to_updates(self.chart.index(row, col)))
        };
        let jumps = Direction::ALL.into_iter().any(|to| {
            let Some(there) = neighbour(to) else { return false };
            let is_uneven = there.max(own) > EVEN_SLOWNESS * there.min(own);
            let back = neighbour(to.opposite());
            is_uneven || back.is_some_and(|back| (there - own + (back - own)).abs() > ROUGH * own)
        });
        if jumps { JUMPS } else { 0 }
    }

    /// Whether the slowness jumps all over the surface: by more than a quarter along a twentieth of the edges of rows and
    /// columns. Measured on random blocks of 5 x 5 and blobs, 40 x 40 points, contrasts of 3 to 1000: ways there and
    /// back differ by 4e-4 to 9e-4 in the mean with planar fronts, and by twice to four times that with curved
    /// ones, which are the earlier where they come from what is slow.
    pub(crate) fn is_slowed_in_patches(&self) -> bool {
        if !self.is_slowed_unevenly() {
            return false;
        }
        let (mut edges, mut jumps) = (0, 0);
        for (row, col) in self.chart.places().filter(|&(row, col)| self.has(row, col)) {
            let here = self.slowness_to_updates(self.chart.index(row, col));
            for (row, col) in [(row + 1, col), (row, col + 1)] {
                if self.has(row, col) {
                    let there = self.slowness_to_updates(self.chart.index(row, col));
                    edges += 1;
                    jumps += usize::from(here.max(there) > EVEN_SLOWNESS * here.min(there));
                }
            }
        }
        PATCHES * jumps > edges
    }

    /// Whether lengths are weighted, and not those on the surface.
    pub(super) fn is_weighted(&self) -> bool {
        self.inputs.slowness.is_some()
    }

    /// The same surface, on which a length is a length.
    pub(super) fn unweighted(mut self) -> Self {
        (self.inputs.slowness, self.floor) = (None, OnceLock::new());
        self
    }

    /// The same surface with the weights of some points of another one.
    pub(super) fn weighted_like(mut self, other: &Self, points: &[usize]) -> Self {
        let slowness = other.slowness();
        self.inputs.slowness = slowness.map(|all| points.iter().map(|&index| all[index]).collect());
        self.floor = OnceLock::new();
        self
    }

    #[inline]
    fn slowness_of(&self, index: usize) -> f64 {
        self.inputs.slowness.as_ref().map_or(1.0, |slowness| slowness[index])
    }

    /// What lengths between two grid points are multiplied by.
    pub(crate) fn weight(&self, from: (usize, usize), to: (usize, usize)) -> f64 {
        let [from, to] = [from, to].map(|(row, col)| self.slowness_of(self.chart.index(row, col)));
        0.5 * (from + to)
    }

    /// What lengths between a grid point and a place are multiplied by.
    pub(super) fn weight_between(&self, (row, col): (usize, usize), at: DVec2) -> f64 {
        let of_point = self.slowness_of(self.chart.index(row, col));
        if self.is_weighted() { 0.5 * (of_point + self.slowness_near(at)) } else { 1.0 }
    }

    /// The slowness between grid points, bilinear over those that are there.
    fn slowness_near(&self, at: DVec2) -> f64 {
        let (row, col) = (at.x as usize, at.y as usize);
        let cell = Cell { rows: [row, row + 1], cols: [col, col + 1] };
        let (sum, weights) = bilinear(at.x.fract(), at.y.fract())
            .into_iter()
            .zip(cell.corners())
            .filter(|&(weight, (row, col))| weight > 0.0 && self.has(row, col))
            .fold((0.0, 0.0), |(sum, weights), (weight, (row, col))| {
                (sum + weight * self.slowness_of(self.chart.index(row, col)), weights + weight)
            });
        sum / weights
    }

    /// A grid point in some precision. Positions and heights are taken relative to `origin`.
    pub(crate) fn point<R: Real>(&self, index: usize, origin: DVec3) -> Point<R> {
        let Inputs { geometry, present, is_scaled, .. } = &self.inputs;
        let slowness = if present[index] { self.slowness_to_updates(index) } else { 0.0 };
        let [x, y, z] = match geometry {
            Geometry::Metric(metric) if *is_scaled => {
                let MetricTensor { rr, rc, cc } = metric[index].shape();
                [rr, rc, cc]
            }
            _ => geometry.numbers(index, origin),
        };
        let held = if slowness > 0.0 { held(slowness) } else { R::zero() };
        [R::of(x), R::of(y), R::of(z), held]
    }
}

/// Of so many edges one jumps, or more, where there are patches.
const PATCHES: usize = 20;

/// What is left of the least slowness where travel is free.
const FREE: f64 = crate::constants::FREE;

/// A slowness in some precision: one that is too small for it is small, but no hole.
fn held<R: Real>(slowness: f64) -> R {
    R::of(slowness).max(R::min_positive_value())
}
