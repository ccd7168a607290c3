//! Computes the stress of a form and its Guttman transform, in one pass over all pairs.

use rayon::prelude::*;

use super::Distances;
use geosweep_cpu::Instructions;
use geosweep_surface::lanes::Loop;

/// The number of pairs in a block. A block fits the first-level cache and is short enough to be summed in
/// single precision; sums over blocks are in double precision.
pub(super) const BLOCK: usize = 512;
/// The number of independent partial sums, which the compiler can keep in SIMD lanes.
pub(super) const LANES: usize = 16;
/// The number of rows that a thread takes at a time.
pub(super) const ROWS: usize = 16;

/// The Guttman transform of a form, of the same length as the form, and the raw stress of the form.
#[derive(Clone, Debug, Default)]
pub(super) struct Transformed {
    pub form: Vec<f64>,
    pub stress: f64,
}

/// Computes the raw stress of a form X and its Guttman transform.
///
/// The raw stress is half the sum over i and j of (d_ij - delta_ij)^2. The Guttman transform for unit weights
/// is B(X) X / n: point i is the mean over j of delta_ij (x_i - x_j) / d_ij. Pairs of coinciding points
/// contribute zero; any other value would be valid too.
pub(super) fn transform(
    distances: &Distances,
    dimensions: usize,
    form: &[f64],
    instructions: Instructions,
) -> Transformed {
    let points = distances.points();
    let planes = planes(form, dimensions);
    let mut transformed = vec![0.0; form.len()];
    let rows = transformed.par_chunks_mut(ROWS * dimensions).enumerate();
    let stresses: Vec<f64> = rows
        .map(|(chunk, out)| {
            let row = |(offset, out): (usize, &mut [f64])| {
                let point = chunk * ROWS + offset;
                let row = Row { planes: &planes, point, distances: distances.row(point), out };
                instructions.run(row)
            };
            let stress = out.chunks_mut(dimensions).enumerate().map(row).sum();
            out.iter_mut().for_each(|coordinate| *coordinate /= points as f64);
            stress
        })
        .collect();
    // The sum runs in row order, so that it does not depend on the number of threads.
    Transformed { form: transformed, stress: 0.5 * stresses.iter().sum::<f64>() }
}

/// Converts coordinates to single precision and stores them axis by axis.
pub(super) fn planes(form: &[f64], dimensions: usize) -> Vec<f32> {
    let axes = (0..dimensions).flat_map(|axis| form.iter().skip(axis).step_by(dimensions));
    axes.map(|&coordinate| coordinate as f32).collect()
}

/// All pairs of one point with the others.
struct Row<'a> {
    planes: &'a [f32],
    point: usize,
    distances: &'a [f32],
    /// Receives the sum over j of delta_ij (x_i - x_j) / d_ij.
    out: &'a mut [f64],
}

impl Loop for Row<'_> {
    /// The sum of squared differences of the distances.
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self { planes, point, distances, out } = self;
        let points = distances.len();
        let mut ratios = [0.0; BLOCK];
        let mut stress = 0.0;
        for start in (0..points).step_by(BLOCK) {
            let distances = &distances[start..points.min(start + BLOCK)];
            let ratios = &mut ratios[..distances.len()];
            let axes = || planes.chunks_exact(points).map(|plane| (plane[point], &plane[start..]));
            // A positive start makes the ratio of coinciding points finite. This ratio is then multiplied by
            // zero.
            ratios.fill(f32::MIN_POSITIVE);
            for (here, there) in axes() {
                for (square, &there) in ratios.iter_mut().zip(there) {
                    *square += (here - there) * (here - there);
                }
            }
            stress += compare(ratios, distances);
            for (out, (here, there)) in out.iter_mut().zip(axes()) {
                *out += pull(ratios, here, &there[..ratios.len()]);
            }
        }
        stress
    }
}

