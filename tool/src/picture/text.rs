//! Writes lines of text on a canvas.

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};

use super::canvas::{Canvas, Color};

/// A font at a size in pixels.
pub struct Pen {
    font: FontRef<'static>,
    scale: PxScale,
}

impl Pen {
    pub fn new(size: f32) -> Self {
        Self::with_font(dejavu::sans::regular(), size)
    }

    pub fn bold(size: f32) -> Self {
        Self::with_font(dejavu::sans::bold(), size)
    }

    fn with_font(bytes: &'static [u8], size: f32) -> Self {
        let font = FontRef::try_from_slice(bytes).expect("the font is part of the program");
        Self { font, scale: PxScale::from(size) }
    }

    /// Returns the width of a line of text, in pixels.
    pub fn width(&self, text: &str) -> f32 {
        self.glyphs(text).last().map_or(0.0, |(_, end)| end)
    }

    /// Writes a text that starts at `x`, with the middle of the digits' height at `y`.
    pub fn write(&self, canvas: &mut Canvas, x: f32, y: f32, text: &str, color: Color) {
        let digits = self.font.glyph_id('0').with_scale(self.scale);
        let height = self.font.outline_glyph(digits).map_or(0.0, |o| o.px_bounds().height());
        for (mut glyph, _) in self.glyphs(text) {
            glyph.position += point(x, y + 0.5 * height);
            let Some(outline) = self.font.outline_glyph(glyph) else { continue };
            let corner = outline.px_bounds().min;
            outline.draw(|right, down, coverage| {
                let (x, y) =
                    (corner.x as usize + right as usize, corner.y as usize + down as usize);
                if x < canvas.width && y < canvas.height {
                    canvas.blend(x, y, color, coverage.min(1.0));
                }
            });
        }
    }

    /// Returns glyphs that start at 0, each with the position of the next one.
    fn glyphs(&self, text: &str) -> impl Iterator<Item = (ab_glyph::Glyph, f32)> {
        let font = self.font.as_scaled(self.scale);
        let mut previous = None;
        let mut end = 0.0;
        text.chars().map(move |character| {
            let id = font.glyph_id(character);
            let start = end + previous.map_or(0.0, |previous| font.kern(previous, id));
            end = start + font.h_advance(id);
            previous = Some(id);
            (id.with_scale_and_position(self.scale, point(start, 0.0)), end)
        })
    }
}
