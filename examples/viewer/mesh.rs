//! Triangles and normals of a grid of points.

use geosweep::glam::{Vec3, Vec4};
use geosweep::surface::{Chart, Groups};

/// Returns the indices of two triangles for each cell of the grid whose corners are all there.
pub fn triangles(chart: Chart, has: impl Fn(u32) -> bool) -> Vec<u32> {
    let cols = chart.cols as u32;
    let cells = (1..chart.rows as u32).flat_map(|row| (1..cols).map(move |col| [row, col]));
    let corners = cells.map(|[row, col]| {
        let last = row * cols + col;
        [last - cols - 1, last - cols, last - 1, last]
    });
    corners
        .filter(|corners| corners.iter().all(|&index| has(index)))
        .flat_map(|[above_left, above, left, last]| [above_left, left, above, above, left, last])
        .collect()
}

/// Returns the normal at each point: the mean over its triangles and over the triangles of its copies beyond seams.
pub fn normals(positions: &[Vec4], triangles: &[u32], copies: &Groups) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for triangle in triangles.as_chunks::<3>().0 {
        let corners = triangle.map(|index| index as usize);
        let [a, b, c] = corners.map(|index| positions[index].truncate());
        let normal = (b - a).cross(c - a);
        corners.into_iter().for_each(|index| sums[index] += normal);
    }
    for group in copies.iter() {
        let first = sums[group[0] as usize];
        // The grid may turn over at a seam, as the grid of a Moebius strip does.
        let side = |normal: Vec3| normal.dot(first).signum();
        let own = group.iter().map(|&index| sums[index as usize]);
        let sum: Vec3 = own.map(|normal| side(normal) * normal).sum();
        for &index in group {
            let normal = &mut sums[index as usize];
            *normal = side(*normal) * sum;
        }
    }
    sums.into_iter().map(Vec3::normalize_or_zero).collect()
}
