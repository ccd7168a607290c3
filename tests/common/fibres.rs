//! Fields of fibres along which lengths are short, and their exact distances.

use std::f64::consts::TAU;

use geosweep::Surface;
use geosweep::glam::{DVec2, DVec3};
use geosweep::surface::MetricTensor;

/// A grid of fibres that follow a sine curve. A step along a fibre is as long as its columns; across fibres, lengths are
/// `ratio` times as long. The surface is flat: (row, column) has the position (column, ratio * (row + amplitude * sin)).
#[derive(Clone, Copy, Debug)]
pub struct Fibres {
    pub rows: usize,
    pub cols: usize,
    pub ratio: f64,
    /// Amplitude of the sine curve, in rows. Its period is the number of columns.
    pub amplitude: f64,
    /// Whether rows and columns are exchanged.
    pub is_transposed: bool,
}

impl Fibres {
    fn turn(self) -> f64 {
        TAU / self.cols as f64
    }

    /// Returns a row and column of the grid as those of fibres along rows, or the reverse.
    fn turned(self, at: DVec2) -> DVec2 {
        if self.is_transposed { DVec2::new(at.y, at.x) } else { at }
    }

    fn chart(self) -> (usize, usize) {
        if self.is_transposed { (self.cols, self.rows) } else { (self.rows, self.cols) }
    }

    pub fn position(self, at: DVec2) -> DVec2 {
        let at = self.turned(at);
        DVec2::new(at.y, self.ratio * (at.x + self.amplitude * (self.turn() * at.y).sin()))
    }

    pub fn places(self) -> impl Iterator<Item = DVec2> {
        let (rows, cols) = self.chart();
        (0..rows * cols).map(move |k| DVec2::new((k / cols) as f64, (k % cols) as f64))
    }

    /// Returns the surface by its positions.
    pub fn by_positions(self) -> Surface {
        let (rows, cols) = self.chart();
        let positions = self.places().map(|at| self.position(at).extend(0.0));
        Surface::from_positions(rows, cols, positions.collect::<Vec<DVec3>>()).unwrap()
    }

    /// Returns the surface by its metric.
    pub fn by_metric(self) -> Surface {
        let (rows, cols) = self.chart();
        let tensor = |at: DVec2| {
            let slope = self.amplitude * self.turn() * (self.turn() * self.turned(at).y).cos();
            let square = self.ratio * self.ratio;
            let across =
                MetricTensor { rr: square, rc: square * slope, cc: 1.0 + square * slope * slope };
            match self.is_transposed {
                true => MetricTensor { rr: across.cc, rc: across.rc, cc: across.rr },
                false => across,
            }
        };
        Surface::from_metric(rows, cols, self.places().map(tensor).collect()).unwrap()
    }

    /// Returns the distance between two places, if the straight line between them stays on the grid.
    pub fn distance(self, from: DVec2, to: DVec2) -> Option<f64> {
        let ends = [from, to].map(|at| self.position(at));
        let is_inside = |share: f64| {
            let at = ends[0].lerp(ends[1], share);
            let row = at.y / self.ratio - self.amplitude * (self.turn() * at.x).sin();
            (-1e-9..=self.rows as f64 - 1.0 + 1e-9).contains(&row)
        };
        let is_free = (0..=50).all(|k| is_inside(f64::from(k) / 50.0));
        is_free.then(|| ends[0].distance(ends[1]))
    }
}
