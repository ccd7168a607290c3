//! Weights lengths by a slowness, and makes holes.
//!
//! The code that measures edges reads the four numbers of a point ([`Surface::point`]), and does not depend
//! on the kind of input.

use std::sync::OnceLock;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::chart::{Cell, Direction, bilinear};
use super::error::check_shape;
use super::geometry::{Geometry, MetricTensor, Point};
use super::inputs::Inputs;
use super::jump::JUMPS;
use super::real::Real;
use super::tag::Tagged;
use super::{Surface, SurfaceError};
use crate::constants::{EVEN_SLOWNESS, ROUGH_SLOWNESS as ROUGH};

impl Surface {
    /// Weights lengths by a slowness (reciprocal speed) at each point, row-major, so that distances become
    /// travel times. The slowness is linear along each edge. The length of an edge is multiplied by the mean
    /// slowness of its ends.
    ///
    /// Points with an infinite or NaN slowness are holes, which nothing passes. Where the slowness is 0,
    /// travel is free, but edges need a length: the value counts as a millionth of the least positive
    /// slowness (of 1 if there is none). Values at holes are ignored.
    ///
    /// # Errors
    /// If a value is negative, no point is left, or the number of values is not rows x columns. On a glued
    /// surface also if the values at the copies of a point differ by more than a thousandth.
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
            // If the value underflowed to zero, an edge would have no length.
            let free = free.max(f64::MIN_POSITIVE);
            slowness.iter_mut().filter(|value| **value == 0.0).for_each(|value| *value = free);
        }
        self.inputs.slowness = Some(slowness);
        self.floor = OnceLock::new();
        self.agree()?;
        self.non_empty()
    }

    /// Makes holes where the row-major `mask` is false.
    pub fn with_mask(mut self, mask: &[bool]) -> Result<Self, SurfaceError> {
        check_shape("mask", mask.len(), self.chart)?;
        self.inputs.present.iter_mut().zip(mask).for_each(|(present, &keep)| *present &= keep);
        self.floor = OnceLock::new();
        self.agree()?;
        self.non_empty()
    }

    /// Returns the slowness, if lengths are weighted.
    pub fn slowness(&self) -> Option<&[f64]> {
        self.inputs.slowness.as_deref()
    }

    /// Returns whether the slowness differs from point to point, so that a front may meet itself.
    #[doc(hidden)]
    pub fn is_slowed_unevenly(&self) -> bool {
        if self.inputs.is_scaled {
            return true;
        }
        let Some(slowness) = self.slowness() else { return false };
        let mut there =
            slowness.iter().zip(&self.inputs.present).filter(|(_, there)| **there).map(|(s, _)| s);
        let first = there.next();
        there.any(|here| Some(here) != first)
    }

    /// Returns whether the surface is given by a metric whose scale the updates treat as a slowness.
    pub(super) fn is_scaled(&self) -> bool {
        self.inputs.is_scaled
    }

    /// Returns the slowness of a point in the updates: the given slowness, times the scale of the metric if
    /// that scale jumps.
    fn slowness_to_updates(&self, index: usize) -> f64 {
        match self.geometry() {
            Geometry::Metric(metric) if self.inputs.is_scaled => {
                self.slowness_of(index) * metric[index].scale()
            }
            _ => self.slowness_of(index),
        }
    }

    /// Returns the slowness as a bordered array, or `None` if it is even. Values are tagged where the
    /// slowness jumps. The value is 1 where there is no point.
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

    /// Returns [`JUMPS`] if the slowness jumps at a point that is present, else 0. It jumps if it differs
    /// from the slowness of a neighbour by more than a quarter, or if its second difference along a line of
    /// points is large; the second differences of a smooth slowness are small.
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

    /// Returns whether the slowness jumps all over the surface: by more than a quarter along a twentieth of
    /// the edges of rows and columns.
    ///
    /// The threshold was measured on random blocks of 5 x 5 and on blobs, at 40 x 40 points with contrasts of 3 to
    /// 1000. Distances from one point to another and back differ by a mean of 4e-4 to 9e-4 with planar fronts, and by
    /// two to four times as much with curved fronts, which arrive earlier where they come from slow regions.
    pub(crate) fn is_slowed_in_patches(&self) -> bool {
        if !self.is_slowed_unevenly() {
            return false;
        }
        let (mut edges, mut jumps) = (0, 0);
        for (row, col) in self.chart.places().filter(|&(row, col)| self.has(row, col)) {
            let here = self.slowness_to_updates(self.chart.index(row, col));
            let beside = [Direction::South, Direction::East]
                .map(|to| self.chart.neighbour(row, col, to).filter(|&(r, c)| self.has(r, c)));
            for (row, col) in beside.into_iter().flatten() {
                let there = self.slowness_to_updates(self.chart.index(row, col));
                edges += 1;
                jumps += usize::from(here.max(there) > EVEN_SLOWNESS * here.min(there));
            }
        }
        PATCHES * jumps > edges
    }

    /// Returns whether lengths are weighted by a slowness.
    pub(super) fn is_weighted(&self) -> bool {
        self.inputs.slowness.is_some()
    }

    /// Removes the slowness.
    pub(super) fn unweighted(mut self) -> Self {
        (self.inputs.slowness, self.floor) = (None, OnceLock::new());
        self
    }

    /// Returns this surface with the slowness that another surface has at `points`.
    pub(super) fn with_slowness_of(mut self, other: &Self, points: &[usize]) -> Self {
        let slowness = other.slowness();
        self.inputs.slowness = slowness.map(|all| points.iter().map(|&index| all[index]).collect());
        self.floor = OnceLock::new();
        self
    }

    #[inline]
    fn slowness_of(&self, index: usize) -> f64 {
        self.inputs.slowness.as_ref().map_or(1.0, |slowness| slowness[index])
    }

    /// Returns the factor by which lengths between two grid points are multiplied.
    #[doc(hidden)]
    pub fn weight(&self, from: (usize, usize), to: (usize, usize)) -> f64 {
        let [from, to] = [from, to].map(|(row, col)| self.slowness_of(self.chart.index(row, col)));
        0.5 * (from + to)
    }

    /// Returns the factor by which lengths between a grid point and a place are multiplied.
    pub(super) fn weight_between(&self, (row, col): (usize, usize), at: DVec2) -> f64 {
        let of_point = self.slowness_of(self.chart.index(row, col));
        if self.is_weighted() { 0.5 * (of_point + self.slowness_near(at)) } else { 1.0 }
    }

    /// Returns the slowness between grid points, bilinear over the corners that are present.
    fn slowness_near(&self, at: DVec2) -> f64 {
        let cell = Cell::of((at.x as usize, at.y as usize));
        let (sum, weights) = bilinear(at.x.fract(), at.y.fract())
            .into_iter()
            .zip(cell.corners())
            .filter(|&(weight, (row, col))| weight > 0.0 && self.has(row, col))
            .fold((0.0, 0.0), |(sum, weights), (weight, (row, col))| {
                (sum + weight * self.slowness_of(self.chart.index(row, col)), weights + weight)
            });
        sum / weights
    }

    /// Returns a grid point in the form and precision in which devices measure edges: three numbers, and its slowness.
    /// Positions and heights are relative to `origin`. The slowness is 0 in holes.
    pub fn point<R: Real>(&self, index: usize, origin: DVec3) -> Point<R> {
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

/// Reciprocal of the share of edges with a jump above which a slowness counts as patches: one edge in twenty.
const PATCHES: usize = 20;

/// Slowness of free travel, relative to the least positive slowness.
const FREE: f64 = crate::constants::FREE;

/// Converts a slowness to the given precision. Values that would underflow become the smallest positive
/// number, so that they do not make holes.
fn held<R: Real>(slowness: f64) -> R {
    R::of(slowness).max(R::min_positive_value())
}
