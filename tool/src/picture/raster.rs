//! Maps grid points to pixels: determines which part of a surface each pixel shows.

use geosweep::glam::{DVec2, Vec2};
use geosweep::surface::Chart;
use rayon::prelude::*;

use super::canvas::{Canvas, Color};
use super::colors::{HATCHING, HOLE, Scale, UNREACHED};
use super::isolines::Isolines;
use super::relief::{Relief, shade};

/// The range of the longer side, in pixels. Smaller grids are enlarged to the lower bound, and larger ones
/// reduced to the upper.
const LONG_SIDE: std::ops::RangeInclusive<f64> = 900.0..=2000.0;
/// The smallest length of a side, in pixels. A narrow strip stays visible, although not in proportion.
const SHORT_SIDE: f64 = 60.0;

/// The position of the grid in the picture. The grid's outermost points lie in the middle of the outermost pixels.
#[derive(Clone, Copy)]
pub struct View {
    pub chart: Chart,
    pub width: usize,
    pub height: usize,
}

impl View {
    /// Returns a view of a grid. `aspect` is the distance between columns divided by that between rows.
    pub fn new(chart: Chart, aspect: f64) -> Self {
        let points = chart.cols.max(chart.rows) as f64;
        Self::with_long_side(chart, aspect, points.clamp(*LONG_SIDE.start(), *LONG_SIDE.end()))
    }

    /// Returns a view with the given number of pixels on the longer side.
    pub fn with_long_side(chart: Chart, aspect: f64, long_side: f64) -> Self {
        let steps = |points: usize| (points - 1).max(1) as f64;
        let (width, height) = (steps(chart.cols) * aspect, steps(chart.rows));
        let scale = long_side / width.max(height);
        let pixels = |length: f64| (length * scale).max(SHORT_SIDE).round() as usize;
        Self { chart, width: pixels(width), height: pixels(height) }
    }

    /// Returns the relative size of marks and lines. It is 1 for about a thousand pixels on the longer side.
    pub fn thickness(self) -> f32 {
        (self.width.max(self.height) as f32 / 1000.0).max(1.0)
    }

    /// Returns the grid steps per pixel: rows downwards and columns rightwards.
    fn steps(self) -> DVec2 {
        let steps = |points: usize, pixels: usize| (points - 1) as f64 / (pixels - 1) as f64;
        DVec2::new(steps(self.chart.rows, self.height), steps(self.chart.cols, self.width))
    }

    /// Returns the pixel (x, y) of a place (row, column).
    pub fn pixel(self, at: DVec2) -> Vec2 {
        let steps = self.steps();
        // A single row or column lies in the middle of its strip.
        let along = |at: f64, step: f64, pixels: usize| {
            if step > 0.0 { at / step } else { 0.5 * (pixels - 1) as f64 }
        };
        DVec2::new(along(at.y, steps.y, self.width), along(at.x, steps.x, self.height)).as_vec2()
    }

    /// Returns the place (row, column) of a pixel.
    fn place(self, x: f64, y: f64) -> DVec2 {
        let last = DVec2::new((self.chart.rows - 1) as f64, (self.chart.cols - 1) as f64);
        (self.steps() * DVec2::new(y, x)).clamp(DVec2::ZERO, last)
    }
}

/// A map over a surface, as it is drawn.
pub struct Raster<'a> {
    pub view: View,
    pub present: &'a [bool],
    /// One value per grid point, infinite where there is none.
    pub values: &'a [f32],
    pub relief: &'a Relief,
    pub paint: Paint<'a>,
}

/// The colours of the surface.
#[derive(Clone, Copy)]
pub enum Paint<'a> {
    /// The values on a scale, optionally with lines.
    Values(&'a Scale, Option<&'a Isolines>),
    /// One colour per grid point.
    Colors(&'a [Color]),
}

/// The surroundings of a place: the cell's corners, their weights, and the nearest corner.
struct Around {
    corners: [(usize, usize, f64); 4],
    nearest: (usize, usize),
}

/// The change of the value per row and per column at each grid point, if precomputed.
type Slopes = Option<Vec<DVec2>>;

