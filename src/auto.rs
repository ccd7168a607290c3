//! Chooses the engine of a map where the caller leaves the choice to the crate. No other module makes this
//! choice.

use crate::surface::Chart;
use crate::update::Wavefront;

/// Nanoseconds of a whole call for each grid point: measuring the edges, uploading them to a GPU, the
/// converged map, and reading the distances back.
struct Costs {
    cpu: f64,
    gpu: f64,
}

/// Seconds in which a GPU is opened: loader, driver, device, and pipelines that a file keeps.
const OPENING: f64 = 0.25;
/// Seconds in which the pipelines of a map are compiled where no file keeps them.
const COMPILING: f64 = 1.0;

/// Returns the cost of a point, as measured on an NVIDIA H200 and 16 cores of its host (docs/devices) on a
/// sphere of 4096 x 4096 points. The CPU measures edges in 3 ns (estimated from smaller grids) and solves maps
/// in 9 ns (planar fronts) and 23 ns (curved). The GPU is set up in 7 ns and solves maps in 2 ns, and the host
/// takes distances in 1 to 2 ns. On the CPU, circular fronts take 1.3 times as long as planar ones
/// (docs/speed.md), and anchored ones as long as curved ones.
fn costs(wavefront: Wavefront) -> Costs {
    match wavefront {
        Wavefront::Planar => Costs { cpu: 12.0, gpu: 10.0 },
        Wavefront::Circular => Costs { cpu: 14.0, gpu: 10.0 },
        Wavefront::Curved | Wavefront::Anchored => Costs { cpu: 26.0, gpu: 11.0 },
    }
}

/// The chosen engine, with the reason for the choice.
#[derive(Debug, PartialEq)]
pub(crate) enum Choice {
    Cpu(String),
    /// A GPU if there is one. Software Vulkan devices (type CPU) do not count as GPUs.
    Gpu(String),
}

impl Choice {
    /// Chooses the engine of a map in single precision. `is_kept` says whether pipelines are kept in a file.
    /// Vulkan is not loaded yet: the loader and its drivers alone take longer than a small map.
    pub(crate) fn of(chart: Chart, wavefront: Wavefront, is_kept: bool) -> Self {
        let points = chart.points();
        let Costs { cpu, gpu } = costs(wavefront);
        let start = if is_kept { OPENING } else { OPENING + COMPILING };
        let least = (start / (1e-9 * (cpu - gpu))).ceil() as usize;
        let front = format!("{wavefront} fronts");
        if points < least {
            Self::Cpu(format!(
                "the CPU computes {points} points before a GPU is set up; with {front} a GPU is used from \
                 {least} on"
            ))
        } else {
            Self::Gpu(format!(
                "with {front} a GPU is worth its set-up for {least} points or more, here {points}"
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_gpu(side: usize, wavefront: Wavefront, is_kept: bool) -> bool {
        let chart = Chart { rows: side, cols: side };
        matches!(Choice::of(chart, wavefront, is_kept), Choice::Gpu(_))
    }

    /// 2048 x 2048 points with curved fronts take the CPU 0.1 s, and a GPU is not open by then.
    #[test]
    fn a_gpu_is_used_only_where_the_whole_call_is_faster() {
        use Wavefront::{Anchored, Circular, Curved, Planar};
        for wavefront in [Planar, Circular, Curved, Anchored] {
            let first =
                |is_kept| (1..=64).map(|k| 256 * k).find(|&side| on_gpu(side, wavefront, is_kept));
            let expected = match wavefront {
                Planar => (Some(11_264), None),
                Circular => (Some(7_936), None),
                Curved | Anchored => (Some(4_096), Some(9_216)),
            };
            assert_eq!((first(true), first(false)), expected, "{wavefront}");
        }
    }

    #[test]
    fn the_reason_names_the_points() {
        let choice = |rows, cols| Choice::of(Chart { rows, cols }, Wavefront::Curved, true);
        let small = choice(1025, 1025);
        assert!(
            matches!(&small, Choice::Cpu(reason) if reason.contains("1050625 points")),
            "{small:?}"
        );
        let large = choice(8192, 8192);
        assert!(matches!(&large, Choice::Gpu(reason) if reason.contains("67108864")), "{large:?}");
    }
}
