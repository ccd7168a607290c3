//! Stores the parts of all obtuse triangles ([`EdgeLengths::split`]) of a surface, in the order in which
//! scans visit them.

use std::ops::Range;
use std::sync::OnceLock;

use rayon::prelude::*;

use super::chart::{Chart, Direction, Lines};
use super::edges::EdgeLengths;
use super::real::Real;

/// Maximum number of obtuse triangles of a surface whose parts are stored: half a gigabyte in single
/// precision. If there are more, parts are found whenever they are needed.
const KEPT: usize = 1 << 23;

/// The parts of all obtuse triangles, by the side of their point on which they lie. They are computed when
/// several maps, or few triangles, make it worth their memory. `None` inside means that there are none, or
/// too many to store.
#[derive(Clone, Debug)]
pub(super) struct Parts<R>(OnceLock<Option<[SideParts<R>; 4]>>);

impl<R> Default for Parts<R> {
    fn default() -> Self {
        Self(OnceLock::new())
    }
}

impl<R: Real> Parts<R> {
    /// Returns the number of bytes held.
    pub(super) fn bytes(&self) -> usize {
        let sides = self.0.get().and_then(Option::as_ref);
        sides.map_or(0, |sides| sides.iter().map(SideParts::bytes).sum())
    }
}

/// The obtuse triangles on one side of their points, with their parts. On each side a point has two
/// triangles, which share the edge to the neighbour there.
///
/// Triangles are sorted by their points: line by line, and along lines. Lines are rows where that neighbour
/// lies in another row, else columns. Lines and places in them are counted from the border.
#[derive(Clone, Debug)]
pub(crate) struct SideParts<R> {
    /// [`LINES`] lines each.
    bands: Vec<Band<R>>,
}

/// Number of adjacent lines whose parts a thread finds together.
const LINES: usize = 16;

/// The obtuse triangles of adjacent lines.
#[derive(Clone, Debug, Default)]
struct Band<R> {
    /// Start of each line's triangles, and their end; empty if there are none.
    starts: Vec<u32>,
    triangles: Vec<Triangle>,
    parts: Vec<Stored<R>>,
    /// Slowness at x0, x1 and x2, by which the lengths are weighted. Empty if there is none.
    slowness: Vec<[R; 3]>,
}

/// An obtuse triangle.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    /// Place of the point in its line.
    place: u32,
    /// End of its parts, which begin where those of the triangle before end. There may be none.
    end: u32,
}

/// A part as it is stored.
#[derive(Clone, Copy, Debug)]
struct Stored<R> {
    corners: [u32; 2],
    lengths: [R; 3],
}

/// A part of an obtuse triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part<R> {
    /// The two other corners, as indices into the bordered array.
    pub corners: [usize; 2],
    /// Lengths of x0 x1, x0 x2 and x1 x2.
    pub lengths: [R; 3],
    /// Slowness at x0, x1 and x2; 1 if there is none.
    pub slowness: [R; 3],
}

/// Successive obtuse triangles of a line.
#[derive(Clone, Debug)]
pub(crate) struct SplitTriangles<'a, R> {
    band: &'a Band<R>,
    triangles: Range<usize>,
}

impl<'a, R: Real> SplitTriangles<'a, R> {
    pub(crate) fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Returns, for each triangle, its parts and the place of its point in the line, counted from the border.
    pub(crate) fn parts(
        self,
    ) -> impl Iterator<Item = (usize, impl Iterator<Item = Part<R>> + use<'a, R>)> + use<'a, R>
    {
        let Self { band, triangles } = self;
        let part = move |at: usize| {
            let Stored { corners, lengths } = band.parts[at];
            Part {
                corners: corners.map(|corner| corner as usize),
                lengths,
                slowness: band.slowness.get(at).copied().unwrap_or([R::one(); 3]),
            }
        };
        let place = |triangle: usize| band.triangles[triangle].place as usize;
        triangles.map(move |triangle| (place(triangle), band.parts_of(triangle).map(part)))
    }
}

impl<R: Real> SideParts<R> {
    /// Returns the obtuse triangles whose points lie in part of a line.
    #[inline]
    pub(crate) fn within(&self, line: usize, range: Range<usize>) -> SplitTriangles<'_, R> {
        let band = &self.bands[line / LINES];
        // Most bands and most lines have none.
        let of_line = match band.starts.get(line % LINES..line % LINES + 2) {
            Some(&[start, end]) if start < end => start as usize..end as usize,
            _ => return SplitTriangles { band, triangles: 0..0 },
        };
        let triangles = &band.triangles[of_line.clone()];
        let before = |end: usize| {
            of_line.start + triangles.partition_point(|triangle| (triangle.place as usize) < end)
        };
        SplitTriangles { band, triangles: before(range.start)..before(range.end) }
    }

