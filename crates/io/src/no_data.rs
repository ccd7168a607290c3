//! Compares values with those that mean "no data", as GDAL does.

/// The precision in which a file holds its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Held {
    /// Integers, or floating-point numbers of at most 32 bits.
    Single,
    /// Floating-point numbers of 64 bits.
    Double,
}

/// Returns whether a value means "no data". Files often give that value rounded, so numbers that agree to four units in
/// the last place of single precision are equal, also in double precision. As in GDAL, the sum of two numbers near the
/// largest one of single precision overflows there, so that all of these are equal: -3.4e38 is -3.4028235e38.
pub(super) fn means_no_data(found: f64, no_data: f64, held: Held) -> bool {
    match held {
        Held::Double => are_equal(found, no_data, f64::from(f32::EPSILON)),
        Held::Single => {
            let (found, no_data) = (found as f32, no_data as f32);
            found == no_data
                || (found - no_data).abs() < 2.0 * (f32::EPSILON * (found + no_data).abs())
        }
    }
}

/// Returns whether two numbers agree up to rounding, in numbers with the distance `epsilon` from 1 to the next one.
fn are_equal(a: f64, b: f64, epsilon: f64) -> bool {
    a == b || (a - b).abs() < 2.0 * (epsilon * (a + b).abs())
}

/// Returns whether a value of an unknown type means "no data", given a value that a user has typed. Integers that single
/// precision holds are compared exactly, so that 1000000 is not 1000001.
pub(super) fn means_given_no_data(found: f64, no_data: f64) -> bool {
    if no_data.is_nan() {
        return found.is_nan();
    }
    let are_integers =
        found.fract() == 0.0 && no_data.fract() == 0.0 && found.abs() <= LARGEST_EXACT;
    if are_integers {
        return found == no_data;
    }
    match f64::from(found as f32) == found {
        true => means_no_data(found, no_data, Held::Single),
        false => are_equal(found, no_data, f64::EPSILON),
    }
}

/// All integers up to this one are numbers in single precision.
const LARGEST_EXACT: f64 = (1 << 24) as f64;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn rounded_values_are_equal_as_for_gdal() {
        // The expectations are the masks of rasterio 1.4 (GDAL 3.9) for an ESRI ASCII grid with these values.
        let largest = f64::from(f32::MAX);
        for (found, no_data, is_equal) in [
            (-largest, -3.4e38, true),
            (-largest, -3.402823e38, true),
            (-largest, -1.7976931348623157e308, false),
            (-largest, 3.4e38, false),
            (-9999.0, -9999.0, true),
            (-9999.0, -9998.99, false),
            (-32768.0, -32767.0, false),
        ] {
            assert_eq!(means_no_data(found, no_data, Held::Single), is_equal, "{found} {no_data}");
        }
        // GDAL 3.10 compares the 64-bit numbers of a GeoTIFF in this way too.
        for (found, no_data, is_equal) in [
            (-9999.0, -9999.001, true),
            (-9999.0, -9999.01, false),
            (-largest, -3.402823e38, true),
            (-largest, -3.4e38, false),
            (1e300, 1e300 * (1.0 + 1e-7), true),
            (2.0, 2.000_01, false),
        ] {
            assert_eq!(means_no_data(found, no_data, Held::Double), is_equal, "{found} {no_data}");
        }
    }

    proptest! {
        #[test]
        fn given_values_are_found_in_either_precision(value in -1e9..1e9f64, integer in -1_000_000..1_000_000i32) {
            prop_assert!(means_given_no_data(f64::from(value as f32), value));
            prop_assert!(means_given_no_data(value, value));
            prop_assert!(!means_given_no_data(value * 1.001, value) || value == 0.0);
            let integer = f64::from(integer);
            prop_assert!(means_given_no_data(integer, integer));
            prop_assert!(!means_given_no_data(integer, integer + 1.0));
        }
    }
}
