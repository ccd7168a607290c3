//! Parses lists in arguments: sizes, and the things to compare.

use geosweep_cli::numbers::whole;

/// Parses a number of points per side.
pub fn size(text: &str) -> Result<usize, String> {
    whole("points per side", 2..=16384)(text)
}

/// Returns sizes in ascending order without duplicates.
pub fn ascending(sizes: &[usize]) -> Vec<usize> {
    let mut sizes = sizes.to_vec();
    sizes.sort_unstable();
    sizes.dedup();
    sizes
}

/// Returns the requested values without duplicates, or the default if none are requested.
pub fn or_else<T: Clone + PartialEq>(asked: &[T], default: impl FnOnce() -> Vec<T>) -> Vec<T> {
    let mut unique = if asked.is_empty() { default() } else { Vec::new() };
    for one in asked {
        if !unique.contains(one) {
            unique.push(one.clone());
        }
    }
    unique
}