    fn bytes(&self) -> usize {
        self.bands.iter().map(|band| size_of_val(band) + band.bytes()).sum()
    }

    fn of(edges: &EdgeLengths<R>, side: Direction) -> Self {
        let lines = if side.step().0 == 0 { Lines::Cols } else { Lines::Rows };
        let count = edges.chart().by(lines).rows + 2;
        let band = |first: usize| {
            Band::of(edges, side, lines, first * LINES..count.min((first + 1) * LINES))
        };
        Self { bands: (0..count.div_ceil(LINES)).into_par_iter().map(band).collect() }
    }
}

impl<R: Real> Band<R> {
    fn parts_of(&self, triangle: usize) -> Range<usize> {
        let start = triangle.checked_sub(1).map_or(0, |before| self.triangles[before].end);
        start as usize..self.triangles[triangle].end as usize
    }

    fn bytes(&self) -> usize {
        size_of_val(self.starts.as_slice())
            + size_of_val(self.triangles.as_slice())
            + size_of_val(self.parts.as_slice())
            + size_of_val(self.slowness.as_slice())
    }

    fn of(edges: &EdgeLengths<R>, side: Direction, lines: Lines, band: Range<usize>) -> Self {
        let mut found = Self::default();
        let Some(obtuse) = edges.obtuse_triangles() else { return found };
        let is_slowed = edges.slowness().is_some();
        let chart: Chart = edges.chart();
        let length = chart.by(lines).cols + 2;
        let points = |line| edges.obtuse_points(lines == Lines::Rows, line, 0..length);
        if band.clone().all(|line| points(line).is_empty()) {
            return found;
        }
        // Sorted along the line, by the first of their directions.
        let in_order = match side {
            Direction::North | Direction::East => [side, side.previous()],
            _ => [side.previous(), side],
        };
        found.starts.push(0);
        for line in band {
            for &place in points(line) {
                let (row, col) = lines.place(line, place as usize);
                let point = chart.entry_index(row, col);
                for first in in_order {
                    if obtuse[point] & 1 << first as u8 == 0 {
                        continue;
                    }
                    edges.split(point, [first, first.next()], |corners, lengths, slowness| {
                        let corners = corners.map(|corner| corner as u32);
                        found.parts.push(Stored { corners, lengths });
                        if is_slowed {
                            found.slowness.push(slowness);
                        }
                    });
                    let end = found.parts.len() as u32;
                    found.triangles.push(Triangle { place, end });
                }
            }
            found.starts.push(found.triangles.len() as u32);
        }
        found
    }
}

/// Reciprocal of the largest fraction of a surface's points that have obtuse triangles for which storing the
/// parts pays within a single map. If all points have some, storing takes half as long again as the map.
const FEW: usize = 4;

impl<R: Real> EdgeLengths<R> {
    /// Stores the parts of obtuse triangles if there are few. A map of few iterations finds more of them as
    /// it needs them.
    pub(crate) fn store_few_parts(&self) {
        if self.obtuse_count() <= self.chart().points() / FEW {
            self.parts_on_side(Direction::North);
        }
    }

    /// Returns the parts of obtuse triangles on one side of their points if they are stored already.
    pub(crate) fn stored_parts_on_side(&self, side: Direction) -> Option<&SideParts<R>> {
        let sides = self.shared.parts.0.get()?.as_ref()?;
        Some(&sides[side as usize / 2])
    }

    /// Returns the parts of obtuse triangles on one side of their points, which are stored from now on. The
    /// result is `None` if the surface has no such triangle, or more than can be stored.
    pub(crate) fn parts_on_side(&self, side: Direction) -> Option<&SideParts<R>> {
        if self.shared.parts.0.get().is_none() {
            // Computed outside the lock: a thread that waits for others here may take up work that needs the
            // parts too.
            let sides = self.find_parts();
            self.shared.parts.0.get_or_init(|| sides);
        }
        self.stored_parts_on_side(side)
    }

