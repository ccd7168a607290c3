//! Represents curves in the parameter domain, and lifts and measures them on the surface.

use glam::{DVec2, DVec3};

use geosweep_surface::Surface;
use geosweep_surface::{Sample, grid_crossings};

/// A polyline in the parameter domain. Its vertices may lie anywhere between grid points.
///
/// On a closed surface ([`Surface::with_gluing`]) a curve may pass seams. Two successive vertices are then
/// the same place of the surface at different rows and columns: the curve *jumps*. See [`Self::jumps`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// The row and column of each vertex, fractional, in order.
    pub vertices: Vec<[f64; 2]>,
    /// Whether the last vertex is connected to the first. The first vertex is not repeated.
    pub closed: bool,
}

/// The reason why a curve cannot be lifted to the surface or measured on it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CurveError {
    /// The surface has no positions.
    #[error("the surface is known only by its metric, so that its points have no place in space")]
    NoPositions,
    /// A vertex or a part of the curve lies off the surface.
    #[error("row {row}, column {col} is off the surface: outside the grid or in a hole")]
    Off {
        /// Row of the place.
        row: f64,
        /// Column of the place.
        col: f64,
    },
}

impl Curve {
    /// Returns the vertices. For a closed curve the first vertex is repeated at the end.
    pub fn points(&self) -> impl Iterator<Item = [f64; 2]> {
        let first = self.vertices.first().filter(|_| self.closed);
        self.vertices.iter().chain(first).copied()
    }

    /// Returns the position of each vertex in space. The interpolation is bilinear between the four grid
    /// points around the vertex, and linear between three points beside a hole.
    ///
    /// # Errors
    /// If the surface has no positions, or a vertex lies off the surface.
    ///
    /// ```
    /// use geosweep::{Spacing, Surface, geometry::Curve};
    /// let ramp = (0..20).map(|i| f64::from(i % 5)).collect();
    /// let surface = Surface::from_heights(4, 5, ramp, Spacing::square(2.0))?;
    /// let curve = Curve { vertices: vec![[0.5, 0.5], [2.5, 3.5]], closed: false };
    /// assert_eq!(curve.lift(&surface)?[1].to_array(), [7.0, 5.0, 3.5]);
    /// assert!((curve.length(&surface)? - 61f64.sqrt()).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn lift(&self, surface: &Surface) -> Result<Vec<DVec3>, CurveError> {
        let place = |&vertex: &[f64; 2]| match sample(surface, vertex.into())? {
            Sample::Position(position) => Ok(position),
            Sample::Metric { .. } => Err(CurveError::NoPositions),
        };
        self.vertices.iter().map(place).collect()
    }

    /// Returns the length of the curve on the surface, in the surface's unit. The length is the sum of the
    /// straight segments between the places where the curve crosses the grid's lines. A slowness does not
    /// change the length. Jumps have no length.
    ///
    /// # Errors
    /// If a part of the curve lies off the surface.
    pub fn length(&self, surface: &Surface) -> Result<f64, CurveError> {
        let points: Vec<DVec2> = self.points().map(DVec2::from).collect();
        let mut length = 0.0;
        for ends in points.windows(2).filter(|ends| !surface.are_copies(ends[0], ends[1])) {
            let places = grid_crossings(ends[0], ends[1])
                .into_iter()
                .map(|cut| sample(surface, ends[0].lerp(ends[1], cut)))
                .collect::<Result<Vec<_>, _>>()?;
            length += places.windows(2).map(|step| step[0].length_to(step[1])).sum::<f64>();
        }
        Ok(length)
    }

    /// Returns the indices of the vertices to which the curve jumps over a seam from the vertex before. The
    /// vertex before the first one of a closed curve is the last one.
    pub fn jumps(&self, surface: &Surface) -> Vec<usize> {
        if !surface.is_glued() {
            return Vec::new();
        }
        let vertices: Vec<DVec2> = self.vertices.iter().copied().map(DVec2::from).collect();
        let jumps = |&index: &usize| match index.checked_sub(1) {
            Some(before) => surface.are_copies(vertices[before], vertices[index]),
            None => self.closed && surface.are_copies(vertices[vertices.len() - 1], vertices[0]),
        };
        (0..vertices.len()).filter(jumps).collect()
    }

    /// Returns the parts of the curve between its jumps, which can be drawn in the parameter domain.
    pub fn parts(&self, surface: &Surface) -> Vec<Self> {
        let jumps = self.jumps(surface);
        let Some(&first) = jumps.first() else { return vec![self.clone()] };
        let mut vertices = self.vertices.clone();
        let mut ends: Vec<usize> = jumps.iter().skip(1).map(|jump| jump - first).collect();
        if self.closed {
            vertices.rotate_left(first);
        } else {
            ends = jumps;
        }
        ends.push(vertices.len());
        let mut start = 0;
        let part = |end| {
            let vertices = vertices[std::mem::replace(&mut start, end)..end].to_vec();
            Self { vertices, closed: false }
        };
        ends.into_iter().map(part).filter(|part| part.vertices.len() > 1).collect()
    }
}

fn sample(surface: &Surface, at: DVec2) -> Result<Sample, CurveError> {
    surface.place(at).ok_or(CurveError::Off { row: at.x, col: at.y })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geosweep_surface::builtin::Builtin;
    use geosweep_surface::{MetricTensor, Spacing};

    #[test]
    fn a_circle_of_latitude_is_as_long_as_it_should_be() {
        // The curve runs around the cylinder of radius 1, over three quarters of a turn, half-way up a cell.
        let surface = Builtin::Cylinder.surface(33, 129).unwrap();
        let curve = Curve { vertices: vec![[8.5, 0.0], [8.5, 128.0]], closed: false };
        let exact = 1.5 * std::f64::consts::PI;
        // Each of the 128 chords is shorter than its arc by a 24th of the squared angle.
        let chords = exact * (1.0 - (exact / 128.0).powi(2) / 24.0);
        let length = curve.length(&surface).unwrap();
        approx::assert_relative_eq!(length, chords, max_relative = 1e-7);
    }

    #[test]
    fn a_metric_has_lengths_and_no_places() {
        let metric = MetricTensor { rr: 4.0, rc: 0.0, cc: 9.0 };
        let surface = Surface::from_metric(4, 4, vec![metric; 16]).unwrap();
        let square = vec![[0.5, 0.5], [2.5, 0.5], [2.5, 2.5], [0.5, 2.5]];
        let curve = Curve { vertices: square, closed: true };
        approx::assert_relative_eq!(curve.length(&surface).unwrap(), 20.0, max_relative = 1e-12);
        assert_eq!(curve.lift(&surface), Err(CurveError::NoPositions));
    }

    #[test]
    fn curves_off_the_surface_are_errors() {
        let mut heights = vec![0.0; 25];
        heights[12] = f64::NAN;
        let surface = Surface::from_heights(5, 5, heights, Spacing::square(1.0)).unwrap();
        let through = Curve { vertices: vec![[0.0, 2.0], [4.0, 2.0]], closed: false };
        assert!(through.lift(&surface).is_ok());
        assert_eq!(through.length(&surface), Err(CurveError::Off { row: 2.0, col: 2.0 }));
        let outside = Curve { vertices: vec![[0.0, 4.5]], closed: false };
        assert_eq!(outside.lift(&surface), Err(CurveError::Off { row: 0.0, col: 4.5 }));
    }
}
