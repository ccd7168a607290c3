//! Lists in arguments: of sizes, and of whatever is compared.

use geosweep::shown::excerpt;

/// Points a side, as an argument.
pub fn size(text: &str) -> Result<usize, String> {
    const RANGE: std::ops::RangeInclusive<usize> = 2..=16384;
    match text.trim().parse() {
        Ok(size) if RANGE.contains(&size) => Ok(size),
        _ => Err(format!(
            "`{}` is no number of points a side from {} to {}",
            excerpt(text),
            RANGE.start(),
            RANGE.end()
        )),
    }
}

/// Sizes in order, each once.
pub fn ascending(sizes: &[usize]) -> Vec<usize> {
    let mut sizes = sizes.to_vec();
    sizes.sort_unstable();
    sizes.dedup();
    sizes
}

/// What was asked for, each once, or else the default.
pub fn or_else<T: Clone + PartialEq>(asked: &[T], default: impl FnOnce() -> Vec<T>) -> Vec<T> {
    let mut unique = if asked.is_empty() { default() } else { Vec::new() };
    for one in asked {
        if !unique.contains(one) {
            unique.push(one.clone());
        }
    }
    unique
}
