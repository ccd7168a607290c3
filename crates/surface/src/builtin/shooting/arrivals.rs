//! Collects the shortest geodesics found to the points of a grid.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use glam::DVec2;

use crate::builtin::unit_square::unit_square;

/// The shortest geodesic found so far to each grid point.
pub(super) struct Arrivals {
    rows: usize,
    cols: usize,
    /// Shortest length of all geodesics, as bits. The bits of positive numbers have the order of the numbers.
    shortest: Vec<AtomicU64>,
    /// Shortest length of the geodesics that stay in the domain.
    inside: Vec<AtomicU64>,
}

impl Arrivals {
    pub(super) fn new(rows: usize, cols: usize) -> Self {
        let none = || (0..rows * cols).map(|_| AtomicU64::new(f64::INFINITY.to_bits())).collect();
        Self { rows, cols, shortest: none(), inside: none() }
    }

    /// Returns (u, v) of a grid point.
    pub(super) fn place(&self, point: usize) -> DVec2 {
        unit_square(self.rows, self.cols, [(point / self.cols) as f64, (point % self.cols) as f64])
    }

    /// Returns the grid points in a triangle and up to `beyond` outside it (in units of the triangle), with
    /// the weights of the triangle's corners.
    pub(super) fn points_near(
        &self,
        triangle: [DVec2; 3],
        beyond: f64,
    ) -> impl Iterator<Item = (usize, [f64; 3])> {
        let [a, b, c] = triangle;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let (low, high) = (low - beyond * (high - low), high + beyond * (high - low));
        let range = |low: f64, high: f64, points: usize| {
            let last = points.saturating_sub(1) as f64;
            let (first, end) = ((low * last).ceil().max(0.0), (high * last).floor().min(last));
            first as usize..if end >= first { end as usize + 1 } else { first as usize }
        };
        let rows = range(low.y, high.y, self.rows);
        let cols = range(low.x, high.x, self.cols);
        let area = (b - a).perp_dot(c - a);
        rows.flat_map(move |row| cols.clone().map(move |col| row * self.cols + col)).filter_map(
            move |point| {
                let from = self.place(point) - a;
                let (second, third) = (from.perp_dot(c - a) / area, (b - a).perp_dot(from) / area);
                let weights = [1.0 - second - third, second, third];
                weights.iter().all(|&weight| weight >= -beyond).then_some((point, weights))
            },
        )
    }

    /// Returns the length of the shortest geodesic found so far to a grid point.
    pub(super) fn shortest(&self, point: usize) -> f64 {
        f64::from_bits(self.shortest[point].load(Relaxed))
    }

    /// Records a geodesic to a grid point. `stays` tells whether it stays in the domain.
    pub(super) fn enter(&self, point: usize, length: f64, stays: impl FnOnce() -> bool) {
        let bits = length.max(0.0).to_bits();
        if bits < self.inside[point].load(Relaxed) {
            self.shortest[point].fetch_min(bits, Relaxed);
            if stays() {
                self.inside[point].fetch_min(bits, Relaxed);
            }
        }
    }

    /// Returns the distances. They are NaN where no geodesic arrives, or the shortest one leaves the domain.
    pub(super) fn distances(self) -> Vec<f64> {
        /// Relative tolerance of lengths: lengths of one geodesic found in two patches may differ by this fraction.
        const SAME: f64 = 1e-9;
        let pairs = self.shortest.into_iter().zip(self.inside);
        pairs
            .map(|pair| {
                let [shortest, inside] = [pair.0, pair.1].map(|x| f64::from_bits(x.into_inner()));
                if inside.is_finite() && inside <= shortest * (1.0 + SAME) {
                    inside
                } else {
                    f64::NAN
                }
            })
            .collect()
    }
}
