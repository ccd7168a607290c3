//! Converts places of a grid to those of the unit square.

use glam::DVec2;

/// Converts a fractional row and column to (u, v).
pub(super) fn unit_square(rows: usize, cols: usize, [row, col]: [f64; 2]) -> DVec2 {
    let fraction = |x: f64, points: usize| if points > 1 { x / (points - 1) as f64 } else { 0.0 };
    DVec2::new(fraction(col, cols), fraction(row, rows))
}
