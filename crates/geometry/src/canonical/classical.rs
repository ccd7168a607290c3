//! Computes classical scaling: the form whose scalar products fit the distances best, from the largest
//! eigenvalues.
//!
//! Let D2 be the matrix of squared distances and J = I - 11^T / n the centring matrix. The scalar products of
//! the centred points are B = -J D2 J / 2 (Torgerson 1952). B itself is never formed. Its product with
//! several vectors takes one pass over the distances. The largest eigenvalues of B come from a block Krylov
//! space. Plain power iteration would find the eigenvalues of largest magnitude, and some of those are
//! negative for geodesic distances.

use nalgebra::{DMatrix, SymmetricEigen};
use rayon::prelude::*;

use super::Distances;
use super::guttman::{BLOCK, LANES, ROWS, total};
use geosweep_cpu::Instructions;
use geosweep_surface::lanes::Loop;

/// The number of extra vectors in a block, beyond the requested dimensions. They make the last eigenvalues
/// converge as fast as the first.
const SPARE: usize = 2;
/// The largest number of blocks in the Krylov space.
const MOST_BLOCKS: usize = 12;
/// The relative change of the requested eigenvalues below which no more blocks are added. The form is only
/// the start of SMACOF, so it need not be more accurate. The rounding errors of single precision are not far
/// below this limit.
const SETTLED: f64 = 1e-5;

/// Returns the coordinates, row-major, with the axes by descending eigenvalue. Dimensions without a positive
/// eigenvalue are zero.
pub(super) fn classical_scaling(
    distances: &Distances,
    dimensions: usize,
    instructions: Instructions,
) -> Vec<f64> {
    let points = distances.points();
    let width = (dimensions + SPARE).min(points - 1);
    let mut basis = DMatrix::zeros(points, 0);
    let mut images = DMatrix::zeros(points, 0);
    let mut block = orthonormal(&basis, start(points, width));
    let mut known = vec![0.0; dimensions];
    loop {
        let image = products(distances, &block, instructions);
        basis = beside(&basis, &block);
        images = beside(&images, &image);
        let projected = basis.tr_mul(&images);
        let eigen = SymmetricEigen::new((&projected + projected.transpose()) * 0.5);
        let mut order: Vec<usize> = (0..basis.ncols()).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let values: Vec<f64> =
            order.iter().take(dimensions).map(|&k| eigen.eigenvalues[k].max(0.0)).collect();
        let change = values.iter().zip(&known).map(|(new, old)| (new - old).abs());
        let settled = change.fold(0.0, f64::max) <= SETTLED * values[0];
        let full = basis.ncols() + width >= points || basis.ncols() >= MOST_BLOCKS * width;
        if settled || full {
            let vectors = &basis * eigen.eigenvectors.select_columns(&order[..dimensions]);
            let coordinate = |index: usize| {
                let (point, axis) = (index / dimensions, index % dimensions);
                vectors[(point, axis)] * values[axis].sqrt()
            };
            return (0..points * dimensions).map(coordinate).collect();
        }
        known = values;
        block = orthonormal(&basis, image);
    }
}

/// Returns a matrix of `width` centred pseudo-random columns, the same on every machine.
fn start(points: usize, width: usize) -> DMatrix<f64> {
    let number = |row, col| {
        let hash = ((row * width + col + 1) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        ((hash ^ (hash >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) as f64
    };
    let mut vectors = DMatrix::from_fn(points, width, number);
    centre(&mut vectors);
    vectors
}

fn centre(vectors: &mut DMatrix<f64>) {
    for mut column in vectors.column_iter_mut() {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
    }
}

/// Returns an orthonormal basis of the part of `vectors` that is orthogonal to `basis`.
fn orthonormal(basis: &DMatrix<f64>, mut vectors: DMatrix<f64>) -> DMatrix<f64> {
    // The projection is repeated, since the first pass leaves the rounding errors of large components.
    for _ in 0..2 {
        vectors -= basis * basis.tr_mul(&vectors);
    }
    let mut block = vectors.qr().q();
    // The QR decomposition fills vanished directions with arbitrary vectors, which may overlap the basis.
    block -= basis * basis.tr_mul(&block);
    block.qr().q()
}

fn beside(left: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    let (old, new) = (left.ncols(), right.ncols());
    let mut both = left.clone().resize_horizontally(old + new, 0.0);
    both.columns_mut(old, new).copy_from(right);
    both
}

/// Returns the products of B with centred vectors.
fn products(
    distances: &Distances,
    vectors: &DMatrix<f64>,
    instructions: Instructions,
) -> DMatrix<f64> {
    let (points, width) = vectors.shape();
    let planes: Vec<f32> = vectors.iter().map(|&number| number as f32).collect();
    let mut rows = vec![0.0; points * width];
    rows.par_chunks_mut(ROWS * width).enumerate().for_each(|(chunk, out)| {
        for (offset, out) in out.chunks_mut(width).enumerate() {
            let distances = distances.row(chunk * ROWS + offset);
            instructions.run(Row { planes: &planes, distances, out });
        }
    });
    let mut products = DMatrix::from_row_slice(points, width, &rows) * -0.5;
    centre(&mut products);
    products
}

/// The product of one row of squared distances with all vectors.
struct Row<'a> {
    planes: &'a [f32],
    distances: &'a [f32],
    out: &'a mut [f64],
}

impl Loop for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { planes, distances, out } = self;
        let points = distances.len();
        let mut squares = [0.0; BLOCK];
        for start in (0..points).step_by(BLOCK) {
            let distances = &distances[start..points.min(start + BLOCK)];
            let squares = &mut squares[..distances.len()];
            for (square, &distance) in squares.iter_mut().zip(distances) {
                *square = distance * distance;
            }
            for (out, plane) in out.iter_mut().zip(planes.chunks_exact(points)) {
                *out += product(squares, &plane[start..][..squares.len()]);
            }
        }
    }
}

#[inline(always)]
fn product(a: &[f32], b: &[f32]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a, last_a) = a.as_chunks::<LANES>();
    let (b, last_b) = b.as_chunks::<LANES>();
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    for (lane, (a, b)) in last_a.iter().zip(last_b).enumerate() {
        sums[lane] += a * b;
    }
    total(sums)
}
