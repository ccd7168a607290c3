//! MATLAB's demonstration surface "peaks".

use glam::{DVec2, DVec3};

/// Height relative to the usual one, so that slopes stay below about 70 degrees.
const HEIGHT: f64 = 0.25;

/// z = 3 (1 - x)^2 e^(-x^2 - (y + 1)^2) - 10 (x/5 - x^3 - y^5) e^(-x^2 - y^2)
///     - 1/3 e^(-(x + 1)^2 - y^2), for x and y from -3 to 3, times [`HEIGHT`].
pub(super) fn position(uv: DVec2) -> DVec3 {
    let xy = 6.0 * uv - DVec2::splat(3.0);
    let DVec2 { x, y } = xy;
    let bell = |centre: DVec2| (-(xy - centre).length_squared()).exp();
    let z = 3.0 * (1.0 - x).powi(2) * bell(DVec2::new(0.0, -1.0))
        - 10.0 * (x / 5.0 - x.powi(3) - y.powi(5)) * bell(DVec2::ZERO)
        - bell(DVec2::new(-1.0, 0.0)) / 3.0;
    xy.extend(HEIGHT * z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn has_its_well_known_heights() {
        let height = |x: f64, y: f64| {
            let position = position(DVec2::new(x + 3.0, y + 3.0) / 6.0);
            approx::assert_abs_diff_eq!(position.x, x, epsilon = 1e-14);
            position.z / HEIGHT
        };
        // The highest of MATLAB's 49 x 49 samples, the lowest extremum and the middle.
        approx::assert_abs_diff_eq!(height(0.0, 1.625), 8.0752, epsilon = 1e-4);
        approx::assert_abs_diff_eq!(height(0.228, -1.626), -6.5511, epsilon = 1e-4);
        approx::assert_abs_diff_eq!(
            height(0.0, 0.0),
            (3.0 - 1.0 / 3.0) / 1f64.exp(),
            epsilon = 1e-12
        );
    }
}
