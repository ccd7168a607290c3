//! Holds and checks the matrix of all pairwise distances.

use rayon::prelude::*;

use super::error::{ASYMMETRY, CanonicalError, EXTENT};

/// The distances between all pairs of n points: a symmetric n x n matrix with a zero diagonal and finite
/// values.
#[derive(Clone, Debug, PartialEq)]
pub struct Distances {
    points: usize,
    values: Vec<f32>,
}

impl Distances {
    /// Checks a row-major matrix and replaces the two distances of each pair of points by their mean.
    ///
    /// # Errors
    /// If the matrix is not square; if a distance is NaN, negative, infinite (one point cannot be reached
    /// from another), or not zero on the diagonal; if the largest distance is zero or outside [`EXTENT`]; or
    /// if the two distances of a pair of points differ by more than [`ASYMMETRY`] times the largest distance.
    pub fn new(points: usize, values: Vec<f32>) -> Result<Self, CanonicalError> {
        check_square(points, &values)?;
        Self::numbered(points, values, |point| point)
    }

    /// Checks and symmetrises a square matrix. In errors, points have the numbers that `number` gives them.
    fn numbered(
        points: usize,
        values: Vec<f32>,
        number: impl Fn(usize) -> usize + Sync,
    ) -> Result<Self, CanonicalError> {
        let largest = check(points, &values, &number)?;
        let mut distances = Self { points, values };
        distances.symmetrise(ASYMMETRY * largest, number)?;
        Ok(distances)
    }

    /// Returns the distances within the largest set of points that reach each other, and the indices of these
    /// points in ascending order.
    ///
    /// All other points are left out: holes, whose rows are +infinity, and points on separate pieces of the
    /// surface. The distances do not say where to place them.
    ///
    /// # Errors
    /// As for [`Distances::new`].
    pub fn of_largest_piece(
        points: usize,
        values: Vec<f32>,
    ) -> Result<(Self, Vec<usize>), CanonicalError> {
        check_square(points, &values)?;
        let kept = largest_piece(points, &values);
        if kept.len() == points {
            return Ok((Self::new(points, values)?, kept));
        }
        let rows = kept.par_iter().flat_map_iter(|&from| {
            let row = &values[from * points..][..points];
            kept.iter().map(|&to| row[to])
        });
        let piece = Self::numbered(kept.len(), rows.collect(), |point| kept[point])?;
        Ok((piece, kept))
    }

    /// Returns the number of points, n.
    pub fn points(&self) -> usize {
        self.points
    }

    /// Returns the distances from a point to all points.
    ///
    /// # Panics
    /// If the index `point` is out of range.
    pub fn row(&self, point: usize) -> &[f32] {
        &self.values[point * self.points..][..self.points]
    }

    /// Replaces both triangles of the matrix by their mean, tile by tile, so that rows and columns stay in
    /// the cache.
    fn symmetrise(
        &mut self,
        tolerance: f32,
        number: impl Fn(usize) -> usize,
    ) -> Result<(), CanonicalError> {
        const TILE: usize = 64;
        let points = self.points;
        let tiles = || (0..points).step_by(TILE).map(|start| start..(start + TILE).min(points));
        for rows in tiles() {
            for cols in tiles().take_while(|cols| cols.start <= rows.start) {
                for row in rows.clone() {
                    for col in cols.start..cols.end.min(row) {
                        let (there, back) =
                            (self.values[col * points + row], self.values[row * points + col]);
                        if (there - back).abs() > tolerance {
                            let (from, to) = (number(col), number(row));
                            return Err(CanonicalError::Asymmetric { from, to, there, back });
                        }
                        let mean = 0.5 * (there + back);
                        self.values[col * points + row] = mean;
                        self.values[row * points + col] = mean;
                    }
                }
            }
        }
        Ok(())
    }
}

fn check_square(points: usize, values: &[f32]) -> Result<(), CanonicalError> {
    let is_square = points.checked_mul(points) == Some(values.len());
    is_square.then_some(()).ok_or(CanonicalError::NotSquare { values: values.len(), points })
}

/// Returns the largest distance, or an error if a distance is not usable.
fn check(
    points: usize,
    values: &[f32],
    number: impl Fn(usize) -> usize + Sync,
) -> Result<f32, CanonicalError> {
    let row = |(from, row): (usize, &[f32])| {
        let mut largest = 0.0f32;
        for (to, &distance) in row.iter().enumerate() {
            let is_finite = (0.0..f32::INFINITY).contains(&distance);
            if is_finite && (from != to || distance == 0.0) {
                largest = largest.max(distance);
                continue;
            }
            let [from, to] = [from, to].map(&number);
            return Err(match distance {
                _ if distance.is_nan() => CanonicalError::NotANumber { from, to },
                _ if distance < 0.0 => CanonicalError::Negative { from, to, distance },
                _ if from == to => CanonicalError::Diagonal { point: from, distance },
                _ => CanonicalError::Unreachable { from, to },
            });
        }
        Ok(largest)
    };
    let rows = values.par_chunks(points.max(1)).enumerate().map(row);
    // Rows are collected before errors are looked at, so that the first error in row-major order is reported.
    let rows: Vec<_> = rows.collect();
    let largest = rows.into_iter().try_fold(0.0f32, |largest, row| row.map(|row| largest.max(row)));
    match largest? {
        0.0 => Err(CanonicalError::NoExtent),
        largest if !EXTENT.contains(&largest) => Err(CanonicalError::Extent { largest }),
        largest => Ok(largest),
    }
}

