//! Computes the fan of each point: the directions of its edges, as angles around the point.
//!
//! The angles of the triangles around a point, measured by their lengths, add up to a full turn less the angle defect.
//! The angles are scaled to a full turn. Rays that pass the point then have one direction in all its triangles, also
//! where grid lines bend.

mod glued;

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use crate::angle::angle_of;
use crate::chart::{Direction, EdgeSlot, ring};
use crate::edges::EdgeLengths;
use crate::lanes::{Instructions, Loop};
use crate::precision::{OfEdges, of_edges};
use crate::{Real, kept, max, min};

/// The Gaussian curvature of the surface at a point, with its tag, and the angles of the point's eight edges.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(transparent)]
#[doc(hidden)]
pub struct Fan<R>([R; 5]);

impl<R: Real> Fan<R> {
    /// Packs the fan from words of angles ([`Real::angle_between`]), one for each direction in [`Direction::ALL`].
    fn new(gaussian: R, angles: [R::Bits; 8]) -> Self {
        let half = size_of::<R>() * 4;
        let pair = |at: usize| R::from_bits(angles[2 * at] | angles[2 * at + 1] >> half);
        Self([gaussian, pair(0), pair(1), pair(2), pair(3)])
    }

    /// Returns the Gaussian curvature.
    #[inline(always)]
    pub fn gaussian(&self) -> R {
        self.0[0]
    }

    /// Returns the angle of an edge. The lower half of the word is not defined.
    #[inline(always)]
    pub fn angle(&self, to: usize) -> R::Bits {
        self.0[1 + to / 2].to_bits() << (to % 2 * size_of::<R>() * 4)
    }
}

impl<R: Real> EdgeLengths<R> {
    /// Returns the fan of each point of the bordered array. The fans are computed on the first call.
    #[doc(hidden)]
    pub fn shared_fans(&self) -> Arc<Vec<Fan<R>>> {
        static FANS: OfEdges<Vec<Fan<f32>>, Vec<Fan<f64>>> = (fans, fans);
        kept(&self.shared.fans, || Arc::new(of_edges(self, FANS))).clone()
    }

    /// Returns the angle in a point's fan of a step in rows and columns, as a word. It follows from the triangle that
    /// the step enters, as if that triangle were flat. Where there is no triangle, the angle is interpolated between
    /// the edges of the chart.
    #[doc(hidden)]
    pub fn angle_of_step(&self, fan: &Fan<R>, point: usize, [down, right]: [f64; 2]) -> R::Bits {
        let shares = |k: usize| {
            let ends = [k, ring::next(k)].map(|to| Direction::ALL[to].vector());
            let area = ends[0].perp_dot(ends[1]);
            let step = glam::DVec2::new(down, right);
            [step.perp_dot(ends[1]) / area, ends[0].perp_dot(step) / area]
        };
        let ahead = |k: usize| {
            let [a, b] = shares(k);
            a.min(b)
        };
        let k = (0..8).max_by(|&a, &b| ahead(a).total_cmp(&ahead(b))).unwrap_or(0);
        let [a, b] = shares(k).map(|share| R::of(share.max(0.0)));
        let [l1, l2, base] = self.wedge(point, k);
        let longest = max(max(l1, l2), base);
        let wedge = R::angle_between(fan.angle(k), fan.angle(ring::next(k)));
        if longest >= R::FAR {
            return R::angle_ahead(fan.angle(k), wedge * b / max(a + b, R::min_positive_value()));
        }
        let [cosine, sine] = corner(l1, l2, base);
        let along = angle_of([a * l1 + b * l2 * cosine, b * l2 * sine]);
        let whole = angle_of([cosine, sine]);
        let sign = if wedge < R::zero() { -R::one() } else { R::one() };
        // The scaling of the fan is shared by both sides of the step.
        let spread = (wedge.abs() - whole) * R::of(0.5);
        R::angle_ahead(
            fan.angle(k),
            sign * (along + spread * (b / max(a + b, R::min_positive_value()) * R::of(2.0))),
        )
    }

    /// Returns the lengths of two successive edges of a point and of the base between their ends.
    fn wedge(&self, point: usize, k: usize) -> [R; 3] {
        let (to, next) = (Direction::ALL[k], Direction::ALL[ring::next(k)]);
        let chart = self.chart();
        let base = EdgeSlot::new(chart, chart.offset(to), to.base());
        [EdgeSlot::of(chart, to), EdgeSlot::of(chart, next), base].map(|slot| self.at(point, slot))
    }
}

/// Computes the fans of all points of the bordered array.
fn fans<R: Real>(edges: &EdgeLengths<R>) -> Vec<Fan<R>> {
    let chart = edges.chart();
    let gaussian = edges.gaussian_curvature();
    let mut all: Vec<_> = gaussian
        .par_iter()
        .map(|&gaussian| Fan([gaussian, R::zero(), R::zero(), R::zero(), R::zero()]))
        .collect();
    chart.rows_mut(&mut all).enumerate().for_each(|(row, line)| {
        Instructions::best().run(OfRow { edges, row, line });
    });
    glued::join(edges, &mut all);
    all
}

/// The fans of a row of points, which already have their Gaussian curvature.
struct OfRow<'a, R> {
    edges: &'a EdgeLengths<R>,
    row: usize,
    line: &'a mut [Fan<R>],
}

