//! Draws lines of equal distance at round values.

use super::canvas::{Color, mix};
use super::colors::{Scale, ink_over, luma};

/// The largest number of lines that suits a picture of one map. Since steps are round, there are at least 12
/// lines.
pub const MOST_LINES: f64 = 30.0;
/// Every fifth line is stronger, and named in the legend.
const STRONG: i64 = 5;

/// Lines at all multiples of a round step.
pub struct Isolines {
    pub step: f64,
    /// The width of a line, relative to the usual one. Large pictures need wider lines.
    pub thickness: f32,
}

/// A line, as a multiple of the step.
#[derive(Clone, Copy)]
pub struct Isoline {
    multiple: i64,
    pub value: f64,
}

impl Isolines {
    /// Returns at most `most_lines` lines.
    pub fn over(scale: &Scale, most_lines: f64, thickness: f32) -> Self {
        let range = f64::from(scale.high) - f64::from(scale.low);
        Self { step: round_step(range / most_lines), thickness }
    }

    /// Returns the line nearest to a value.
    pub fn nearest(&self, value: f64) -> Isoline {
        self.at((value / self.step).round() as i64)
    }

    /// Returns all lines in a range, in ascending order.
    pub fn within(&self, low: f64, high: f64) -> impl Iterator<Item = Isoline> {
        let (first, last) = ((low / self.step).ceil() as i64, (high / self.step).floor() as i64);
        (first..=last).map(|multiple| self.at(multiple))
    }

    /// Returns the distance between strong lines.
    pub fn strong_step(&self) -> f64 {
        STRONG as f64 * self.step
    }

    fn at(&self, multiple: i64) -> Isoline {
        Isoline { multiple, value: multiple as f64 * self.step }
    }

    /// Returns the nearest line and how much of a pixel it covers, where the value changes by `slope` per
    /// pixel. Lines that are only a few pixels apart fade.
    pub fn coverage(&self, value: f64, slope: f64) -> (Isoline, f32) {
        let line = self.nearest(value);
        if slope <= 0.0 {
            return (line, 0.0);
        }
        let pixels = |difference: f64| (difference / slope) as f32;
        let distance = pixels((value - line.value).abs());
        let apart = pixels(self.step);
        let fading = ((apart / self.thickness - 3.0) / 5.0).clamp(0.0, 1.0);
        let half_width = line.half_width() * self.thickness;
        (line, fading * (half_width + 0.5 - distance).clamp(0.0, 1.0))
    }
}

/// Returns at most `most` round values within a scale.
pub fn round_levels(scale: &Scale, most: f64) -> Vec<f64> {
    let lines = Isolines::over(scale, most, 1.0);
    let within = lines.within(f64::from(scale.low), f64::from(scale.high));
    within.map(|line| line.value).filter(|value| *value > f64::from(scale.low)).collect()
}

impl Isoline {
    pub fn is_strong(self) -> bool {
        self.multiple % STRONG == 0
    }

    fn half_width(self) -> f32 {
        if self.is_strong() { 0.9 } else { 0.45 }
    }

    /// Blends the line over the colour `ground`. The line is light over the dark end of the scale, and dark
    /// over the light end.
    pub fn over(self, ground: Color, scale: &Scale, coverage: f32) -> Color {
        let ink = ink_over(scale.color(self.value as f32));
        let (weak, strong) = if luma(ink) > 0.5 { (0.38, 0.8) } else { (0.36, 0.7) };
        mix(ground, ink, coverage * if self.is_strong() { strong } else { weak })
    }
}

/// Returns the smallest number of the form 1, 2 or 5 times a power of ten that is at least `least`.
fn round_step(least: f64) -> f64 {
    if least.is_nan() || least <= 0.0 {
        return 1.0;
    }
    let power = 10f64.powf(least.log10().floor());
    // A rounding error must not turn 1 into 2.
    let wanted = least / power * (1.0 - 1e-9);
    power * [1.0, 2.0, 5.0].into_iter().find(|step| *step >= wanted).unwrap_or(10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        for (least, step) in [(1.0, 1.0), (1.1, 2.0), (0.3, 0.5), (60.0, 100.0), (2e-7, 2e-7)] {
            approx::assert_relative_eq!(round_step(least), step, max_relative = 1e-12);
        }
        assert_eq!(round_step(0.0), 1.0);
    }

    #[test]
    fn a_line_is_about_as_wide_as_asked() {
        let lines = Isolines { step: 10.0, thickness: 1.0 };
        // A slope of a tenth per pixel, sampled finely around the line at 30.
        let width: f32 =
            (-400..400).map(|i| lines.coverage(30.0 + f64::from(i) * 1e-3, 0.1).1 * 0.01).sum();
        approx::assert_relative_eq!(width, 0.9, max_relative = 0.02);
    }
}
