//! Draws curves on the shaded surface in space.

use std::collections::HashMap;

use geosweep::Surface;
use geosweep::geometry::Curve;
use geosweep::glam::{DVec2, DVec3, Vec2};
use geosweep::io::Orientation;
use geosweep::surface::Chart;

use super::super::canvas::{Canvas, Color};
use super::super::colors::{INK, PAPER, UNREACHED};
use super::super::raster::Paint;
use super::super::scene::{Mesh, Scene, Stroke, View};
use super::super::text::Pen;
use super::CurvePicture;
use super::pose::Pose;

const SHORTEST_SIDE: usize = 240;
/// The smallest number of points along the longer side of a thinned-out mesh: about one per pixel. Grids are thinned
/// out from twice this number of points on.
const FINEST: usize = 1200;

impl CurvePicture<'_> {
    pub(super) fn draw_space(
        &self,
        (toward, orientation): (Option<DVec3>, Orientation),
        long_side: usize,
    ) -> Canvas {
        let pose = Pose::of(self.shape, toward, orientation);
        let mesh = self.mesh(&pose);
        let thickness = (long_side as f32 / 1000.0).max(0.8);
        let view = fitted(&pose, &mesh, long_side);
        let stroke = |(vertices, radius, color): (Vec<[f64; 2]>, f32, Color)| {
            let stroke = move |vertices| Stroke { vertices, radius, color };
            lifted(self.shape, &vertices, &pose).into_iter().map(stroke).collect::<Vec<_>>()
        };
        let strokes: Vec<Stroke> = self.strokes(thickness).flat_map(stroke).collect();
        let mut canvas = Scene { view, mesh: &mesh, strokes: &strokes, background: PAPER }.draw();
        let pixel = |at| {
            let place = lifted(self.shape, &[at], &pose).concat().first().copied()?;
            Some(view.pixel(place).truncate())
        };
        self.write_names(&mut canvas, thickness, pixel);
        if pose.exaggeration > 1.05 {
            let pen = Pen::new(20.0);
            let note = format!("heights × {:.1}", pose.exaggeration);
            pen.write(&mut canvas, 12.0, (view.height - 20) as f32, &note, INK);
        }
        canvas
    }

    /// Returns the mesh of the surface. On large grids it has only every k-th row and column, and the last ones.
    fn mesh(&self, pose: &Pose) -> Mesh {
        let whole = self.surface.chart();
        let every = (whole.rows.max(whole.cols) / FINEST).max(1);
        let lines = |count: usize| (count - 1).div_ceil(every) + 1;
        let chart = Chart { rows: lines(whole.rows), cols: lines(whole.cols) };
        let at = |index| {
            let (row, col) = chart.position(index);
            ((row * every).min(whole.rows - 1), (col * every).min(whole.cols - 1))
        };
        let place = |index| {
            let (row, col) = at(index);
            let position = self.shape.position(row, col).filter(|_| self.surface.has(row, col));
            position.map_or(DVec3::NAN, |position| pose.place(position))
        };
        let color = |index| {
            let (row, col) = at(index);
            let index = whole.index(row, col);
            match self.paint {
                _ if !self.values[index].is_finite() => UNREACHED,
                Paint::Values(scale, _) => scale.color(self.values[index]),
                Paint::Colors(colors) => colors[index],
            }
        };
        let all = 0..chart.points();
        let colors = all.clone().map(color).collect();
        let mut mesh = Mesh::of_grid(chart, all.clone().map(place).collect(), colors);
        if let Some(groups) = self.surface.copies() {
            let vertices: HashMap<_, _> = all.map(|vertex| (at(vertex), vertex)).collect();
            let vertex = |&index: &u32| vertices.get(&whole.position(index as usize)).copied();
            let groups = groups.iter().map(|group| group.iter().filter_map(vertex).collect());
            let groups: Vec<Vec<usize>> = groups.collect();
            mesh.share_normals(groups.iter().map(Vec::as_slice).filter(|group| group.len() > 1));
        }
        mesh
    }
}

/// Returns a camera whose picture has the width and height that the surface needs.
fn fitted(pose: &Pose, mesh: &Mesh, long_side: usize) -> View {
    let fit = |width, height| View::fit(pose.toward, pose.up, mesh.present(), width, height);
    let square = fit(long_side, long_side);
    let (low, high) = mesh
        .present()
        .map(|at| square.pixel(at).truncate())
        .fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    let extent = (high - low).max(Vec2::ONE);
    let part = extent / extent.max_element() * long_side as f32;
    let pixels = |part: f32| (part as usize).clamp(SHORTEST_SIDE, long_side);
    fit(pixels(part.x), pixels(part.y))
}

