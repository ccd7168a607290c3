//! Least-squares scaling by majorisation (SMACOF), accelerated.

use super::classical::classical_scaling;
use super::extrapolation::{Extrapolation, Iterate};
use super::guttman::{Transformed, transform};
use super::{CanonicalError, CanonicalForm, Distances};
use crate::cpu::Instructions;

/// Default of [`FormOptions::tolerance`].
pub const DEFAULT_TOLERANCE: f64 = 1e-4;
/// Iterations that must change little before the stress counts as settled: extrapolated steps
/// are of all sizes.
const CALM: u32 = 2;
/// The stress at which distances agree but for the rounding of single precision, relative to the
/// sum of their squares.
const ROUNDING: f64 = 1e-13;

/// How to compute a canonical form.
#[derive(Clone, Debug, PartialEq)]
pub struct FormOptions {
    /// Number of coordinates of a point, K.
    pub dimensions: usize,
    /// Stop when the stress falls by less than this fraction in each of two iterations.
    pub tolerance: f64,
    /// Stop after this many iterations. Each is one pass over all pairs, or two where an
    /// extrapolated step fails.
    pub iterations: usize,
    /// Where to start from.
    pub start: Start,
    /// Extrapolate from the last steps; else each iteration is a Guttman transform and no more.
    pub extrapolate: bool,
}

impl Default for FormOptions {
    fn default() -> Self {
        Self {
            dimensions: 3,
            tolerance: DEFAULT_TOLERANCE,
            iterations: 1000,
            start: Start::Classical,
            extrapolate: true,
        }
    }
}

/// What majorisation starts from. It ends in a minimum of the stress, which need not be the least
/// one, and never leaves a plane that it starts in.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Start {
    /// The form by classical scaling.
    #[default]
    Classical,
    /// These n x K coordinates, row-major.
    Form(Vec<f64>),
}

/// The state after an iteration, for a progress bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Iterations made.
    pub iteration: usize,
    /// The raw stress.
    pub stress: f64,
    /// By which fraction the stress fell.
    pub change: f64,
}

/// Computes the canonical form of a matrix of distances: the points whose straight distances fit
/// best, by least squares with a weight of 1 for every pair.
///
/// # Errors
/// If there are too few points for the dimensions, an option is out of its range, or the start
/// does not fit.
pub fn canonical_form(
    distances: &Distances,
    options: &FormOptions,
) -> Result<CanonicalForm, CanonicalError> {
    canonical_form_with(distances, options, |_| ())
}

/// As [`canonical_form`], and calls `after` with each step.
///
/// # Errors
/// As [`canonical_form`].
pub fn canonical_form_with(
    distances: &Distances,
    options: &FormOptions,
    mut after: impl FnMut(Step),
) -> Result<CanonicalForm, CanonicalError> {
    options.check(distances.points())?;
    let &FormOptions { dimensions, tolerance, iterations, .. } = options;
    let instructions = Instructions::best();
    let mut place = match &options.start {
        Start::Classical => classical_scaling(distances, dimensions, instructions),
        Start::Form(coordinates) => coordinates.clone(),
    };
    let at = |place: &[f64]| {
        let Transformed { form, stress } = transform(distances, dimensions, place, instructions);
        (Iterate::new(place, form), stress)
    };
    let floor = ROUNDING * sum_of_squares(distances);
    let mut extrapolation = Extrapolation::default();
    let (mut here, mut stress) = at(&place);
    let mut stresses = vec![stress];
    let mut calm = 0;
    let mut converged = stress <= floor;
    while !converged && stresses.len() <= iterations {
        let extrapolated = if options.extrapolate { extrapolation.from(&here) } else { None };
        let mut taken = None;
        if let Some(ahead) = extrapolated {
            let (there, less) = at(ahead.as_slice());
            if less < stress {
                taken = Some((ahead, there, less));
            } else {
                extrapolation.forget();
            }
        }
        let (next, there, less) = taken.unwrap_or_else(|| {
            let ahead = here.image.clone();
            let (there, less) = at(ahead.as_slice());
            (ahead, there, less)
        });
        if less >= stress {
            // A Guttman transform fails to lower the stress at a minimum only, as far as single
            // precision can tell.
            converged = true;
            break;
        }
        let change = (stress - less) / stress;
        extrapolation.note(&here, &there);
        (place, here, stress) = (next.as_slice().to_vec(), there, less);
        stresses.push(stress);
        after(Step { iteration: stresses.len() - 1, stress, change });
        calm = if change < tolerance { calm + 1 } else { 0 };
        converged = calm >= CALM || stress <= floor;
    }
    Ok(CanonicalForm::new(dimensions, &place, stresses, converged))
}

impl FormOptions {
    fn check(&self, points: usize) -> Result<(), CanonicalError> {
        let Self { dimensions, tolerance, .. } = *self;
        if dimensions == 0 {
            return Err(CanonicalError::Options("a form has at least one dimension".into()));
        }
        if points <= dimensions {
            return Err(CanonicalError::TooFewPoints { points, dimensions });
        }
        if !(0.0..1.0).contains(&tolerance) {
            let message = format!("tolerance {tolerance} is not in the range from 0 to 1");
            return Err(CanonicalError::Options(message));
        }
        let Start::Form(coordinates) = &self.start else { return Ok(()) };
        let found = coordinates.len();
        if points.checked_mul(dimensions) != Some(found) {
            return Err(CanonicalError::StartSize { found, points, dimensions });
        }
        match coordinates.iter().position(|coordinate| !coordinate.is_finite()) {
            Some(index) => {
                let (point, axis) = (index / dimensions, index % dimensions);
                Err(CanonicalError::StartNotFinite { point, axis })
            }
            None => Ok(()),
        }
    }
}

/// Over all pairs i < j.
fn sum_of_squares(distances: &Distances) -> f64 {
    let square = |&distance: &f32| f64::from(distance).powi(2);
    let row = |point| distances.row(point).iter().map(square).sum::<f64>();
    0.5 * (0..distances.points()).map(row).sum::<f64>()
}
