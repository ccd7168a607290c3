//! Pictures of curves over a map and a few of its contours.

use geosweep::geometry::contours;
use geosweep::{DistanceMap, Sources};

use crate::picture::{
    Canvas, CurvePicture, Key, Line, Look, Mark, Paint, contour_lines, mark_all, round_levels,
    scale_of,
};
use crate::problem::Scene;

/// More contours would hide the curves.
const MOST_LINES: f64 = 20.0;

pub fn draw_over_map(
    scene: &Scene,
    sources: &Sources,
    map: &DistanceMap,
    quantity: &str,
    (curves, mut marks): (Vec<Line>, Vec<Mark>),
    look: Look,
) -> Canvas {
    let scale = scale_of(map, sources);
    let levels = round_levels(&scale, MOST_LINES);
    let mut lines = contour_lines(&contours(map, sources, &levels), &scale, false);
    let (source_lines, source_marks) = mark_all(sources);
    lines.extend(source_lines.into_iter().chain(curves));
    marks.extend(source_marks);
    CurvePicture {
        surface: &scene.surface,
        shape: scene.shape(),
        values: &map.distances,
        paint: Paint::Values(&scale, None),
        lines: &lines,
        marks: &marks,
        key: Key::Scale { quantity, scale: &scale, levels: &levels },
    }
    .draw(look)
}