/// Replaces squared distances d^2 by ratios delta / d. Returns the sum of (d - delta)^2.
#[inline(always)]
fn compare(squares: &mut [f32], distances: &[f32]) -> f64 {
    #[inline(always)]
    fn one(square: &mut f32, wanted: f32) -> f32 {
        let found = square.sqrt();
        *square = wanted / found;
        (found - wanted) * (found - wanted)
    }
    let mut sums = [0.0; LANES];
    let (squares, last_squares) = squares.as_chunks_mut::<LANES>();
    let (distances, last_distances) = distances.as_chunks::<LANES>();
    for (squares, distances) in squares.iter_mut().zip(distances) {
        for lane in 0..LANES {
            sums[lane] += one(&mut squares[lane], distances[lane]);
        }
    }
    for (lane, (square, &distance)) in last_squares.iter_mut().zip(last_distances).enumerate() {
        sums[lane] += one(square, distance);
    }
    total(sums)
}

/// Returns the sum of ratio * (here - there).
#[inline(always)]
fn pull(ratios: &[f32], here: f32, there: &[f32]) -> f64 {
    let mut sums = [0.0; LANES];
    let (ratios, last_ratios) = ratios.as_chunks::<LANES>();
    let (there, last_there) = there.as_chunks::<LANES>();
    for (ratios, there) in ratios.iter().zip(there) {
        for lane in 0..LANES {
            sums[lane] += ratios[lane] * (here - there[lane]);
        }
    }
    for (lane, (ratio, there)) in last_ratios.iter().zip(last_there).enumerate() {
        sums[lane] += ratio * (here - there);
    }
    total(sums)
}

#[inline(always)]
pub(super) fn total(sums: [f32; LANES]) -> f64 {
    sums.iter().map(|&sum| f64::from(sum)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computes the transform by its definition, in double precision.
    fn plainly(distances: &Distances, dimensions: usize, form: &[f64]) -> Transformed {
        let points = distances.points();
        let at = |point: usize| &form[point * dimensions..][..dimensions];
        let mut transformed = vec![0.0; form.len()];
        let mut stress = 0.0;
        for i in 0..points {
            for (j, &wanted) in distances.row(i).iter().enumerate() {
                let difference: Vec<f64> = at(i).iter().zip(at(j)).map(|(a, b)| a - b).collect();
                let found = difference.iter().map(|d| d * d).sum::<f64>().sqrt();
                let wanted = f64::from(wanted);
                stress += 0.5 * (found - wanted).powi(2);
                if found > 0.0 {
                    for (axis, difference) in difference.iter().enumerate() {
                        transformed[i * dimensions + axis] +=
                            wanted * difference / found / points as f64;
                    }
                }
            }
        }
        Transformed { form: transformed, stress }
    }

    #[test]
    fn lanes_do_what_the_definition_says() {
        // Sizes around a whole number of lanes and of blocks.
        for (points, dimensions) in [(5, 2), (16, 3), (100, 1), (511, 3), (530, 4)] {
            let hash = |index: usize| (index * 7919 % 1009) as f64 / 1009.0;
            let mut form: Vec<f64> = (0..points * dimensions).map(hash).collect();
            // Two points at the same place.
            form.copy_within(..dimensions, 2 * dimensions);
            let values = (0..points * points).map(|index| {
                let (row, col) = (index / points, index % points);
                if row == col { 0.0 } else { 0.1 + hash(row.max(col) * 31 + row.min(col)) as f32 }
            });
            let distances = Distances::new(points, values.collect()).unwrap();
            let expected = plainly(&distances, dimensions, &form);
            for instructions in Instructions::available() {
                let found = transform(&distances, dimensions, &form, instructions);
                // The sums are in single precision, of at most 32 numbers each.
                approx::assert_relative_eq!(found.stress, expected.stress, max_relative = 2e-6);
                for (found, expected) in found.form.iter().zip(&expected.form) {
                    approx::assert_abs_diff_eq!(found, expected, epsilon = 1e-6);
                }
            }
        }
    }
}
