//! Holds a canonical form and measures how well it fits.

use nalgebra::{DMatrix, RowDVector, SymmetricEigen};

/// Points in Euclidean space whose straight-line distances approximate given distances.
#[derive(Clone, Debug, PartialEq)]
pub struct CanonicalForm {
    /// The number of coordinates of a point, K.
    pub dimensions: usize,
    /// The n x K coordinates, row-major, in the unit of the distances.
    ///
    /// The form is centred. Its axes are the principal axes, the widest first. On each axis the coordinate of
    /// the farthest point is positive.
    pub coordinates: Vec<f64>,
    /// The raw stress of the start and after each iteration. It never increases.
    ///
    /// The raw stress is the sum over i < j of (d_ij - delta_ij)^2, where d are the straight-line distances
    /// and delta the given distances.
    pub stresses: Vec<f64>,
    /// Whether the stress settled before the limit of iterations was reached.
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

    /// Returns the number of points, n.
    pub fn points(&self) -> usize {
        self.coordinates.len() / self.dimensions
    }

    /// Returns the number of iterations.
    pub fn iterations(&self) -> usize {
        self.stresses.len() - 1
    }

    /// Returns the raw stress.
    pub fn raw_stress(&self) -> f64 {
        self.stresses.last().copied().unwrap_or_default()
    }

    /// Returns Kruskal's stress-1: the square root of the raw stress divided by the sum over i < j of d_ij^2.
    pub fn stress_1(&self) -> f64 {
        // For centred points, the sum of d_ij^2 is n times the sum of squared coordinates.
        let squares: f64 = self.coordinates.iter().map(|coordinate| coordinate.powi(2)).sum();
        (self.raw_stress() / (squares * self.points() as f64)).sqrt()
    }
}

/// Returns points relative to their mean, one per row, and the mean.
pub(super) fn centred(dimensions: usize, coordinates: &[f64]) -> (DMatrix<f64>, RowDVector<f64>) {
    let mut form = DMatrix::from_row_slice(coordinates.len() / dimensions, dimensions, coordinates);
    let mean = form.row_mean();
    form.row_iter_mut().for_each(|mut point| point -= &mean);
    (form, mean)
}

fn along_principal_axes(dimensions: usize, coordinates: &[f64]) -> Vec<f64> {
    let (form, _) = centred(dimensions, coordinates);
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
