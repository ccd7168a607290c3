//! Neighbours behind a point in a scan: the three points that the scan has just passed, and their triangles.

use super::scan::Scan;
use geosweep_surface::update::Triangle;
use geosweep_surface::{Chart, Direction, EdgeLengths, EdgeSlot, Offset, Real};

/// Three successive neighbours around a point, and the two triangles that they form with the point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Behind {
    triangles: [TriangleSlots; 2],
    middle: Direction,
}

impl Behind {
    pub(super) fn new(chart: Chart, [a, b, c]: [Direction; 3]) -> Self {
        let triangles = [TriangleSlots::new(chart, a, b), TriangleSlots::new(chart, b, c)];
        Self { triangles, middle: b }
    }

    /// Returns the neighbours that a scan has just passed.
    pub(super) fn of(chart: Chart, scan: Scan) -> Self {
        Self::new(chart, scan.behind())
    }

    pub(super) fn triangles(&self) -> &[TriangleSlots; 2] {
        &self.triangles
    }

    /// Returns the bits of the two triangles in [`EdgeLengths::obtuse_triangles`].
    pub(super) fn bits(&self) -> u8 {
        self.triangles.iter().fold(0, |bits, triangle| bits | triangle.bit())
    }

    /// Returns the direction of the second neighbour.
    pub(super) fn middle(&self) -> Direction {
        self.middle
    }

    /// Returns the offsets from the point to the neighbours.
    pub(super) fn points(&self) -> [Offset; 3] {
        let [a, b] = &self.triangles;
        [a.x1, a.x2, b.x2]
    }

    /// Returns the edges to the neighbours.
    pub(super) fn edges(&self) -> [EdgeSlot; 3] {
        let [a, b] = &self.triangles;
        [a.l1, a.l2, b.l2]
    }

    /// Returns the edges between the neighbours.
    pub(super) fn bases(&self) -> [EdgeSlot; 2] {
        self.triangles.each_ref().map(|triangle| triangle.c)
    }
}

/// Positions of a triangle's corners x1 and x2 and of its edges, relative to its corner x0.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleSlots {
    /// The directions of x1 and x2.
    directions: [Direction; 2],
    /// Index of the corner (0 for x1, 1 for x2) that is a neighbour along a grid axis. The other corner is a diagonal
    /// neighbour.
    axis: usize,
    x1: Offset,
    x2: Offset,
    l1: EdgeSlot,
    l2: EdgeSlot,
    c: EdgeSlot,
}

impl TriangleSlots {
    /// Returns the triangle between two successive directions.
    pub(super) fn new(chart: Chart, first: Direction, second: Direction) -> Self {
        let is_counter_clockwise = first.next() == second;
        let base = if is_counter_clockwise { first.base() } else { second.base().opposite() };
        let x1 = chart.offset(first);
        Self {
            directions: [first, second],
            axis: usize::from(first.is_diagonal()),
            x1,
            x2: chart.offset(second),
            l1: EdgeSlot::of(chart, first),
            l2: EdgeSlot::of(chart, second),
            c: EdgeSlot::new(chart, x1, base),
        }
    }

    /// Returns the directions of the two other corners.
    pub(super) fn directions(&self) -> [Direction; 2] {
        self.directions
    }

    /// Returns the bit of this triangle in [`EdgeLengths::obtuse_triangles`].
    pub(super) fn bit(&self) -> u8 {
        let [first, second] = self.directions;
        let clockwise = if first.next() == second { first } else { second };
        1 << clockwise as u8
    }

    /// Returns the two other corners of a point's triangle.
    #[inline]
    pub(super) fn corners(&self, point: usize) -> [usize; 2] {
        [self.x1, self.x2].map(|offset| offset.from(point))
    }

    /// Returns the lengths of x0 x1, x0 x2 and x1 x2.
    #[inline]
    pub(super) fn lengths<R: Real>(&self, edges: &EdgeLengths<R>, point: usize) -> [R; 3] {
        [self.l1, self.l2, self.c].map(|slot| edges.at(point, slot))
    }

    /// Returns the triangle with the given arrival times at its two other corners.
    #[inline]
    pub(super) fn triangle<R: Real>(
        &self,
        edges: &EdgeLengths<R>,
        point: usize,
        [t1, t2]: [R; 2],
    ) -> Triangle<R> {
        let [l1, l2, c] = self.lengths(edges, point);
        Triangle { t1, t2, l1, l2, c }
    }

    /// Returns whether the neighbour along a grid axis has no edge to x0.
    #[inline]
    pub(super) fn is_alone<R: Real>(&self, triangle: Triangle<R>) -> bool {
        [triangle.l1, triangle.l2][self.axis] >= R::FAR
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_join_the_neighbours() {
        let surface = geosweep_surface::builtin::Builtin::Peaks.surface(5, 6).unwrap();
        let edges = EdgeLengths::<f64>::new(&surface).unwrap();
        let chart = edges.chart();
        let (row, col) = (2, 3);
        for scan in Scan::ALL {
            let behind = scan.behind();
            let slots = Behind::of(chart, scan);
            for (ends, base) in behind.windows(2).zip(slots.bases()) {
                let [a, b] = [0, 1].map(|k| chart.neighbour(row, col, ends[k]).unwrap());
                let expected = surface.length_on_surface(a, b);
                let found = edges.at(chart.bordered(row, col), base);
                approx::assert_relative_eq!(found, expected, max_relative = 0.1);
            }
        }
    }
}
