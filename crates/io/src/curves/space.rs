//! Writes curves in space, for programs that show meshes.

use std::io::{self, Write};

use super::super::ply;
use super::drawing::{Drawing, Polyline};

/// Writes binary, little-endian PLY: vertices with colours, and edges between them.
pub fn write_ply(writer: &mut impl Write, drawing: &Drawing) -> io::Result<()> {
    let polylines = &drawing.polylines;
    let count = polylines.iter().map(|polyline| polyline.positions.len()).sum::<usize>();
    i32::try_from(count).map_err(io::Error::other)?;
    let edge_count = polylines.iter().map(|polyline| edges(polyline).count()).sum();
    ply::write_header(
        writer,
        &[
            ("vertex", count, "float x,float y,float z,uchar red,uchar green,uchar blue"),
            ("edge", edge_count, "int vertex1,int vertex2"),
        ],
    )?;
    for polyline in polylines {
        for position in &polyline.positions {
            ply::write_point(writer, position.to_array())?;
            writer.write_all(&polyline.color)?;
        }
    }
    let mut first = 0;
    for polyline in polylines {
        for end in edges(polyline).flatten() {
            writer.write_all(&((first + end) as i32).to_le_bytes())?;
        }
        first += polyline.positions.len();
    }
    Ok(())
}

/// Returns the pairs of neighbouring vertices, including the last and the first one of a closed curve.
fn edges(polyline: &Polyline) -> impl Iterator<Item = [usize; 2]> {
    let count = polyline.positions.len();
    let closing = polyline.curve.closed && count > 1;
    let open = (1..count).map(|index| [index - 1, index]);
    open.chain(closing.then_some([count.saturating_sub(1), 0]))
}

/// Writes OBJ text: an object with one line element per curve.
pub fn write_obj(writer: &mut impl Write, drawing: &Drawing) -> io::Result<()> {
    // OBJ counts vertices from 1, over the whole file.
    let mut first = 1;
    for (index, polyline) in drawing.polylines.iter().enumerate() {
        write!(writer, "o {}_{index}\n# {}", polyline.kind, polyline.kind)?;
        for (name, value) in &polyline.attributes {
            write!(writer, " {name}={value}")?;
        }
        writeln!(writer)?;
        for position in &polyline.positions {
            writeln!(writer, "v {} {} {}", position.x, position.y, position.z)?;
        }
        let count = polyline.positions.len();
        if count > 0 {
            write!(writer, "{}", if count == 1 { "p" } else { "l" })?;
            let closing = (polyline.curve.closed && count > 1).then_some(first);
            for number in (first..first + count).chain(closing) {
                write!(writer, " {number}")?;
            }
            writeln!(writer)?;
        }
        first += count;
    }
    Ok(())
}
