//! Computes canonical forms: points in Euclidean space whose straight-line distances approximate the geodesic
//! distances of a surface (multidimensional scaling).
//!
//! Bending a surface changes no geodesic distance. All bendings of a surface therefore share one canonical
//! form, up to rotation, reflection and translation. The form is an isometry-invariant signature (A. Elad and
//! R. Kimmel, "On bending invariant signatures for surfaces", IEEE PAMI 25(10), 2003; the paper, section 6.4
//! and figure 8).
//!
//! [`canonical_form`] minimises the raw stress, the sum over all pairs i < j of (|x_i - x_j| - delta_ij)^2.
//! The method is scaling by majorisation of a complicated function (SMACOF; J. de Leeuw and W. J. Heiser
//! 1980): each Guttman transform lowers the stress. The iteration starts from classical scaling and
//! extrapolates from step to step.
//!
//! ```
//! use geosweep::geometry::canonical::{Distances, FormOptions, align, canonical_form};
//! use geosweep::pairwise::Pairwise;
//! use geosweep::surface::builtin::Builtin;
//! use geosweep::{Options, Wavefront};
//!
//! // Three quarters of a cylinder unroll.
//! let cylinder = Builtin::Cylinder.surface(13, 17)?;
//! let options = Options::default().with_wavefront(Wavefront::Circular);
//! let (matrix, _) = Pairwise::new(&cylinder, &options)?.matrix(|_| ())?;
//! let distances = Distances::new(13 * 17, matrix)?;
//! let form = canonical_form(&distances, &FormOptions::default().with_dimensions(2))?;
//!
//! let (width, height) = (1.5 * std::f64::consts::PI, 3.0);
//! let flat: Vec<f64> = (0..13)
//!     .flat_map(|row| (0..17).map(move |col| (row, col)))
//!     .flat_map(|(row, col)| [width * col as f64 / 16.0, height * row as f64 / 12.0])
//!     .collect();
//! // The deviation is that of distances on so coarse a grid.
//! assert!(align(&form.coordinates, &flat, 2).deviation < 5e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod alignment;
mod classical;
mod distances;
mod error;
mod extrapolation;
mod form;
mod guttman;
mod smacof;

pub use alignment::{Alignment, align};
pub use distances::Distances;
pub use error::{ASYMMETRY, CanonicalError, EXTENT};
pub use form::CanonicalForm;
pub use smacof::{
    DEFAULT_TOLERANCE, FormOptions, FormStep, Start, canonical_form, canonical_form_with,
};
