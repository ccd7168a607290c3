//! Computes the Gaussian curvature of the metric in which lengths are travel times. A part of the twin of
//! `glsl/passes/fan_curvature.comp`.

use super::chart::{Direction, EdgeSlot, ring};
use super::edges::EdgeLengths;
use super::jump::jumps;
use super::real::{Real, max};
use super::tag::Tagged;
use crate::lanes::Loop;

/// Number of points that are computed together. Compilers do not map loops over as many arrays as a point needs to SIMD
/// lanes unless these arrays are local.
const SPAN: usize = 16;

/// Number of terms of the series for a logarithm. They suffice for double precision, since the slowness of neighbours
/// differs by less than a quarter where it does not jump.
const TERMS: usize = 8;

/// The Gaussian curvature (K - L) / s^2 of the metric that a slowness s gives to a surface of curvature K, for a row of
/// points. L is the Laplacian of the logarithm of s. Where s jumps, L is meaningless and left out. `line` has K, which is
/// replaced, or at least FAR where the fan of triangles is incomplete.
///
/// L is the flux of the gradient out of the point's own quarter of the fan, through the four sides towards
/// the neighbours along rows and columns. The flux through a side follows from the difference of the logarithms at the
/// point and the neighbour, from their difference along the side, and from the metric that the lengths of the edges
/// around define. Second differences alone would treat grid lines that bend on the surface as straight.
pub(super) struct SlowedCurvature<'a, R> {
    pub edges: &'a EdgeLengths<R>,
    pub row: usize,
    pub line: &'a mut [R],
}

impl<R: Real> Loop for SlowedCurvature<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { edges, row, line } = self;
        let (chart, cols) = (edges.chart(), line.len());
        let Some((own, around)) = edges.fan_slowness(row, 0..cols) else { return };
        let [fan, bases] = edges.fans(row, 0..cols);
        // The other diagonals of the four cells: each leads from a neighbour along a row or column to the next one.
        let first = chart.bordered(row, 0);
        let diagonals = ALONG_LINES.map(|to| {
            let step = to.next().next().next();
            edges.row(first, EdgeSlot::new(chart, chart.offset(to), step), cols)
        });
        for (span, line) in line.chunks_mut(SPAN).enumerate() {
            let of_span = |slice: &[R]| padded(slice, span * SPAN);
            let row = Row {
                own: of_span(own),
                around: around.map(of_span),
                fan: fan.map(of_span),
                bases: bases.map(of_span),
                diagonals: diagonals.map(of_span),
            };
            let (mut curvature, points) = (padded(line, 0), line.len());
            row.slow(&mut curvature);
            line.copy_from_slice(&curvature[..points]);
        }
    }
}

/// The directions along rows and columns.
const ALONG_LINES: [Direction; 4] =
    [Direction::East, Direction::North, Direction::West, Direction::South];

/// Returns [`SPAN`] numbers of a row from a column on, of which those after its end are 1.
#[inline(always)]
fn padded<R: Real>(row: &[R], first: usize) -> [R; SPAN] {
    let rest = &row[first..];
    rest.first_chunk().copied().unwrap_or_else(|| {
        let mut padded = [R::one(); SPAN];
        padded[..rest.len()].copy_from_slice(rest);
        padded
    })
}

/// The values on which the curvatures of [`SPAN`] points depend: slownesses, and weighted lengths.
struct Row<R> {
    own: [R; SPAN],
    around: [[R; SPAN]; 8],
    fan: [[R; SPAN]; 8],
    bases: [[R; SPAN]; 8],
    diagonals: [[R; SPAN]; 4],
}

impl<R: Real> Row<R> {
    /// Replaces the curvature of the surface by that of the metric with the slowness.
    #[inline(always)]
    fn slow(&self, curvature: &mut [R; SPAN]) {
        let (quarter, half, eighth) = (R::of(0.25), R::of(0.5), R::of(0.125));
        for (i, curvature) in curvature.iter_mut().enumerate() {
            let (own, gaussian) = (self.own[i], *curvature);
            let (mut rises, mut fan, mut bases) = ([own; 8], [own; 8], [own; 8]);
            for to in 0..8 {
                let (there, next) = (self.around[to][i], self.around[ring::next(to)][i]);
                rises[to] = log_ratio(there, own);
                fan[to] = squared(self.fan[to][i], [own, there]);
                bases[to] = squared(self.bases[to][i], [there, next]);
            }
            let mut diagonals = [own; 4];
            for (k, diagonal) in diagonals.iter_mut().enumerate() {
                let ends = [self.around[2 * k][i], self.around[(2 * k + 2) % 8][i]];
                *diagonal = squared(self.diagonals[k][i], ends);
            }
            let mut flow = R::zero();
            for k in 0..4 {
                // The neighbours around the side, as seen from the point, from right to left.
                let to = 2 * k;
                let [right, before, after, left] =
                    [(to + 6) % 8, (to + 7) % 8, (to + 1) % 8, (to + 2) % 8];
                let across = fan[to];
                let along = (bases[to] + bases[before] + fan[left] + fan[right]) * quarter;
                let skew =
                    ((fan[after] - diagonals[k]) + (diagonals[(k + 3) % 4] - fan[before])) * eighth;
                let area = max(across * along - skew * skew, R::min_positive_value()).sqrt();
                let rises_along =
                    quarter * (rises[after] - rises[before] + rises[left] - rises[right]);
                flow = flow + (along * rises[to] - skew * rises_along) / area;
            }
            let mut area = R::zero();
            for to in 0..8 {
                let (first, second) = (fan[to], fan[ring::next(to)]);
                let inner = half * (first + second - bases[to]);
                area = area + half * max(first * second - inner * inner, R::zero()).sqrt();
            }
            let per_square = (own * own).recip();
            let slowed = (gaussian - flow / (quarter * area)) * per_square;
            let is_smooth = !jumps(own) & slowed.is_finite();
            let slowed = if is_smooth { slowed } else { gaussian * per_square };
            *curvature = if gaussian < R::FAR { slowed.with_tag(0) } else { gaussian };
        }
    }
}

/// Returns the square of the length of an edge on the surface from its weighted length and the slowness at its ends.
#[inline(always)]
fn squared<R: Real>(length: R, [from, to]: [R; 2]) -> R {
    let length = (length + length) / (from + to);
    length * length
}

/// Returns the logarithm of a / b for numbers that differ by less than a quarter, from the series of the inverse
/// hyperbolic tangent. Unlike the logarithm of the system, it is computed in SIMD lanes, and is the same everywhere.
#[inline(always)]
fn log_ratio<R: Real>(a: R, b: R) -> R {
    let z = (a - b) / (a + b);
    let square = z * z;
    let mut sum = R::zero();
    for term in (0..TERMS).rev() {
        sum = sum * square + R::of(2.0 / (2 * term + 1) as f64);
    }
    z * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_is_the_logarithm() {
        for k in 0..=100 {
            let ratio = 0.8 + 0.0045 * f64::from(k);
            let error = |found: f64| (found - ratio.ln()).abs();
            assert!(error(log_ratio(3.0 * ratio, 3.0)) < 1e-15, "{ratio}");
            assert!(error(log_ratio(ratio as f32, 1.0).into()) < 1e-7, "{ratio}");
        }
    }
}
