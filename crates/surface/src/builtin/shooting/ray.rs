//! Integrates geodesics from one place, and the rate at which neighbouring ones diverge.

use glam::{DVec2, DVec3};

use crate::builtin::jet::Jet;

/// A function from u and v to a position in space, with derivatives.
pub(in crate::builtin) trait Position: Fn([Jet; 2]) -> [Jet; 3] + Sync {}

impl<F: Fn([Jet; 2]) -> [Jet; 3] + Sync> Position for F {}

/// The state of a geodesic at some length, with the Jacobi field along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ray {
    /// (u, v).
    pub(super) at: DVec2,
    /// Derivative of (u, v) with respect to length.
    pub(super) heading: DVec2,
    /// The Jacobi field J: the distance between neighbouring rays per angle between them at the start.
    pub(super) spread: f64,
    /// Derivative of J with respect to length.
    pub(super) spreading: f64,
}

/// First and second derivatives of a parametrisation at one place.
pub(super) struct Frame {
    by_u: DVec3,
    by_v: DVec3,
    /// Derivatives with respect to uu, uv and vv.
    second: [DVec3; 3],
    /// Coefficients of the first fundamental form, E, F and G.
    metric: DVec3,
}

impl Frame {
    pub(super) fn new(position: [Jet; 3]) -> Self {
        let [x, y, z] = position;
        let by_u = DVec3::new(x.first.x, y.first.x, z.first.x);
        let by_v = DVec3::new(x.first.y, y.first.y, z.first.y);
        let second = |k: usize| DVec3::new(x.second[k], y.second[k], z.second[k]);
        Self {
            by_u,
            by_v,
            second: [second(0), second(1), second(2)],
            metric: DVec3::new(by_u.length_squared(), by_u.dot(by_v), by_v.length_squared()),
        }
    }

    /// Returns the length of a vector given by its u and v components.
    pub(super) fn length(&self, along: DVec2) -> f64 {
        (along.x * self.by_u + along.y * self.by_v).length()
    }

    /// Returns the unit tangent vector, by its u and v components, at an angle from the direction of u.
    pub(super) fn direction(&self, angle: f64) -> DVec2 {
        let DVec3 { x: e, y: f, z: g } = self.metric;
        let across = (g - f * f / e).sqrt().recip();
        let (sin, cos) = angle.sin_cos();
        cos * DVec2::new(e.sqrt().recip(), 0.0) + sin * across * DVec2::new(-f / e, 1.0)
    }

    /// Returns the second derivative of (u, v) with respect to length. A geodesic's acceleration in space is
    /// normal to the surface.
    pub(super) fn acceleration(&self, heading: DVec2) -> DVec2 {
        let [uu, uv, vv] = self.second;
        let DVec2 { x: u, y: v } = heading;
        let curved = u * u * uu + 2.0 * u * v * uv + v * v * vv;
        let (along_u, along_v) = (-self.by_u.dot(curved), -self.by_v.dot(curved));
        let DVec3 { x: e, y: f, z: g } = self.metric;
        DVec2::new(g * along_u - f * along_v, e * along_v - f * along_u) / (e * g - f * f)
    }

    /// Returns the Gaussian curvature.
    pub(super) fn curvature(&self) -> f64 {
        let normal = self.by_u.cross(self.by_v);
        let [l, m, n] = self.second.map(|second| second.dot(normal));
        (l * n - m * m) / normal.length_squared().powi(2)
    }
}

impl Ray {
    /// Returns the ray whose numbers differ from this one's by `factor` times those of another.
    fn moved(self, by: Self, factor: f64) -> Self {
        Self {
            at: self.at + by.at * factor,
            heading: self.heading + by.heading * factor,
            spread: self.spread + by.spread * factor,
            spreading: self.spreading + by.spreading * factor,
        }
    }

    pub(super) fn start(from: DVec2, frame: &Frame, angle: f64) -> Self {
        Self { at: from, heading: frame.direction(angle), spread: 0.0, spreading: 1.0 }
    }

    /// Returns the derivative with respect to length, with J'' = -K J.
    pub(super) fn derivative(self, position: &impl Position) -> Self {
        let frame = Frame::new(position(Jet::variables(self.at)));
        Self {
            at: self.heading,
            heading: frame.acceleration(self.heading),
            spread: self.spreading,
            spreading: -frame.curvature() * self.spread,
        }
    }

    /// Returns the ray one step further, given its derivative here. The method is the extrapolation of
    /// Gragg's midpoint rule, of sixth order (Hairer, Norsett, Wanner, "Solving Ordinary Differential
    /// Equations I", section II.9).
    pub(super) fn advance(self, derivative: Self, step: f64, position: &impl Position) -> Self {
        const PARTS: [usize; 3] = [2, 4, 6];
        let midpoint = |parts: usize| {
            let part = step / parts as f64;
            let (mut before, mut now) = (self, self.moved(derivative, part));
            for _ in 1..parts {
                (before, now) = (now, before.moved(now.derivative(position), 2.0 * part));
            }
            now
        };
        // Aitken-Neville extrapolation to parts of length 0. The error is an even function of the length.
        let mut row = [self; PARTS.len()];
        for (index, parts) in PARTS.into_iter().enumerate() {
            let mut better = midpoint(parts);
            for k in 0..index {
                let coarser = std::mem::replace(&mut row[k], better);
                let ratio = parts as f64 / PARTS[index - 1 - k] as f64;
                let change = better.moved(coarser, -1.0);
                better = better.moved(change, (ratio * ratio - 1.0).recip());
            }
            row[index] = better;
        }
        row[row.len() - 1]
    }
}
