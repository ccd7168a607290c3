//! The length of geodesics on the ellipsoid of WGS 84: the reference for maps of the Earth.

/// Semi-axes of the WGS84 ellipsoid in metres, and its flattening.
pub const EQUATOR: f64 = 6_378_137.0;
const FLATTENING: f64 = 1.0 / 298.257_223_563;
const POLAR: f64 = EQUATOR * (1.0 - FLATTENING);

/// Returns the length of the geodesic between two places, given by longitude and latitude in degrees, by Vincenty's
/// inverse formula (Survey Review 23, 1975), which errs by less than a millimetre. The result is `None` for opposite
/// points, and for nearly opposite ones for which the iteration does not converge.
pub fn vincenty(from: [f64; 2], to: [f64; 2]) -> Option<f64> {
    let [[lon1, lat1], [lon2, lat2]] = [from, to].map(|place| place.map(f64::to_radians));
    let reduced = |lat: f64| ((1.0 - FLATTENING) * lat.tan()).atan().sin_cos();
    let ((sin1, cos1), (sin2, cos2)) = (reduced(lat1), reduced(lat2));
    let mut lambda = lon2 - lon1;
    for _ in 0..200 {
        let (sin, cos) = lambda.sin_cos();
        let across = (cos2 * sin).hypot(cos1 * sin2 - sin1 * cos2 * cos);
        let along = sin1 * sin2 + cos1 * cos2 * cos;
        let sigma = across.atan2(along);
        if across == 0.0 {
            return (along > 0.0).then_some(0.0);
        }
        let sin_alpha = cos1 * cos2 * sin / across;
        let squared = 1.0 - sin_alpha * sin_alpha;
        // Along the equator, `squared`, the squared cosine of alpha, is zero.
        let middle = if squared > 0.0 { along - 2.0 * sin1 * sin2 / squared } else { 0.0 };
        let c = FLATTENING / 16.0 * squared * (4.0 + FLATTENING * (4.0 - 3.0 * squared));
        let bracket = middle + c * along * (2.0 * middle * middle - 1.0);
        let next =
            lon2 - lon1 + (1.0 - c) * FLATTENING * sin_alpha * (sigma + c * across * bracket);
        if (next - lambda).abs() < 1e-13 {
            let u2 = squared * (EQUATOR * EQUATOR - POLAR * POLAR) / (POLAR * POLAR);
            let a = 1.0 + u2 / 16384.0 * (4096.0 + u2 * (-768.0 + u2 * (320.0 - 175.0 * u2)));
            let b = u2 / 1024.0 * (256.0 + u2 * (-128.0 + u2 * (74.0 - 47.0 * u2)));
            let m2 = middle * middle;
            let last = b / 6.0 * middle * (4.0 * across * across - 3.0) * (4.0 * m2 - 3.0);
            let correction = b * across * (middle + b / 4.0 * (along * (2.0 * m2 - 1.0) - last));
            return Some(POLAR * a * (sigma - correction));
        }
        lambda = next;
    }
    None
}
