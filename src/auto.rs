//! Which engine computes a map where the choice is left to the crate: the one place where it is made.

use crate::surface::Chart;

/// Grids of fewer points are computed on the CPU before a GPU is set up. A driver takes some 0.2 s for
/// instance, device and pipelines, in which the CPU computes about four million points, curved fronts at
/// 40 ns a point. The latter is measured, the former reckoned: no GPU was at hand.
const WORTH_A_GPU: usize = 1 << 22;

/// An engine, and why it.
#[derive(Debug, PartialEq)]
pub(crate) enum Choice {
    Cpu(String),
    /// A GPU if there is one. A Vulkan device that is the same CPU is none.
    Gpu(String),
}

impl Choice {
    /// For a map in single precision. Nothing is asked of Vulkan yet: a loader and its drivers alone take
    /// longer than a small map.
    pub(crate) fn of(chart: Chart) -> Self {
        let points = chart.points();
        if points < WORTH_A_GPU {
            Self::Cpu(format!(
                "{points} points are computed before a GPU is set up; from {WORTH_A_GPU} on a GPU is used"
            ))
        } else {
            Self::Gpu(format!(
                "a GPU is worth its set-up for {WORTH_A_GPU} points or more, here {points}"
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_grids_are_for_the_cpu_and_large_ones_for_a_gpu() {
        let choice = |rows, cols| Choice::of(Chart { rows, cols });
        let small = choice(1025, 1025);
        assert!(
            matches!(&small, Choice::Cpu(reason) if reason.contains("1050625 points")),
            "{small:?}"
        );
        let large = choice(2048, 2048);
        assert!(matches!(&large, Choice::Gpu(reason) if reason.contains("4194304")), "{large:?}");
    }
}
