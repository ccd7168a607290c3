//! The eight neighbours of a point, and the triangles through which the point passes its front on to them.

use crate::fronts::Pushed;
use geosweep_surface::lanes::prefetch;
use geosweep_surface::update::{Carried, Triangle};
use geosweep_surface::{Chart, Direction, EdgeLengths, EdgeSlot, Offset, Real};
use rayon::prelude::*;

/// The neighbours of a point in a bordered array.
#[derive(Clone, Debug)]
pub(super) struct Neighbours {
    all: [Neighbour; 8],
    stride: usize,
}

/// A neighbour x0 of a point x1.
#[derive(Clone, Copy, Debug)]
struct Neighbour {
    to: Offset,
    edge: Slot,
    is_diagonal: bool,
    /// The third corners of the two triangles that have x0 and x1 as corners.
    others: [Other; 2],
}

/// The third corner x2 of a triangle, seen from x1.
#[derive(Clone, Copy, Debug)]
struct Other {
    to: Offset,
    /// Its number among the neighbours.
    place: usize,
    /// The edges x0 x2 and x1 x2.
    edge: Slot,
    base: Slot,
}

/// Lengths of the four edges that are stored at each point, as a bordered array. A point needs ten of its own edges and
/// of those around it. So they lie closer together than in the four arrays of [`EdgeLengths`].
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

/// Number of points whose edges a thread gathers together.
const CHUNK: usize = 1 << 14;

/// Where the length of an edge is stored, relative to x1: an index among the edges of a point, and an offset.
#[derive(Clone, Copy, Debug)]
struct Slot {
    stored: usize,
    offset: Offset,
}

impl Slot {
    fn new(EdgeSlot { offset, stored }: EdgeSlot) -> Self {
        Self { stored, offset }
    }

    #[inline(always)]
    fn of<R: Real>(self, lengths: &[[R; 4]], point: usize) -> R {
        lengths[self.offset.from(point)][self.stored % 4]
    }
}

impl Neighbours {
    pub(super) fn new(chart: Chart) -> Self {
        let neighbour = |to: Direction| {
            // The third corners are also neighbours of x0, beside the direction back to x1.
            let back = to.opposite();
            let other = |from_x0: Direction| {
                let step = to.vector() + from_x0.vector();
                let from_x1 = Direction::ALL.into_iter().find(|to| to.vector() == step);
                let from_x1 = from_x1.expect("the corners of a triangle are neighbours");
                Other {
                    to: chart.offset(from_x1),
                    place: from_x1 as usize,
                    edge: Slot::new(EdgeSlot::new(chart, chart.offset(to), from_x0)),
                    base: Slot::new(EdgeSlot::of(chart, from_x1)),
                }
            };
            Neighbour {
                to: chart.offset(to),
                edge: Slot::new(EdgeSlot::of(chart, to)),
                is_diagonal: to.is_diagonal(),
                others: [other(back.previous()), other(back.next())],
            }
        };
        Self { all: Direction::ALL.map(neighbour), stride: chart.stride() }
    }

    /// Adds the triangles through which a point may pass on its front. A triangle counts with the front at its third
    /// corner x2 only if x2 does not wait to pass on its own front: otherwise the triangle is used when the time of x2
    /// has come. Neighbours that are reached no later than the point need nothing.
    #[inline(always)]
    pub(super) fn add<R: Real, C: Carried>(
        &self,
        lengths: &[[R; 4]],
        (times, carried): (&[R], &[C]),
        waits: &[bool],
        point: usize,
        lanes: &mut Pushed<R, C>,
    ) {
        let (own, of_own) = (times[point], carried[point]);
        let (around, waiting) = (self.around(times, point), self.around(waits, point));
        let mut later = 0u32;
        for (k, &time) in around.iter().enumerate() {
            later |= u32::from(time > own) << k;
        }
        while later != 0 {
            let k = later.trailing_zeros() as usize;
            later &= later - 1;
            let Neighbour { to, edge, is_diagonal, others } = &self.all[k % 8];
            let l1 = edge.of(lengths, point);
            if l1 >= R::FAR {
                continue;
            }
            let now = around[k % 8];
            let is_face = |other: &Other| !waiting[other.place] & (around[other.place] < now);
            let [first, second] = [is_face(&others[0]), is_face(&others[1])];
            let mut add = |other: &Other, is_face: bool| {
                let x2 = other.to.from(point);
                let [l2, c] = [other.edge.of(lengths, point), other.base.of(lengths, point)];
                let (t2, of_x2) = if is_face {
                    (around[other.place], carried[x2])
                } else {
                    (R::FAR, C::default())
                };
                let triangle = Triangle { t1: own, t2, l1, l2, c };
                let corners = [to.from(point) as u32, point as u32, x2 as u32];
                lanes.add(corners, triangle, [of_own, of_x2], *is_diagonal & (l2 >= R::FAR));
            };
            // Without a face, a triangle stands for the edge alone. The one beside a hole tells that it is alone.
            let is_alone = |other: &Other| *is_diagonal && other.edge.of(lengths, point) >= R::FAR;
            let takes_first = first || (!second && is_alone(&others[0]));
            add(&others[usize::from(!takes_first)], first | second);
            if first & second {
                add(&others[1], true);
            }
        }
    }

    /// Returns the entries of a bordered array at the eight neighbours of a point, in the order of [`Direction::ALL`].
    #[inline(always)]
    fn around<T: Copy>(&self, array: &[T], point: usize) -> [T; 8] {
        let row = |first: usize| array[first..].first_chunk::<3>().expect("points have neighbours");
        let (above, own) = (row(point - self.stride - 1), row(point - 1));
        let below = row(point + self.stride - 1);
        [own[2], above[2], above[1], above[0], own[0], below[0], below[1], below[2]]
    }

    /// Prefetches what a point needs to pass on its front.
    #[inline(always)]
    pub(super) fn prefetch<R: Real>(&self, lengths: &[[R; 4]], times: &[R], point: usize) {
        for row in [point - self.stride, point, point + self.stride] {
            prefetch(times, row as isize);
            prefetch(lengths, row as isize);
        }
    }
}