    fn find_parts(&self) -> Option<[SideParts<R>; 4]> {
        self.obtuse_triangles()?;
        let sides =
            || SIDES.into_par_iter().map(|side| SideParts::of(self, side)).collect::<Vec<_>>();
        (self.obtuse_triangles_count() <= KEPT)
            .then(|| sides().try_into().expect("an element for each side"))
    }
}

/// The sides in the order of [`Direction::ALL`].
const SIDES: [Direction; 4] =
    [Direction::East, Direction::North, Direction::West, Direction::South];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::builtin::Builtin;
    use crate::surface::{Spacing, Surface};

    /// Returns hills with holes, flat sheared cells, and hills with a slowness.
    fn surfaces() -> [Surface; 3] {
        let (rows, cols) = (19, 23);
        let height = |k: usize| 2.5 * ((k * k / 3 % 7) as f64).sin();
        let heights = || (0..rows * cols).map(height).collect();
        let hills = || Surface::from_heights(rows, cols, heights(), Spacing::square(1.0)).unwrap();
        let present: Vec<_> = (0..rows * cols).map(|k| k % 29 != 3).collect();
        let slowness = (0..rows * cols).map(|k| 1.0 + (k % 5) as f64).collect();
        [
            hills().with_mask(&present).unwrap(),
            Builtin::ShearedPlane { degrees: 65.0 }.surface(rows, cols).unwrap(),
            hills().with_slowness(slowness).unwrap(),
        ]
    }

    /// Corners, lengths and slowness of a part of a triangle.
    type Told = ([usize; 2], [f64; 3], [f64; 3]);

    /// Returns the parts of a point's triangles on a side, as they are found one by one.
    fn found(edges: &EdgeLengths<f64>, point: usize, side: Direction) -> Vec<Told> {
        let mut found = Vec::new();
        let bits = edges.obtuse_triangles().unwrap()[point];
        for first in [side.previous(), side].into_iter().filter(|&to| bits >> to as u8 & 1 != 0) {
            edges.split(point, [first, first.next()], |corners, lengths, slowness| {
                found.push((corners, lengths, slowness));
            });
        }
        found
    }

    #[test]
    fn parts_are_listed_by_line_with_the_triangles_they_come_from() {
        for surface in surfaces() {
            let edges = EdgeLengths::<f64>::new(&surface).unwrap();
            let (chart, bits) = (edges.chart(), edges.obtuse_triangles().unwrap());
            let mut triangles = 0;
            for side in SIDES {
                let lines = if side.step().0 == 0 { Lines::Cols } else { Lines::Rows };
                let listed = edges.parts_on_side(side).unwrap();
                let turned = chart.by(lines);
                for (line, range) in (0..turned.rows + 2)
                    .flat_map(|line| [(line, 0..turned.cols + 2), (line, 3..turned.cols - 2)])
                {
                    let mut told: Vec<(usize, Told)> = Vec::new();
                    let mut places = Vec::new();
                    for (place, parts) in listed.within(line, range.clone()).parts() {
                        places.push(place);
                        told.extend(
                            parts.map(|part| (place, (part.corners, part.lengths, part.slowness))),
                        );
                    }
                    assert!(places.is_sorted() && places.iter().all(|at| range.contains(at)));
                    let at = |place: usize| {
                        let (row, col) = lines.place(line, place);
                        chart.entry_index(row, col)
                    };
                    let of_side = 1 << side as u8 | 1 << side.previous() as u8;
                    let count = |place| (bits[at(place)] & of_side).count_ones() as usize;
                    assert_eq!(places.len(), range.clone().map(count).sum::<usize>());
                    triangles += if range.start == 0 { places.len() } else { 0 };
                    let expected = range.flat_map(|place| {
                        let found = found(&edges, at(place), side);
                        found.into_iter().map(move |part| (place, part))
                    });
                    let mut expected: Vec<_> = expected.collect();
                    // Either of a point's two triangles may come first.
                    let by = |a: &(usize, Told), b: &(usize, Told)| a.partial_cmp(b).unwrap();
                    told.sort_by(by);
                    expected.sort_by(by);
                    assert_eq!(told, expected);
                }
            }
            let all: u32 = bits.iter().map(|bits| bits.count_ones()).sum();
            assert_eq!(triangles, all as usize);
        }
    }
}
