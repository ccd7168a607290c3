//! Computes the Gaussian curvature from edge lengths. The twin of `glsl/passes/gaussian_curvature.comp`.

use std::sync::Arc;

use rayon::prelude::*;

#[cfg(doc)]
use super::arc::EdgeRule;
use super::chart::{Direction, EdgeSlot, ring};
use super::edges::EdgeLengths;
use super::kept;
use super::precision::{OfEdges, of_edges};
use super::real::{Real, max, min};
use super::slowed_curvature::SlowedCurvature;
use super::tag::Tagged;
use crate::constants::{DEFECT_NOISE, LARGEST_DEFECT, REFLEX};
use crate::lanes::{Instructions, Loop};

/// Tag ([`Tagged::with_tag`]) of the Gaussian curvature at points that lack a triangle, beside a hole or the
/// border.
pub const LACKING: u8 = crate::constants::LACKING as u8;
/// Additional tag at the corners of holes, where fronts diffract.
pub const DIFFRACTS: u8 = crate::constants::DIFFRACTS as u8;

impl<R: Real> EdgeLengths<R> {
    /// Returns the Gaussian curvature at each point of the bordered array. It is computed from the lengths
    /// alone, on the first call.
    #[doc(hidden)]
    pub fn gaussian_curvature(&self) -> &[R] {
        self.kept_gaussian_curvature()
    }

    /// Returns the array of [`Self::gaussian_curvature`] for data that may outlive these edges.
    #[doc(hidden)]
    pub fn shared_gaussian_curvature(&self) -> Arc<Vec<R>> {
        self.kept_gaussian_curvature().clone()
    }

    fn kept_gaussian_curvature(&self) -> &Arc<Vec<R>> {
        static CURVATURE: OfEdges<Vec<f32>, Vec<f64>> = (gaussian_curvature, gaussian_curvature);
        kept(&self.shared.gaussian_curvature, || Arc::new(of_edges(self, CURVATURE)))
    }
}

/// Computes the Gaussian curvature at each point of the bordered array. It is the angle defect of the fan of
/// eight triangles around the point, divided by its share of the fan's area ([`EdgeRule::share_of_fan`]), and reduced
/// where the curvatures of neighbours differ ([`settled`]).
///
/// Defects near `DEFECT_NOISE`, the rounding of lengths in single precision, are shrunk towards zero;
/// otherwise a flat surface would seem bent the same way everywhere. Defects are limited to `LARGEST_DEFECT`
/// radians, the range of the series for the arc tangent.
///
/// Points with an incomplete fan, at a border or hole, carry the tag `LACKING` and the mean of their
/// neighbours' curvature. At corners of holes the rest of the fan is clearly more than a half turn. Such points
/// also carry `DIFFRACTS`, since most fronts that pass them turn.
fn gaussian_curvature<R: Real>(edges: &EdgeLengths<R>) -> Vec<R> {
    let chart = edges.chart();
    // The curvature is FAR where a triangle of the fan is missing, and larger where fronts diffract.
    let mut fans = vec![R::FAR; chart.bordered_points()];
    let is_slowed = edges.slowness().is_some();
    chart.rows_mut(&mut fans).enumerate().for_each(|(row, line)| match is_slowed {
        true => Instructions::best().run(SlowedFans { edges, row, line }),
        false => Instructions::best().run(Fans { edges, row, line }),
    });
    if let Some(metric) = &edges.shared.metric_curvature {
        for (curvature, &known) in fans.iter_mut().zip(metric) {
            if *curvature < R::FAR && !known.is_nan() {
                *curvature = known.with_tag(0);
            }
        }
    }
    if is_slowed {
        chart
            .rows_mut(&mut fans)
            .enumerate()
            .for_each(|(row, line)| Instructions::best().run(SlowedCurvature { edges, row, line }));
    }
    let mut curvature = vec![R::zero().with_tag(LACKING); chart.bordered_points()];
    chart.rows_mut(&mut curvature).enumerate().for_each(|(row, line)| {
        Instructions::best().run(Settled { edges, row, fans: &fans, line })
    });
    edges.across_seams(&mut curvature);
    curvature
}

