//! Finds the parts of obtuse triangles, line by line, and stores them once it pays.

use std::ops::Range;

use rayon::prelude::*;

use super::parts::{Band, LINES, SideParts, Stored, Triangle};
use crate::chart::{Chart, Direction, Lines};
use crate::edges::EdgeLengths;
use crate::kept;
use crate::real::Real;

/// Maximum number of obtuse triangles of a surface whose parts are stored: half a gigabyte in single
/// precision. If there are more, parts are found whenever they are needed.
const KEPT: usize = 1 << 23;

impl<R: Real> SideParts<R> {
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
        // The first directions of a point's two triangles, in the order in which the triangles lie along the line.
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

/// Reciprocal of the share of points with obtuse triangles up to which a single map stores parts: one point in `FEW`.
/// If all points have some, storing adds about half of the map's time.
const FEW: usize = 4;

impl<R: Real> EdgeLengths<R> {
    /// Stores the parts of obtuse triangles if there are few. If there are more, a map of few iterations finds them
    /// when it needs them.
    #[doc(hidden)]
    pub fn store_few_parts(&self) {
        if self.obtuse_count() <= self.chart().points() / FEW {
            self.parts_on_side(Direction::North);
        }
    }

    /// Returns the stored parts of obtuse triangles on one side of their points. The result is `None` if nothing is
    /// stored yet, if there is no such triangle, or if there are too many to store.
    #[doc(hidden)]
    pub fn stored_parts_on_side(&self, side: Direction) -> Option<&SideParts<R>> {
        let sides = self.shared.parts.0.get()?.as_ref()?;
        Some(&sides[side as usize / 2])
    }

    /// Returns the parts of obtuse triangles on one side of their points, and stores them. The result is `None` if the
    /// surface has no such triangle, or more than can be stored.
    #[doc(hidden)]
    pub fn parts_on_side(&self, side: Direction) -> Option<&SideParts<R>> {
        kept(&self.shared.parts.0, || self.find_parts());
        self.stored_parts_on_side(side)
    }

    fn find_parts(&self) -> Option<[SideParts<R>; 4]> {
        let triangles = self.obtuse_triangles()?.par_iter().map(|bits| bits.count_ones() as usize);
        let sides =
            || SIDES.into_par_iter().map(|side| SideParts::of(self, side)).collect::<Vec<_>>();
        (triangles.sum::<usize>() <= KEPT)
            .then(|| sides().try_into().expect("an element for each side"))
    }
}

/// The sides in the order of [`Direction::ALL`].
const SIDES: [Direction; 4] =
    [Direction::East, Direction::North, Direction::West, Direction::South];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::Builtin;
    use crate::{Spacing, Surface};

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
