//! Builds triangles over the points of a grid.

use geosweep::glam::{DVec3, Vec3};
use geosweep::surface::Chart;

use super::super::canvas::Color;
use super::view::View;

/// Triangles with one colour per vertex.
pub struct Mesh {
    pub positions: Vec<DVec3>,
    pub colors: Vec<Color>,
    pub triangles: Vec<[u32; 3]>,
    /// The unit normals, each the mean over the triangles around a vertex.
    normals: Vec<DVec3>,
}

/// A mesh as seen in a view.
pub struct Seen<'a> {
    /// The pixels and depths; see [`View::pixel`].
    pub places: Vec<Vec3>,
    /// The normals, as (rightwards, upwards, towards the viewer).
    pub normals: Vec<Vec3>,
    pub colors: &'a [Color],
    pub triangles: &'a [[u32; 3]],
}

impl Mesh {
    /// Builds two triangles for each cell of a grid, split along its shorter diagonal. A cell with one
    /// missing corner (NaN) has one triangle, and a cell with more missing corners has none. There is one
    /// position and one colour per grid point, row-major.
    pub fn of_grid(chart: Chart, positions: Vec<DVec3>, colors: Vec<Color>) -> Self {
        let triangles = grid_triangles(chart, &positions);
        Self::new(positions, colors, triangles)
    }

    /// Builds a mesh with one colour per position. Triangles are indices of positions. The triangles around a vertex
    /// must all have the same orientation, which may be either.
    pub fn new(positions: Vec<DVec3>, colors: Vec<Color>, triangles: Vec<[u32; 3]>) -> Self {
        assert_eq!(positions.len(), colors.len(), "one colour per position");
        let mut normals = vec![DVec3::ZERO; positions.len()];
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|corner| positions[corner as usize]);
            // The length is twice the triangle's area, so that slivers count little.
            let normal = (b - a).cross(c - a);
            triangle.iter().for_each(|&corner| normals[corner as usize] += normal);
        }
        normals.iter_mut().for_each(|normal| *normal = normal.normalize_or_zero());
        Self { positions, colors, triangles, normals }
    }

    /// Gives all vertices of each group the mean of their normals, so that no edge is seen where the grid of a closed
    /// surface begins and ends. The vertices of a group are one point of the surface. Each normal stays on its own side
    /// of the surface.
    pub fn share_normals<'a>(&mut self, groups: impl Iterator<Item = &'a [usize]>) {
        for group in groups {
            let first = self.normals[group[0]];
            let side = |normal: DVec3| if normal.dot(first) < 0.0 { -1.0 } else { 1.0 };
            let all = group.iter().map(|&vertex| self.normals[vertex]);
            let mean = all.map(|normal| side(normal) * normal).sum::<DVec3>().normalize_or_zero();
            for &vertex in group {
                self.normals[vertex] = side(self.normals[vertex]) * mean;
            }
        }
    }

    /// Returns the positions that are not missing, for [`View::fit`].
    pub fn present(&self) -> impl Iterator<Item = DVec3> + Clone {
        self.positions.iter().copied().filter(|position| position.is_finite())
    }

    pub(super) fn seen(&self, view: &View) -> Seen<'_> {
        Seen {
            places: self.positions.iter().map(|&position| view.pixel(position)).collect(),
            normals: self.normals.iter().map(|&normal| view.turn(normal).as_vec3()).collect(),
            colors: &self.colors,
            triangles: &self.triangles,
        }
    }
}

/// Returns the triangles of a grid whose missing points are NaN; see [`Mesh::of_grid`].
pub fn grid_triangles(chart: Chart, positions: &[DVec3]) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(2 * chart.points());
    for row in 1..chart.rows {
        for col in 1..chart.cols {
            let corners = [(row - 1, col - 1), (row, col - 1), (row, col), (row - 1, col)]
                .map(|(row, col)| chart.index(row, col));
            let at = corners.map(|corner| positions[corner]);
            let missing = at.iter().filter(|position| !position.is_finite()).count();
            let around = |first: usize, count: usize| {
                let corner = |k: usize| corners[(first + k) % 4] as u32;
                match count {
                    1 => [corner(1), corner(2), corner(3)],
                    _ => [corner(0), corner(1), corner(2)],
                }
            };
            match missing {
                0 => {
                    let first = usize::from(at[1].distance(at[3]) < at[0].distance(at[2]));
                    triangles.extend([around(first, 2), around(first + 2, 2)]);
                }
                1 => {
                    let hole = at.iter().position(|position| !position.is_finite());
                    triangles.extend(hole.map(|hole| around(hole, 1)));
                }
                _ => {}
            }
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_cost_their_triangles_and_no_more() {
        let chart = Chart { rows: 4, cols: 5 };
        let mut positions: Vec<_> = (0..20)
            .map(|index| {
                let (row, col) = chart.position(index);
                DVec3::new(col as f64, row as f64, 0.0)
            })
            .collect();
        assert_eq!(grid_triangles(chart, &positions).len(), 2 * 3 * 4);
        positions[chart.index(1, 2)] = DVec3::NAN;
        let triangles = grid_triangles(chart, &positions);
        // Four cells keep one triangle each.
        assert_eq!(triangles.len(), 2 * 3 * 4 - 4);
        assert!(triangles.iter().flatten().all(|&corner| corner != 7));
        let area: f64 = triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(|corner| positions[corner as usize]);
                0.5 * (b - a).cross(c - a).z
            })
            .sum();
        // All triangles have the same orientation.
        assert_eq!(area.abs(), 12.0 - 2.0);
    }
}
