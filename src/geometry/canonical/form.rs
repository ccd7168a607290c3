//! The canonical form, and how well it fits.

use nalgebra::{DMatrix, SymmetricEigen};

/// Points in Euclidean space whose straight distances fit given ones.
#[derive(Clone, Debug, PartialEq)]
pub struct CanonicalForm {
    /// Number of coordinates of a point, K.
    pub dimensions: usize,
    /// n x K coordinates, row-major, in the unit of the distances: centred, along the form's
    /// principal axes, the widest first, with the farthest point's coordinate positive on each.
    pub coordinates: Vec<f64>,
    /// The raw stress, the sum over i < j of (d_ij - delta_ij)^2 for straight distances d and given
    /// ones delta: of the start, then after each iteration. It never rises.
    pub stresses: Vec<f64>,
    /// Whether the stress settled before the iterations ran out.
    pub converged: bool,
}

impl CanonicalForm {
    pub(super) fn new(
        dimensions: usize,
        coordinates: &[f64],
        stresses: Vec<f64>,
        converged: bool,
    ) -> Self {
        let coordinates = along_principal_axes(dimensions, coordinates);
        Self { dimensions, coordinates, stresses, converged }
    }

    /// Number of points, n.
    pub fn points(&self) -> usize {
        self.coordinates.len() / self.dimensions
    }

    /// Iterations made.
    pub fn iterations(&self) -> usize {
        self.stresses.len() - 1
    }

    /// The raw stress.
    pub fn raw_stress(&self) -> f64 {
        self.stresses.last().copied().unwrap_or_default()
    }

    /// Kruskal's stress-1, the square root of the raw stress over the sum over i < j of d_ij^2.
    pub fn stress_1(&self) -> f64 {
        // For centred points that sum is n times the sum of their squares.
        let squares: f64 = self.coordinates.iter().map(|coordinate| coordinate.powi(2)).sum();
        (self.raw_stress() / (squares * self.points() as f64)).sqrt()
    }
}

fn along_principal_axes(dimensions: usize, coordinates: &[f64]) -> Vec<f64> {
    let mut form = DMatrix::from_row_slice(coordinates.len() / dimensions, dimensions, coordinates);
    let mean = form.row_mean();
    form.row_iter_mut().for_each(|mut point| point -= &mean);
    let axes = SymmetricEigen::new(form.tr_mul(&form));
    let mut order: Vec<usize> = (0..dimensions).collect();
    order.sort_by(|&a, &b| axes.eigenvalues[b].total_cmp(&axes.eigenvalues[a]));
    let mut turned = form * axes.eigenvectors.select_columns(&order);
    for mut axis in turned.column_iter_mut() {
        if axis.max() < -axis.min() {
            axis.neg_mut();
        }
    }
    turned.transpose().as_slice().to_vec()
}
