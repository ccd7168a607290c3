//! Draws which points of a surface have been visited, pass by pass.

use geosweep::glam::Vec2;
use geosweep::{Sources, Surface};

use super::canvas::{Canvas, Color};
use super::colors::PAPER;
use super::gallery::{Tile, tiled};
use super::raster::{Paint, Raster, View};
use super::relief::Relief;
use super::swatches::Swatches;
use super::{aspect, mark_sources};

/// A grid with a colour for each point.
pub struct Visit {
    pub title: String,
    pub colors: Vec<Color>,
}

/// Visits in rows, with the meanings of the colours.
pub struct Visits<'a> {
    pub surface: &'a Surface,
    /// The grid with positions, for proportions.
    pub shape: &'a Surface,
    pub sources: &'a Sources,
    pub rows: &'a [Vec<Visit>],
    pub key: Swatches<'a>,
}

/// The longer side of a grid, in pixels.
const LONG_SIDE: f64 = 460.0;
const GAP: usize = 40;
const TEXT: usize = 26;

impl Visits<'_> {
    pub fn draw(&self) -> Canvas {
        let view = View::with_long_side(self.surface.chart(), aspect(self.shape), LONG_SIDE);
        // The order of visits is easier to see without hills.
        let relief = Relief::level();
        let tile = |visit: &Visit| {
            let raster = Raster {
                view,
                present: self.surface.present(),
                // All points have a colour, so no value is infinite.
                values: &vec![0.0; visit.colors.len()],
                relief: &relief,
                paint: Paint::Colors(&visit.colors),
            };
            let picture = raster.draw();
            let (width, height) = (picture.width + GAP, picture.height + 3 * GAP / 4);
            let mut framed = Canvas::new(width, height, PAPER);
            // The margin has room for marks of sources at the border.
            let corner = [GAP / 2, GAP / 4];
            framed.paste(corner[0], corner[1], &picture);
            let corner = Vec2::from_array(corner.map(|pixels| pixels as f32));
            mark_sources(&mut framed, view, corner, self.sources);
            Tile { title: visit.title.clone(), heading: false, picture: framed }
        };
        let rows: Vec<Vec<Tile>> =
            self.rows.iter().map(|row| row.iter().map(tile).collect()).collect();
        self.key.beside(&tiled(&rows), TEXT).0
    }
}
