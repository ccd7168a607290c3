//! Draws colours and their meanings next to a picture.

use geosweep::glam::Vec2;

use super::canvas::{Canvas, Color};
use super::colors::{INK, PAPER};
use super::text::Pen;

/// A title above coloured squares with their names.
pub struct Swatches<'a> {
    pub title: &'a str,
    pub entries: &'a [(Color, String)],
}

impl Swatches<'_> {
    /// Draws the picture on a white background with the swatches to its right, as many as fit. Also returns
    /// the position of the picture's first pixel. All sizes are proportional to `size`, the size of the
    /// text in pixels.
    pub fn beside(&self, picture: &Canvas, size: usize) -> (Canvas, Vec2) {
        let pen = Pen::new(size as f32);
        let line = 3 * size / 2;
        let room = (picture.height / line).saturating_sub(2);
        let (shown, more) = match self.entries.len() {
            count if count <= room => (count, String::new()),
            count => (room, format!("and {} more", count - room)),
        };
        let entries = &self.entries[..shown];
        let left = picture.width + 2 * size;
        let text_left = left + line;
        let end = |left: usize, text: &str| left + pen.width(text).ceil() as usize;
        let names = entries.iter().map(|(_, name)| name).chain([&more]);
        let width = names.map(|name| end(text_left, name)).fold(end(left, self.title), usize::max);
        let mut canvas = Canvas::new(width + size, picture.height + 2 * size, PAPER);
        canvas.paste(size, size, picture);
        let y = |row: usize| (size + row * line + size / 2) as f32;
        pen.write(&mut canvas, left as f32, y(0), self.title, INK);
        for (index, (color, name)) in entries.iter().enumerate() {
            let y = y(index + 1);
            let middle = Vec2::new((left + size / 2) as f32, y);
            canvas.stroke(middle, middle, 0.5 * size as f32, *color);
            pen.write(&mut canvas, text_left as f32, y, name, INK);
        }
        pen.write(&mut canvas, text_left as f32, y(shown + 1), &more, INK);
        (canvas, Vec2::splat(size as f32))
    }
}
