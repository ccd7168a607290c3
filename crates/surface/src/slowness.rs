//! Weights lengths by a slowness, and makes holes.
//!
//! The code that measures edges reads the four numbers of a point ([`Surface::point`]), and does not depend
//! on the kind of input.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::chart::{Cell, bilinear};
use super::error::check_shape;
use super::geometry::{Geometry, MetricTensor, Point};
use super::inputs::Inputs;
use super::jump::JUMPS;
use super::real::Real;
use super::tag::Tagged;
use super::{Known, Surface, SurfaceError};
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
        self.known = Known::default();
        self.agree()?;
        self.non_empty()
    }

    /// Makes holes where the row-major `mask` is false.
    pub fn with_mask(mut self, mask: &[bool]) -> Result<Self, SurfaceError> {
        check_shape("mask", mask.len(), self.chart)?;
        self.inputs.present.iter_mut().zip(mask).for_each(|(present, &keep)| *present &= keep);
        self.known = Known::default();
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
    #[doc(hidden)]
    pub fn is_scaled(&self) -> bool {
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
        let chart = self.chart;
        let mut wide = vec![f64::NAN; chart.bordered_points()];
        chart.rows_mut(&mut wide).enumerate().for_each(|(row, line)| self.write_row(row, line));
        let mut bordered = vec![R::one(); chart.bordered_points()];
        chart.rows_mut(&mut bordered).enumerate().for_each(|(row, line)| {
            let mut jumps = vec![0; line.len()];
            mark_jumps(chart.rows_around(&wide, row), &mut jumps);
            let there = chart.row_of(&wide, row).iter().zip(jumps);
            for (here, (&slowness, tag)) in line.iter_mut().zip(there) {
                if !slowness.is_nan() {
                    *here = held::<R>(slowness).with_tag(tag);
                }
            }
        });
        Some(bordered)
    }

    /// Writes the slowness of a row's points in the updates, NaN where there is no point.
    fn write_row(&self, row: usize, line: &mut [f64]) {
        for (col, here) in line.iter_mut().enumerate() {
            let index = self.chart.index(row, col);
            let present = self.inputs.present[index];
            *here = if present { self.slowness_to_updates(index) } else { f64::NAN };
        }
    }

    /// Returns whether lengths are weighted by a slowness.
    pub(super) fn is_weighted(&self) -> bool {
        self.inputs.slowness.is_some()
    }

    /// Removes the slowness.
    pub(super) fn unweighted(mut self) -> Self {
        (self.inputs.slowness, self.known) = (None, Known::default());
        self
    }

    /// Returns this surface with the slowness that another surface has at `points`.
    pub(super) fn with_slowness_of(mut self, other: &Self, points: &[usize]) -> Self {
        let slowness = other.slowness();
        self.inputs.slowness = slowness.map(|all| points.iter().map(|&index| all[index]).collect());
        self.known = Known::default();
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
        0.5 * (of_point + self.slowness_near(at))
    }

    /// Returns the slowness between grid points, bilinear over the corners that are present; 1 without a slowness.
    fn slowness_near(&self, at: DVec2) -> f64 {
        if self.is_weighted() { self.mean_near(at, |index| self.slowness_of(index)) } else { 1.0 }
    }

    /// Returns the cost of a straight line within a cell, as in the updates: its length times the mean slowness of its
    /// ends. If the scale of a metric counts as a slowness, the length is that of the metric without its scale. The
    /// length is that of a number of pieces. The result is `None` if a place lies in a hole.
    #[doc(hidden)]
    pub fn cost_in_cell(&self, from: DVec2, to: DVec2, pieces: usize) -> Option<f64> {
        let place = |piece: usize| {
            let place = self.place(from.lerp(to, piece as f64 / pieces as f64))?;
            Some(if self.is_scaled() { place.without_scale() } else { place })
        };
        let length = |piece: usize| Some(place(piece)?.length_to(place(piece + 1)?));
        let length: f64 = (0..pieces).map(length).sum::<Option<_>>()?;
        let slowness = |at: DVec2| match self.is_scaled() || self.is_weighted() {
            true => self.mean_near(at, |index| self.slowness_to_updates(index)),
            false => 1.0,
        };
        Some(0.5 * length * (slowness(from) + slowness(to)))
    }

    /// Returns the bilinear mean of a value over the corners of a place's cell that are present.
    fn mean_near(&self, at: DVec2, value: impl Fn(usize) -> f64) -> f64 {
        let cell = Cell::of((at.x as usize, at.y as usize));
        let (sum, weights) = bilinear(at.x.fract(), at.y.fract())
            .into_iter()
            .zip(cell.corners())
            .filter(|&(weight, (row, col))| weight > 0.0 && self.has(row, col))
            .fold((0.0, 0.0), |(sum, weights), (weight, (row, col))| {
                (sum + weight * value(self.chart.index(row, col)), weights + weight)
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

/// Returns whether the slownesses of two neighbours differ by more than a quarter. NaN differs from nothing.
#[inline(always)]
fn differ(a: f64, b: f64) -> bool {
    (a > EVEN_SLOWNESS * b) | (b > EVEN_SLOWNESS * a)
}

/// Sets a tag to [`JUMPS`] where the slowness jumps at a point of a row that is present: where it differs from the
/// slowness of a neighbour by more than a quarter, or where its second difference along a line of points is large. The
/// second differences of a smooth slowness are small. `rows` are the rows before, at and after it, with one point of the
/// border on each side.
fn mark_jumps(rows: [&[f64]; 3], tags: &mut [u8]) {
    let [above, line, below] = rows.map(|row| &row[..tags.len() + 2]);
    for (col, tag) in tags.iter_mut().enumerate() {
        let own = line[col + 1];
        let lines = [
            [line[col], line[col + 2]],
            [above[col + 1], below[col + 1]],
            [above[col], below[col + 2]],
            [above[col + 2], below[col]],
        ];
        let mut jumps = false;
        for [there, back] in lines {
            let second = (there - own + (back - own)).abs();
            jumps |= differ(there, own) | differ(back, own) | (second > ROUGH * own);
        }
        *tag = if jumps { JUMPS } else { 0 };
    }
}

/// Slowness of free travel, relative to the least positive slowness.
const FREE: f64 = crate::constants::FREE;

/// Converts a slowness to the given precision. Values that would underflow become the smallest positive
/// number, so that they do not make holes.
fn held<R: Real>(slowness: f64) -> R {
    R::of(slowness).max(R::min_positive_value())
}
