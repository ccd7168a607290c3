//! Connects points to farther neighbours where the eight nearest ones leave an obtuse angle.

use rayon::prelude::*;

use geosweep_surface::constants::EVEN_SLOWNESS;
use geosweep_surface::update::Triangle;
use geosweep_surface::{Chart, Direction, EdgeLengths, Real, Surface, SurfaceError};

/// The triangles into which obtuse triangles are split, for [`crate::fast_marching_with`] (paper, end of
/// section 3, after Spira and Kimmel).
///
/// An obtuse triangle between the neighbours x0 + a and x0 + b is split by the grid point x0 + a + b, the
/// nearest one between their directions. Halves that are obtuse at x0 are split again, up to a largest distance.
/// A triangle is not split if a connection would cross a hole or the border. It is not split either if the slowness, or
/// the length of a step under a metric, varies by more than a quarter among the points around the connection: the data
/// at the ends of the connection do not describe what lies between them.
#[derive(Clone, Debug)]
pub struct Connections<R> {
    triangles: Vec<Split<R>>,
    /// Start of each point's entries in `lookers`: the triangles with `point` as x1 or x2 are
    /// `lookers[first[point]..first[point + 1]]`.
    first: Vec<usize>,
    lookers: Vec<usize>,
}

/// One half of a split triangle. Points are indices into a bordered array.
#[derive(Clone, Copy, Debug)]
struct Split<R> {
    x0: usize,
    x1: usize,
    x2: usize,
    l1: R,
    l2: R,
    c: R,
    /// The slowness by which the lengths are weighted.
    slowness: R,
}

/// A step in rows and columns.
type Step = (isize, isize);

/// Maximum length of a connection, in rows or columns. Over longer distances a front is not straight.
const FARTHEST: isize = 8;

impl<R: Real> Connections<R> {
    /// Returns an empty set of connections, with which points are updated from their eight neighbours only.
    pub fn eight(chart: Chart) -> Self {
        Self::new(chart, Vec::new())
    }

    /// Splits the obtuse triangles of a surface.
    ///
    /// # Errors
    /// [`SurfaceError::EdgeLength`], as from [`EdgeLengths::new`].
    pub fn split(surface: &Surface) -> Result<Self, SurfaceError> {
        let (chart, edges) = (surface.chart(), EdgeLengths::<f64>::new(surface)?);
        let in_row = |row: usize| {
            let mut triangles = Vec::new();
            for col in 0..chart.cols {
                let corner = Corner { surface, row, col };
                for a in Direction::ALL {
                    let b = a.next();
                    let longer = edges.length(row, col, a).max(edges.length(row, col, b));
                    if longer < f64::FAR && corner.is_obtuse(a.step(), b.step()) {
                        corner.split(a.step(), b.step(), &mut triangles);
                    }
                }
            }
            triangles
        };
        let triangles = (0..chart.rows).into_par_iter().flat_map_iter(in_row).collect();
        Ok(Self::new(chart, triangles))
    }

    /// Returns the number of added triangles.
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    fn new(chart: Chart, triangles: Vec<Split<R>>) -> Self {
        let ends = || {
            let indexed = triangles.iter().enumerate();
            indexed.flat_map(|(index, triangle)| [(triangle.x1, index), (triangle.x2, index)])
        };
        let mut first = vec![0; chart.bordered_points() + 1];
        ends().for_each(|(point, _)| first[point + 1] += 1);
        (1..first.len()).for_each(|point| first[point] += first[point - 1]);
        let (mut next, mut lookers) = (first.clone(), vec![0; 2 * triangles.len()]);
        for (point, index) in ends() {
            lookers[next[point]] = index;
            next[point] += 1;
        }
        Self { triangles, first, lookers }
    }

    /// Returns the triangles that have `point` as x1 or x2: for each its x0, its x1 and x2, its lengths, and the
    /// slowness by which the lengths are weighted.
    pub(crate) fn around(
        &self,
        point: usize,
    ) -> impl Iterator<Item = (usize, [usize; 2], Triangle<R>, R)> {
        self.lookers[self.first[point]..self.first[point + 1]].iter().map(move |&index| {
            let Split { x0, x1, x2, l1, l2, c, slowness } = self.triangles[index];
            (x0, [x1, x2], Triangle { t1: R::FAR, t2: R::FAR, l1, l2, c }, slowness)
        })
    }
}

/// A grid point of a surface.
#[derive(Clone, Copy)]
struct Corner<'a> {
    surface: &'a Surface,
    row: usize,
    col: usize,
}

