//! The eight neighbours of a point, and the triangles of the point with them.

use crate::fronts::Pulled;
use geosweep_surface::lanes::prefetch;
use geosweep_surface::update::{Carried, Triangle};
use geosweep_surface::{Chart, Direction, EdgeLengths, Offset, Real};
use rayon::prelude::*;

/// The neighbours of points in a bordered array, in the order of [`Direction::ALL`].
#[derive(Clone, Debug)]
pub(super) struct Neighbours {
    to: [Offset; 8],
    stride: usize,
}

/// Lengths of the four edges that are stored at each point, as a bordered array. A point needs sixteen of its own edges
/// and of those around it. So they lie closer together than in the four arrays of [`EdgeLengths`].
pub(super) type Lengths<R> = Vec<[R; 4]>;

/// Returns the lengths of all edges.
pub(super) fn lengths_of<R: Real>(edges: &EdgeLengths<R>) -> Lengths<R> {
    let planes = edges.planes();
    let mut lengths = vec![[R::FAR; 4]; planes[0].len()];
    lengths.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, lengths)| {
        let [a, b, c, d] = planes.map(|plane| &plane[chunk * CHUNK..][..lengths.len()]);
        for (k, lengths) in lengths.iter_mut().enumerate() {
            *lengths = [a[k], b[k], c[k], d[k]];
        }
    });
    lengths
}

/// Difference of times, in units of their rounding, up to which fronts arrive together.
pub(super) const TOGETHER: f64 = 4.0;

/// Number of points whose edges a thread gathers together.
const CHUNK: usize = 1 << 14;

/// The lengths around a point: of the edges to its neighbours, and of the bases from each neighbour to the next.
struct Around<R> {
    edges: [R; 8],
    bases: [R; 8],
}

/// Returns [`geosweep_surface::update::Curvatures::alone`] of the triangle with the neighbours `first` and the next one.
#[inline(always)]
fn is_alone<R: Real>(first: usize, triangle: Triangle<R>) -> bool {
    let along_axis = if first.is_multiple_of(2) { triangle.l1 } else { triangle.l2 };
    along_axis >= R::FAR
}

/// A neighbour that a point may pass its front on to.
#[derive(Clone, Copy)]
pub(super) struct Later<R> {
    pub point: usize,
    /// The number of the point among the neighbours of this one.
    pub number: usize,
    /// The time at which the front arrives there along the edge.
    pub by_edge: R,
}

impl Neighbours {
    pub(super) fn new(chart: Chart) -> Self {
        Self { to: Direction::ALL.map(|to| chart.offset(to)), stride: chart.stride() }
    }

    /// Adds the triangles through which the first front may reach a point. `is_final` tells by a point's state whether the
    /// front there counts. Of the two triangles beside the earliest edge, one counts even if its third corner does not.
    #[inline(always)]
    pub(super) fn add_behind<R: Real, C: Carried, S: Copy>(
        &self,
        lengths: &[[R; 4]],
        (times, carried): (&[R], &[C]),
        (states, is_final): (&[S], impl Fn(S) -> bool),
        point: usize,
        lanes: &mut Pulled<R, C>,
    ) {
        let (mut around, states) = (self.around(times, point), self.around(states, point));
        let Around { edges, bases } = self.lengths(lengths, point);
        let mut by_edges = [R::FAR; 8];
        let mut first = R::FAR;
        for k in 0..8 {
            around[k] = if is_final(states[k]) { around[k] } else { R::FAR };
            by_edges[k] = around[k] + edges[k];
            first = if by_edges[k] < first { by_edges[k] } else { first };
        }
        if first >= R::FAR {
            return;
        }
        // A front through a triangle arrives no earlier than at both other corners. So corners after the first arrival
        // along an edge do not matter. Fronts that arrive along one edge from two triangles differ in curvature.
        let (mut counts, mut shortest) = (0u32, 0u32);
        let together = first + first * R::of(TOGETHER) * R::epsilon();
        for k in 0..8 {
            let is_shortest = by_edges[k] <= together;
            counts |= u32::from((around[k] < first) & (edges[k] < R::FAR) | is_shortest) << k;
            shortest |= u32::from(is_shortest) << k;
        }
        let next = |bits: u32| (bits >> 1) | (bits << 7);
        let edges_alone = (shortest & !next(counts)) | (next(shortest) & !counts);
        let mut triangles = (counts & next(counts) | edges_alone) & 0xff;
        while triangles != 0 {
            let k = triangles.trailing_zeros() as usize;
            triangles &= triangles - 1;
            let ends = [k % 8, (k + 1) % 8];
            let at = |k: usize| {
                let x = self.to[k].from(point);
                if counts >> k & 1 == 1 { (around[k], carried[x]) } else { (R::FAR, C::default()) }
            };
            let corners = [point, self.to[ends[0]].from(point), self.to[ends[1]].from(point)];
            let ([(t1, c1), (t2, c2)], l1, l2) =
                ([at(ends[0]), at(ends[1])], edges[ends[0]], edges[ends[1]]);
            let triangle = Triangle { t1, t2, l1, l2, c: bases[ends[0]] };
            lanes.add(corners, triangle, [c1, c2], is_alone(ends[0], triangle));
        }
    }

