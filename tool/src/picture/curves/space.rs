//! Draws curves on the shaded surface in space.

use geosweep::Surface;
use geosweep::geometry::Curve;
use geosweep::glam::{DVec2, DVec3, Vec2};
use geosweep::surface::Chart;

use super::super::canvas::{Canvas, Color};
use super::super::colors::{INK, PAPER, UNREACHED};
use super::super::raster::Paint;
use super::super::scene::{Mesh, Scene, Stroke, View};
use super::super::text::Pen;
use super::CurvePicture;
use super::pose::Pose;

const SHORTEST_SIDE: usize = 240;
/// The largest number of mesh points per side, which is about one point per pixel.
const FINEST: usize = 1200;

impl CurvePicture<'_> {
    pub(super) fn draw_space(&self, toward: Option<DVec3>, long_side: usize) -> Canvas {
        let pose = Pose::of(self.shape, toward);
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

    /// Returns the mesh of the surface, or of every k-th point of it.
    fn mesh(&self, pose: &Pose) -> Mesh {
        let whole = self.surface.chart();
        let every = (whole.rows.max(whole.cols) / FINEST).max(1);
        let chart = Chart { rows: whole.rows.div_ceil(every), cols: whole.cols.div_ceil(every) };
        let at = |index| {
            let (row, col) = chart.position(index);
            (row * every, col * every)
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
        Mesh::of_grid(chart, all.clone().map(place).collect(), all.map(color).collect())
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
