//! Checks whether a surface fits the machine's memory.

/// The number of bytes per point: its position, its edge lengths in double and single precision, both
/// engines, and a map.
const POINT_BYTES: usize = 150;

/// Returns whether `points` points fit the available memory. If the system does not report it (only Linux
/// does), returns true.
pub fn fits(points: usize) -> bool {
    let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    available(&text).is_none_or(|bytes| points.saturating_mul(POINT_BYTES) < bytes)
}

fn available(meminfo: &str) -> Option<usize> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<usize>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_is_found() {
        let text = "MemTotal:  24689764 kB\nMemAvailable:   1024 kB\n";
        assert_eq!(available(text), Some(1 << 20));
        assert_eq!(available("MemTotal: 1 kB\n"), None);
        assert!(
            !fits(usize::MAX)
                || available(&std::fs::read_to_string("/proc/meminfo").unwrap_or_default())
                    .is_none()
        );
    }
}
