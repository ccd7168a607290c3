//! Gaussian curvature from edge lengths. The twin of `glsl/gaussian_curvature.comp`.

use rayon::prelude::*;

use super::chart::Direction;
use super::edges::{EdgeLengths, EdgeSlot};
use super::real::Real;
use crate::constants::{DEFECT_NOISE, LARGEST_DEFECT};

/// Tag ([`Real::with_tag`]) of the Gaussian curvature at points where waves diffract.
pub(crate) const DIFFRACTS: u8 = 1;

/// Gaussian curvature at each point of the bordered array: the angle defect of the fan of eight
/// triangles around the point, over a quarter of the fan's area (a cell's worth).
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
    let fan = fan(edges);
    let mut own = vec![None; chart.bordered_points()];
    let rows = |row: usize| row * chart.stride()..(row + 1) * chart.stride();
    own.par_chunks_mut(chart.stride()).enumerate().skip(1).take(chart.rows).for_each(
        |(row, line)| {
            for (point, curvature) in rows(row).zip(line).skip(1).take(chart.cols) {
                *curvature = fan_curvature(edges, &fan, point);
            }
        },
    );
    let or_mean = |point: usize| match own[point] {
        Some(curvature) => curvature.with_tag(0),
        None => {
            let around = fan.iter().filter_map(|spoke| {
                let exists = edges.at(point, spoke.edge) < R::FAR;
                own[point.wrapping_add_signed(spoke.offset)].filter(|_| exists)
            });
            let (sum, count) = around.fold((R::zero(), R::zero()), |(sum, count), curvature| {
                (sum + curvature, count + R::one())
            });
            (sum / count.max(R::one())).with_tag(DIFFRACTS)
        }
    };
    let border = R::zero().with_tag(DIFFRACTS);
    let inside = |point: usize| {
        let (row, col) = (point / chart.stride(), point % chart.stride());
        (1..=chart.rows).contains(&row) && (1..=chart.cols).contains(&col)
    };
    (0..chart.bordered_points())
        .into_par_iter()
        .map(|point| if inside(point) { or_mean(point) } else { border })
        .collect()
}

/// An edge of the fan and the base of the triangle that follows it counter-clockwise.
struct Spoke {
    offset: isize,
    edge: EdgeSlot,
    base: EdgeSlot,
}

fn fan<R: Real>(edges: &EdgeLengths<R>) -> [Spoke; 8] {
    let chart = edges.chart();
    Direction::ALL.map(|to| Spoke {
        offset: chart.offset(to),
        edge: EdgeSlot::new(chart, 0, to),
        base: EdgeSlot::new(chart, chart.offset(to), to.base()),
    })
}

/// `None` if a triangle of the fan is missing.
fn fan_curvature<R: Real>(edges: &EdgeLengths<R>, fan: &[Spoke; 8], point: usize) -> Option<R> {
    let half = R::of(0.5);
    // The angles are added up as the product of complex numbers with these arguments: all of
    // them make a full turn less the defect.
    let (mut re, mut im, mut area) = (R::one(), R::zero(), R::zero());
    for (index, spoke) in fan.iter().enumerate() {
        let a = edges.at(point, spoke.edge);
        let b = edges.at(point, fan[(index + 1) % 8].edge);
        let c = edges.at(point, spoke.base);
        let longest = a.max(b).max(c);
        if !(longest < R::FAR && longest + longest < a + b + c) {
            return None;
        }
        let x = half * ((a * a + b * b) - c * c) / (a * b);
        let y = ((R::one() - x) * (R::one() + x)).max(R::zero()).sqrt();
        (re, im) = (re * x - im * y, re * y + im * x);
        area = area + half * (a * b) * y;
    }
    let largest = R::of(LARGEST_DEFECT);
    let tangent = if re > R::zero() {
        (-im / re).max(-largest).min(largest)
    } else if im > R::zero() {
        -largest
    } else {
        largest
    };
    // The arc tangent to 3e-4 at the largest defect, where it is limited anyhow.
    let (one, square) = (R::one(), tangent * tangent);
    let [third, fifth, seventh] = [3.0, 5.0, 7.0].map(|n| R::of(1.0 / n));
    let defect = tangent * (one - square * (third - square * (fifth - square * seventh)));
    // The noise is that of f32; f64's is as much smaller as its digits are more.
    let noise = R::of(DEFECT_NOISE / f64::from(f32::EPSILON)) * R::epsilon();
    let signal = defect * defect / (defect * defect + noise * noise);
    Some(defect * signal / (R::of(0.25) * area))
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
