//! Writes curves as tables of vertices.

use std::io::{self, Write};

use super::super::npy;
use super::drawing::Drawing;

const SEPARATOR: [f64; 5] = [f64::NAN; 5];

/// Writes an array (K, 5) with a row of NaN between curves.
pub fn write_npy(writer: &mut impl Write, drawing: &Drawing) -> io::Result<()> {
    let single = drawing.polylines.iter().all(|polyline| polyline.curve.vertices.len() == 1);
    let mut rows = Vec::new();
    for polyline in &drawing.polylines {
        if !rows.is_empty() && !single {
            rows.push(SEPARATOR);
        }
        rows.extend(polyline.around().map(|([row, col], at)| [row, col, at.x, at.y, at.z]));
    }
    npy::write_npy(writer, &[rows.len(), SEPARATOR.len()], rows.as_flattened())
}

/// Writes a line per vertex.
pub fn write_csv(writer: &mut impl Write, drawing: &Drawing) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(writer);
    let header = ["curve", "kind"].into_iter().chain(drawing.attributes.iter().copied());
    table.write_record(header.chain(["closed", "row", "col", "x", "y", "z"]))?;
    for (index, polyline) in drawing.polylines.iter().enumerate() {
        let attributes = polyline.attributes.iter().map(|(_, value)| value.to_string());
        let closed = u8::from(polyline.curve.closed).to_string();
        let record: Vec<String> = [index.to_string(), polyline.kind.into()]
            .into_iter()
            .chain(attributes)
            .chain([closed])
            .collect();
        for ([row, col], at) in polyline.vertices() {
            let place =
                at.to_array().map(|c| if c.is_nan() { String::new() } else { c.to_string() });
            let vertex = [row.to_string(), col.to_string()].into_iter().chain(place);
            table.write_record(record.iter().cloned().chain(vertex))?;
        }
    }
    table.flush()
}
