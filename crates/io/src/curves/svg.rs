//! Writes curves as a drawing of the parameter domain.

use std::fmt::Write as _;
use std::io::{self, Write};

use ::svg::Document;
use ::svg::node::element::{Group, Path, Rectangle, Style, Title};

use super::drawing::{Drawing, Polyline};

/// The style of the drawing. Lines have the same width at any scale: the width is in pixels, not in grid
/// steps.
const STYLE: &str = "\
path { fill: none; stroke-width: 1.5; stroke-linecap: round; stroke-linejoin: round; \
vector-effect: non-scaling-stroke }
rect { fill: #f7f7f7; stroke: #b0b0b0; stroke-width: 1; vector-effect: non-scaling-stroke }";
/// Margin around the grid, relative to its longer side.
const MARGIN: f64 = 0.02;

/// Writes the drawing with one unit per grid step, columns to the right and rows down, and a frame around the
/// grid.
pub fn write(writer: &mut impl Write, drawing: &Drawing) -> io::Result<()> {
    let steps = |points: usize| points.saturating_sub(1) as f64;
    let (width, height) = (steps(drawing.chart.cols), steps(drawing.chart.rows));
    let margin = MARGIN * width.max(height).max(1.0);
    let frame = Rectangle::new().set("width", width).set("height", height);
    let paths = drawing.polylines.iter().map(path).fold(Group::new(), Group::add);
    let document = Document::new()
        .set("viewBox", (-margin, -margin, width + 2.0 * margin, height + 2.0 * margin))
        .add(Style::new(STYLE))
        .add(frame)
        .add(paths);
    ::svg::write(writer, &document)
}

fn path(polyline: &Polyline) -> Path {
    let (mut data, Polyline { curve, jumps, .. }) = (String::new(), polyline);
    for (index, [row, col]) in curve.vertices.iter().enumerate() {
        let starts = index == 0 || jumps.binary_search(&index).is_ok();
        let command = if starts { "M" } else { "L" };
        let _ = write!(data, "{command}{col:.4},{row:.4}");
    }
    match curve.vertices[..] {
        [_] => data.push('Z'),
        [[row, col], ..] if curve.closed && jumps.first() != Some(&0) => {
            if jumps.is_empty() {
                data.push('Z');
            } else {
                let _ = write!(data, "L{col:.4},{row:.4}");
            }
        }
        _ => {}
    }
    let [red, green, blue] = polyline.color;
    let path = Path::new()
        .set("class", polyline.kind)
        .set("stroke", format!("#{red:02x}{green:02x}{blue:02x}"))
        .set("d", data);
    let mut title = polyline.kind.to_owned();
    let path = polyline.attributes.iter().fold(path, |path, (name, value)| {
        let _ = write!(title, ", {name} {value}");
        path.set(format!("data-{name}"), value.to_string())
    });
    // The title is shown when the pointer rests on a curve.
    path.add(Title::new(title))
}
