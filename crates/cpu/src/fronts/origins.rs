//! Stores the origins of a map's fronts, and finds the origins of the fronts behind the points of a line.

use std::collections::HashMap;

use crate::lines::span::{Span, TILE};
use crate::scan::Scan;
use geosweep_surface::constants::MOST_ORIGINS;
use geosweep_surface::update::{Curvature, Curvatures, Front, Sighted, Steps, curved_from_origins};
use geosweep_surface::{Origin, Real};

/// The origins of a map, numbered in the order in which they are added.
#[derive(Clone, Debug, Default)]
pub(super) struct OriginTable<R> {
    numbers: HashMap<[u64; 5], u32>,
    sighted: Vec<Sighted<R>>,
}

/// Row and column of the chart's first point in bordered arrays.
const FIRST: [f64; 2] = [1.0; 2];

impl<R: Real> OriginTable<R> {
    pub(super) fn clear(&mut self) {
        self.numbers.clear();
        self.sighted.clear();
    }

    /// Returns the origin with the given number.
    pub(super) fn get(&self, number: u32) -> &Sighted<R> {
        &self.sighted[number as usize]
    }

    /// Returns the number of an origin, or `None` once there are too many origins.
    pub(super) fn number(&mut self, origin: &Origin) -> Option<u32> {
        let next = self.sighted.len() as u32;
        if let Some(&number) = self.numbers.get(&origin.key()) {
            return Some(number);
        }
        (next < MOST_ORIGINS).then(|| {
            self.numbers.insert(origin.key(), next);
            self.sighted.push(Sighted::of(origin, FIRST));
            next
        })
    }

    /// Returns the origin of a front from the data that it carries, in rows and columns of the bordered
    /// array.
    #[inline(always)]
    pub(super) fn of(&self, carried: Curvature<R>) -> Sighted<R> {
        let known = carried.origin().and_then(|number| self.sighted.get(number));
        known.copied().unwrap_or(Sighted::unknown())
    }
}

/// Origins of the fronts behind a line, and the line's position.
pub(super) struct LineOrigins<'a, R> {
    pub table: &'a OriginTable<R>,
    /// Row and column of the line's first point in the bordered array, and the step to the next point.
    first: [R; 2],
    along: [R; 2],
    /// The steps from a point to both ends of the base, for the triangle before and the triangle after the point.
    steps: [Steps; 2],
}

impl<'a, R: Real> LineOrigins<'a, R> {
    pub(super) fn new(table: &'a OriginTable<R>, first: [usize; 2], scan: Scan) -> Self {
        let along = if scan.by_rows() { [0, 1] } else { [1, 0] };
        let back = scan.ahead().map(|by| -by);
        let [before, after] = [-1, 1].map(|by| [back[0] + by * along[0], back[1] + by * along[1]]);
        Self {
            table,
            first: first.map(|at| R::of(at as f64)),
            along: along.map(|by| R::of(by as f64)),
            steps: [Steps::new([before, back]), Steps::new([back, after])],
        }
    }

    /// Returns the origins of the fronts behind a span, or `None` if no origin is known.
    #[inline(always)]
    pub(super) fn behind<C>(
        &self,
        start: usize,
        span: &Span<R, Curvature<R>, C>,
        points: usize,
    ) -> Option<SpanOrigins<'_, R>> {
        let [before, beside, after] = span.carried_behind;
        let mut sighted = [Sighted::unknown(); TILE + 2];
        let mut any = false;
        for (place, slot) in sighted[..points + 2].iter_mut().enumerate() {
            let carried = match place {
                0 => before[0],
                _ if place <= points => beside[place - 1],
                _ => after[points - 1],
            };
            any |= carried.origin().is_some();
            *slot = self.table.of(carried);
        }
        any.then(|| SpanOrigins { line: self, start: R::of(start as f64), sighted })
    }
}

/// The origins of the fronts behind a span of points, from the neighbour before the first point to the neighbour after
/// the last point.
pub(super) struct SpanOrigins<'a, R> {
    line: &'a LineOrigins<'a, R>,
    /// Position of the first point in the line.
    start: R,
    sighted: [Sighted<R>; TILE + 2],
}

impl<R: Real> SpanOrigins<'_, R> {
    /// Returns the front through one of the two triangles of point `i`.
    #[inline(always)]
    pub(super) fn front<C, const LEFT: bool>(
        &self,
        span: &Span<R, Curvature<R>, C>,
        bends: Curvatures<R>,
        i: usize,
    ) -> Front<R> {
        let LineOrigins { first, along, steps, .. } = self.line;
        let place = self.start + R::of(i as f64);
        let at = [first[0] + place * along[0], first[1] + place * along[1]];
        let x1 = if LEFT { i } else { i + 1 };
        let sighted = [self.sighted[x1].from(at), self.sighted[x1 + 1].from(at)];
        let steps = &steps[usize::from(!LEFT)];
        curved_from_origins(span.weighted_triangle::<LEFT>(i), bends, steps, sighted)
    }
}
