//! Draws curves and marks on a surface, either as a map from above or shaded in space.

mod map;
mod over_map;
mod pose;
mod space;

use geosweep::geometry::{Contour, Curve, Path, Ridge};
use geosweep::glam::{DVec3, Vec2};
use geosweep::io::Orientation;
use geosweep::surface::Source;
use geosweep::{Sources, Surface};

use super::canvas::{Canvas, Color, mix};
use super::colors::{Scale, ink_over};
use super::legend::{Legend, Lines};
use super::raster::Paint;
use super::swatches::Swatches;
use super::text::Pen;
pub use over_map::MapPicture;

/// A picture of curves on a surface.
pub struct CurvePicture<'a> {
    /// The surface on which the map was computed.
    pub surface: &'a Surface,
    /// The grid with positions.
    pub shape: &'a Surface,
    /// One value per grid point, infinite where there is none.
    pub values: &'a [f32],
    pub paint: Paint<'a>,
    /// The lines in the order of drawing. All rims are drawn below all lines.
    pub lines: &'a [Line],
    pub marks: &'a [Mark],
    pub names: &'a [Name],
    pub key: Key<'a>,
}

/// A polyline in the parameter domain.
pub struct Line {
    /// The rows and columns of the vertices.
    pub vertices: Vec<[f64; 2]>,
    /// Half the width, in pixels of a picture of about a thousand pixels.
    pub radius: f32,
    pub color: Color,
    pub rim: Option<Color>,
}

/// A disc with a dark rim.
pub struct Mark {
    pub at: [f64; 2],
    pub radius: f32,
    pub color: Color,
}

/// A word next to a place, drawn over everything else.
pub struct Name {
    pub at: [f64; 2],
    pub text: String,
}

/// The legend that explains the colours.
pub enum Key<'a> {
    /// A scale of the quantity, with lines at the given values.
    Scale {
        quantity: &'a str,
        scale: &'a Scale,
        levels: &'a [f64],
    },
    /// Colours and their names.
    Names {
        title: &'a str,
        entries: &'a [(Color, String)],
    },
    Nothing,
}

/// The kind of view.
#[derive(Clone, Copy, PartialEq)]
pub enum Look {
    /// A map: the parameter domain with relief.
    Map,
    /// A view in space, from the given direction or from the side that shows most. `long_side` is the longer
    /// side of the picture, in pixels.
    Space { toward: Option<DVec3>, orientation: Option<Orientation>, long_side: usize },
}

const WHITE: Color = [1.0; 3];

/// Returns contours over the colours of a scale. They are faint unless `plain` is set.
pub fn contour_lines(contours: &[Contour], scale: &Scale, plain: bool) -> Vec<Line> {
    let line = |level: f64, curve: &Curve| {
        let ground = scale.color(level as f32);
        let (radius, opacity) = if plain { (0.9, 0.9) } else { (0.5, 0.3) };
        let color = mix(ground, ink_over(ground), opacity);
        Line { vertices: curve.points().collect(), radius, color, rim: None }
    };
    let lines = |contour: &Contour| {
        contour.curves.iter().map(|curve| line(contour.level, curve)).collect::<Vec<_>>()
    };
    contours.iter().flat_map(lines).collect()
}

/// The colour of important lines, which contrasts with every colour of the scale.
const BOLD: Color = [1.0, 0.42, 0.25];

/// Returns a path, and a mark at its start.
pub fn path_line(path: &Path) -> (Line, Mark) {
    let vertices = path.curve.vertices.clone();
    let mark = Mark { at: vertices[0], radius: 3.5, color: BOLD };
    (Line { vertices, radius: 1.5, color: BOLD, rim: Some(RIM) }, mark)
}

/// Returns the line of a ridge.
pub fn ridge_line(ridge: &Ridge) -> Line {
    Line { vertices: ridge.curve.points().collect(), radius: 1.5, color: BOLD, rim: Some(RIM) }
}