    /// Adds the two triangles of a point that have a given neighbour as a corner.
    #[inline(never)]
    pub(super) fn add_beside<R: Real, C: Carried, S: Copy>(
        &self,
        lengths: &[[R; 4]],
        (times, carried): (&[R], &[C]),
        (states, is_final): (&[S], impl Fn(S) -> bool),
        [point, number]: [usize; 2],
        lanes: &mut Pulled<R, C>,
    ) {
        let Around { edges, bases } = self.lengths(lengths, point);
        for a in [number, (number + 7) % 8] {
            let b = (a + 1) % 8;
            let at = |k: usize| {
                let x = self.to[k].from(point);
                if is_final(states[x]) {
                    (x, times[x], carried[x])
                } else {
                    (x, R::FAR, C::default())
                }
            };
            let [(x1, t1, c1), (x2, t2, c2)] = [at(a), at(b)];
            let triangle = Triangle { t1, t2, l1: edges[a], l2: edges[b], c: bases[a] };
            lanes.add([point, x1, x2], triangle, [c1, c2], is_alone(a, triangle));
        }
    }

    /// Returns the neighbours that a point reaches along edges and that are later than the point, and their number.
    #[inline(always)]
    pub(super) fn later<R: Real>(
        &self,
        lengths: &[[R; 4]],
        times: &[R],
        point: usize,
    ) -> ([Later<R>; 8], usize) {
        let (own, around) = (times[point], self.around(times, point));
        let Around { edges, .. } = self.lengths(lengths, point);
        let mut later = 0u32;
        for k in 0..8 {
            later |= u32::from((edges[k] < R::FAR) & (around[k] > own)) << k;
        }
        let (mut all, mut count) = ([Later { point, number: 0, by_edge: own }; 8], 0);
        while later != 0 {
            let k = later.trailing_zeros() as usize % 8;
            later &= later - 1;
            let (point, number) = (self.to[k].from(point), (k + 4) % 8);
            all[count % 8] = Later { point, number, by_edge: own + edges[k] };
            count += 1;
        }
        (all, count)
    }

    /// Returns the entries of a bordered array at the eight neighbours of a point, in the order of [`Direction::ALL`].
    #[inline(always)]
    fn around<T: Copy>(&self, array: &[T], point: usize) -> [T; 8] {
        let [above, own, below] = self.rows(array, point);
        [own[2], above[2], above[1], above[0], own[0], below[0], below[1], below[2]]
    }

    /// Returns the lengths of edges around a point. Each point stores those of [`geosweep_surface::STORED`].
    #[inline(always)]
    fn lengths<R: Real>(&self, lengths: &[[R; 4]], point: usize) -> Around<R> {
        let [above, own, below] = self.rows(lengths, point);
        let [east, north, north_east, north_west] = own[1];
        let edges =
            [east, north_east, north, north_west, own[0][0], below[0][2], below[1][1], below[2][3]];
        let bases = [
            own[2][1],
            above[1][0],
            above[0][0],
            own[0][1],
            below[0][1],
            below[0][0],
            below[1][0],
            below[2][1],
        ];
        Around { edges, bases }
    }

    /// Returns the entries of a bordered array at a point and around it, row by row.
    #[inline(always)]
    fn rows<'a, T>(&self, array: &'a [T], point: usize) -> [&'a [T; 3]; 3] {
        let row = |first: usize| array[first..].first_chunk::<3>().expect("points have neighbours");
        [row(point - self.stride - 1), row(point - 1), row(point + self.stride - 1)]
    }

    /// Prefetches what a point needs.
    #[inline(always)]
    pub(super) fn prefetch<R: Real>(&self, lengths: &[[R; 4]], times: &[R], point: usize) {
        for row in [point - self.stride, point, point + self.stride] {
            prefetch(times, row as isize);
            prefetch(lengths, row as isize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geosweep_surface::EdgeSlot;
    use geosweep_surface::builtin::Builtin;

    #[test]
    fn lengths_around_points_are_those_of_their_directions() {
        let surface = Builtin::Peaks.surface(5, 6).unwrap();
        let edges = EdgeLengths::<f64>::new(&surface).unwrap();
        let (chart, lengths) = (edges.chart(), lengths_of(&edges));
        let neighbours = Neighbours::new(chart);
        for point in (0..chart.points()).map(|index| {
            let (row, col) = chart.position(index);
            chart.bordered(row, col)
        }) {
            let around = neighbours.lengths(&lengths, point);
            for to in Direction::ALL {
                let base = EdgeSlot::new(chart, chart.offset(to), to.base());
                let expected = [EdgeSlot::of(chart, to), base].map(|slot| edges.at(point, slot));
                assert_eq!([around.edges, around.bases].map(|of| of[to as usize]), expected);
            }
        }
    }
}
