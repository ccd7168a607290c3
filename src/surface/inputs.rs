//! What is given at each grid point: a geometry, whether the surface is there, and a slowness.
//!
//! What makes edges of it reads a point's four numbers ([`Surface::point`]) and knows of no input.

use std::sync::OnceLock;

use glam::{DVec2, DVec3};

use super::chart::{Block, Cell, Chart, bilinear};
use super::geometry::{Geometry, Point};
use super::real::Real;
use super::{Surface, SurfaceError, check_shape};

/// What is given at each grid point, row-major.
#[derive(Clone, Debug)]
pub(super) struct Inputs {
    pub geometry: Geometry,
    pub slowness: Option<Vec<f64>>,
    pub present: Vec<bool>,
}

impl Inputs {
    /// Those of the points of a block.
    pub(super) fn cut(&self, chart: Chart, block: &Block) -> Self {
        Self {
            geometry: self.geometry.cut(chart, block),
            slowness: self.slowness.as_deref().map(|slowness| block.cut(chart, slowness)),
            present: block.cut(chart, &self.present),
        }
    }
}

impl Surface {
    /// Weights lengths by a slowness (reciprocal speed) at each point, row-major, so that
    /// distances become travel times. An edge's length is multiplied by the mean of both ends.
    /// Values at holes are not looked at.
    pub fn with_slowness(mut self, slowness: Vec<f64>) -> Result<Self, SurfaceError> {
        check_shape("slowness", slowness.len(), self.chart)?;
        for (index, &value) in slowness.iter().enumerate() {
            if self.inputs.present[index] && !(value > 0.0 && value.is_finite()) {
                let (row, col) = self.chart.position(index);
                return Err(SurfaceError::Slowness { value, row, col });
            }
        }
        self.inputs.slowness = Some(slowness);
        self.floor = OnceLock::new();
        Ok(self)
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
        self.slowness().is_some_and(|slowness| slowness.iter().any(|here| *here != slowness[0]))
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
    pub(super) fn weight(&self, from: (usize, usize), to: (usize, usize)) -> f64 {
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
        let Inputs { geometry, present, .. } = &self.inputs;
        let slowness = if present[index] { self.slowness_of(index) } else { 0.0 };
        let [x, y, z] = geometry.numbers(index, origin);
        // A slowness too small for this precision is small, but no hole.
        let held =
            if slowness > 0.0 { R::of(slowness).max(R::min_positive_value()) } else { R::zero() };
        [R::of(x), R::of(y), R::of(z), held]
    }
}