/// The step from the curvatures of the fans to the final curvatures, for a row of points.
struct Settled<'a, R> {
    edges: &'a EdgeLengths<R>,
    row: usize,
    fans: &'a [R],
    line: &'a mut [R],
}

impl<R: Real> Loop for Settled<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { edges, row, fans, line } = self;
        let (chart, cols) = (edges.chart(), line.len());
        let first = chart.bordered(row, 0);
        let lengths = Direction::ALL.map(|to| edges.row(first, EdgeSlot::of(chart, to), cols));
        let around = Direction::ALL.map(|to| &fans[chart.beside(first, to)..][..cols]);
        let own = &fans[first..][..cols];
        for (col, curvature) in line.iter_mut().enumerate() {
            let mut neighbours = [R::FAR; 8];
            for to in 0..8 {
                let neighbour = around[to][col];
                neighbours[to] = if lengths[to][col] < R::FAR { neighbour } else { R::FAR };
            }
            *curvature = settled(own[col], neighbours);
        }
    }
}

/// Returns the final curvature of a point: the curvature of its own fan, or the mean of its neighbours' curvatures if
/// its fan is incomplete, times (m^2 - v) / (m^2 + v) if that is positive, else 0. Here m is the mean and v the
/// variance over the point and its neighbours.
///
/// On a smooth surface v falls with the square of the spacing, so that the curvature counts in full. Where
/// the grid does not resolve the surface, the curvature changes its sign from point to point. Its effects on
/// a front would not cancel: saddles spread the front for longer than caps focus it, and it would arrive early.
/// Measured on real terrain (ten maps over 65 x 65 points against exact polyhedral distances on a spline
/// refinement), the mean relative error is 1.9e-3 when all curvature counts and 9.4e-4 with this
/// rule. A limit on the defect also helps (1.2e-3 at 0.005 radians), but it removes the curvature of well resolved
/// surfaces too.
#[inline(always)]
fn settled<R: Real>(own: R, around: [R; 8]) -> R {
    let [a, b, c, d, e, f, g, h] = around;
    let all = [own, a, b, c, d, e, f, g, h];
    // Values are taken relative to the largest, so that squares stay within range.
    let mut largest = R::zero();
    for curvature in all {
        let size = if curvature < R::FAR { max(curvature, -curvature) } else { R::zero() };
        largest = max(largest, size);
    }
    let (mut sum, mut squares, mut count) = (R::zero(), R::zero(), R::zero());
    for curvature in all {
        let known = curvature < R::FAR;
        let relative = if known { curvature / largest } else { R::zero() };
        sum = sum + relative;
        squares = squares + relative * relative;
        count = count + if known { R::one() } else { R::zero() };
    }
    let (mean, mean_square) = (sum / count, squares / count);
    let agreement = max(R::of(2.0) * (mean * mean) - mean_square, R::zero()) / mean_square;
    let beside = if largest > R::zero() { largest * mean * agreement } else { R::zero() };
    let lacking =
        if own > R::FAR { beside.with_tag(LACKING | DIFFRACTS) } else { beside.with_tag(LACKING) };
    if own < R::FAR { (own * agreement).with_tag(0) } else { lacking }
}

/// The curvatures of the fans of a row of points, see [`defect_density`].
struct Fans<'a, R> {
    edges: &'a EdgeLengths<R>,
    row: usize,
    line: &'a mut [R],
}

impl<R: Real> Loop for Fans<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { edges, row, line } = self;
        let [fan, bases] = edges.fans(row, 0..line.len());
        let share = R::of(edges.rule().share_of_fan());
        for (col, curvature) in line.iter_mut().enumerate() {
            let (mut edges, mut opposite) = ([R::FAR; 8], [R::FAR; 8]);
            for to in 0..8 {
                (edges[to], opposite[to]) = (fan[to][col], bases[to][col]);
            }
            *curvature = defect_density(edges, opposite, share);
        }
    }
}

