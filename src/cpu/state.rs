//! Arrival times in a bordered array, and the update of one point in it.

use crate::surface::EdgeSlot;
use crate::surface::{Chart, Direction, EdgeLengths, Real, Seed};
use crate::update::Triangle;

/// A distance map as a CPU solver leaves it.
#[derive(Clone, Debug)]
pub struct Solution<R> {
    pub(super) chart: Chart,
    pub(super) times: Vec<R>,
    /// Iterations of four scans; fast marching counts as one.
    pub iterations: u32,
    /// Largest relative fall of an arrival time in the last iteration; a point that was reached
    /// in it counts as 1.
    pub residual: f64,
}

impl<R: Real> Solution<R> {
    /// No point reached but the seeds.
    pub(super) fn start(chart: Chart, seeds: &[Seed]) -> Self {
        let mut times = vec![R::FAR; chart.bordered_points()];
        for seed in seeds {
            let time = &mut times[chart.bordered(seed.row, seed.col)];
            *time = time.min(R::of(seed.time));
        }
        Self { chart, times, iterations: 0, residual: 1.0 }
    }

    /// The distances, row-major, +infinity where the sources do not reach.
    pub fn distances(&self) -> Vec<R> {
        let Chart { rows, cols } = self.chart;
        let finite = |&time: &R| if time < R::FAR { time } else { R::infinity() };
        (0..rows)
            .flat_map(|row| &self.times[self.chart.bordered(row, 0)..][..cols])
            .map(finite)
            .collect()
    }

    /// Lowers the arrival time at a point to that of an update; returns the relative change.
    #[inline]
    pub(super) fn lower(&mut self, point: usize, time: R) -> R {
        let before = self.times[point];
        if time < before {
            self.times[point] = time;
            (before - time) / before
        } else {
            R::zero()
        }
    }
}

/// Where a triangle's two other corners and its edges lie, seen from its point x0.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleSlots {
    x1: isize,
    x2: isize,
    l1: EdgeSlot,
    l2: EdgeSlot,
    c: EdgeSlot,
}

impl TriangleSlots {
    /// The triangle between two directions that follow one another.
    pub(super) fn new(chart: Chart, first: Direction, second: Direction) -> Self {
        let (from, to) = (first.step(), second.step());
        let base = Direction::ALL
            .into_iter()
            .find(|direction| direction.step() == (to.0 - from.0, to.1 - from.1))
            .expect("the directions of a triangle follow one another");
        Self {
            x1: chart.offset(first),
            x2: chart.offset(second),
            l1: EdgeSlot::new(chart, 0, first),
            l2: EdgeSlot::new(chart, 0, second),
            c: EdgeSlot::new(chart, chart.offset(first), base),
        }
    }

    /// The triangle's lengths and its arrival times, each seen through `time`.
    #[inline]
    pub(super) fn load<R: Real>(
        self,
        edges: &EdgeLengths<R>,
        point: usize,
        time: impl Fn(usize) -> R,
    ) -> Triangle<R> {
        Triangle {
            t1: time(point.wrapping_add_signed(self.x1)),
            t2: time(point.wrapping_add_signed(self.x2)),
            l1: edges.at(point, self.l1),
            l2: edges.at(point, self.l2),
            c: edges.at(point, self.c),
        }
    }
}
