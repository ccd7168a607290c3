//! Formats tables as Markdown with aligned columns, so that they are also readable as plain text in a terminal.

use std::fmt::{self, Display, Formatter};

/// A table of `N` columns with heads.
pub struct Columns<'a, const N: usize> {
    pub heads: [&'a str; N],
    /// The columns that hold text and are aligned to the left. All others hold numbers and are aligned to the
    /// right.
    pub texts: &'a [usize],
    pub lines: Vec<[String; N]>,
}

impl<const N: usize> Display for Columns<'_, N> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { heads, texts, lines } = self;
        let width = |text: &str| text.chars().count();
        let widths: [usize; N] = std::array::from_fn(|k| {
            lines.iter().map(|line| width(&line[k])).fold(width(heads[k]), usize::max)
        });
        let cells = |f: &mut Formatter<'_>, cells: [&str; N]| -> fmt::Result {
            for (k, (cell, width)) in cells.iter().zip(&widths).enumerate() {
                if texts.contains(&k) {
                    write!(f, "| {cell:<width$} ")?
                } else {
                    write!(f, "| {cell:>width$} ")?
                }
            }
            writeln!(f, "|")
        };
        cells(f, *heads)?;
        for (k, width) in widths.iter().enumerate() {
            let colon = if texts.contains(&k) { '-' } else { ':' };
            write!(f, "|{}{colon}", "-".repeat(width + 1))?;
        }
        writeln!(f, "|")?;
        lines.iter().try_for_each(|line| cells(f, line.each_ref().map(String::as_str)))
    }
}

/// Formats a share as a percentage. Returns an empty string for `None`.
pub fn percent(share: Option<f64>) -> String {
    share.map_or(String::new(), |share| format!("{:.0} %", 100.0 * share))
}

/// Formats a number with two decimals below 1, with one decimal below 10, and without decimals otherwise.
pub fn digits(number: f64) -> String {
    let decimals = if number < 0.995 { 2 } else { usize::from(number < 9.95) };
    format!("{number:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_two_digits_or_more() {
        let texts = [0.123, 1.23, 9.96, 123.4].map(digits);
        assert_eq!(texts, ["0.12", "1.2", "10", "123"]);
    }

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let lines = vec![["a".into(), "1".into()], ["\u{3b1}\u{3b2}\u{3b3}".into(), "23".into()]];
        let table = Columns { heads: ["x", "n"], texts: &[0], lines }.to_string();
        let expected = "| x   |  n |\n|-----|---:|\n| a   |  1 |\n| \u{3b1}\u{3b2}\u{3b3} | 23 |\n";
        assert_eq!(table, expected);
    }
}
