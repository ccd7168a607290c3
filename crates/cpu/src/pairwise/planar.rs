//! Implements the planar wavefront in SIMD lanes, with coefficients that all maps share.

use super::kernel::{Fan, Kernel, LANES, Lanes};
use super::reach::Reach;
use geosweep_surface::update::Corner;
use geosweep_surface::{Real, max, min};

/// The planar update. If it is `CAUSAL`, no front arrives at x0 earlier than at either end of the base, as in single
/// maps. In triangles that are not obtuse at x0, this holds anyway.
pub(super) struct Planar<const CAUSAL: bool>;

/// Coefficients of the planar update of a triangle (paper, eqs. 10 and 15, solved for t0).
///
/// With d = t2 - t1, the front arrives at t0 = t1 + w d + sqrt(alpha - beta d^2) if d is between `low` and
/// `high`. Beyond these limits the ray runs along an edge. The same formula, taken at the nearer limit, gives the
/// arrival along that edge. So the coefficients include the Dijkstra step (16) without a comparison.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlanarTriangle {
    low: f32,
    high: f32,
    w: f32,
    alpha: f32,
    beta: f32,
}

/// Coefficients of the update of a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coefficients {
    reach: Reach,
    edges: [f32; 3],
    triangles: [PlanarTriangle; 2],
}

/// Coefficients of the update through a part of an obtuse triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlanarPart {
    edges: [f32; 2],
    triangle: PlanarTriangle,
}

impl PlanarTriangle {
    fn new([l1, l2, c]: [f32; 3]) -> Self {
        let along_edges = |alpha, low| Self { low, high: f32::FAR, w: 0.0, alpha, beta: 0.0 };
        match Corner::new(l1, l2, c) {
            Corner::Triangle { foot, height, base } => {
                let (l1, l2) = (f64::from(l1), f64::from(l2));
                let [low, high] = [base * (foot - base) / l2, base * foot / l1];
                let slope = height / base;
                Self {
                    low: low as f32,
                    high: high as f32,
                    w: (foot / base) as f32,
                    alpha: (height * height) as f32,
                    beta: (slope * slope) as f32,
                }
            }
            Corner::Edges => along_edges(l1 * l1, l1 - l2),
            // One corner is a hole, which no front reaches.
            Corner::Edge(length) => along_edges(length * length, 0.0),
            Corner::Nothing => along_edges(f32::INFINITY, 0.0),
        }
    }

    /// Returns the arrival time at x0, given the arrival times at x1 and x2. The lengths of x0 x1 and x0 x2 serve only
    /// the bound of a causal update; arrivals along edges follow from the coefficients.
    #[inline(always)]
    fn arrival<const CAUSAL: bool>(&self, [t1, t2]: [f32; 2], [l1, l2]: [f32; 2]) -> f32 {
        let Self { low, high, w, alpha, beta } = *self;
        let later = min(max(t1, t2), min(t1 + l1, t2 + l2));
        let t1 = min(t1, t2 - low);
        let d = min(t2 - t1, high);
        let across = max(alpha - beta * d * d, 0.0);
        let time = t1 + (w * d + across.sqrt());
        if CAUSAL { max(time, later) } else { time }
    }
}

impl<const CAUSAL: bool> Kernel for Planar<CAUSAL> {
    type Coefficients = Coefficients;

    fn coefficients(fan: Fan) -> Coefficients {
        Coefficients {
            reach: Reach::new(fan),
            edges: fan.edges,
            triangles: fan.triangles().map(PlanarTriangle::new),
        }
    }

    #[inline(always)]
    fn may_change(
        here: &Lanes,
        [before, beside, after]: [&Lanes; 3],
        Coefficients { reach, .. }: &Coefficients,
    ) -> bool {
        let mut some = false;
        for lane in 0..LANES {
            let (a, b, c) = (before.0[lane], beside.0[lane], after.0[lane]);
            some |= reach.earliest(a, b, c) < here.0[lane];
        }
        some
    }

    #[inline(always)]
    fn arrivals(
        [before, beside, after]: [&Lanes; 3],
        Coefficients { edges: [la, lb, lc], triangles: [left, right], .. }: &Coefficients,
    ) -> Lanes {
        let mut times = Lanes::all(0.0);
        for lane in 0..LANES {
            let (a, b, c) = (before.0[lane], beside.0[lane], after.0[lane]);
            times.0[lane] = min(
                left.arrival::<CAUSAL>([a, b], [*la, *lb]),
                right.arrival::<CAUSAL>([b, c], [*lb, *lc]),
            );
        }
        times
    }

    type Part = PlanarPart;

    fn part(lengths: [f32; 3]) -> PlanarPart {
        let [l1, l2, _] = lengths;
        PlanarPart { edges: [l1, l2], triangle: PlanarTriangle::new(lengths) }
    }

    #[inline(always)]
    fn through([x1, x2]: [&Lanes; 2], PlanarPart { edges, triangle }: &PlanarPart) -> Lanes {
        let mut times = Lanes::all(0.0);
        for lane in 0..LANES {
            times.0[lane] = triangle.arrival::<CAUSAL>([x1.0[lane], x2.0[lane]], *edges);
        }
        times
    }
}
