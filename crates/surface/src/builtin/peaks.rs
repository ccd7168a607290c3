//! Defines MATLAB's demonstration surface "peaks".

use super::jet::Smooth;

/// Height relative to MATLAB's, so that slopes stay below about 70 degrees.
const HEIGHT: f64 = 0.25;

/// Returns the position of (u, v). The height is [`HEIGHT`] times
/// 3 (1 - x)^2 e^(-x^2 - (y + 1)^2) - 10 (x/5 - x^3 - y^5) e^(-x^2 - y^2) - 1/3 e^(-(x + 1)^2 - y^2),
/// for x and y from -3 to 3.
pub(super) fn position<T: Smooth>(uv: [T; 2]) -> [T; 3] {
    let [x, y] = uv.map(|along| along * 6.0 - 3.0);
    let bell = |x: T, y: T| ((x.squared() + y.squared()) * -1.0).exp();
    let (x_cubed, y_fifth) = (x.squared() * x, y.squared().squared() * y);
    let z = (x - 1.0).squared() * bell(x, y + 1.0) * 3.0
        - (x * 0.2 - x_cubed - y_fifth) * bell(x, y) * 10.0
        - bell(x + 1.0, y) * (1.0 / 3.0);
    [x, y, z * HEIGHT]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn has_its_well_known_heights() {
        let height = |x: f64, y: f64| {
            let position = position([(x + 3.0) / 6.0, (y + 3.0) / 6.0]);
            approx::assert_abs_diff_eq!(position[0], x, epsilon = 1e-14);
            position[2] / HEIGHT
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
