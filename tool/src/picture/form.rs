//! Pictures of canonical forms.

use geosweep::glam::DVec3;
use geosweep::surface::Chart;

use super::canvas::Canvas;
use super::colors::{INK, PAPER, Scale};
use super::scene::{Mesh, Scene, Stroke, View};

/// A grid or single points, seen in space.
pub struct FormPicture<'a> {
    /// NaN where a point is missing.
    pub positions: &'a [DVec3],
    /// The grid that the points are of, if they are.
    pub chart: Option<Chart>,
    /// The direction towards the viewer, and what is upwards.
    pub toward: DVec3,
    pub up: DVec3,
    /// Width and height, in pixels.
    pub size: [usize; 2],
}

const SIZE: [usize; 2] = [1200, 900];
/// Lines along rows and along columns, about.
const LINES: usize = 16;
/// Half the width of the grid's lines, and of single points, in pixels.
const LINE: f32 = 0.8;
const POINT: f32 = 4.0;

impl<'a> FormPicture<'a> {
    /// A form along its principal axes: from above its widest one, or as flat as it is.
    pub fn new(positions: &'a [DVec3], chart: Option<Chart>) -> Self {
        let flat = positions.iter().all(|at| !at.is_finite() || at.z == 0.0);
        let (toward, up) = match flat {
            true => (DVec3::Z, DVec3::Y),
            false => (DVec3::new(0.35, -1.0, 0.9), DVec3::Z),
        };
        Self { positions, chart, toward, up, size: SIZE }
    }

    pub fn draw(&self) -> Canvas {
        let mesh = self.mesh();
        let [width, height] = self.size;
        let view = View::fit(self.toward, self.up, mesh.present(), width, height);
        let strokes = match self.chart {
            Some(chart) => grid_lines(chart, self.positions),
            None => self.discs(&mesh, &view),
        };
        Scene { view, mesh: &mesh, strokes: &strokes, background: PAPER }.draw()
    }

    /// Coloured along the grid's columns, or along the form's widest axis.
    fn mesh(&self) -> Mesh {
        let along = |(index, at): (usize, &DVec3)| match self.chart {
            Some(chart) => chart.position(index).1 as f32,
            None => at.x as f32,
        };
        let values: Vec<f32> = self.positions.iter().enumerate().map(along).collect();
        let scale = Scale::over(values.iter().copied().filter(|value| value.is_finite()));
        let color = |&value: &f32| if value.is_finite() { scale.color(value) } else { PAPER };
        let colors = values.iter().map(color).collect();
        let positions = self.positions.to_vec();
        match self.chart {
            Some(chart) => Mesh::of_grid(chart, positions, colors),
            None => Mesh::new(positions, colors, Vec::new()),
        }
    }

    /// Points without a surface, the farthest first, each with a dark rim.
    fn discs(&self, mesh: &Mesh, view: &View) -> Vec<Stroke> {
        let mut order: Vec<usize> =
            (0..self.positions.len()).filter(|&index| self.positions[index].is_finite()).collect();
        let depth = |index: usize| view.pixel(self.positions[index]).z;
        order.sort_by(|&a, &b| depth(a).total_cmp(&depth(b)));
        let disc = |index: usize, radius, color| Stroke {
            vertices: vec![self.positions[index]],
            radius,
            color,
        };
        let pair =
            |index: usize| [disc(index, POINT + 1.0, INK), disc(index, POINT, mesh.colors[index])];
        order.into_iter().flat_map(pair).collect()
    }
}

/// Some rows and columns of the grid, the outermost among them, as far as no point is missing.
fn grid_lines(chart: Chart, positions: &[DVec3]) -> Vec<Stroke> {
    let some = |count: usize| {
        let step = (count / LINES).max(1);
        (0..count).filter(move |&k| k % step == 0 || k + 1 == count)
    };
    let row = |row| (0..chart.cols).map(move |col| chart.index(row, col)).collect();
    let col = |col| (0..chart.rows).map(move |row| chart.index(row, col)).collect();
    let lines: Vec<Vec<usize>> =
        some(chart.rows).map(row).chain(some(chart.cols).map(col)).collect();
    let pieces = |line: Vec<usize>| {
        let line: Vec<DVec3> = line.into_iter().map(|index| positions[index]).collect();
        let pieces = line.split(|at| !at.is_finite());
        pieces.filter(|piece| piece.len() > 1).map(<[_]>::to_vec).collect::<Vec<_>>()
    };
    let stroke = |vertices| Stroke { vertices, radius: LINE, color: INK };
    lines.into_iter().flat_map(pieces).map(stroke).collect()
}
