//! Chooses the engine of a map if the caller leaves the choice to the crate. Only this module does so.

use crate::surface::Chart;
use crate::update::Wavefront;

/// Cost of a whole call in nanoseconds per grid point: measuring the edges, uploading them to a GPU, solving the map,
/// and reading the distances back.
#[derive(Clone, Copy)]
struct Costs {
    cpu: f64,
    gpu: f64,
}

/// CPU time to measure the edges, in nanoseconds per grid point. A limited map needs it for all points, reached or not.
const MEASURING: f64 = 3.0;
/// GPU time to solve a map, in nanoseconds per grid point. The rest of the GPU's cost, set-up and read-back, is for all
/// points even in a limited map.
const SOLVING_ON_GPU: f64 = 2.0;

impl Costs {
    /// Returns the costs per grid point of a map that reaches the fraction `share` of the points.
    fn of_share(self, share: f64) -> Self {
        Self {
            cpu: MEASURING + (self.cpu - MEASURING) * share,
            gpu: self.gpu - SOLVING_ON_GPU * (1.0 - share),
        }
    }
}

/// Seconds to open a GPU: the loader, the driver, the device, and the pipelines stored in a file.
const OPENING: f64 = 0.25;
/// Seconds to compile the pipelines of a map if no file stores them.
const COMPILING: f64 = 1.0;

/// Returns the costs of a point, as measured on an NVIDIA H200 and 16 cores of its host (docs/devices) on a sphere of
/// 4096 x 4096 points. The CPU measures edges in 3 ns (estimated from smaller grids) and solves maps in 9 ns (planar
/// fronts) and 23 ns (curved). The GPU is set up in 7 ns and solves maps in 2 ns, and the host reads distances back in
/// 1 to 2 ns. On the CPU, circular fronts take 1.3 times as long as planar ones (docs/speed.md), and anchored ones as
/// long as curved ones.
fn costs(wavefront: Wavefront) -> Costs {
    match wavefront {
        Wavefront::Planar => Costs { cpu: 12.0, gpu: 10.0 },
        Wavefront::Circular => Costs { cpu: 14.0, gpu: 10.0 },
        // A GPU has no fronts that carry their ray.
        Wavefront::Rays => Costs { cpu: 80.0, gpu: f64::INFINITY },
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
    /// Chooses the engine of a map in single precision. `share` is the expected share of the points that the map
    /// reaches: 1 without a radius and targets. `is_kept`: whether pipelines are stored in a file. Vulkan is not loaded
    /// for this choice, since the loader and its drivers alone take longer than a small map.
    pub(crate) fn of(chart: Chart, wavefront: Wavefront, share: f64, is_kept: bool) -> Self {
        let points = chart.points();
        if wavefront == Wavefront::Rays {
            return Self::Cpu(format!("only the CPU computes {wavefront} fronts"));
        }
        let Costs { cpu, gpu } = costs(wavefront).of_share(share);
        let start = if is_kept { OPENING } else { OPENING + COMPILING };
        let mut of = format!("with {wavefront} fronts");
        if share < 1.0 {
            of += &format!(" and a limit to about {:.2} % of the points", 100.0 * share);
        }
        if cpu <= gpu {
            return Self::Cpu(format!(
                "{of} a GPU is not worth its set-up at any size, here {points} points"
            ));
        }
        let least = (start / (1e-9 * (cpu - gpu))).ceil() as usize;
        if points < least {
            Self::Cpu(format!(
                "the CPU computes {} points before a GPU is set up; {of} a GPU is used for grids of \
                 {least} points or more",
                (share * points as f64).ceil()
            ))
        } else {
            Self::Gpu(format!(
                "{of} a GPU is worth its set-up for {least} points or more, here {points}"
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_gpu(side: usize, wavefront: Wavefront, is_kept: bool) -> bool {
        let chart = Chart { rows: side, cols: side };
        matches!(Choice::of(chart, wavefront, 1.0, is_kept), Choice::Gpu(_))
    }

    /// Expects the smallest side, in steps of 256 points, for which a GPU is chosen, with and without pipelines stored
    /// in a file. For comparison, 2048 x 2048 points with curved fronts take the CPU 0.1 s, and opening a GPU alone
    /// takes longer.
    #[test]
    fn a_gpu_is_used_only_where_the_whole_call_is_faster() {
        use Wavefront::{Anchored, Circular, Curved, Planar, Rays};
        for wavefront in Wavefront::ALL {
            let first =
                |is_kept| (1..=64).map(|k| 256 * k).find(|&side| on_gpu(side, wavefront, is_kept));
            let expected = match wavefront {
                Planar => (Some(11_264), None),
                Circular => (Some(7_936), None),
                Curved | Anchored => (Some(4_096), Some(9_216)),
                Rays => (None, None),
            };
            assert_eq!((first(true), first(false)), expected, "{wavefront}");
        }
    }

    #[test]
    fn the_reason_names_the_points() {
        let choice = |rows, cols| Choice::of(Chart { rows, cols }, Wavefront::Curved, 1.0, true);
        let small = choice(1025, 1025);
        assert!(
            matches!(&small, Choice::Cpu(reason) if reason.contains("1050625 points")),
            "{small:?}"
        );
        let large = choice(8192, 8192);
        assert!(matches!(&large, Choice::Gpu(reason) if reason.contains("67108864")), "{large:?}");
    }

    /// With curved fronts, a map of 30 % of the points costs 9.9 ns on the CPU and 9.6 ns on a GPU for each point of
    /// the grid. A map of a fifth of the points costs less on the CPU at any size.
    #[test]
    fn a_limited_map_takes_a_gpu_where_its_part_is_large_enough() {
        let choice = |side: usize, share| {
            let chart = Chart { rows: side, cols: side };
            Choice::of(chart, Wavefront::Curved, share, true)
        };
        let first = |share| {
            (1..=256).map(|k| 256 * k).find(|&side| matches!(choice(side, share), Choice::Gpu(_)))
        };
        assert_eq!(first(1.0), Some(4_096));
        assert_eq!(first(0.5), Some(7_680));
        assert_eq!(first(0.3), Some(28_928));
        assert_eq!(first(0.2), None);
        let limited = choice(1025, 0.5);
        assert!(
            matches!(&limited, Choice::Cpu(reason)
                if reason.contains("525313 points") && reason.contains("about 50.00 % of the points")),
            "{limited:?}"
        );
        let small = choice(1025, 0.01);
        assert!(
            matches!(&small, Choice::Cpu(reason) if reason.contains("at any size")),
            "{small:?}"
        );
    }
}
