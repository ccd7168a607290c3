//! Draws canonical forms.

use std::borrow::Cow;

use geosweep::glam::DVec3;
use geosweep::surface::Chart;

use super::canvas::Canvas;
use super::colors::{INK, PAPER, Scale};
use super::scene::{Mesh, Scene, Stroke, View};

/// A grid or a set of points, seen in space.
pub struct FormPicture<'a> {
    /// The positions, NaN where a point is missing.
    pub positions: Cow<'a, [DVec3]>,
    /// The grid of the points, if they form one.
    pub chart: Option<Chart>,
    /// The direction towards the viewer. `up` is the upward direction.
    pub toward: DVec3,
    pub up: DVec3,
    /// The width and height, in pixels.
    pub size: [usize; 2],
}

const SIZE: [usize; 2] = [1200, 900];
/// The approximate number of lines along rows and along columns.
const LINES: usize = 16;
/// Half the width of grid lines, in pixels. `POINT` is the radius of single points.
const LINE: f32 = 0.8;
const POINT: f32 = 4.0;

impl<'a> FormPicture<'a> {
    /// Chooses the view of a form. A grid is shown upright. Other points are shown with the form's widest
    /// axis (x) across the picture, obliquely from above or, if the form is flat, straight on.
    pub fn new(positions: &'a [DVec3], chart: Option<Chart>) -> Self {
        if let Some(picture) = chart.and_then(|chart| Self::upright(positions, chart)) {
            return picture;
        }
        let (toward, up) = match is_flat(positions) {
            true => (DVec3::Z, DVec3::Y),
            false => (DVec3::new(0.35, -1.0, 0.9), DVec3::Z),
        };
        Self { positions: positions.into(), chart, toward, up, size: SIZE }
    }

    /// Returns the view with rows downwards and columns to the right, or `None` if rows and columns have no
    /// overall direction. A form and its mirror image have the same distances; the one that bulges towards
    /// the viewer is shown.
    fn upright(positions: &'a [DVec3], chart: Chart) -> Option<Self> {
        let right = mean_step(positions, chart, [0, 1]);
        let up = -mean_step(positions, chart, [1, 0]);
        let toward = right.cross(up);
        if toward.length() < 0.1 * right.length() * up.length() {
            return None;
        }
        let (toward, up) = (toward.try_normalize()?, up.normalize());
        let tilt = 0.3 * right.normalize() + 0.35 * up;
        let mut picture = Self {
            positions: positions.into(),
            chart: Some(chart),
            toward: if is_flat(positions) { toward } else { toward + tilt },
            up,
            size: SIZE,
        };
        if !bulges(positions, toward) {
            let mirrored = |at: &DVec3| *at - 2.0 * at.dot(toward) * toward;
            picture.positions = positions.iter().map(mirrored).collect();
        }
        Some(picture)
    }

    pub fn draw(&self) -> Canvas {
        let mesh = self.mesh();
        let [width, height] = self.size;
        let view = View::fit(self.toward, self.up, mesh.present(), width, height);
        let strokes = match self.chart {
            Some(chart) => grid_lines(chart, &self.positions),
            None => self.discs(&mesh, &view),
        };
        Scene { view, mesh: &mesh, strokes: &strokes, background: PAPER }.draw()
    }

    /// Returns the mesh, coloured along the grid's columns or along the form's widest axis.
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

    /// Returns points without a surface as discs with dark rims, the farthest first.
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

fn is_flat(positions: &[DVec3]) -> bool {
    positions.iter().all(|at| !at.is_finite() || at.z == 0.0)
}

/// Returns the mean vector from a point to the point `down` rows and `right` columns further on.
fn mean_step(positions: &[DVec3], chart: Chart, [down, right]: [usize; 2]) -> DVec3 {
    let step = |index: usize| {
        let (row, col) = chart.position(index);
        let there = (row + down < chart.rows && col + right < chart.cols)
            .then(|| positions[chart.index(row + down, col + right)])?;
        let step = there - positions[index];
        step.is_finite().then_some(step)
    };
    let (sum, count) = (0..chart.points())
        .filter_map(step)
        .fold((DVec3::ZERO, 0u32), |(sum, count), step| (sum + step, count + 1));
    sum / f64::from(count.max(1))
}

/// Returns whether points near the middle are, overall, nearer to the viewer.
fn bulges(positions: &[DVec3], toward: DVec3) -> bool {
    let present = || positions.iter().filter(|at| at.is_finite());
    let count = present().count().max(1) as f64;
    let middle = present().sum::<DVec3>() / count;
    let aside = |at: &DVec3| (at - middle).reject_from_normalized(toward).length_squared();
    let mean = present().map(aside).sum::<f64>() / count;
    let slope = |at: &DVec3| (at - middle).dot(toward) * (aside(at) - mean);
    present().map(slope).sum::<f64>() <= 0.0
}

/// Returns some rows and columns of the grid, including the outermost. They are split where points are
/// missing.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a shell over a grid, placed in space by `pose`.
    fn shell(chart: Chart, pose: impl Fn(DVec3) -> DVec3) -> Vec<DVec3> {
        let place = |index| {
            let (row, col) = chart.position(index);
            let (x, y) = (col as f64 - 4.0, row as f64 - 6.0);
            pose(DVec3::new(x, y, -0.05 * (x * x + y * y)))
        };
        (0..chart.points()).map(place).collect()
    }

    #[test]
    fn a_form_is_seen_upright_whatever_its_pose() {
        let chart = Chart { rows: 13, cols: 9 };
        let turned = geosweep::glam::DQuat::from_rotation_arc(
            DVec3::Z,
            DVec3::new(0.4, -0.7, 0.2).normalize(),
        );
        for mirror in [1.0, -1.0] {
            let positions = shell(chart, |at| turned * DVec3::new(mirror * at.x, at.y, at.z));
            let picture = FormPicture::new(&positions, Some(chart));
            let view =
                View::fit(picture.toward, picture.up, picture.positions.iter().copied(), 400, 300);
            let pixel = |row, col| view.pixel(picture.positions[chart.index(row, col)]);
            let (middle, below, right) = (pixel(6, 4), pixel(12, 4), pixel(6, 8));
            assert!(below.y > middle.y + 50.0 && right.x > middle.x + 50.0, "{mirror}");
            // The view is oblique, so the rim lies behind the middle on average.
            let corners = [pixel(0, 0), pixel(0, 8), pixel(12, 0), pixel(12, 8)];
            let rim = corners.iter().map(|corner| corner.z).sum::<f32>() / 4.0;
            assert!(rim < middle.z - 20.0, "{mirror}: {corners:?}, {middle}");
        }
    }
}
