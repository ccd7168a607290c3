//! Geometry at single points of the surface, and the lengths between them.

use glam::{DMat2, DVec2, DVec3};

/// Geometry at one point of the surface, on the grid or between its points.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub enum Sample {
    Position(DVec3),
    Metric { at: DVec2, tensor: DMat2 },
}

impl Sample {
    /// Interpolates between samples of the same kind. The weights add up to one.
    pub(crate) fn interpolate(samples: &[(f64, Self)]) -> Self {
        let mut sum = match samples[0].1 {
            Self::Position(_) => Self::Position(DVec3::ZERO),
            Self::Metric { .. } => Self::Metric { at: DVec2::ZERO, tensor: DMat2::ZERO },
        };
        for &(weight, sample) in samples {
            match (&mut sum, sample) {
                (Self::Position(sum), Self::Position(position)) => *sum += weight * position,
                (Self::Metric { at, tensor }, Self::Metric { at: a, tensor: t }) => {
                    *at += weight * a;
                    *tensor += t * weight;
                }
                _ => unreachable!("a surface has one kind of geometry"),
            }
        }
        sum
    }

    /// Returns the place with a metric of determinant 1.
    pub(crate) fn without_scale(self) -> Self {
        match self {
            Self::Position(_) => self,
            Self::Metric { at, tensor } => {
                let scale = tensor.determinant().sqrt();
                Self::Metric { at, tensor: tensor * scale.recip() }
            }
        }
    }

    /// Returns the length of the straight step between two places: the chord between positions, or the mean
    /// of the lengths that the metric gives at both ends.
    #[doc(hidden)]
    pub fn length_to(self, other: Self) -> f64 {
        match (self, other) {
            (Self::Position(a), Self::Position(b)) => a.distance(b),
            (Self::Metric { at: a, tensor: g }, Self::Metric { at: b, tensor: h }) => {
                let m = b - a;
                0.5 * (m.dot(g * m).max(0.0).sqrt() + m.dot(h * m).max(0.0).sqrt())
            }
            _ => unreachable!("a surface has one kind of geometry"),
        }
    }

    /// Returns the parameter at which the straight line through `a` (0) and `b` (1) is nearest to this place. The
    /// parameter may lie outside of 0 to 1.
    pub(crate) fn foot_on(self, a: Self, b: Self) -> f64 {
        let (along, across) = match (self, a, b) {
            (Self::Position(x), Self::Position(a), Self::Position(b)) => {
                ((b - a).length_squared(), (x - a).dot(b - a))
            }
            (
                Self::Metric { at: x, tensor },
                Self::Metric { at: a, .. },
                Self::Metric { at: b, .. },
            ) => ((b - a).dot(tensor * (b - a)), (x - a).dot(tensor * (b - a))),
            _ => unreachable!("a surface has one kind of geometry"),
        };
        if along > 0.0 { across / along } else { 0.0 }
    }
}
