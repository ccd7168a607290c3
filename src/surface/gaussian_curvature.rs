//! Gaussian curvature from edge lengths. The twin of `glsl/gaussian_curvature.comp`.

use rayon::prelude::*;

#[cfg(doc)]
use super::arc::EdgeRule;
use super::chart::Direction;
use super::edges::{EdgeLengths, EdgeSlot, inner_rows};
use super::real::{Real, max, min};
use crate::constants::{DEFECT_NOISE, LARGEST_DEFECT};
use crate::lanes::{Instructions, Work};

/// Tag ([`Real::with_tag`]) of the Gaussian curvature at points where waves diffract.
pub(crate) const DIFFRACTS: u8 = 1;

/// Gaussian curvature at each point of the bordered array: the angle defect of the fan of eight
/// triangles around the point, over its share of the fan's area ([`EdgeRule::share_of_fan`]).
///
/// The defect is kept below `LARGEST_DEFECT` radians: a rougher point is a crease or a spike, whose
/// curvature says little of the front that passes beside it. Measured on real terrain: 0.5 brings
/// the front early by 2.9e-3, 0.005 by 1.8e-3, and a sphere octant needs 0.003 at 33 points a side. Defects near `DEFECT_NOISE`, the
/// rounding of lengths in single precision, are shrunk towards zero, or a flat surface would seem
/// bent the same way everywhere.
///
/// Points whose fan is not whole, at a border or hole, carry the tag `DIFFRACTS` and
/// the mean of their neighbours' curvature: waves diffract there.
pub(crate) fn gaussian_curvature<R: Real>(edges: &EdgeLengths<R>) -> Vec<R> {
    let chart = edges.chart();
    // Where a triangle of the fan is missing, so is the curvature: FAR.
    let mut own = vec![R::FAR; chart.bordered_points()];
    inner_rows(chart, &mut own)
        .enumerate()
        .for_each(|(row, own)| Instructions::best().run(Row { edges, row, own }));
    let mut curvature = vec![R::zero().with_tag(DIFFRACTS); chart.bordered_points()];
    inner_rows(chart, &mut curvature).enumerate().for_each(|(row, line)| {
        for (col, curvature) in line.iter_mut().enumerate() {
            let point = chart.bordered(row, col);
            *curvature = if own[point] < R::FAR {
                own[point].with_tag(0)
            } else {
                mean_around(edges, &own, point).with_tag(DIFFRACTS)
            };
        }
    });
    curvature
}

/// The mean curvature of the neighbours that have one of their own.
fn mean_around<R: Real>(edges: &EdgeLengths<R>, own: &[R], point: usize) -> R {
    let chart = edges.chart();
    let (mut sum, mut count) = (R::zero(), R::zero());
    for to in Direction::ALL {
        let neighbour = own[point.wrapping_add_signed(chart.offset(to))];
        if edges.at(point, EdgeSlot::new(chart, 0, to)) < R::FAR && neighbour < R::FAR {
            (sum, count) = (sum + neighbour, count + R::one());
        }
    }
    sum / count.max(R::one())
}

/// The curvature of a row of points, FAR where a triangle of the fan is.
struct Row<'a, R> {
    edges: &'a EdgeLengths<R>,
    row: usize,
    own: &'a mut [R],
}

impl<R: Real> Work for Row<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { edges, row, own } = self;
        let (chart, cols) = (edges.chart(), own.len());
        let first = chart.bordered(row, 0);
        let fan = Direction::ALL.map(|to| edges.row(first, EdgeSlot::new(chart, 0, to), cols));
        let bases = Direction::ALL.map(|to| {
            edges.row(first, EdgeSlot::new(chart, chart.offset(to), to.base()), cols)
        });
        let share = R::of(edges.rule().share_of_fan());
        for (col, own) in own.iter_mut().enumerate() {
            *own = defect_density(fan.map(|edges| edges[col]), bases.map(|c| c[col]), share);
        }
    }
}

