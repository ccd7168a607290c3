//! Writes polygon files, for programs that show meshes.

use std::io::{self, Write};

/// Writes points and triangles between them as binary, little-endian PLY in single precision. Points that are
/// missing (NaN) are left out; no triangle may have them as corners.
///
/// # Errors
/// The errors of the writer. It is also an error if there are more points than PLY's 32-bit indices can
/// distinguish, or if a corner of a triangle is missing.
pub fn write_ply(
    writer: &mut impl Write,
    points: &[[f64; 3]],
    triangles: &[[u32; 3]],
) -> io::Result<()> {
    let present = |point: &&[f64; 3]| point.iter().all(|coordinate| coordinate.is_finite());
    let mut count = 0;
    let numbers: Vec<Option<i32>> = points
        .iter()
        .map(|point| {
            let number = present(&point).then_some(count);
            count += i32::from(number.is_some());
            number
        })
        .collect();
    write_header(
        writer,
        &[
            ("vertex", count as usize, "float x,float y,float z"),
            ("face", triangles.len(), "list uchar int vertex_indices"),
        ],
    )?;
    points.iter().filter(present).try_for_each(|point| write_point(writer, *point))?;
    for triangle in triangles {
        writer.write_all(&[3])?;
        for &corner in triangle {
            let number = numbers.get(corner as usize).copied().flatten();
            let number = number.ok_or_else(|| io::Error::other("a triangle at a missing point"))?;
            writer.write_all(&number.to_le_bytes())?;
        }
    }
    Ok(())
}

/// Writes the header for elements with their names, counts and properties. Commas separate the properties.
pub(super) fn write_header(
    writer: &mut impl Write,
    elements: &[(&str, usize, &str)],
) -> io::Result<()> {
    writeln!(writer, "ply\nformat binary_little_endian 1.0")?;
    for (name, count, properties) in elements {
        writeln!(writer, "element {name} {count}")?;
        for property in properties.split(',') {
            writeln!(writer, "property {property}")?;
        }
    }
    writeln!(writer, "end_header")
}

/// Writes a vertex's position in single precision.
pub(super) fn write_point(writer: &mut impl Write, point: [f64; 3]) -> io::Result<()> {
    for coordinate in point {
        writer.write_all(&(coordinate as f32).to_le_bytes())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_points_are_left_out_and_the_others_renumbered() {
        let points = [[0.0; 3], [f64::NAN; 3], [1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        let mut bytes = Vec::new();
        write_ply(&mut bytes, &points, &[[0, 2, 3]]).unwrap();
        let end = b"end_header\n";
        let data = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
        let header = std::str::from_utf8(&bytes[..data]).unwrap();
        assert!(header.contains("element vertex 3\n") && header.contains("element face 1\n"));
        let (vertices, faces) = bytes[data..].split_at(3 * 12);
        let second: Vec<f32> =
            vertices[12..24].as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        assert_eq!(second, [1.0, 2.0, 3.0]);
        assert_eq!(faces, [3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
        assert!(write_ply(&mut Vec::new(), &points, &[[0, 1, 2]]).is_err());
    }
}