impl<R: Real> Loop for OfRow<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { edges, row, line } = self;
        let [fan, bases] = edges.fans(row, 0..line.len());
        for (number, block) in line.chunks_mut(BLOCK).enumerate() {
            let (first, count) = (number * BLOCK, block.len().min(BLOCK));
            let [fan, bases] = [fan, bases].map(|of| of.map(|lengths| &lengths[first..][..count]));
            let mut angles = [[R::Bits::default(); BLOCK]; 8];
            for col in 0..count {
                let mut wedges = [R::zero(); 8];
                for to in 0..8 {
                    wedges[to] = wedge(fan[to][col], fan[ring::next(to)][col], bases[to][col]);
                }
                let of_point = around(wedges);
                for to in 0..8 {
                    angles[to][col] = of_point[to];
                }
            }
            for (col, of_point) in block.iter_mut().enumerate() {
                *of_point = Fan::new(of_point.gaussian(), angles.map(|of_edge| of_edge[col]));
            }
        }
    }
}

/// Number of points whose angles are computed at once. They are packed by a loop of its own, which compilers do not
/// vectorize.
const BLOCK: usize = 16;

/// Returns cosine and sine of the angle between two edges.
#[inline(always)]
fn corner<R: Real>(a: R, b: R, base: R) -> [R; 2] {
    let (zero, one) = (R::zero(), R::one());
    let x = R::of(0.5) * ((a * a + b * b) - base * base) / (a * b);
    let x = min(max(x, -one), one);
    [x, max((one - x) * (one + x), zero).sqrt()]
}

/// Returns the angle between two successive edges, or `FAR` if the triangle is missing.
#[inline(always)]
fn wedge<R: Real>(a: R, b: R, base: R) -> R {
    let is_there = max(max(a, b), base) < R::FAR;
    let angle = angle_of(corner(a, b, base));
    if is_there { angle } else { R::FAR }
}

/// Returns the angle of each edge, from the angles between successive edges, of which some may be `FAR`. Whole fans are
/// scaled to a full turn. In others, the missing triangles fill what is left of the turn, each in proportion to the
/// triangle opposite to it.
#[inline(always)]
fn around<R: Real>(wedges: [R; 8]) -> [R::Bits; 8] {
    let zero = R::zero();
    let (mut there, mut missing, mut filled) = (zero, zero, [zero; 8]);
    for to in 0..8 {
        let opposite = wedges[ring::opposite(to)];
        let guess = if opposite < R::FAR { opposite } else { R::of(std::f64::consts::FRAC_PI_4) };
        let is_there = wedges[to] < R::FAR;
        filled[to] = if is_there { wedges[to] } else { guess };
        there = there + if is_there { wedges[to] } else { zero };
        missing = missing + if is_there { zero } else { guess };
    }
    let turn = R::of(std::f64::consts::TAU);
    let is_whole = missing <= zero;
    let (of_there, of_missing) = (
        if is_whole { turn / there } else { R::one() },
        if is_whole { R::one() } else { max(turn - there, zero) / missing },
    );
    let mut angles = [R::Bits::default(); 8];
    let mut angle = zero;
    for to in 0..8 {
        angles[to] = R::angle_ahead(R::Bits::default(), angle);
        angle = angle + filled[to] * if wedges[to] < R::FAR { of_there } else { of_missing };
    }
    angles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::Builtin;

    fn angle(fan: &Fan<f64>, to: Direction) -> f64 {
        f64::angle_between(0, fan.angle(to as usize))
    }

    #[test]
    fn fans_on_a_plane_are_those_of_the_chart() {
        let surface =
            crate::Surface::from_heights(7, 9, vec![0.0; 63], crate::Spacing { dx: 3.0, dy: 1.0 });
        let edges = EdgeLengths::<f64>::new(&surface.unwrap()).unwrap();
        let (fans, chart) = (edges.shared_fans(), edges.chart());
        for (row, col) in chart.places() {
            let point = chart.bordered(row, col);
            let fan = &fans[point];
            for to in Direction::ALL {
                let (down, right) = to.step();
                let expected = f64::atan2(-down as f64, 3.0 * right as f64);
                let off = f64::angle_between(f64::angle_ahead(0, expected), fan.angle(to as usize));
                let is_there = chart.neighbour(row, col, to).is_some();
                assert!(!is_there || off.abs() < 1e-6, "{row},{col} {to:?}: {off}");
            }
            for step in [[0.3, 0.4], [-0.2, 0.1], [0.5, -2.0], [1.0, 0.0], [-3.0, -1.0]] {
                let expected = f64::atan2(-step[0], 3.0 * step[1]);
                let found = edges.angle_of_step(fan, point, step);
                let off = f64::angle_between(f64::angle_ahead(0, expected), found);
                let is_inside = row > 0 && col > 0 && row < 6 && col < 8;
                assert!(!is_inside || off.abs() < 1e-6, "{row},{col} {step:?}: {off}");
            }
        }
    }

    #[test]
    fn fans_make_a_full_turn() {
        let edges = EdgeLengths::<f64>::new(&Builtin::Peaks.surface(31, 40).unwrap()).unwrap();
        let (fans, chart) = (edges.shared_fans(), edges.chart());
        for (row, col) in chart.places() {
            let fan = &fans[chart.bordered(row, col)];
            let between = |to: usize| f64::angle_between(fan.angle(to), fan.angle(ring::next(to)));
            let turn: f64 = (0..8).map(between).sum();
            assert!((turn - std::f64::consts::TAU).abs() < 1e-6, "{row},{col}: {turn}");
            assert!((0..8).all(|to| between(to) > 0.0));
            assert!(angle(fan, Direction::East).abs() < 1e-6);
        }
    }
}
