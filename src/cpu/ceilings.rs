//! What the CPU can do at best, measured: against these ceilings a map's time tells what bounds
//! it. Solvers do not use them.

use std::sync::Barrier;
use std::time::{Duration, Instant};

use super::Instructions;
use super::line::{Line, Times};
use super::line_update::{How, Update};
use super::tiles::{Scan, TILE};
use crate::surface::Real;
use crate::update::Wavefront;

/// What some threads can do at best in single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ceilings {
    /// At work side by side.
    pub threads: usize,
    /// Bytes a second, read plus written, of copies of 32 MiB for each thread, which may fit a
    /// large cache.
    pub copy: f64,
    /// Updates from one triangle a second, by wavefront ([`Wavefront::ALL`]), of a line of points
    /// that stays in the nearest cache, on the best instructions there are. Two are counted for a
    /// point, also where one is left out because it brings nothing.
    pub triangles: [f64; Wavefront::ALL.len()],
}

/// Numbers that a thread copies.
const COPIED: usize = 8 << 20;
/// Points of a line: with all that belongs to them some 12 KiB.
const POINTS: usize = 256;
/// Work is repeated until it takes so long.
const LONG_ENOUGH: Duration = Duration::from_millis(20);
/// And again so many times, of which the shortest counts: other work only adds.
const TRIES: usize = 3;

impl Ceilings {
    /// Measures so many threads, in about half a second.
    pub fn measure(threads: usize) -> Self {
        let copied = (2 * COPIED * size_of::<f32>()) as f64;
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
            triangles: Wavefront::ALL.map(|wavefront| {
                2.0 * POINTS as f64
                    * rate(threads, || {
                        let mut line = WarmLine::new(wavefront);
                        move || {
                            line.update();
                        }
                    })
            }),
        }
    }
}

/// How many times a second all threads together do some work.
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

/// A line of points and the line behind it, with squares between them.
struct WarmLine {
    how: How,
    times: Vec<f32>,
    curvatures: Vec<f32>,
    behind: Vec<f32>,
    curvatures_behind: Vec<f32>,
    gaussian: Vec<f32>,
    sides: Vec<f32>,
    diagonals: Vec<f32>,
    changed: [bool; POINTS / TILE],
}

impl WarmLine {
    fn new(wavefront: Wavefront) -> Self {
        let instructions = Instructions::best();
        Self {
            how: How { wavefront, scan: Scan::DOWN, renews: true, instructions },
            times: vec![f32::FAR; POINTS],
            curvatures: vec![0.0; POINTS],
            behind: (0..POINTS + 2).map(|i| (1.0 + i as f32).hypot(300.0)).collect(),
            curvatures_behind: (0..POINTS + 2)
                .map(|i| 1.0 / (1.0 + i as f32).hypot(300.0))
                .collect(),
            gaussian: vec![0.0; POINTS + 2],
            sides: vec![1.0; POINTS + 1],
            diagonals: vec![std::f32::consts::SQRT_2; POINTS],
            changed: [false; POINTS / TILE],
        }
    }

    /// Updates all points, none of which has been reached: those would be settled. Returns how many.
    fn update(&mut self) -> u64 {
        self.times.fill(f32::FAR);
        let (sides, diagonals) = (self.sides.as_slice(), self.diagonals.as_slice());
        let times = Times {
            here: &mut self.times,
            behind: &self.behind,
            edges: [diagonals, &sides[..POINTS], diagonals],
            bases: sides,
        };
        let line = Line {
            times,
            curvatures: &mut self.curvatures,
            gaussian: &self.gaussian[..POINTS],
            curvatures_behind: &self.curvatures_behind,
            gaussian_behind: &self.gaussian,
            next: 0,
        };
        let update = Update { line, how: self.how, changed: &mut self.changed };
        std::hint::black_box(self.how.instructions.run(update)).points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ceilings_are_those_of_some_machine() {
        let Ceilings { threads, copy, triangles } = Ceilings::measure(1);
        assert_eq!(threads, 1);
        // Wide enough for any machine, and narrow enough to find a wrong unit.
        for rate in [copy, triangles[0], triangles[1], triangles[2]] {
            assert!((1e5..1e14).contains(&rate), "{copy:e} {triangles:?}");
        }
    }

    #[test]
    fn the_line_that_is_timed_is_one_that_a_front_reaches() {
        for wavefront in Wavefront::ALL {
            let mut line = WarmLine::new(wavefront);
            for _ in 0..2 {
                assert_eq!(line.update(), POINTS as u64, "none is settled");
            }
            // The front of a point 301 lines behind, so that it comes through the line behind
            // everywhere. Planar fronts are off by a tenth of a cell.
            for (i, time) in line.times.iter().enumerate() {
                let exact = (2.0 + i as f32).hypot(301.0);
                assert!((time - exact).abs() < 0.1, "{wavefront} {i}: {time} {exact}");
            }
        }
    }
}