impl Corner<'_> {
    fn at(self, step: Step) -> Option<(usize, usize)> {
        let (row, col) = (self.row as isize + step.0, self.col as isize + step.1);
        let place = self.surface.chart().at(row, col);
        place.filter(|&(row, col)| self.surface.has(row, col))
    }

    /// Returns the length on the surface, without slowness, between the points to which two steps lead. It is
    /// infinite if one of these points is missing.
    fn length(self, from: Step, to: Step) -> f64 {
        match self.at(from).zip(self.at(to)) {
            Some((from, to)) => self.surface.length_on_surface(from, to),
            None => f64::INFINITY,
        }
    }

    fn is_obtuse(self, a: Step, b: Step) -> bool {
        let (l1, l2) = (self.length((0, 0), a), self.length((0, 0), b));
        let c = self.length(a, b);
        // Excludes right angles that rounding has widened.
        l1 * l1 + l2 * l2 < c * c * (1.0 - 1e-9)
    }

    /// Adds the halves of an obtuse triangle. Obtuse halves are split in turn.
    fn split<R: Real>(self, a: Step, b: Step, triangles: &mut Vec<Split<R>>) {
        let middle = (a.0 + b.0, a.1 + b.1);
        if middle.0.abs().max(middle.1.abs()) > FARTHEST {
            return;
        }
        let Some(slowness) = self.slowness_of_box(a, b, middle) else { return };
        for (a, b) in [(a, middle), (middle, b)] {
            triangles.push(self.triangle(a, b, slowness));
            if self.is_obtuse(a, b) {
                self.split(a, b, triangles);
            }
        }
    }

    fn triangle<R: Real>(self, a: Step, b: Step, slowness: f64) -> Split<R> {
        let point = |step| {
            let (row, col) =
                self.at(step).expect("the caller has checked that the point is present");
            self.surface.chart().bordered(row, col)
        };
        Split {
            x0: point((0, 0)),
            x1: point(a),
            x2: point(b),
            l1: R::of(slowness * self.length((0, 0), a)),
            l2: R::of(slowness * self.length((0, 0), b)),
            c: R::of(slowness * self.length(a, b)),
            slowness: R::of(slowness),
        }
    }

    /// Returns the largest slowness in the smallest box around the steps and the point itself. Returns `None`
    /// if a point is missing from the box, or if the slowness or the metric varies by more than a quarter within the
    /// box.
    fn slowness_of_box(self, a: Step, b: Step, middle: Step) -> Option<f64> {
        let range = |k: fn(Step) -> isize| {
            let all = [0, k(a), k(b), k(middle)];
            all.into_iter().min().unwrap()..=all.into_iter().max().unwrap()
        };
        let mut slowness = Range::default();
        let mut lengths = [Range::default(); 2];
        for row in range(|step| step.0) {
            for col in range(|step| step.1) {
                let place = self.at((row, col))?;
                slowness.add(self.surface.weight(place, place));
                for (range, step) in lengths.iter_mut().zip([a, b]) {
                    let step = [step.0 as f64, step.1 as f64];
                    self.surface.metric_length(place, step).into_iter().for_each(|l| range.add(l));
                }
            }
        }
        let even = slowness.is_even() && lengths.iter().all(|range| range.is_even());
        even.then_some(slowness.largest)
    }
}

/// The least and the largest of some positive numbers.
#[derive(Clone, Copy)]
struct Range {
    least: f64,
    largest: f64,
}

impl Default for Range {
    fn default() -> Self {
        Self { least: f64::INFINITY, largest: 0.0 }
    }
}

impl Range {
    fn add(&mut self, value: f64) {
        (self.least, self.largest) = (self.least.min(value), self.largest.max(value));
    }

    fn is_even(&self) -> bool {
        self.largest <= EVEN_SLOWNESS * self.least
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geosweep_surface::Block;
    use geosweep_surface::builtin::Builtin;

    #[test]
    fn acute_triangles_are_left_alone() {
        for builtin in [Builtin::Plane, Builtin::Sphere, Builtin::ShearedPlane { degrees: 45.0 }] {
            let surface = builtin.surface(9, 9).unwrap();
            assert_eq!(Connections::<f64>::split(&surface).unwrap().triangles(), 0, "{builtin}");
        }
    }

    #[test]
    fn every_obtuse_triangle_inside_is_split_into_two() {
        // At 60 degrees two of the eight triangles of a point are split, each into two. The 7 x 5 points in the middle
        // are far enough from the border.
        let surface = Builtin::ShearedPlane { degrees: 60.0 }.surface(9, 9).unwrap();
        let split = Connections::<f64>::split(&surface).unwrap();
        let chart = surface.chart();
        let inside = Block { rows: 1..8, cols: 2..7 };
        for point in inside.places().map(|(row, col)| chart.bordered(row, col)) {
            let own = split.triangles.iter().filter(|triangle| triangle.x0 == point);
            assert_eq!(own.count(), 4);
        }
    }

    #[test]
    fn nothing_reaches_over_a_hole() {
        let surface = Builtin::ShearedPlane { degrees: 75.0 }.surface(7, 9).unwrap();
        let mut mask = vec![true; 63];
        mask[3 * 9 + 4] = false;
        let holed = surface.with_mask(&mask).unwrap();
        let split = Connections::<f64>::split(&holed).unwrap();
        let row = |point: usize| holed.chart().entry(point).0;
        for triangle in &split.triangles {
            let col = |point: usize| holed.chart().entry(point).1;
            let corners = [triangle.x0, triangle.x1, triangle.x2];
            let rows = corners.map(row);
            let cols = corners.map(col);
            let spans = |at: usize, of: [usize; 3]| {
                (*of.iter().min().unwrap()..=*of.iter().max().unwrap()).contains(&at)
            };
            assert!(!(spans(4, rows) && spans(5, cols)), "{triangle:?}");
        }
    }
}