/// The angle defect of a fan over its share of the fan's area, given its edges and the bases between one
/// and the next; FAR if a triangle is.
#[inline(always)]
fn defect_density<R: Real>(edges: [R; 8], bases: [R; 8], share_of_fan: R) -> R {
    let (zero, one, half) = (R::zero(), R::one(), R::of(0.5));
    // The angles are added up as the product of complex numbers with these arguments: all of
    // them make a full turn less the defect.
    let (mut re, mut im, mut area, mut whole) = (one, zero, zero, true);
    for index in 0..8 {
        let (a, b, c) = (edges[index], edges[(index + 1) % 8], bases[index]);
        let longest = max(max(a, b), c);
        whole &= (longest < R::FAR) & (longest + longest < a + b + c);
        let x = half * ((a * a + b * b) - c * c) / (a * b);
        let y = max((one - x) * (one + x), zero).sqrt();
        (re, im) = (re * x - im * y, re * y + im * x);
        area = area + half * (a * b) * y;
    }
    let largest = R::of(LARGEST_DEFECT);
    let beyond = if im > zero { -largest } else { largest };
    let within = min(max(-im / re, -largest), largest);
    let tangent = if re > zero { within } else { beyond };
    // The arc tangent to 3e-4 at the largest defect, where it is limited anyhow.
    let square = tangent * tangent;
    let (third, fifth, seventh) = (R::of(1.0 / 3.0), R::of(1.0 / 5.0), R::of(1.0 / 7.0));
    let defect = tangent * (one - square * (third - square * (fifth - square * seventh)));
    // The noise is that of f32; f64's is as much smaller as its digits are more.
    let noise = R::of(DEFECT_NOISE / f64::from(f32::EPSILON)) * R::epsilon();
    let signal = defect * defect / (defect * defect + noise * noise);
    let curvature = defect * signal / (share_of_fan * area);
    if whole { curvature } else { R::FAR }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::builtin::Builtin;

    fn at_the_middle(builtin: Builtin, points: usize) -> (f64, f64) {
        let surface = builtin.surface(points, points).unwrap();
        let double = EdgeLengths::<f64>::new(&surface).unwrap();
        let single = EdgeLengths::<f32>::new(&surface).unwrap();
        let middle = double.chart().bordered(points / 2, points / 3);
        (double.gaussian_curvature()[middle], single.gaussian_curvature()[middle].into())
    }

    #[test]
    fn a_sphere_has_curvature_one_and_developable_surfaces_none() {
        let (double, single) = at_the_middle(Builtin::Sphere, 65);
        approx::assert_abs_diff_eq!(double, 1.0, epsilon = 1e-3);
        // Eight angles rounded to 1e-7 or so, over the area of a cell.
        approx::assert_abs_diff_eq!(single, 1.0, epsilon = 2e-2);
        for builtin in [Builtin::Plane, Builtin::Cylinder, Builtin::Cone] {
            let (double, single) = at_the_middle(builtin, 65);
            approx::assert_abs_diff_eq!(double, 0.0, epsilon = 1e-3);
            approx::assert_abs_diff_eq!(single, 0.0, epsilon = 2e-2);
        }
    }

    #[test]
    fn points_beside_a_hole_or_the_border_are_flagged() {
        let mut mask = vec![true; 81];
        mask[4 * 9 + 4] = false;
        let surface = Builtin::Plane.surface(9, 9).unwrap().with_mask(&mask).unwrap();
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        for row in 0..9usize {
            for col in 0..9usize {
                let beside_the_hole = row.abs_diff(4) <= 1 && col.abs_diff(4) <= 1;
                let at_the_border = row % 8 == 0 || col % 8 == 0;
                let tag = edges.gaussian_curvature()[edges.chart().bordered(row, col)].tag();
                assert_eq!(tag == DIFFRACTS, beside_the_hole || at_the_border, "{row},{col}");
            }
        }
    }
}
