//! Draws surfaces in space: shaded triangles with curves and marks on them.
//!
//! Drawing is done in software. Triangles go through a depth buffer with sixteen samples per pixel, in bands
//! of rows in parallel. Strokes have a fixed width in the picture, and are hidden by what lies in front of
//! them.

mod band;
mod light;
mod mesh;
mod view;

use geosweep::glam::DVec3;
use rayon::prelude::*;

use super::canvas::{Canvas, Color};
use band::Band;
pub use mesh::{Mesh, grid_triangles};
pub use view::View;

/// A mesh and the strokes on it.
pub struct Scene<'a> {
    pub view: View,
    pub mesh: &'a Mesh,
    /// The strokes in the order of drawing. Later ones are drawn over earlier ones.
    pub strokes: &'a [Stroke],
    pub background: Color,
}

/// A polyline on or near the surface, with round ends and joints. With a single vertex it is a disc.
pub struct Stroke {
    pub vertices: Vec<DVec3>,
    /// Half the width, in pixels.
    pub radius: f32,
    pub color: Color,
}

/// The number of rows of pixels in a band.
const BAND: usize = 16;

impl Scene<'_> {
    pub fn draw(&self) -> Canvas {
        let View { width, height, .. } = self.view;
        let mut canvas = Canvas::new(width, height, self.background);
        let seen = self.mesh.seen(&self.view);
        let paths: Vec<Vec<_>> = self
            .strokes
            .iter()
            .map(|stroke| stroke.vertices.iter().map(|&at| self.view.pixel(at)).collect())
            .collect();
        let triangles = self.bins(seen.triangles.iter().map(|corners| {
            let ys = corners.map(|corner| seen.places[corner as usize].y);
            (ys.into_iter().fold(f32::INFINITY, f32::min), ys.into_iter().fold(0.0, f32::max))
        }));
        canvas.pixels.par_chunks_mut(BAND * width).zip(triangles).enumerate().for_each(
            |(index, (pixels, triangles))| {
                let mut band = Band::new(index * BAND, width, pixels.len() / width);
                for triangle in triangles {
                    band.cover(&seen, triangle);
                }
                band.shade(&seen, self.background);
                for (stroke, path) in self.strokes.iter().zip(&paths) {
                    band.stroke(path, stroke.radius, stroke.color);
                }
                band.resolve(pixels);
            },
        );
        canvas
    }

    /// Returns the items that reach into each band. `extents` are the first and last rows of the items.
    fn bins(&self, extents: impl Iterator<Item = (f32, f32)>) -> Vec<Vec<usize>> {
        let count = self.view.height.div_ceil(BAND);
        let mut bins = vec![Vec::new(); count];
        // Pixels extend half a row beyond their centres.
        let band = |row: f32| ((row + 0.5) / BAND as f32).floor().max(0.0) as usize;
        for (index, (top, bottom)) in extents.enumerate() {
            if bottom >= -0.5 {
                let last = band(bottom).min(count - 1);
                bins.iter_mut().take(last + 1).skip(band(top)).for_each(|bin| bin.push(index));
            }
        }
        bins
    }
}

#[cfg(test)]
mod tests {
    use geosweep::glam::{DVec2, Vec3};

    use super::*;

    const WHITE: Color = [1.0; 3];
    const RED: Color = [1.0, 0.0, 0.0];
    const BLUE: Color = [0.0, 0.0, 1.0];

    /// Returns level squares with the z axis towards the viewer, each with its middle, half side and colour.
    fn squares(squares: &[(DVec3, f64, Color)]) -> Mesh {
        let corners =
            [DVec2::new(-1.0, -1.0), DVec2::new(1.0, -1.0), DVec2::ONE, DVec2::new(-1.0, 1.0)];
        let (mut positions, mut colors, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        for &(middle, half, color) in squares {
            let first = positions.len() as u32;
            positions.extend(corners.map(|corner| middle + half * corner.extend(0.0)));
            colors.extend([color; 4]);
            triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
        Mesh::new(positions, colors, triangles)
    }

    fn draw(mesh: &Mesh, strokes: &[Stroke]) -> Canvas {
        let view = View::fit(DVec3::Z, DVec3::Y, mesh.present(), 50, 50);
        Scene { view, mesh, strokes, background: WHITE }.draw()
    }

    fn pixel(canvas: &Canvas, x: usize, y: usize) -> Color {
        canvas.pixels[y * canvas.width + x]
    }

    #[test]
    fn the_nearer_hides_the_farther_in_any_order() {
        let near = (DVec3::new(0.0, 0.0, 0.5), 1.0, RED);
        let far = (DVec3::ZERO, 2.0, BLUE);
        for order in [[near, far], [far, near]] {
            let canvas = draw(&squares(&order), &[]);
            let (middle, side) = (pixel(&canvas, 25, 25), pixel(&canvas, 6, 25));
            assert!(middle[0] > middle[2] && side[2] > side[0], "{middle:?} {side:?}");
            assert_eq!(pixel(&canvas, 0, 0), WHITE);
            // There is no gap across bands, nor along the diagonal that two triangles share.
            let inside = (18..32).flat_map(|y| (18..32).map(move |x| (x, y)));
            for (x, y) in inside {
                // Weights sum to one, apart from rounding errors.
                let difference = std::array::from_fn(|k| pixel(&canvas, x, y)[k] - middle[k]);
                assert!(Vec3::from(difference).length() < 1e-5, "{x} {y}");
            }
        }
    }

    #[test]
    fn strokes_lie_on_the_surface_and_behind_what_is_before_it() {
        let mesh = squares(&[(DVec3::ZERO, 2.0, BLUE), (DVec3::new(1.0, 0.0, 0.5), 1.0, BLUE)]);
        let vertices = vec![DVec3::new(-1.8, 0.0, 0.0), DVec3::new(1.8, 0.0, 0.0)];
        let stroke = Stroke { vertices, radius: 2.0, color: RED };
        let canvas = draw(&mesh, &[stroke]);
        let (seen, hidden) = (pixel(&canvas, 12, 25), pixel(&canvas, 37, 25));
        assert_eq!(seen, RED);
        assert!(hidden[2] > hidden[0], "{hidden:?}");
        // The line has the requested width: two pixels on each side of the line between the middle rows.
        let width =
            (0..50).filter(|&y| pixel(&canvas, 12, y)[0] > 0.9 && pixel(&canvas, 12, y) != WHITE);
        assert_eq!(width.count(), 4);
    }
}
