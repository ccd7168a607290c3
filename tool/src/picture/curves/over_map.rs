//! Draws a map with some of its contours, its sources, and curves computed from it.

use geosweep::geometry::Contour;
use geosweep::{DistanceMap, Sources, Surface};

use super::{CurvePicture, Key, Line, Look, Mark, contour_lines, mark_all};
use crate::picture::raster::Paint;
use crate::picture::{Canvas, scale_of};

/// A picture of curves over a map.
pub struct MapPicture<'a> {
    /// The surface on which the map was computed.
    pub surface: &'a Surface,
    /// The grid with positions.
    pub shape: &'a Surface,
    pub map: &'a DistanceMap,
    pub sources: &'a Sources,
    pub contours: &'a [Contour],
    /// Whether contours are the only curves. Otherwise they are drawn faintly.
    pub plain: bool,
    /// The curves and marks computed from the map.
    pub curves: (Vec<Line>, Vec<Mark>),
    /// The quantity and unit of the map's values, if a legend is drawn.
    pub quantity: Option<&'a str>,
}

impl MapPicture<'_> {
    pub fn draw(self, look: Look) -> Canvas {
        let Self { surface, shape, map, sources, contours, plain, quantity, .. } = self;
        let (curves, mut marks) = self.curves;
        let scale = scale_of(map, sources);
        let levels: Vec<f64> = contours.iter().map(|contour| contour.level).collect();
        let (source_lines, source_marks) = mark_all(sources);
        let mut lines = contour_lines(contours, &scale, plain);
        lines.extend(source_lines.into_iter().chain(curves));
        marks.extend(source_marks);
        let key = |quantity| Key::Scale { quantity, scale: &scale, levels: &levels };
        CurvePicture {
            surface,
            shape,
            values: &map.distances,
            paint: Paint::Values(&scale, None),
            lines: &lines,
            marks: &marks,
            names: &[],
            key: quantity.map_or(Key::Nothing, key),
        }
        .draw(look)
    }
}
