//! The eight neighbours of a point, and the triangles of the point with them.

use crate::fronts::Pulled;
use geosweep_surface::update::{Carried, Triangle};
use geosweep_surface::{Chart, Direction, EdgeLengths, Offset, Real, min};
use rayon::prelude::*;

/// The neighbours of points in a bordered array, in the order of [`Direction::ALL`].
#[derive(Clone, Debug)]
pub(super) struct Neighbours {
    to: [Offset; 8],
    stride: usize,
    /// The neighbours in the arrays of the surface, which hold the edges.
    on_surface: [Offset; 8],
    stride_on_surface: usize,
}

/// A point: its indices in the arrays of fronts and in those of the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub here: usize,
    pub on_surface: usize,
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

/// The neighbours of a point whose fronts are later than the point's, as bits in the order of [`Direction::ALL`].
#[derive(Clone, Copy)]
pub(super) struct Later<R> {
    /// The times at which the point's front arrives along edges.
    pub by_edges: [R; 8],
    /// The neighbours that are not final and that the front reaches along an edge before the time that they wait for.
    pub waiting: u32,
    /// The neighbours that are final.
    pub settled: u32,
}

impl Neighbours {
    /// Returns the neighbours of points whose fronts lie in arrays of the layout `own`.
    pub(super) fn new(surface: Chart, own: Chart) -> Self {
        let offsets = |chart: Chart| Direction::ALL.map(|to| chart.offset(to));
        Self {
            to: offsets(own),
            stride: own.stride(),
            on_surface: offsets(surface),
            stride_on_surface: surface.stride(),
        }
    }

    /// Adds the triangles through which the first front may reach a point, given the times of the fronts that count. Of
    /// the two triangles beside the earliest edge, one counts even if its third corner does not.
    #[inline(always)]
    pub(super) fn add_behind<R: Real, C: Carried>(
        &self,
        lengths: &[[R; 4]],
        (settled, carried): (&[R], &[C]),
        point: Place,
        lanes: &mut Pulled<R, C>,
    ) {
        let around = self.around(settled, point.here);
        let Around { edges, bases } = self.lengths(lengths, point.on_surface);
        let mut by_edges = [R::FAR; 8];
        for k in 0..8 {
            by_edges[k] = around[k] + edges[k];
        }
        let first = least(by_edges);
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
        let triangles = (counts & next(counts) | edges_alone) & 0xff;
        for k in bits(triangles) {
            let ends = [k, (k + 1) % 8];
            let at = |k: usize| {
                let x = self.to[k].from(point.here);
                if counts >> k & 1 == 1 { (around[k], carried[x]) } else { (R::FAR, C::default()) }
            };
            let [x1, x2] = ends.map(|k| self.on_surface[k].from(point.on_surface));
            let corners = [point.on_surface, x1, x2];
            let ([(t1, c1), (t2, c2)], l1, l2) =
                ([at(ends[0]), at(ends[1])], edges[ends[0]], edges[ends[1]]);
            let triangle = Triangle { t1, t2, l1, l2, c: bases[ends[0]] };
            lanes.add(corners, triangle, [c1, c2], is_alone(ends[0], triangle));
        }
    }

    /// Adds the two triangles of a point that have a given neighbour as a corner.
    #[inline(never)]
    pub(super) fn add_beside<R: Real, C: Carried>(
        &self,
        lengths: &[[R; 4]],
        (settled, carried): (&[R], &[C]),
        (point, number): (Place, usize),
        lanes: &mut Pulled<R, C>,
    ) {
        let Around { edges, bases } = self.lengths(lengths, point.on_surface);
        for a in [number % 8, (number + 7) % 8] {
            let b = (a + 1) % 8;
            let at = |k: usize| {
                let x = self.to[k].from(point.here);
                let carried = if settled[x] < R::FAR { carried[x] } else { C::default() };
                (settled[x], carried)
            };
            let [(t1, c1), (t2, c2)] = [at(a), at(b)];
            let [x1, x2] = [a, b].map(|k| self.on_surface[k].from(point.on_surface));
            let triangle = Triangle { t1, t2, l1: edges[a], l2: edges[b], c: bases[a] };
            let corners = [point.on_surface, x1, x2];
            lanes.add(corners, triangle, [c1, c2], is_alone(a, triangle));
        }
    }

