//! Draws the colour bar next to a picture.

use geosweep::glam::Vec2;

use super::canvas::Canvas;
use super::colors::{INK, PAPER, Scale, ink_over};
use super::isolines::Isolines;
use super::text::Pen;

/// A legend of colours, lines and their values.
pub struct Legend<'a> {
    /// The name of the quantity.
    pub quantity: &'a str,
    pub scale: &'a Scale,
    pub lines: Lines<'a>,
}

/// The lines in the picture.
#[derive(Clone, Copy)]
pub enum Lines<'a> {
    /// Lines at all multiples of a step.
    Every(&'a Isolines),
    /// Lines at the given values, ascending.
    At(&'a [f64]),
}

/// A rectangle of pixels.
struct Bar {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl Legend<'_> {
    /// Returns the size of text that suits a picture of one map, in pixels.
    pub fn text_size(picture: &Canvas) -> usize {
        (picture.width.max(picture.height) / 45).clamp(18, 40)
    }

    /// Draws the picture on a white background with this legend to its right. Also returns the position of
    /// the picture's first pixel. All sizes are proportional to `size`, the size of the text in pixels. The
    /// bar starts below the picture's first `above` rows of pixels, or further down if its title needs the
    /// space.
    pub fn beside(&self, picture: &Canvas, size: usize, above: usize) -> (Canvas, Vec2) {
        let pen = Pen::new(size as f32);
        let above = above.max(3 * size / 2);
        let bar = Bar {
            left: size + picture.width + size,
            top: size + above,
            width: size,
            height: picture.height.saturating_sub(above).max(10 * size),
        };
        let labels = self.labels(2.0 * size as f64 / bar.height as f64);
        let tick = size / 4;
        let label_left = bar.left + bar.width + 2 * tick;
        let text_end = |left: usize, text: &str| left + pen.width(text).ceil() as usize;
        let ends = labels.iter().map(|(_, label)| text_end(label_left, label));
        let width = ends.fold(text_end(bar.left, self.quantity), usize::max) + size;
        let mut canvas = Canvas::new(width, bar.top + bar.height + size, PAPER);

        let (left, top) = (size, (canvas.height - picture.height) / 2);
        canvas.paste(left, top, picture);
        pen.write(&mut canvas, bar.left as f32, (bar.top - size) as f32, self.quantity, INK);
        self.draw_scale(&mut canvas, &bar);
        for (value, label) in labels {
            let y = bar.y(self.scale, value);
            for x in bar.left + bar.width..bar.left + bar.width + tick {
                canvas.blend(x, y, INK, 1.0);
            }
            pen.write(&mut canvas, label_left as f32, y as f32, &label, INK);
        }
        (canvas, Vec2::new(left as f32, top as f32))
    }

    /// Draws the colours from the largest value down, with the picture's lines.
    fn draw_scale(&self, canvas: &mut Canvas, bar: &Bar) {
        let (low, high) = (f64::from(self.scale.low), f64::from(self.scale.high));
        let slope = (high - low) / bar.height as f64;
        for y in 0..bar.height {
            let value = high - (y as f64 + 0.5) * slope;
            let ground = self.scale.color(value as f32);
            let color = match self.lines {
                Lines::Every(isolines) => {
                    let (line, coverage) = isolines.coverage(value, slope);
                    line.over(ground, self.scale, coverage)
                }
                Lines::At(_) => ground,
            };
            for x in bar.left..bar.left + bar.width {
                canvas.blend(x, bar.top + y, color, 1.0);
            }
        }
        if let Lines::At(values) = self.lines {
            let inside = values.iter().filter(|value| (low..=high).contains(*value));
            for &value in inside {
                let y = bar.y(self.scale, value) as f32;
                let [left, right] = [0, bar.width - 1].map(|x| Vec2::new((bar.left + x) as f32, y));
                canvas.stroke(left, right, 0.7, ink_over(self.scale.color(value as f32)));
            }
        }
    }

    /// Returns the labels in ascending order: at strong lines, or at those given lines whose labels do not overlap. A
    /// label takes the fraction `room` of the bar. Without any such line, a single label is at the smallest value.
    fn labels(&self, room: f64) -> Vec<(f64, String)> {
        let (low, high) = (f64::from(self.scale.low), f64::from(self.scale.high));
        let within = |value: &f64| (low..=high).contains(value);
        let largest = low.abs().max(high.abs());
        let (mut values, format): (Vec<f64>, _) = match self.lines {
            Lines::Every(isolines) => {
                let strong = isolines.within(low, high).filter(|line| line.is_strong());
                let format = NumberFormat::new(isolines.strong_step(), largest);
                (strong.map(|line| line.value).collect(), format)
            }
            Lines::At(levels) => {
                let levels: Vec<f64> = levels.iter().copied().filter(within).collect();
                let every = (levels.len() as f64 * room).ceil().max(1.0) as usize;
                let levels = apart(levels.into_iter().step_by(every), 0.5 * room * (high - low));
                let format = NumberFormat::telling_apart(&levels, largest);
                (levels, format)
            }
        };
        if values.is_empty() {
            values.push(low);
        }
        values.into_iter().map(|value| (value, format.text(value))).collect()
    }
}

/// Removes from ascending values those that are closer than `least` to the previous remaining value.
fn apart(values: impl Iterator<Item = f64>, least: f64) -> Vec<f64> {
    let mut kept: Vec<f64> = Vec::new();
    for value in values {
        if kept.last().is_none_or(|last| value - last >= least) {
            kept.push(value);
        }
    }
    kept
}

impl Bar {
    /// Returns the row of pixels of a value.
    fn y(&self, scale: &Scale, value: f64) -> usize {
        let down = (1.0 - scale.fraction(value as f32)) * (self.height - 1) as f32;
        self.top + down.round() as usize
    }
}

/// The format of a series of numbers.
enum NumberFormat {
    Decimals(usize),
    Exponent,
}

impl NumberFormat {
    fn new(step: f64, largest: f64) -> Self {
        // The step has one or two significant digits, such as 0.25.
        let is_whole = |decimals: &usize| {
            let scaled = step * 10f64.powi(*decimals as i32);
            (scaled - scaled.round()).abs() < 1e-6 * scaled
        };
        match (0..=5).find(is_whole) {
            Some(decimals) if largest < 1e7 => Self::Decimals(decimals),
            _ => Self::Exponent,
        }
    }

    /// Returns a format with enough digits to distinguish the values, which need not be multiples of a round
    /// step.
    fn telling_apart(values: &[f64], largest: f64) -> Self {
        let gaps = values.windows(2).map(|pair| pair[1] - pair[0]);
        let alone = values.first().map_or(1.0, |first| first.abs());
        let gap = gaps.reduce(f64::min).unwrap_or(alone);
        let are_told = |decimals: &usize| {
            let rounded = |value: f64| (value * 10f64.powi(*decimals as i32)).round();
            let error =
                |value: &f64| (rounded(*value) / 10f64.powi(*decimals as i32) - value).abs();
            values.iter().map(error).fold(0.0, f64::max) <= 0.01 * gap
        };
        match (0..=5).find(are_told) {
            Some(decimals) if largest < 1e7 => Self::Decimals(decimals),
            _ => Self::Exponent,
        }
    }

    fn text(&self, value: f64) -> String {
        match self {
            _ if value == 0.0 => "0".into(),
            Self::Exponent => format!("{value:.1e}"),
            Self::Decimals(0) => with_thousands(value),
            Self::Decimals(decimals) => format!("{value:.decimals$}"),
        }
    }
}

/// Formats a single number with three or more significant digits.
pub fn number(value: f64) -> String {
    let magnitude = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    match (-3.0..6.0).contains(&magnitude) {
        true => NumberFormat::Decimals((3.0 - magnitude).max(0.0) as usize).text(value),
        false => format!("{value:.2e}"),
    }
}

/// Formats a number with thin spaces between thousands, as in `12 500`.
fn with_thousands(value: f64) -> String {
    let number = format!("{value:.0}");
    let first_digit = number.len() - number.trim_start_matches('-').len();
    let mut text = String::new();
    for (index, character) in number.char_indices() {
        let left = number.len() - index;
        if index > first_digit && left % 3 == 0 && value.abs() >= 1e4 {
            text.push('\u{2009}');
        }
        text.push(character);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_have_the_digits_of_their_step() {
        let text = |step, value| NumberFormat::new(step, 30_000.0).text(value);
        assert_eq!(text(0.25, 0.5), "0.50");
        assert_eq!(text(1.0, 3.0), "3");
        assert_eq!(text(2500.0, 7500.0), "7500");
        assert_eq!(text(5000.0, -25_000.0), "-25\u{2009}000");
        assert_eq!(text(1e-8, 3e-8), "3.0e-8");
        assert_eq!(NumberFormat::new(5e7, 2e8).text(5e7), "5.0e7");
        let apart = |values: &[f64]| NumberFormat::telling_apart(values, 3e4).text(values[0]);
        assert_eq!(apart(&[12.5, 25.0, 37.5]), "12.5");
        assert_eq!(apart(&[1.0 / 3.0, 2.0 / 3.0]), "0.333");
        assert_eq!(apart(&[3171.9, 6343.8]), "3172");
        assert_eq!(apart(&[5.0, 5.01, 5.02]), "5.00");
    }

    #[test]
    fn labels_do_not_collide() {
        let scale = Scale::over([0.0, 10.0].into_iter());
        let labels = |levels: &[f64]| {
            let legend = Legend { quantity: "", scale: &scale, lines: Lines::At(levels) };
            legend.labels(0.05).into_iter().map(|(_, label)| label).collect::<Vec<_>>()
        };
        assert_eq!(labels(&[1e-6, 5.0, 5.01, 5.02]), ["0", "5"]);
        assert_eq!(labels(&[1.0, 2.0, 3.5]), ["1.0", "2.0", "3.5"]);
        let many: Vec<f64> = (0..=100).map(|k| f64::from(k) / 10.0).collect();
        assert!((10..=21).contains(&labels(&many).len()));
    }
}
