//! Chooses the engine of a map where the caller leaves the choice to the crate. No other module makes this
//! choice.

use crate::surface::Chart;

/// Minimum number of grid points for which a GPU is set up. Smaller grids are computed on the CPU.
///
/// A driver takes about 0.2 s for instance, device and pipelines. In that time the CPU computes about four
/// million points, at 40 ns a point for curved fronts. The time per point is measured; the set-up time is an
/// estimate, as no GPU was available.
const WORTH_A_GPU: usize = 1 << 22;

/// The chosen engine, with the reason for the choice.
#[derive(Debug, PartialEq)]
pub(crate) enum Choice {
    Cpu(String),
    /// A GPU if there is one. Software Vulkan devices (type CPU) do not count as GPUs.
    Gpu(String),
}

impl Choice {
    /// Chooses the engine of a map in single precision. Vulkan is not loaded yet: the loader and its drivers
    /// alone take longer than a small map.
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
