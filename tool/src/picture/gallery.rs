//! Arranges pictures with titles in rows and columns.

use super::canvas::Canvas;
use super::colors::{INK, PAPER};
use super::text::Pen;

const TEXT: usize = 30;
/// The height of a line of text, including the space around it.
const LINE: usize = 2 * TEXT;

/// A picture below its title.
pub struct Tile {
    pub title: String,
    /// Whether the title is a heading.
    pub heading: bool,
    pub picture: Canvas,
}

/// Arranges pictures of similar size in rows and columns. Each column is as wide as the widest picture.
pub fn tiled(rows: &[Vec<Tile>]) -> Canvas {
    let size = |side: fn(&Canvas) -> usize| {
        rows.iter().flatten().map(|tile| side(&tile.picture)).max().unwrap_or_default()
    };
    let (width, height) = (size(|picture| picture.width), size(|picture| picture.height));
    let columns = rows.iter().map(Vec::len).max().unwrap_or_default();
    let mut canvas = Canvas::new(columns * width, rows.len() * (LINE + height), PAPER);
    let (bold, plain) = (Pen::bold(TEXT as f32), Pen::new(0.85 * TEXT as f32));
    for (row, tiles) in rows.iter().enumerate() {
        let top = row * (LINE + height);
        for (column, Tile { title, heading, picture }) in tiles.iter().enumerate() {
            let left = column * width;
            let pen = if *heading { &bold } else { &plain };
            let x = left as f32 + 0.5 * (width as f32 - pen.width(title));
            canvas.paste(left + (width - picture.width) / 2, top + LINE, picture);
            pen.write(&mut canvas, x, (top + LINE / 2) as f32, title, INK);
        }
    }
    canvas
}
