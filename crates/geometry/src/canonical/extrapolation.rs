//! Accelerates a fixed-point iteration by extrapolating from its last steps.

use std::collections::VecDeque;

use nalgebra::{Cholesky, DMatrix, DVector};

/// The number of steps that the extrapolation uses.
const MEMORY: usize = 8;
/// The regularisation, added to the diagonal of the normal equations relative to the largest diagonal entry.
/// It prevents nearly parallel steps from getting huge coefficients of opposite signs.
const REGULARISATION: f64 = 1e-10;

/// Anderson acceleration (1965; Walker and Ni, "Anderson acceleration for fixed-point iterations", 2011).
///
/// For linear iterations it is equivalent to reduced-rank extrapolation, which works in cycles (Rosman,
/// Bronstein, Bronstein, Sidi and Kimmel, "Fast multidimensional scaling using vector extrapolation", 2008,
/// for SMACOF). Anderson acceleration extrapolates anew at every step.
#[derive(Clone, Debug, Default)]
pub(super) struct Extrapolation {
    /// The changes of residual and image between consecutive accepted iterates, oldest first.
    steps: VecDeque<[DVector<f64>; 2]>,
}

/// The image of an iterate under the fixed-point map, and its residual.
#[derive(Clone, Debug)]
pub(super) struct Iterate {
    pub image: DVector<f64>,
    /// The image minus the iterate.
    pub residual: DVector<f64>,
}

impl Iterate {
    pub fn new(place: &[f64], image: Vec<f64>) -> Self {
        let image = DVector::from_vec(image);
        let residual = DVector::from_fn(place.len(), |index, _| image[index] - place[index]);
        Self { image, residual }
    }
}

impl Extrapolation {
    /// Records the step from one accepted iterate to the next.
    pub fn note(&mut self, from: &Iterate, to: &Iterate) {
        if self.steps.len() == MEMORY {
            self.steps.pop_front();
        }
        self.steps.push_back([&to.residual - &from.residual, &to.image - &from.image]);
    }

    pub fn forget(&mut self) {
        self.steps.clear();
    }

    /// Returns the point at which the residual would vanish if it were linear, by a least-squares fit to the
    /// recorded steps. Returns `None` without usable steps.
    pub fn from(&self, iterate: &Iterate) -> Option<DVector<f64>> {
        let count = self.steps.len();
        let residual = |k: usize| &self.steps[k][0];
        let mut normal = DMatrix::from_fn(count, count, |i, j| residual(i).dot(residual(j)));
        let largest = (0..count).map(|k| normal[(k, k)]).fold(0.0, f64::max);
        if largest == 0.0 {
            return None;
        }
        (0..count).for_each(|k| normal[(k, k)] += REGULARISATION * largest);
        let right = DVector::from_fn(count, |k, _| residual(k).dot(&iterate.residual));
        let weights = Cholesky::new(normal)?.solve(&right);
        let mut place = iterate.image.clone();
        for ([_, image], weight) in self.steps.iter().zip(weights.iter()) {
            place.axpy(-weight, image, 1.0);
        }
        Some(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_iteration_is_solved_in_a_few_steps() {
        // The iteration is x -> A x + b with eigenvalues up to 0.99. It would take a thousand plain steps for
        // four digits.
        let rates = [0.99, 0.9, 0.5, -0.3];
        let fixed = [1.0, -2.0, 3.0, 4.0];
        let image = |x: &[f64]| {
            let along = |k: usize| fixed[k] + rates[k] * (x[k] - fixed[k]);
            Iterate::new(x, (0..4).map(along).collect())
        };
        let mut extrapolation = Extrapolation::default();
        let mut here = image(&[0.0; 4]);
        for _ in 0..10 {
            let place = extrapolation.from(&here).unwrap_or_else(|| here.image.clone());
            let next = image(place.as_slice());
            extrapolation.note(&here, &next);
            here = next;
        }
        assert!((&here.image - DVector::from_row_slice(&fixed)).amax() < 1e-6, "{}", here.image);
    }
}
