//! The point-source wavefront in lanes, from coefficients that all maps share.

use super::kernel::{Changes, Fan, How, Kernel, LANES, Lanes};
use crate::surface::{Real, Seed, max, min};
use crate::update::Corner;

pub(super) struct PointSource;

/// What the circular update needs of a triangle: the place of x0 over the base, x1 at the origin.
/// Not a number where there is no triangle, so that every comparison fails.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    foot: f32,
    height: f32,
    base: f32,
    half_base: f32,
    half_per_base: f32,
}

/// What the update needs of a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coefficients {
    edges: [f32; 3],
    triangles: [Triangle; 2],
}

impl Triangle {
    fn new(l1: f32, l2: f32, c: f32) -> Self {
        let (foot, height, base) = match Corner::new(l1, l2, c) {
            Corner::Triangle { foot, height, base } => (foot, height, base),
            _ => (f64::NAN, f64::NAN, f64::NAN),
        };
        Self {
            foot: foot as f32,
            height: height as f32,
            base: base as f32,
            half_base: (0.5 * base) as f32,
            half_per_base: (0.5 / base) as f32,
        }
    }

    /// The square of the arrival time at x0 if the ray crosses the base, else infinity.
    ///
    /// The same front as in [`crate::update::point_source`]: its virtual source lies at (x, -y), t1
    /// away from x1 and t2 from x2. In squares, which costs no division and one square root, and
    /// rounds to the precision of t0 and not to that of the step; with a coefficient or two ready
    /// and all sources at grid points, that is what is fast and good enough.
    #[inline(always)]
    fn arrival_squared(&self, t1: f32, t2: f32) -> f32 {
        let Self { foot, height, base, half_base, half_per_base } = *self;
        let x = (t1 - t2) * (t1 + t2) * half_per_base + half_base;
        let y_squared = (t1 - x) * (t1 + x);
        let y = max(y_squared, 0.0).sqrt();
        let crossing = x * height + y * foot;
        let width = base * (y + height);
        let upwind = (y_squared >= 0.0) & (crossing >= 0.0) & (crossing <= width);
        let (across, along) = (height + y, foot - x);
        if upwind { across * across + along * along } else { f32::INFINITY }
    }
}

impl Kernel for PointSource {
    type State = Lanes;
    type Coefficients = Coefficients;

    const UNREACHED: Lanes = Lanes::all(f32::FAR);

    fn coefficients(fan: Fan) -> Coefficients {
        let [before, beside, after] = fan.edges;
        let [first, second] = fan.bases;
        Coefficients {
            edges: fan.edges,
            triangles: [Triangle::new(before, beside, first), Triangle::new(beside, after, second)],
        }
    }

    fn start(times: &mut Lanes, lane: usize, seed: Seed) {
        times.0[lane] = seed.time as f32;
    }

    #[inline(always)]
    fn update<const TRACKS: bool>(
        here: &mut Lanes,
        [before, beside, after]: [&Lanes; 3],
        Coefficients { edges, triangles: [left, right] }: &Coefficients,
        _: How,
        changes: &mut Changes,
    ) {
        for lane in 0..LANES {
            let (a, b, c) = (before.0[lane], beside.0[lane], after.0[lane]);
            let along_edge = min(min(a + edges[0], b + edges[1]), c + edges[2]);
            let squared = min(left.arrival_squared(a, b), right.arrival_squared(b, c));
            let old = here.0[lane];
            let new = min(old, min(along_edge, squared.sqrt()));
            here.0[lane] = new;
            if TRACKS {
                changes.largest[lane] = changes.largest[lane].max(old.units_between(new));
            }
        }
    }
}