/// Returns the points of the largest set whose points all reach each other. If several sets have this size,
/// the set with the first point is returned.
fn largest_piece(points: usize, values: &[f32]) -> Vec<usize> {
    let mut left: Vec<usize> = (0..points).collect();
    let mut largest = Vec::new();
    while let Some(&first) = left.first() {
        let row = &values[first * points..][..points];
        // In a matrix of path lengths, reachability is transitive. A matrix without this property, or with a
        // NaN, is rejected by the later check of the piece.
        let reached = |&to: &usize| to == first || row[to] != f32::INFINITY;
        let (piece, others): (Vec<_>, Vec<_>) = left.into_iter().partition(reached);
        if piece.len() > largest.len() {
            largest = piece;
        }
        left = others;
    }
    // A hole does not reach any point, not even itself.
    if let [only] = largest[..] {
        largest.retain(|_| values[only * points + only] != f32::INFINITY);
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAR: f32 = f32::INFINITY;

    #[test]
    fn both_ways_are_averaged() {
        let distances = Distances::new(2, vec![0.0, 10.1, 9.9, 0.0]).unwrap();
        assert_eq!(distances.row(0), [0.0, 10.0]);
        assert_eq!(distances.row(1), [10.0, 0.0]);
    }

    #[test]
    fn invalid_matrices_are_refused() {
        let refused = |values: &[f32]| Distances::new(2, values.to_vec()).unwrap_err();
        assert_eq!(refused(&[0.0; 3]), CanonicalError::NotSquare { values: 3, points: 2 });
        assert!(matches!(
            refused(&[0.0, f32::NAN, 1.0, 0.0]),
            CanonicalError::NotANumber { from: 0, to: 1 }
        ));
        let negative = refused(&[0.0, 1.0, -1.0, 0.0]);
        assert_eq!(negative, CanonicalError::Negative { from: 1, to: 0, distance: -1.0 });
        let diagonal = refused(&[0.0, 1.0, 1.0, 0.5]);
        assert_eq!(diagonal, CanonicalError::Diagonal { point: 1, distance: 0.5 });
        assert_eq!(refused(&[0.0, FAR, FAR, 0.0]), CanonicalError::Unreachable { from: 0, to: 1 });
        let asymmetric = CanonicalError::Asymmetric { from: 0, to: 1, there: 1.0, back: 1.1 };
        assert_eq!(refused(&[0.0, 1.0, 1.1, 0.0]), asymmetric);
        assert_eq!(refused(&[0.0; 4]), CanonicalError::NoExtent);
    }

    #[test]
    fn tiles_cover_the_whole_matrix() {
        let points: usize = 150;
        let values: Vec<f32> = (0..points * points)
            .map(|index| {
                let (row, col) = (index / points, index % points);
                let skew = if row < col { 0.5 } else { -0.5 };
                if row == col { 0.0 } else { 100.0 + row.abs_diff(col) as f32 + skew }
            })
            .collect();
        let distances = Distances::new(points, values).unwrap();
        for row in 0..points {
            for (col, &found) in distances.row(row).iter().enumerate() {
                let expected = if row == col { 0.0 } else { 100.0 + row.abs_diff(col) as f32 };
                assert_eq!(found, expected, "{row} {col}");
            }
        }
    }

    #[test]
    fn the_largest_piece_keeps_its_points_numbers() {
        // A hole at 1, an isolated point at 3, and three connected points.
        #[rustfmt::skip]
        let values = vec![
            0.0, FAR, 2.0, FAR, 4.0,
            FAR, FAR, FAR, FAR, FAR,
            2.0, FAR, 0.0, FAR, 3.0,
            FAR, FAR, FAR, 0.0, FAR,
            4.0, FAR, 3.0, FAR, 0.0,
        ];
        let (piece, kept) = Distances::of_largest_piece(5, values.clone()).unwrap();
        assert_eq!(kept, [0, 2, 4]);
        assert_eq!(piece.values, [0.0, 2.0, 4.0, 2.0, 0.0, 3.0, 4.0, 3.0, 0.0]);

        let mut bad = values;
        bad[2 * 5 + 4] = 30.0;
        let error = Distances::of_largest_piece(5, bad).unwrap_err();
        assert!(matches!(error, CanonicalError::Asymmetric { from: 2, to: 4, .. }), "{error}");
    }
}
