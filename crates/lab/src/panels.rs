//! Draws several maps of one surface side by side, with one legend.

use geosweep::glam::Vec2;
use geosweep::{Sources, Surface};

use geosweep_cli::picture::canvas::Canvas;
use geosweep_cli::picture::colors::{INK, PAPER, Scale};
use geosweep_cli::picture::isolines::Isolines;
use geosweep_cli::picture::legend::{Legend, Lines};
use geosweep_cli::picture::raster::{Paint, Raster, View};
use geosweep_cli::picture::relief::Relief;
use geosweep_cli::picture::text::Pen;
use geosweep_cli::picture::{aspect, mark_sources, start};

/// A map with its title.
pub struct Panel<'a> {
    pub title: String,
    /// A second title line, in lighter type.
    pub subtitle: String,
    /// One value per grid point, infinite where there is none.
    pub values: &'a [f32],
}

/// Maps of the same surface from the same sources, on one scale.
pub struct Panels<'a> {
    pub surface: &'a Surface,
    pub sources: &'a Sources,
    pub panels: &'a [Panel<'a>],
}

/// The longer side of a panel, in pixels.
const LONG_SIDE: f64 = 480.0;
/// The size of text. It is legible when four panels are scaled to the width of a page.
const TEXT: usize = 36;
const GAP: usize = TEXT;
/// The height of title and subtitle.
const TITLES: usize = 5 * TEXT / 2;
/// The relative width of lines. They are wider, since pictures are scaled down on a page.
const THICKNESS: f32 = 1.5;
/// The largest number of lines. A winding corridor has room for more lines than an open surface.
const MOST_LINES: f64 = 60.0;

impl Panels<'_> {
    pub fn draw(&self) -> Canvas {
        let view = View::with_long_side(self.surface.chart(), aspect(self.surface), LONG_SIDE);
        let values = self.panels.iter().flat_map(|panel| panel.values.iter().copied());
        let scale = Scale::over(values.filter(|v| v.is_finite()).chain([start(self.sources)]));
        let isolines = Isolines::over(&scale, MOST_LINES, THICKNESS);
        let relief = Relief::of(self.surface);

        let step = view.width + GAP;
        let width = self.panels.len() * step - GAP;
        let mut picture = Canvas::new(width, TITLES + view.height, PAPER);
        let (title_pen, subtitle_pen) = (Pen::bold(TEXT as f32), Pen::new(0.8 * TEXT as f32));
        for (index, panel) in self.panels.iter().enumerate() {
            let left = index * step;
            let raster = Raster {
                view,
                present: self.surface.present(),
                values: panel.values,
                relief: &relief,
                paint: Paint::Values(&scale, Some(&isolines)),
            };
            picture.paste(left, TITLES, &raster.draw());
            let x = left as f32;
            title_pen.write(&mut picture, x, 0.5 * TEXT as f32, &panel.title, INK);
            subtitle_pen.write(&mut picture, x, 1.8 * TEXT as f32, &panel.subtitle, INK);
        }
        let legend = Legend { quantity: "distance", scale: &scale, lines: Lines::Every(&isolines) };
        let (mut canvas, corner) = legend.beside(&picture, TEXT, TITLES);
        for index in 0..self.panels.len() {
            let panel = corner + Vec2::new((index * step) as f32, TITLES as f32);
            mark_sources(&mut canvas, view, panel, self.sources);
        }
        canvas
    }
}
