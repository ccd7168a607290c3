//! Implements the circular wavefront in SIMD lanes, with coefficients that all maps share.

use super::kernel::{Fan, Kernel, LANES, Lanes};
use super::reach::{Bulge, Reach};
use geosweep_surface::update::Corner;
use geosweep_surface::{max, min};

/// The circular update. If it is `CAUSAL`, no front arrives at x0 earlier than at either end of the base.
pub(super) struct Circular<const CAUSAL: bool>;

/// Coefficients of the circular update of a triangle with x1 at the origin, x2 at (base, 0) and x0 at (foot,
/// height). They are NaN where there is no triangle, so that every comparison fails.
#[derive(Clone, Copy, Debug)]
pub(super) struct CircularTriangle {
    half_base: f32,
    half_per_base: f32,
    /// Square of the length of x0 x1.
    side_squared: f32,
    twice_foot: f32,
    twice_height: f32,
    base: f32,
    /// Slopes of the rays that pass x1 and x2 on their way to x0: the distance along the base per distance
    /// across it.
    slopes: [f32; 2],
}

/// Coefficients of the update of a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coefficients {
    edges: [f32; 3],
    reach: Reach,
    bulge: Bulge,
    triangles: [CircularTriangle; 2],
}

/// Coefficients of the update through a part of an obtuse triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct CircularPart {
    edges: [f32; 2],
    triangle: CircularTriangle,
}

impl CircularTriangle {
    fn new([l1, l2, c]: [f32; 3]) -> Self {
        let (foot, height, base) = match Corner::new(l1, l2, c) {
            Corner::Triangle { foot, height, base } => (foot, height, base),
            _ => (f64::NAN, f64::NAN, f64::NAN),
        };
        Self {
            half_base: (0.5 * base) as f32,
            half_per_base: (0.5 / base) as f32,
            side_squared: (foot * foot + height * height) as f32,
            twice_foot: (2.0 * foot) as f32,
            twice_height: (2.0 * height) as f32,
            base: base as f32,
            slopes: [(-foot / height) as f32, ((base - foot) / height) as f32],
        }
    }

    /// Returns the square of the arrival time at x0 if the ray crosses the base, else infinity, given the squares of
    /// the arrival times at x1 and x2.
    ///
    /// The front is the same as in [`geosweep_surface::update::circular`]: its virtual source lies at (x, -y), t1
    /// away from x1 and t2 from x2. A computation with squares needs no division and one square root. It rounds to the
    /// precision of t0, which is coarser than the precision of the step from the base to x0. With a few precomputed
    /// coefficients and all sources at grid points, this is fast and accurate enough.
    #[inline(always)]
    fn arrival_squared<const CAUSAL: bool>(&self, t1_squared: f32, t2_squared: f32) -> f32 {
        let x = (t1_squared - t2_squared) * self.half_per_base + self.half_base;
        // `y` is NaN if no point has these distances from x1 and x2. All comparisons with NaN fail.
        let y = (t1_squared - x * x).sqrt();
        let upwind = (x >= self.slopes[0] * y) & (x <= self.base + self.slopes[1] * y);
        let rise = self.twice_height * y - self.twice_foot * x;
        let squared = (t1_squared + self.side_squared) + rise;
        let squared = if CAUSAL { max(squared, max(t1_squared, t2_squared)) } else { squared };
        if upwind { squared } else { f32::INFINITY }
    }
}

impl<const CAUSAL: bool> Kernel for Circular<CAUSAL> {
    type Coefficients = Coefficients;

    fn coefficients(fan: Fan) -> Coefficients {
        Coefficients {
            edges: fan.edges,
            reach: Reach::new(fan),
            bulge: Bulge::new(fan),
            triangles: fan.triangles().map(CircularTriangle::new),
        }
    }

    #[inline(always)]
    fn may_change(
        here: &Lanes,
        [before, beside, after]: [&Lanes; 3],
        Coefficients { reach, bulge, .. }: &Coefficients,
    ) -> bool {
        let mut some = false;
        for lane in 0..LANES {
            let (a, b, c, now) = (before.0[lane], beside.0[lane], after.0[lane], here.0[lane]);
            let first = min(min(a, b), c);
            some |= (first < now) & !bulge.keeps(reach.earliest(a, b, c) - now, first);
        }
        some
    }

    #[inline(always)]
    fn arrivals(
        [before, beside, after]: [&Lanes; 3],
        Coefficients { edges, triangles: [left, right], .. }: &Coefficients,
    ) -> Lanes {
        let mut times = Lanes::all(0.0);
        for lane in 0..LANES {
            let (a, b, c) = (before.0[lane], beside.0[lane], after.0[lane]);
            let along_edge = min(min(a + edges[0], b + edges[1]), c + edges[2]);
            let [aa, bb, cc] = [a * a, b * b, c * c];
            let [left, right] =
                [left.arrival_squared::<CAUSAL>(aa, bb), right.arrival_squared::<CAUSAL>(bb, cc)];
            times.0[lane] = min(along_edge, min(left, right).sqrt());
        }
        times
    }

    type Part = CircularPart;

    fn part(lengths: [f32; 3]) -> CircularPart {
        let [l1, l2, _] = lengths;
        CircularPart { edges: [l1, l2], triangle: CircularTriangle::new(lengths) }
    }

    #[inline(always)]
    fn through([x1, x2]: [&Lanes; 2], CircularPart { edges, triangle }: &CircularPart) -> Lanes {
        let mut times = Lanes::all(0.0);
        for lane in 0..LANES {
            let (a, b) = (x1.0[lane], x2.0[lane]);
            let along_edge = min(a + edges[0], b + edges[1]);
            let squared = triangle.arrival_squared::<CAUSAL>(a * a, b * b);
            times.0[lane] = min(along_edge, squared.sqrt());
        }
        times
    }
}
