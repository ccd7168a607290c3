//! Draws curves over the parameter domain with relief.

use geosweep::glam::Vec2;

use super::super::aspect;
use super::super::canvas::Canvas;
use super::super::raster::{Raster, View};
use super::super::relief::Relief;
use super::CurvePicture;

impl CurvePicture<'_> {
    pub(super) fn draw_map(&self) -> Canvas {
        let Self { surface, shape, values, paint, .. } = *self;
        let view = View::new(surface.chart(), aspect(shape));
        let relief = &Relief::of(shape);
        let mut canvas = Raster { view, present: surface.present(), values, relief, paint }.draw();
        for (vertices, radius, color) in self.strokes(view.thickness()) {
            let pixels: Vec<Vec2> = vertices.iter().map(|&at| view.pixel(at.into())).collect();
            match pixels[..] {
                [center] => canvas.stroke(center, center, radius, color),
                _ => canvas.polyline(&pixels, radius, color),
            }
        }
        self.write_names(&mut canvas, view.thickness(), |at| Some(view.pixel(at.into())));
        canvas
    }
}