/// The curvatures of the fans of a row of points where edges are weighted by a slowness. This is a separate
/// loop: with these loads in [`Fans`], compilers would not vectorize it.
struct SlowedFans<'a, R> {
    edges: &'a EdgeLengths<R>,
    row: usize,
    line: &'a mut [R],
}

impl<R: Real> Loop for SlowedFans<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { edges, row, line } = self;
        let [fan, bases] = edges.fans(row, 0..line.len());
        let Some((own, around)) = edges.fan_slowness(row, 0..line.len()) else { return };
        let share = R::of(edges.rule().share_of_fan());
        for (col, curvature) in line.iter_mut().enumerate() {
            let (mut edges, mut opposite) = ([R::FAR; 8], [R::FAR; 8]);
            for to in 0..8 {
                let (here, next) = (around[to][col], around[ring::next(to)][col]);
                edges[to] = on_surface(fan[to][col], [own[col], here]);
                opposite[to] = on_surface(bases[to][col], [here, next]);
            }
            *curvature = defect_density(edges, opposite, share);
        }
    }
}

/// Returns the length of an edge on the surface from its weighted length and the slowness at its ends.
#[inline(always)]
fn on_surface<R: Real>(length: R, [from, to]: [R; 2]) -> R {
    if length < R::FAR { (length + length) / (from + to) } else { length }
}

/// Returns the angle defect of a fan divided by its share of the fan's area. `bases` are the edges between
/// the ends of successive `edges`. The result is FAR if a triangle is missing or has no area, and twice FAR if the
/// point is a corner of a hole.
#[inline(always)]
fn defect_density<R: Real>(edges: [R; 8], bases: [R; 8], share_of_fan: R) -> R {
    let (zero, one, half) = (R::zero(), R::one(), R::of(0.5));
    // The angles are added up by multiplying complex numbers with these arguments. Together they make a full
    // turn less the defect.
    let (mut re, mut im, mut area, mut whole, mut lacks) = (one, zero, zero, true, false);
    for index in 0..8 {
        let (a, b, c) = (edges[index], edges[ring::next(index)], bases[index]);
        let longest = max(max(a, b), c);
        let is_there = longest < R::FAR;
        lacks |= !is_there;
        whole &= is_there & (longest + longest < a + b + c);
        let x = half * ((a * a + b * b) - c * c) / (a * b);
        let y = max((one - x) * (one + x), zero).sqrt();
        let (x, y) = if is_there { (x, y) } else { (one, zero) };
        (re, im) = (re * x - im * y, re * y + im * x);
        area = area + half * (a * b) * y;
    }
    let largest = R::of(LARGEST_DEFECT);
    let beyond = if im > zero { -largest } else { largest };
    let within = min(max(-im / re, -largest), largest);
    let tangent = if re > zero { within } else { beyond };
    // A series for the arc tangent, with an error of 2e-4 at the largest defect.
    let square = tangent * tangent;
    let (third, fifth, seventh) = (R::of(1.0 / 3.0), R::of(1.0 / 5.0), R::of(1.0 / 7.0));
    let defect = tangent * (one - square * (third - square * (fifth - square * seventh)));
    // `DEFECT_NOISE` is the noise of f32. The noise of f64 is smaller by the ratio of both precisions.
    let noise = R::of(DEFECT_NOISE / f64::from(f32::EPSILON)) * R::epsilon();
    let signal = defect * defect / (defect * defect + noise * noise);
    let curvature = defect * signal / (share_of_fan * area);
    let is_reflex = (im < zero) & (im < R::of(REFLEX) * re);
    let missing = if lacks & is_reflex { R::FAR + R::FAR } else { R::FAR };
    if whole { curvature.with_tag(0) } else { missing }
}

