//! Measures the best rates that the CPU can reach. Comparing a map's time with them shows what limits its speed.
//! Solvers do not use them.

use std::sync::Barrier;
use std::time::{Duration, Instant};

use super::Instructions;
use super::behind::Behind;
use super::fronts::{LaneKind, SurfaceArray, TriangleFronts, TriangleKind, for_triangle_kind};
use super::lines::line::{GridLines, LinesInGrid};
use super::lines::span::TILE;
use super::rotated::changed::Changed;
use super::rotated::line_update::update_line;
use super::scan::{Scan, UpdateOptions};
use geosweep_surface::update::Wavefront;
use geosweep_surface::{EdgeLengths, Real, Spacing, Surface};

/// Best rates of several threads in single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CpuCeilings {
    /// Number of threads that run in parallel.
    pub threads: usize,
    /// Bytes per second, read plus written, of copies of 32 MiB for each thread. Copies of this size may fit
    /// a large cache.
    pub copy: f64,
    /// Updates from one triangle per second, by wavefront ([`Wavefront::FOR_ANY_SURFACE`]), for a line of points that
    /// stays in the nearest cache, with the best available instructions. Each point counts as two updates, even if one
    /// of its triangles is skipped.
    pub triangles: [f64; Wavefront::FOR_ANY_SURFACE.len()],
}

/// Number of values that a thread copies.
const COPIED: usize = 8 << 20;
/// Number of points of a line. With all their data they take about 12 KiB.
const POINTS: usize = 256;
/// Minimum duration of a measurement. The work is repeated for at least this time.
const LONG_ENOUGH: Duration = Duration::from_millis(20);
/// Number of repeated measurements. The shortest counts, since other work only adds time.
const TRIES: usize = 3;

impl CpuCeilings {
    /// Measures the ceilings of `threads` threads, in about half a second.
    pub fn measure(threads: usize) -> Self {
        let copied = (2 * COPIED * size_of::<f32>()) as f64;
        let edges = two_rows();
        Self {
            threads,
            copy: copied
                * rate(threads, || {
                    let (from, mut to) = (vec![1.0f32; COPIED], vec![0.0f32; COPIED]);
                    move || {
                        to.copy_from_slice(std::hint::black_box(&from));
                        std::hint::black_box(&mut to);
                    }
                }),
            triangles: Wavefront::FOR_ANY_SURFACE.map(|wavefront| {
                let lines = for_triangle_kind!(&edges, wavefront, kind => rate(threads, || {
                    let mut line = WarmLine::new(&edges, Clone::clone(&kind));
                    move || {
                        line.update();
                    }
                }));
                2.0 * POINTS as f64 * lines
            }),
        }
    }
}

/// Returns the rate, per second, at which all threads together repeat some work.
fn rate<W: FnMut()>(threads: usize, work: impl Fn() -> W + Sync) -> f64 {
    let together = Barrier::new(threads);
    let of_thread = || {
        let mut work = work();
        let mut time = |count: u32| {
            let start = Instant::now();
            (0..count).for_each(|_| work());
            start.elapsed()
        };
        let mut count = 1;
        while time(count) < LONG_ENOUGH {
            count *= 2;
        }
        together.wait();
        let shortest = (0..TRIES).map(|_| time(count)).min().unwrap_or(Duration::MAX);
        f64::from(count) / shortest.as_secs_f64()
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(of_thread)).collect();
        threads.into_iter().map(|thread| thread.join().expect("copies and updates end")).sum()
    })
}

/// Two rows of a plane. The second row is repeatedly updated from the first one.
struct WarmLine<'a, K: LaneKind<f32>> {
    edges: &'a EdgeLengths<f32>,
    kind: K,
    surface_data: SurfaceArray<K::SurfaceData>,
    times: Vec<f32>,
    carried: Vec<K::Carried>,
    changed: [Changed; POINTS / TILE],
}

fn two_rows() -> EdgeLengths<f32> {
    let plane = Surface::from_heights(2, POINTS, vec![0.0; 2 * POINTS], Spacing::square(1.0));
    let edges = plane.and_then(|plane| EdgeLengths::new(&plane));
    edges.expect("a plane is a surface with edges")
}

impl<'a, K: TriangleKind<f32> + LaneKind<f32>> WarmLine<'a, K> {
    /// Creates the rows. The first row has the front of a source that lies 300 rows before it, in the first
    /// column.
    fn new(edges: &'a EdgeLengths<f32>, kind: K) -> Self {
        let chart = edges.chart();
        let mut times = vec![f32::FAR; chart.bordered_points()];
        let mut carried = vec![K::Carried::default(); times.len()];
        for col in 0..POINTS {
            let (point, radius) = (chart.bordered(0, col), (col as f32).hypot(300.0));
            (times[point], carried[point]) = (radius, K::Carried::circle(radius));
        }
        let surface_data = kind.surface_data(chart);
        Self { edges, kind, surface_data, times, carried, changed: [Changed::No; POINTS / TILE] }
    }

    /// Updates all points and returns their number. They are reset to unreached first: a reached point would be
    /// settled, and its update skipped.
    fn update(&mut self) -> u64 {
        let (chart, scan) = (self.edges.chart(), Scan::DOWN);
        chart.row_of_mut(&mut self.times, 1).fill(f32::FAR);
        let mut lines = GridLines {
            behind: Behind::of(chart, scan),
            times: &mut self.times,
            carried: &mut self.carried,
            surface_data: &self.surface_data,
            edges: self.edges.planes(),
            surface: (chart.stride(), 0),
            place: LinesInGrid {
                edges: self.edges,
                scan,
                stride: chart.stride(),
                first: 0,
                before: 0,
                beyond: None,
            },
        };
        let options = UpdateOptions {
            scan,
            renews: true,
            limit: f64::INFINITY,
            instructions: Instructions::best(),
        };
        let updated =
            update_line(&self.kind, &mut lines, 2, &(0..POINTS), options, &mut self.changed);
        std::hint::black_box(updated).points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ceilings_are_those_of_some_machine() {
        let CpuCeilings { threads, copy, triangles } = CpuCeilings::measure(1);
        assert_eq!(threads, 1);
        // Wide enough for any machine, and narrow enough to detect a wrong unit.
        for rate in [copy, triangles[0], triangles[1], triangles[2]] {
            assert!((1e5..1e14).contains(&rate), "{copy:e} {triangles:?}");
        }
    }

    #[test]
    fn the_line_that_is_timed_is_one_that_a_front_reaches() {
        let edges = two_rows();
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let times = for_triangle_kind!(&edges, wavefront, kind => {
                let mut line = WarmLine::new(&edges, Clone::clone(&kind));
                for _ in 0..2 {
                    assert_eq!(line.update(), POINTS as u64, "none is settled");
                }
                line.times
            });
            // The front comes through the first row everywhere. Planar fronts are off by a tenth of a cell.
            for (i, time) in edges.chart().row_of(&times, 1).iter().enumerate() {
                let exact = (i as f32).hypot(301.0);
                assert!((time - exact).abs() < 0.1, "{wavefront} {i}: {time} {exact}");
            }
        }
    }
}
