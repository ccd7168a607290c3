//! The parts of obtuse triangles, kept for a surface that has few of them: scans ask for them again at each visit.

use rayon::prelude::*;

use super::chart::Direction;
use super::edges::EdgeLengths;
use super::real::Real;

/// A triangle of a point x0 between two grid points beyond the base of an obtuse one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part<R> {
    /// The steps in rows and columns from x0 to the other corners.
    pub steps: [[i8; 2]; 2],
    /// Of x0 x1, x0 x2 and x1 x2 in the plane.
    pub lengths: [R; 3],
    /// The obtuse triangle: that between the neighbours in this direction and the next of [`Direction::ALL`].
    of: u8,
}

/// Those of all points that have obtuse triangles, point by point in row-major order.
#[derive(Clone, Debug)]
pub(super) struct Parts<R> {
    /// Where each point's begin.
    starts: Vec<u32>,
    parts: Vec<Part<R>>,
}

/// Parts are kept if they are no more than so many a grid point: a surface whose triangles are obtuse everywhere
/// would have five times as much of them as of anything else.
const MOST_PER_POINT: usize = 1;

impl<R: Real> Parts<R> {
    /// Those of a surface with obtuse triangles; `None` if they are too many.
    pub(super) fn of(edges: &EdgeLengths<R>, bits: &[u8], points: &[usize]) -> Option<Self> {
        let triangles: usize =
            points.par_iter().map(|&point| bits[point].count_ones() as usize).sum();
        let most = MOST_PER_POINT * edges.chart().points();
        // Two or more of each, as a rule.
        if 2 * triangles > most {
            return None;
        }
        let of_point = |&point: &usize| {
            let mut parts = Vec::new();
            for (of, &to) in
                Direction::ALL.iter().enumerate().filter(|(of, _)| bits[point] >> of & 1 != 0)
            {
                edges.split(point, to, |steps, lengths| {
                    parts.push(Part {
                        steps: steps.map(|(down, right)| [down as i8, right as i8]),
                        lengths,
                        of: of as u8,
                    });
                });
            }
            parts
        };
        let by_point: Vec<_> = points.par_iter().map(of_point).collect();
        let parts: usize = by_point.iter().map(Vec::len).sum();
        (parts <= most).then(|| {
            let mut kept = Self { starts: vec![0], parts: Vec::with_capacity(parts) };
            for of_point in by_point {
                kept.parts.extend(of_point);
                kept.starts.push(kept.parts.len() as u32);
            }
            kept
        })
    }

    /// Those of the obtuse triangle of a point between the neighbours in a direction and the next. The point is
    /// told by how many points with obtuse triangles come before it.
    pub(super) fn of_triangle(&self, rank: usize, to: Direction) -> impl Iterator<Item = &Part<R>> {
        let [first, end] = [rank, rank + 1].map(|rank| self.starts[rank] as usize);
        self.parts[first..end].iter().filter(move |part| part.of == to as u8)
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.parts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::builtin::Builtin;

    /// Told of each triangle of each point.
    fn told(edges: &EdgeLengths<f32>) -> Vec<([usize; 2], [f32; 3])> {
        let (chart, mut told) = (edges.chart(), Vec::new());
        for index in 0..chart.points() {
            let (row, col) = chart.position(index);
            for to in Direction::ALL {
                edges.for_parts(chart.bordered(row, col), [to.next(), to], |corners, lengths| {
                    told.push((corners, lengths));
                });
            }
        }
        told
    }

    #[test]
    fn kept_parts_are_those_found_anew() {
        let surface = Builtin::Peaks.surface(129, 97).unwrap();
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let bits = edges.obtuse_triangles().expect("peaks have some");
        let anew = edges.clone();
        // Nothing is kept there.
        anew.parts.set(None).unwrap();
        let (kept, anew) = (told(&edges), told(&anew));
        assert!(edges.parts.get().unwrap().is_some() && edges.bytes() > 20 * kept.len());
        let triangles: u32 = bits.iter().map(|bits| bits.count_ones()).sum();
        assert!(kept.len() > triangles as usize, "{} parts of {triangles}", kept.len());
        assert_eq!(kept, anew);
    }

    #[test]
    fn parts_are_not_kept_where_all_triangles_are_obtuse() {
        let surface = Builtin::ShearedPlane { degrees: 60.0 }.surface(33, 33).unwrap();
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        assert!(!told(&edges).is_empty());
        assert!(edges.parts.get().unwrap().is_none());
    }
}
