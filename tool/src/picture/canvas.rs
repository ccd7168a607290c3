//! Provides an RGB picture in memory.

use std::io::{self, Write};

use geosweep::glam::Vec2;

/// A colour with channels from 0 to 1, as displayed (sRGB).
pub type Color = [f32; 3];

/// A picture with row-major pixels.
#[derive(Clone)]
pub struct Canvas {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<Color>,
}

/// Interpolates between `a` (0) and `b` (1).
pub fn mix(a: Color, b: Color, t: f32) -> Color {
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t)
}

impl Canvas {
    pub fn new(width: usize, height: usize, color: Color) -> Self {
        Self { width, height, pixels: vec![color; width * height] }
    }

    /// Blends a colour over a pixel with the opacity `alpha`.
    pub fn blend(&mut self, x: usize, y: usize, color: Color, alpha: f32) {
        let pixel = &mut self.pixels[y * self.width + x];
        *pixel = mix(*pixel, color, alpha);
    }

    /// Copies another picture into this one, with its top left corner at (`x`, `y`).
    pub fn paste(&mut self, x: usize, y: usize, other: &Self) {
        for (row, line) in other.pixels.chunks(other.width).enumerate() {
            let start = (y + row) * self.width + x;
            self.pixels[start..start + other.width].copy_from_slice(line);
        }
    }

    /// Draws a straight line with round ends, antialiased. It is a disc if both ends are the same.
    pub fn stroke(&mut self, from: Vec2, to: Vec2, radius: f32, color: Color) {
        self.polyline(&[from, to], radius, color);
    }

    /// Draws a polyline with round ends and joints, antialiased.
    pub fn polyline(&mut self, points: &[Vec2], radius: f32, color: Color) {
        // Segments overlap at their joints. Each pixel is painted once, with the largest coverage by any
        // segment.
        let mut covered: Vec<(usize, f32)> = Vec::new();
        for ends in points.windows(2) {
            self.cover(ends[0], ends[1], radius, |index, coverage| covered.push((index, coverage)));
        }
        covered.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        covered.dedup_by_key(|(index, _)| *index);
        for (index, coverage) in covered {
            self.pixels[index] = mix(self.pixels[index], color, coverage);
        }
    }

    /// Calls `found` with each pixel that a straight line covers, and its coverage.
    fn cover(&self, from: Vec2, to: Vec2, radius: f32, mut found: impl FnMut(usize, f32)) {
        let reach = Vec2::splat(radius + 1.0);
        let low = (from.min(to) - reach).max(Vec2::ZERO).as_usizevec2();
        let end = (from.max(to) + reach + 1.0).max(Vec2::ZERO).as_usizevec2();
        let along = to - from;
        for y in low.y..end.y.min(self.height) {
            for x in low.x..end.x.min(self.width) {
                let center = Vec2::new(x as f32, y as f32);
                let t = (center - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
                let distance = center.distance(from + along * t.clamp(0.0, 1.0));
                // A line thinner than a pixel covers only its width of the pixel.
                let coverage = (radius + 0.5 - distance).clamp(0.0, (2.0 * radius).min(1.0));
                if coverage > 0.0 {
                    found(y * self.width + x, coverage);
                }
            }
        }
    }

    /// Fills a triangle, antialiased.
    pub fn triangle(&mut self, corners: [Vec2; 3], color: Color) {
        let [a, b, c] = corners;
        let turn = (b - a).perp_dot(c - a).signum();
        let low = (a.min(b).min(c) - 1.0).max(Vec2::ZERO).as_usizevec2();
        let end = (a.max(b).max(c) + 2.0).max(Vec2::ZERO).as_usizevec2();
        for y in low.y..end.y.min(self.height) {
            for x in low.x..end.x.min(self.width) {
                let at = Vec2::new(x as f32, y as f32);
                let inside = |from: Vec2, to: Vec2| {
                    turn * (to - from).normalize_or_zero().perp_dot(at - from)
                };
                let depth = inside(a, b).min(inside(b, c)).min(inside(c, a));
                self.blend(x, y, color, (depth + 0.5).clamp(0.0, 1.0));
            }
        }
    }

    /// Returns the pixels in eight bits per channel.
    fn bytes(&self) -> Vec<u8> {
        let byte = |channel: &f32| (channel.clamp(0.0, 1.0) * 255.0).round() as u8;
        self.pixels.iter().flatten().map(byte).collect()
    }

    pub fn write_png(&self, writer: impl Write) -> io::Result<()> {
        let size = |n: usize| u32::try_from(n).map_err(io::Error::other);
        let mut encoder = png::Encoder::new(writer, size(self.width)?, size(self.height)?);
        encoder.set_color(png::ColorType::Rgb);
        // The highest level takes ten times as long for a file that is a tenth smaller.
        encoder.set_compression(png::Compression::Balanced);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.bytes())?;
        Ok(writer.finish()?)
    }
}
