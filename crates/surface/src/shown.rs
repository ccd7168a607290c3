//! Formats texts and numbers for messages. The result is short for any file or argument.

use std::borrow::Cow;

/// Maximum number of characters of a text that a message quotes.
const MOST_QUOTED: usize = 60;

/// Returns `text` as a message quotes it: in one line, and cut after 60 characters.
///
/// ```
/// use geosweep::shown::excerpt;
/// assert_eq!(excerpt("row;col"), "row;col");
/// assert_eq!(excerpt("two\nlines"), "two lines");
/// assert_eq!(excerpt(&"x".repeat(1_000_000)).chars().count(), 61);
/// ```
pub fn excerpt(text: &str) -> Cow<'_, str> {
    let is_short = text.char_indices().nth(MOST_QUOTED).is_none();
    if is_short && !text.contains(char::is_control) {
        return text.into();
    }
    let printable = |c: char| if c.is_control() { ' ' } else { c };
    let mut shown: String = text.chars().take(MOST_QUOTED).map(printable).collect();
    if !is_short {
        shown.push('…');
    }
    shown.into()
}

/// Returns `text` without its middle if it has more than `most` characters. This suits file names, and the
/// errors of other crates.
pub fn shortened(text: &str, most: usize) -> Cow<'_, str> {
    let characters = text.chars().count();
    if characters <= most {
        return text.into();
    }
    let half = most / 2;
    let head = text.chars().take(half);
    let tail = text.chars().skip(characters - half);
    head.chain(['…']).chain(tail).collect::<String>().into()
}

/// Returns a number with all its digits. Numbers that would need many zeros have an exponent.
///
/// ```
/// use geosweep::shown::exact;
/// assert_eq!([exact(12.5), exact(-3.0)], ["12.5", "-3"]);
/// assert_eq!([exact(1e38), exact(1.5e-7)], ["1e38", "1.5e-7"]);
/// ```
pub fn exact(number: f64) -> String {
    match number.abs() {
        0.0 | 1e-5..1e15 => number.to_string(),
        size if size.is_finite() => format!("{number:e}"),
        _ => number.to_string(),
    }
}

/// Returns a number rounded to seven significant digits, as many as single precision has.
///
/// ```
/// use geosweep::shown::seven_digits;
/// assert_eq!(seven_digits(32611.8311), "32611.83");
/// assert_eq!(seven_digits(1.41421356e-8), "1.414214e-8");
/// assert_eq!(seven_digits(1e38), "1.000000e38");
/// assert_eq!(seven_digits(20015086.8), "20015087");
/// ```
pub fn seven_digits(number: f64) -> String {
    match number.abs() {
        0.0 => "0".into(),
        size @ 1e-4..1e9 => {
            let behind = 6 - size.log10().floor() as i32;
            format!("{number:.*}", behind.max(0) as usize)
        }
        size if size.is_finite() => format!("{number:.6e}"),
        _ => number.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn quotes_are_short_and_in_one_line(text in ".{0,200}", repeats in 1usize..50) {
            let text = text.repeat(repeats);
            let shown = excerpt(&text);
            prop_assert!(shown.chars().count() <= MOST_QUOTED + 1);
            prop_assert!(!shown.contains(char::is_control));
            prop_assert!(shortened(&text, 300).chars().count() <= 301);
        }

        #[test]
        fn numbers_are_short_and_keep_their_digits(digits in 1.0..10.0f64, exponent in -300i32..300, negative: bool) {
            let number = if negative { -1.0 } else { 1.0 } * digits * 10f64.powi(exponent);
            for (shown, error) in [(seven_digits(number), 5.1e-7), (exact(number), 0.0)] {
                prop_assert!(shown.len() <= 26, "{shown}");
                let read: f64 = shown.parse().unwrap();
                prop_assert!((read - number).abs() <= error * number.abs(), "{shown} {number}");
            }
        }
    }

    #[test]
    fn numbers_that_are_none_have_names() {
        for shown in [exact(f64::INFINITY), seven_digits(f64::INFINITY)] {
            assert_eq!(shown, "inf");
        }
        assert_eq!([exact(0.0), seven_digits(0.0)], ["0", "0"]);
        assert_eq!(exact(f64::NAN), "NaN");
    }
}