/// Returns the sources as white marks and lines with dark rims.
pub fn mark_all(sources: &Sources) -> (Vec<Line>, Vec<Mark>) {
    let (mut lines, mut marks) = (Vec::new(), Vec::new());
    for source in sources.iter() {
        match source {
            Source::Point { at, .. } => {
                marks.push(Mark { at: at.to_array(), radius: 5.5, color: WHITE });
            }
            Source::Curve { vertices, .. } => {
                let vertices = vertices.iter().map(|vertex| vertex.to_array()).collect();
                lines.push(Line { vertices, radius: 1.8, color: WHITE, rim: Some(RIM) });
            }
        }
    }
    (lines, marks)
}

/// Returns names that show the number of each source, next to the source or to the middle of a curve.
pub fn number_all(sources: &Sources) -> Vec<Name> {
    let name = |(number, source): (usize, &Source)| {
        let at = match source {
            Source::Point { at, .. } => *at,
            Source::Curve { vertices, .. } => vertices[vertices.len() / 2],
        };
        Name { at: at.to_array(), text: number.to_string() }
    };
    sources.iter().enumerate().map(name).collect()
}

/// Converts a colour to eight bits per channel.
pub fn rgb(color: Color) -> [u8; 3] {
    color.map(|channel| (channel.clamp(0.0, 1.0) * 255.0).round() as u8)
}

/// The colour of rims. `RIM_WIDTH` is their width in pixels.
const RIM: Color = [0.1, 0.1, 0.1];
const RIM_WIDTH: f32 = 1.6;

impl CurvePicture<'_> {
    pub fn draw(&self, look: Look) -> Canvas {
        let picture = match look {
            Look::Map => self.draw_map(),
            Look::Space { toward, orientation, long_side } => {
                self.draw_space((toward, orientation.unwrap_or_default()), long_side)
            }
        };
        let size = Legend::text_size(&picture);
        match self.key {
            Key::Nothing => picture,
            Key::Names { title, entries } => Swatches { title, entries }.beside(&picture, size).0,
            Key::Scale { quantity, scale, levels } => {
                let legend = Legend { quantity, scale, lines: Lines::At(levels) };
                legend.beside(&picture, size, 0).0
            }
        }
    }

    /// Writes the names. `pixel` converts a place to its position in the picture.
    fn write_names(
        &self,
        canvas: &mut Canvas,
        thickness: f32,
        pixel: impl Fn([f64; 2]) -> Option<Vec2>,
    ) {
        let pen = Pen::bold(22.0 * thickness);
        for Name { at, text } in self.names {
            if let Some(at) = pixel(*at) {
                let width = pen.width(text);
                let (right, gap) = (at.x + 10.0 * thickness, 10.0 * thickness);
                let fits = right + width < canvas.width as f32;
                let left = if fits { right } else { at.x - gap - width };
                let pixel = |at: f32, pixels: usize| (at.max(0.0) as usize).min(pixels - 1);
                let middle = pixel(left + 0.5 * width, canvas.width);
                let ground = canvas.pixels[pixel(at.y, canvas.height) * canvas.width + middle];
                pen.write(canvas, left, at.y, text, ink_over(ground));
            }
        }
    }

    /// Returns polylines with their half widths in pixels and their colours, in the order of drawing.
    fn strokes(&self, thickness: f32) -> impl Iterator<Item = (Vec<[f64; 2]>, f32, Color)> {
        let lines = self.lines.iter().flat_map(|line| {
            let whole = Curve { vertices: line.vertices.clone(), closed: false };
            let parts =
                if line.vertices.len() > 1 { whole.parts(self.surface) } else { vec![whole] };
            parts.into_iter().map(move |part| (part.vertices, line))
        });
        let rims = lines.clone().filter_map(move |(vertices, line)| {
            Some((vertices, line.radius * thickness + RIM_WIDTH, line.rim?))
        });
        let lines =
            lines.map(move |(vertices, line)| (vertices, line.radius * thickness, line.color));
        let marks = self.marks.iter().flat_map(move |mark| {
            let radius = mark.radius * thickness;
            [(radius + RIM_WIDTH, RIM), (radius, mark.color)]
                .map(|(radius, color)| (vec![mark.at], radius, color))
        });
        rims.chain(lines).chain(marks)
    }
}