/// Returns a curve on the surface, in steps of at most half a cell. It is split where a part of it is off the
/// surface.
fn lifted(shape: &Surface, vertices: &[[f64; 2]], pose: &Pose) -> Vec<Vec<DVec3>> {
    let mut fine: Vec<[f64; 2]> = vertices.first().copied().into_iter().collect();
    for ends in vertices.windows(2) {
        let [from, to] = [ends[0], ends[1]].map(DVec2::from);
        let steps = (2.0 * (to - from).abs().max_element()).ceil().max(1.0) as usize;
        let step = |k| from.lerp(to, k as f64 / steps as f64).to_array();
        fine.extend((1..=steps).map(step));
    }
    let lift = |at: &[f64; 2]| {
        let single = Curve { vertices: vec![*at], closed: false };
        single.lift(shape).map_or(DVec3::NAN, |lifted| pose.place(lifted[0]))
    };
    let places: Vec<DVec3> = fine.iter().map(lift).collect();
    let pieces = places.split(|place| !place.is_finite());
    pieces.filter(|piece| !piece.is_empty()).map(<[_]>::to_vec).collect()
}

#[cfg(test)]
mod tests {
    use geosweep::surface::builtin::Closed;
    use geosweep::{Options, Sources, distance_map};

    use super::*;
    use crate::picture::colors::luma;
    use crate::picture::{Look, MapPicture, round_levels, scale_of};

    /// Draws the distances from a source on a surface, with contours, as seen from a side.
    fn drawn(surface: &Surface, source: [f64; 2], toward: DVec3) -> Canvas {
        let sources = Sources::point(source[0], source[1]);
        let map = distance_map(surface, &sources, &Options::default()).unwrap();
        let levels = round_levels(&scale_of(&map, &sources), 10.0);
        let picture = MapPicture {
            surface,
            shape: surface,
            map: &map,
            sources: &sources,
            contours: &geosweep::geometry::contours(&map, &sources, &levels),
            plain: false,
            curves: Default::default(),
            quantity: None,
        };
        picture.draw(Look::Space { toward: Some(toward), orientation: None, long_side: 300 })
    }

    /// The seam of a globe is in front in one picture and behind in the other. Both pictures must look the same.
    #[test]
    fn a_closed_surface_has_no_edge_where_its_grid_begins_and_ends() {
        let globe = Closed::Globe.surface(61, 121).unwrap();
        let [front, back] = [(DVec3::X, 10.0), (-DVec3::X, 70.0)]
            .map(|(toward, col)| drawn(&globe, [20.0, col], toward));
        assert_eq!([front.width, front.height], [back.width, back.height]);
        let pairs = front.pixels.iter().zip(&back.pixels);
        let apart = pairs.map(|(a, b)| (luma(*a) - luma(*b)).abs()).collect::<Vec<_>>();
        let mean = apart.iter().sum::<f32>() / apart.len() as f32;
        let different = apart.iter().filter(|&&apart| apart > 0.05).count();
        assert!(mean < 1e-3 && different < 20, "{mean}, {different} pixels");
    }

    /// The picture of a globe is a disc. The picture of a torus has a hole, in which the background is seen.
    #[test]
    fn closed_surfaces_are_seen_whole_from_outside() {
        let is_paper =
            |canvas: &Canvas, x: usize, y: usize| canvas.pixels[y * canvas.width + x] == PAPER;
        let globe = drawn(&Closed::Globe.surface(61, 121).unwrap(), [20.0, 10.0], DVec3::ONE);
        let (width, height) = (globe.width, globe.height);
        // The mesh is a polyhedron, whose outline is a disc up to two pixels.
        assert!(width.abs_diff(height) <= 2, "{width} x {height}");
        let disc = (0..width * height).filter(|&k| !is_paper(&globe, k % width, k / width));
        // The disc fills the picture up to its margins.
        let share = disc.count() as f64 / (width * height) as f64;
        assert!((share - std::f64::consts::FRAC_PI_4 * 0.92 * 0.92).abs() < 0.02, "{share}");
        let torus = drawn(&Closed::Torus.surface(61, 121).unwrap(), [3.0, 4.0], DVec3::Z);
        assert!(is_paper(&torus, torus.width / 2, torus.height / 2));
        assert!(!is_paper(&torus, torus.width / 2, torus.height / 8));
    }
}
