//! Parses numbers as C libraries and GDAL write them.

/// Parses a number. It may have a decimal comma. NaN and infinity may be given by name, or as Microsoft's C library
/// prints them (`-1.#IND`, `1.#INF`).
pub fn c_number(text: &str) -> Option<f64> {
    let fallback = || match &text.to_ascii_lowercase()[..] {
        "1.#qnan" | "-1.#qnan" | "1.#snan" | "-1.#snan" | "1.#ind" | "-1.#ind" => Some(f64::NAN),
        "1.#inf" => Some(f64::INFINITY),
        "-1.#inf" => Some(f64::NEG_INFINITY),
        text => text.replacen(',', ".", 1).parse().ok(),
    };
    text.parse().ok().or_else(fallback)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_commas_are_understood() {
        assert_eq!(c_number("-9999"), Some(-9999.0));
        assert_eq!(c_number("0,5"), Some(0.5));
        assert_eq!(c_number("-1.#INF"), Some(f64::NEG_INFINITY));
        for text in ["nan", "-nan", "NaN", "-1.#IND", "1.#QNAN"] {
            assert!(c_number(text).unwrap().is_nan(), "{text}");
        }
        for text in ["", "abc", "3abc", "1,2,3", "1 2"] {
            assert_eq!(c_number(text), None, "{text}");
        }
    }
}
