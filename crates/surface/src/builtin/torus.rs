//! Defines a quarter of a torus, and the whole of it.

use std::f64::consts::PI;

use super::jet::{Jet, Smooth};
use super::shooting;
use super::unit_square::unit_square;

/// Radius of the tube; its centre line has radius 1.
const TUBE: f64 = 0.4;

pub(super) fn position<T: Smooth>([u, v]: [T; 2]) -> [T; 3] {
    let ((sin_a, cos_a), (sin_b, cos_b)) = ((u * PI).sin_cos(), (v * PI).sin_cos());
    let radius = cos_b * TUBE + 1.0;
    [radius * cos_a, radius * sin_a, sin_b * TUBE]
}

/// Returns the position of (u, v) on the whole torus.
pub(super) fn whole<T: Smooth>([u, v]: [T; 2]) -> [T; 3] {
    position([u * 2.0, v * 2.0])
}

/// Lines of a torus, unrolled on both sides of a place.
struct Unrolled {
    /// Number of lines in one turn.
    round: usize,
    /// The first line, which may be negative.
    first: f64,
    lines: usize,
}

impl Unrolled {
    /// Unrolls `turns` turns in each direction.
    fn new(lines: usize, at: f64, turns: f64) -> Self {
        let round = lines - 1;
        let reach = turns * round as f64;
        let (first, last) = ((at - reach).ceil(), (at + reach).floor());
        Self { round, first, lines: (last - first) as usize + 1 }
    }

    /// Returns the number of turns at a fraction of the unrolled lines.
    fn turns(&self, fraction: Jet) -> Jet {
        (fraction * (self.lines - 1) as f64 + self.first) * (self.round as f64).recip()
    }

    /// Returns the line of the grid to which an unrolled line belongs.
    fn line(&self, unrolled: usize) -> usize {
        (self.first as isize + unrolled as isize).rem_euclid(self.round as isize) as usize
    }
}

/// Returns distances on the whole torus (see `Closed::distances`), by shooting geodesics on the unrolled torus. Across
/// the columns, a shortest path makes at most half a turn, since the torus is its own mirror image. Across the rows, it
/// makes less than a turn.
pub(super) fn whole_distances(rows: usize, cols: usize, from: [f64; 2]) -> Vec<f64> {
    let mut distances = vec![f64::NAN; rows * cols];
    if rows < 2 || cols < 2 {
        return distances;
    }
    let (down, right) = (Unrolled::new(rows, from[0], 1.0), Unrolled::new(cols, from[1], 0.5));
    let position = |[u, v]: [Jet; 2]| whole([right.turns(u), down.turns(v)]);
    let at = [from[0] - down.first, from[1] - right.first];
    let at = unit_square(down.lines, right.lines, at);
    let unrolled = shooting::distances(position, down.lines, right.lines, at);
    for (index, distance) in unrolled.into_iter().enumerate() {
        let (row, col) = (down.line(index / right.lines), right.line(index % right.lines));
        let shortest = &mut distances[row * cols + col];
        *shortest = shortest.min(distance);
    }
    // The last lines repeat the first ones.
    (0..rows).for_each(|row| distances[row * cols + cols - 1] = distances[row * cols]);
    distances.copy_within(..cols, (rows - 1) * cols);
    distances
}
