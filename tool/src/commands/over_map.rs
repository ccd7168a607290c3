//! Draws curves over a map with a few of its contours.

use geosweep::geometry::contours;
use geosweep::{DistanceMap, Sources};

use crate::picture::{Canvas, Line, Look, MapPicture, Mark, round_levels, scale_of};
use crate::problem::Scene;

/// The largest number of contours. More would hide the curves.
const MOST_LINES: f64 = 20.0;

pub fn draw_over_map(
    scene: &Scene,
    sources: &Sources,
    map: &DistanceMap,
    quantity: &str,
    curves: (Vec<Line>, Vec<Mark>),
    look: Look,
) -> Canvas {
    let levels = round_levels(&scale_of(map, sources), MOST_LINES);
    MapPicture {
        surface: &scene.surface,
        shape: scene.shape(),
        map,
        sources,
        contours: &contours(map, sources, &levels),
        plain: false,
        curves,
        quantity: Some(quantity),
    }
    .draw(look)
}