#[cfg(test)]
mod tests {
    use super::super::tag::TAG;
    use super::*;
    use crate::builtin::{Builtin, Closed};

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
        // The error is that of eight angles, each rounded to about 1e-7, divided by the area of a cell.
        approx::assert_abs_diff_eq!(single, 1.0, epsilon = 2e-2);
        for builtin in [Builtin::Plane, Builtin::Cylinder, Builtin::Cone] {
            let (double, single) = at_the_middle(builtin, 65);
            approx::assert_abs_diff_eq!(double, 0.0, epsilon = 1e-3);
            approx::assert_abs_diff_eq!(single, 0.0, epsilon = 2e-2);
        }
    }

    /// The lines of an equal-area map have corners where its quarters meet. If arcs were measured as if steps had equal
    /// lengths, the curvature there would be 0.8.
    #[test]
    fn corners_of_grid_lines_bend_no_sphere() {
        const SIZE: usize = 121;
        for closed in [Closed::EqualAreaSphere, Closed::OctahedralSphere] {
            let surface = closed.surface(SIZE, SIZE).unwrap();
            let edges = EdgeLengths::<f64>::new(&surface).unwrap();
            let inner = 5..SIZE - 5;
            for (row, col) in surface.chart().places() {
                let from_pole = row.abs_diff(SIZE / 2) + col.abs_diff(SIZE / 2);
                if inner.contains(&row) && inner.contains(&col) && from_pole > 8 {
                    let found = edges.gaussian_curvature()[edges.chart().bordered(row, col)];
                    let name = closed.name();
                    assert!((found - 1.0).abs() < 0.05, "{name} {row},{col}: {found}");
                }
            }
        }
    }

    #[test]
    fn curvature_counts_as_far_as_neighbours_agree() {
        let smooth = [0.9, 1.1, 1.0, 1.05, 0.95, 1.0, 1.0, 1.0];
        approx::assert_relative_eq!(settled(1.0f64, smooth), 1.0, max_relative = 0.02);
        let rough = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
        assert!(settled(1.0f64, rough).abs() < 1e-29);
        // The largest curvature that the unit of length allows.
        let largest = settled(1e24f32, smooth.map(|k| 1e24 * k as f32));
        approx::assert_relative_eq!(largest, 1e24, max_relative = 0.02);
        let far = f32::FAR;
        let alone = settled::<f32>(far, [far; 8]);
        assert!(alone.tag_has(TAG, LACKING) && alone < 1e-29);
        let beside = settled(2.0 * far, [2.0f32, 2.0, far, far, far, far, far, far]);
        approx::assert_relative_eq!(beside, 2.0, max_relative = 1e-5);
        assert!(beside.tag_has(TAG, LACKING | DIFFRACTS));
    }

    #[test]
    fn points_beside_a_hole_or_the_border_and_corners_of_holes_are_flagged() {
        let size = 11;
        let in_hole = |row: usize, col: usize| row.abs_diff(5) <= 1 && col.abs_diff(5) <= 1;
        let mask: Vec<_> = (0..size * size).map(|k| !in_hole(k / size, k % size)).collect();
        let surface = Builtin::Plane.surface(size, size).unwrap().with_mask(&mask).unwrap();
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        for (row, col) in (0..size * size).map(|k| (k / size, k % size)) {
            let beside_the_hole = row.abs_diff(5).max(col.abs_diff(5)) == 2;
            // Corners of the hole diffract; the middles of its sides and the border do not.
            let is_corner = beside_the_hole && row != 5 && col != 5;
            let at_the_border = row % 10 == 0 || col % 10 == 0;
            let lacking = if beside_the_hole || at_the_border { LACKING } else { 0 };
            let expected = lacking | if is_corner { DIFFRACTS } else { 0 };
            let curvature = edges.gaussian_curvature()[edges.chart().bordered(row, col)];
            assert!(in_hole(row, col) || curvature.tag_has(TAG, expected), "{row},{col}");
        }
    }
}