    /// Returns the neighbours that are later than a point, given the times of all fronts and of those that are final.
    #[inline(always)]
    pub(super) fn later<R: Real>(
        &self,
        lengths: &[[R; 4]],
        [times, settled]: [&[R]; 2],
        Place { here, on_surface }: Place,
    ) -> Later<R> {
        let own = times[here];
        let (times, settled) = (self.around(times, here), self.around(settled, here));
        let Around { edges, .. } = self.lengths(lengths, on_surface);
        let mut by_edges = [own; 8];
        let mut later = Later { by_edges, waiting: 0, settled: 0 };
        for k in 0..8 {
            let (there, is_final) = (edges[k] < R::FAR, settled[k] < R::FAR);
            by_edges[k] = own + edges[k];
            later.waiting |= u32::from(there & !is_final & (by_edges[k] < times[k])) << k;
            later.settled |= u32::from(there & is_final & (settled[k] > own)) << k;
        }
        Later { by_edges, ..later }
    }

    /// Returns a neighbour of a point by its number in [`Direction::ALL`].
    #[inline(always)]
    pub(super) fn neighbour(&self, point: Place, number: usize) -> Place {
        Place {
            here: self.to[number % 8].from(point.here),
            on_surface: self.on_surface[number % 8].from(point.on_surface),
        }
    }

    /// Returns the entries of a bordered array at the eight neighbours of a point, in the order of [`Direction::ALL`].
    #[inline(always)]
    fn around<T: Copy>(&self, array: &[T], point: usize) -> [T; 8] {
        let [above, own, below] = rows(array, point, self.stride);
        [own[2], above[2], above[1], above[0], own[0], below[0], below[1], below[2]]
    }

    /// Returns the lengths of edges around a point. Each point stores those of [`geosweep_surface::STORED`].
    #[inline(always)]
    fn lengths<R: Real>(&self, lengths: &[[R; 4]], point: usize) -> Around<R> {
        let [above, own, below] = rows(lengths, point, self.stride_on_surface);
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

    /// Returns the indices of a point and of those before and after it in its column: those of their fronts, and those
    /// on the surface.
    #[inline(always)]
    pub(super) fn rows_of(&self, Place { here, on_surface }: Place) -> [[usize; 3]; 2] {
        let rows = |point: usize, stride: usize| [point - stride, point, point + stride];
        [rows(here, self.stride), rows(on_surface, self.stride_on_surface)]
    }
}

/// Returns the entries of a bordered array at a point and around it, row by row.
#[inline(always)]
fn rows<T>(array: &[T], point: usize, stride: usize) -> [&[T; 3]; 3] {
    let row = |first: usize| array[first..].first_chunk::<3>().expect("points have neighbours");
    [row(point - stride - 1), row(point - 1), row(point + stride - 1)]
}

/// Returns the numbers of the bits that are set among the lowest eight.
#[inline(always)]
pub(super) fn bits(set: u32) -> impl Iterator<Item = usize> {
    let mut rest = set & 0xff;
    std::iter::from_fn(move || {
        let next = rest.trailing_zeros() as usize % 8;
        let is_there = rest != 0;
        rest &= rest.wrapping_sub(1);
        is_there.then_some(next)
    })
}

/// Returns the least of eight numbers, in SIMD lanes.
#[inline(always)]
fn least<R: Real>([a, b, c, d, e, f, g, h]: [R; 8]) -> R {
    let [a, b, c, d] = [min(a, e), min(b, f), min(c, g), min(d, h)];
    min(min(a, c), min(b, d))
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
        let neighbours = Neighbours::new(chart, chart);
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
