//! Draws distance maps, with colours and lines of equal distance over the shaded surface, and plots.

mod arrows;
pub mod canvas;
pub mod colors;
mod curves;
mod form;
mod gallery;
pub mod isolines;
pub mod legend;
pub mod raster;
mod regions;
pub mod relief;
pub mod scene;
mod swatches;
pub mod text;
mod visits;

use geosweep::glam::{DVec2, Vec2};
use geosweep::surface::{Direction, Geometry, Source};
use geosweep::{DistanceMap, Sources, Surface};

pub use arrows::Arrows;
pub use canvas::{Canvas, Color};
pub use colors::Scale;
pub use curves::{Line, Look, MapPicture, Mark, path_line, rgb, ridge_line};
pub use form::FormPicture;
pub use gallery::{Tile, tiled};
pub use isolines::round_levels;
use isolines::{Isolines, MOST_LINES};
use legend::{Legend, Lines};
pub use raster::Paint;
use raster::{Raster, View};
pub use regions::Regions;
use relief::Relief;
pub use swatches::Swatches;
pub use visits::{Visit, Visits};

/// A picture of a distance map.
pub struct Picture<'a> {
    /// The surface on which the map was computed.
    pub surface: &'a Surface,
    /// The grid with positions, for shading and proportions.
    pub shape: &'a Surface,
    pub map: &'a DistanceMap,
    pub sources: &'a Sources,
    /// The quantity and unit of the map's values.
    pub quantity: &'a str,
}

impl Picture<'_> {
    pub fn draw(&self) -> Canvas {
        let Self { surface, shape, map, sources, quantity } = *self;
        let view = View::new(surface.chart(), aspect(shape));
        let scale = scale_of(map, sources);
        let isolines = Isolines::over(&scale, MOST_LINES, view.thickness());
        let raster = Raster {
            view,
            present: surface.present(),
            values: &map.distances,
            relief: &Relief::of(shape),
            paint: Paint::Values(&scale, Some(&isolines)),
        };
        let legend = Legend { quantity, scale: &scale, lines: Lines::Every(&isolines) };
        let picture = raster.draw();
        let (mut canvas, corner) = legend.beside(&picture, Legend::text_size(&picture), 0);
        mark_sources(&mut canvas, view, corner, sources);
        canvas
    }
}

/// Returns the colour scale over a map's distances.
pub fn scale_of(map: &DistanceMap, sources: &Sources) -> Scale {
    let distances = map.distances.iter().copied().filter(|distance| distance.is_finite());
    Scale::over(distances.chain([start(sources)]))
}

/// Returns the smallest distance, which may lie between grid points.
pub fn start(sources: &Sources) -> f32 {
    sources.start() as f32
}

/// Returns the mean distance between columns divided by the mean distance between rows. For heights, these
/// are the horizontal distances, as seen from above.
pub fn aspect(shape: &Surface) -> f64 {
    if let Geometry::Heights { spacing, .. } = shape.geometry() {
        return spacing.dx / spacing.dy;
    }
    let ratio = mean_step(shape, Direction::East) / mean_step(shape, Direction::South);
    if ratio.is_finite() && ratio > 0.0 { ratio } else { 1.0 }
}

fn mean_step(shape: &Surface, to: Direction) -> f64 {
    let chart = shape.chart();
    let step = |index| {
        let (row, col) = chart.position(index);
        let there = chart.neighbour(row, col, to).filter(|_| shape.has_edge(row, col, to))?;
        match (shape.geometry(), to) {
            (Geometry::Metric(metric), Direction::East) => Some(metric[index].cc.sqrt()),
            (Geometry::Metric(metric), _) => Some(metric[index].rr.sqrt()),
            _ => Some(shape.position(row, col)?.distance(shape.position(there.0, there.1)?)),
        }
    };
    let steps = (0..chart.points()).filter_map(step);
    let (sum, count) = steps.fold((0.0, 0u32), |(sum, count), step| (sum + step, count + 1));
    sum / f64::from(count)
}

/// Draws points as discs and curves as bands, white with dark rims. `corner` is the position of the picture's
/// first pixel.
pub fn mark_sources(canvas: &mut Canvas, view: View, corner: Vec2, sources: &Sources) {
    const RIM: [f32; 3] = [0.1, 0.1, 0.1];
    const FILL: [f32; 3] = [1.0, 1.0, 1.0];
    let size = view.thickness();
    let pixel = |at: &DVec2| corner + view.pixel(*at);
    // All rims are drawn first, so that a curve's segments and crossing sources join.
    for (color, wider) in [(RIM, 1.6 * size), (FILL, 0.0)] {
        for source in sources.iter() {
            match source {
                Source::Point { at, .. } => {
                    let center = pixel(at);
                    canvas.stroke(center, center, 5.5 * size + wider, color);
                }
                Source::Curve { vertices, .. } => {
                    // The first vertex is repeated, so that a single vertex is visible too.
                    let pixels: Vec<Vec2> =
                        vertices.first().into_iter().chain(vertices).map(pixel).collect();
                    canvas.polyline(&pixels, 1.8 * size + wider, color);
                }
            }
        }
    }
}
