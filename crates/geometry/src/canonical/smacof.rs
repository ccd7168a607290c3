//! Computes least-squares scaling by majorisation (SMACOF) with extrapolation.

use super::classical::classical_scaling;
use super::extrapolation::{Extrapolation, Iterate};
use super::guttman::{Transformed, transform};
use super::{CanonicalError, CanonicalForm, Distances};
use geosweep_cpu::Instructions;

/// The default of [`FormOptions::tolerance`].
pub const DEFAULT_TOLERANCE: f64 = 1e-4;
/// The number of consecutive iterations with a small change after which the stress counts as settled. A
/// single such iteration is not enough, since extrapolated steps vary in size.
const CALM: u32 = 2;
/// The stress, relative to the sum of squared distances, at which the distances agree up to the rounding of
/// single precision.
const ROUNDING: f64 = 1e-13;

/// The options of a canonical form.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FormOptions {
    /// The number of coordinates of a point, K.
    pub dimensions: usize,
    /// The relative decrease of the stress below which the computation stops, if two iterations in a row stay
    /// below it.
    pub tolerance: f64,
    /// The largest number of iterations. Each takes one pass over all pairs, or two if an extrapolated step
    /// fails.
    pub iterations: usize,
    /// The start of the iteration.
    pub start: Start,
    /// Whether to extrapolate from the last steps. Without extrapolation each iteration is one Guttman
    /// transform.
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

impl FormOptions {
    /// Sets [`FormOptions::dimensions`].
    pub fn with_dimensions(self, dimensions: usize) -> Self {
        Self { dimensions, ..self }
    }

    /// Sets [`FormOptions::tolerance`].
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// Sets [`FormOptions::iterations`].
    pub fn with_iterations(self, iterations: usize) -> Self {
        Self { iterations, ..self }
    }

    /// Sets [`FormOptions::start`].
    pub fn with_start(self, start: Start) -> Self {
        Self { start, ..self }
    }

    /// Sets [`FormOptions::extrapolate`].
    pub fn with_extrapolation(self, extrapolate: bool) -> Self {
        Self { extrapolate, ..self }
    }
}

/// The start of the majorisation.
///
/// Majorisation ends in a local minimum of the stress, which need not be the global one. A start that lies in
/// a plane never leaves it.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Start {
    /// The form from classical scaling.
    #[default]
    Classical,
    /// The given n x K coordinates, row-major.
    Form(Vec<f64>),
}

/// The state after an iteration, for a progress bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FormStep {
    /// The number of iterations so far.
    pub iteration: usize,
    /// The raw stress.
    pub stress: f64,
    /// The relative decrease of the stress in this iteration.
    pub change: f64,
}

/// Computes the canonical form of a matrix of distances.
///
/// The straight-line distances of the form fit the given distances best by least squares, with weight 1 for
/// every pair.
///
/// # Errors
/// If there are too few points for the dimensions, an option is out of range, or the start does not fit.
pub fn canonical_form(
    distances: &Distances,
    options: &FormOptions,
) -> Result<CanonicalForm, CanonicalError> {
    canonical_form_with(distances, options, |_| ())
}

/// Computes the canonical form like [`canonical_form`], and calls `after` with each step.
///
/// # Errors
/// As for [`canonical_form`].
pub fn canonical_form_with(
    distances: &Distances,
    options: &FormOptions,
    mut after: impl FnMut(FormStep),
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
            // A Guttman transform lowers the stress except at a minimum, up to single precision.
            converged = true;
            break;
        }
        let change = (stress - less) / stress;
        extrapolation.note(&here, &there);
        (place, here, stress) = (next.as_slice().to_vec(), there, less);
        stresses.push(stress);
        after(FormStep { iteration: stresses.len() - 1, stress, change });
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

/// Returns the sum of squared distances over all pairs i < j.
fn sum_of_squares(distances: &Distances) -> f64 {
    let square = |&distance: &f32| f64::from(distance).powi(2);
    let row = |point| distances.row(point).iter().map(square).sum::<f64>();
    0.5 * (0..distances.points()).map(row).sum::<f64>()
}
