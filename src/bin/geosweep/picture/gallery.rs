//! Surfaces over what becomes of them, side by side.

use super::canvas::Canvas;
use super::colors::{INK, PAPER};
use super::form::FormPicture;
use super::text::Pen;

/// A surface and its form, with their titles.
pub struct Exhibit<'a> {
    pub title: String,
    pub surface: FormPicture<'a>,
    pub subtitle: String,
    pub form: FormPicture<'a>,
}

/// Exhibits from left to right; all pictures are of one size.
pub struct Gallery<'a> {
    pub exhibits: &'a [Exhibit<'a>],
}

const TEXT: usize = 30;
/// Height of a line of text with what is around it.
const LINE: usize = 2 * TEXT;

impl Gallery<'_> {
    pub fn draw(&self) -> Canvas {
        let Some(first) = self.exhibits.first() else { return Canvas::new(0, 0, PAPER) };
        let [width, height] = first.surface.size;
        let mut canvas = Canvas::new(self.exhibits.len() * width, 2 * (LINE + height), PAPER);
        let (bold, plain) = (Pen::bold(TEXT as f32), Pen::new(0.85 * TEXT as f32));
        for (index, exhibit) in self.exhibits.iter().enumerate() {
            let left = index * width;
            let rows = [
                (&bold, &exhibit.title, &exhibit.surface),
                (&plain, &exhibit.subtitle, &exhibit.form),
            ];
            for (row, (pen, text, picture)) in rows.into_iter().enumerate() {
                let top = row * (LINE + height);
                let x = left as f32 + 0.5 * (width as f32 - pen.width(text));
                canvas.paste(left, top + LINE, &picture.draw());
                pen.write(&mut canvas, x, (top + LINE / 2) as f32, text, INK);
            }
        }
        canvas
    }
}