impl Raster<'_> {
    pub fn draw(&self) -> Canvas {
        let View { width, height, .. } = self.view;
        let steps = self.view.steps().max_element();
        // Several samples per pixel smooth the borders of holes, and average reduced grids.
        let samples = (steps.ceil() as usize).clamp(2, 3);
        let slopes = self.slopes();
        let pixel = |index: usize| self.pixel(index % width, index / width, samples, &slopes);
        let pixels = (0..width * height).into_par_iter().map(pixel).collect();
        Canvas { width, height, pixels }
    }

    /// Precomputes the slopes at all grid points if lines are drawn and there are more pixels than points.
    /// Most points are then used many times.
    fn slopes(&self) -> Slopes {
        let View { chart, width, height } = self.view;
        if !matches!(self.paint, Paint::Values(_, Some(_))) || chart.points() > width * height {
            return None;
        }
        let slope = |index| {
            let (row, col) = chart.position(index);
            self.larger_slope(row, col)
        };
        Some((0..chart.points()).into_par_iter().map(slope).collect())
    }

    fn pixel(&self, x: usize, y: usize, samples: usize, slopes: &Slopes) -> Color {
        let offset = |k: usize| (k as f64 + 0.5) / samples as f64 - 0.5;
        let mut sum = [0.0; 3];
        for k in 0..samples * samples {
            let (x, y) = (x as f64 + offset(k % samples), y as f64 + offset(k / samples));
            let color = self.sample(x, y, slopes);
            sum = std::array::from_fn(|channel| sum[channel] + color[channel]);
        }
        sum.map(|channel| channel / (samples * samples) as f32)
    }

    fn sample(&self, x: f64, y: f64, slopes: &Slopes) -> Color {
        let place = self.view.place(x, y);
        let around = self.around(place);
        let index = self.view.chart.index(around.nearest.0, around.nearest.1);
        if !self.present[index] {
            return HOLE;
        }
        let brightness = self.brightness(&around);
        if !self.values[index].is_finite() {
            let hatched = (x + y).rem_euclid(14.0) < 4.0;
            return shade(if hatched { HATCHING } else { UNREACHED }, brightness);
        }
        match self.paint {
            Paint::Colors(colors) => shade(self.blended(colors, &around), brightness),
            Paint::Values(scale, isolines) => {
                let value = self.value(&around);
                let ground = shade(scale.color(value as f32), brightness);
                let Some(isolines) = isolines else { return ground };
                let (line, coverage) = isolines.coverage(value, self.slope(&around, slopes));
                line.over(ground, scale, coverage)
            }
        }
    }

    /// Interpolates the colour between the grid points that have a value.
    fn blended(&self, colors: &[Color], around: &Around) -> Color {
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for &(row, col, weight) in &around.corners {
            if self.at(row, col).is_some() {
                let color = colors[self.view.chart.index(row, col)];
                sum = std::array::from_fn(|k| sum[k] + weight as f32 * color[k]);
                weights += weight as f32;
            }
        }
        sum.map(|channel| channel / weights)
    }

    fn around(&self, place: DVec2) -> Around {
        let Chart { rows, cols } = self.view.chart;
        let low = |at: f64, points: usize| (at as usize).min(points.saturating_sub(2));
        let (row, col) = (low(place.x, rows), low(place.y, cols));
        let (v, u) = (place.x - row as f64, place.y - col as f64);
        let (below, right) = ((row + 1).min(rows - 1), (col + 1).min(cols - 1));
        let corners = [
            (row, col, (1.0 - v) * (1.0 - u)),
            (row, right, (1.0 - v) * u),
            (below, col, v * (1.0 - u)),
            (below, right, v * u),
        ];
        let nearest = (if v < 0.5 { row } else { below }, if u < 0.5 { col } else { right });
        Around { corners, nearest }
    }

    /// Interpolates the value bilinearly. Next to a hole, missing corners are extrapolated from the nearest
    /// point, so that lines run straight into the hole's border.
    fn value(&self, around: &Around) -> f64 {
        let corner = |&(row, col, weight): &(usize, usize, f64)| {
            let value = self.at(row, col).unwrap_or_else(|| self.continued(around, row, col));
            weight * value
        };
        around.corners.iter().map(corner).sum()
    }

    fn continued(&self, around: &Around, row: usize, col: usize) -> f64 {
        let (near_row, near_col) = around.nearest;
        let along = |to: usize, from: usize, (dr, dc)| {
            (to as f64 - from as f64) * self.difference(near_row, near_col, dr, dc)
        };
        let value = self.at(near_row, near_col).unwrap_or_default();
        value + along(row, near_row, (1, 0)) + along(col, near_col, (0, 1))
    }

    /// Returns the mean of the differences to both neighbours in a direction, as far as they exist.
    fn difference(&self, row: usize, col: usize, down: isize, right: isize) -> f64 {
        let [ahead, behind] = self.differences(row, col, down, right);
        match (ahead, behind) {
            (Some(ahead), Some(behind)) => 0.5 * (ahead + behind),
            (one, other) => one.or(other).unwrap_or_default(),
        }
    }

    fn differences(&self, row: usize, col: usize, down: isize, right: isize) -> [Option<f64>; 2] {
        [1, -1].map(|sign| {
            let row_there = row.checked_add_signed(sign * down)?;
            let col_there = col.checked_add_signed(sign * right)?;
            let there = self.at(row_there, col_there)?;
            Some(sign as f64 * (there - self.at(row, col)?))
        })
    }

    /// Returns the magnitude of the value's change per pixel. At each corner of the cell, the side with the larger
    /// change counts.
    fn slope(&self, around: &Around, slopes: &Slopes) -> f64 {
        let (mut slope, mut weights) = (DVec2::ZERO, 0.0);
        for &(row, col, weight) in &around.corners {
            if weight > 0.0 && self.at(row, col).is_some() {
                let here = match slopes {
                    Some(slopes) => slopes[self.view.chart.index(row, col)],
                    None => self.larger_slope(row, col),
                };
                slope += weight * here;
                weights += weight;
            }
        }
        (slope / weights * self.view.steps()).length()
    }

    /// Returns the change of the value per row and per column at a grid point, from the side with the larger
    /// change. On a ridge, where wavefronts meet, the mean of both sides would vanish and lines would widen.
    fn larger_slope(&self, row: usize, col: usize) -> DVec2 {
        let larger = |down, right| {
            let sides = self.differences(row, col, down, right).into_iter().flatten();
            sides.map(f64::abs).fold(0.0, f64::max)
        };
        DVec2::new(larger(1, 0), larger(0, 1))
    }

    fn brightness(&self, around: &Around) -> f32 {
        let (sum, weights) = around
            .corners
            .iter()
            .map(|&(row, col, weight)| (self.view.chart.index(row, col), weight as f32))
            .filter(|&(index, _)| self.present[index])
            .fold((0.0, 0.0), |(sum, weights), (index, weight)| {
                (sum + weight * self.relief.brightness(index), weights + weight)
            });
        sum / weights
    }

    /// Returns the value at a grid point, if there is one.
    fn at(&self, row: usize, col: usize) -> Option<f64> {
        let Chart { rows, cols } = self.view.chart;
        let value = *self.values.get(row * cols + col).filter(|_| row < rows && col < cols)?;
        value.is_finite().then_some(f64::from(value))
    }
}
