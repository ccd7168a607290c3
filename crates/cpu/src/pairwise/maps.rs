//! Maps of a batch, and their initial distances.

use std::sync::Arc;

use super::farther::Farther;
use super::kernel::Lanes;
use super::marks::Marks;
use super::outward::Outward;
use super::pending::Pending;
use super::stage::Stage;
use geosweep_surface::{Chart, Lines, Real};

/// The maps of a batch: bordered arrays of points. Each lane of a point belongs to one of the maps. Between
/// two batches no point is reached.
pub(super) struct Maps {
    pub points: Vec<Lanes>,
    pub pending: Pending,
    /// The lines to which the first iteration is restricted; `None` afterwards.
    pub outward: Option<Outward>,
    /// Points of a line that change through parts of obtuse triangles, for the scans by rows and by columns.
    pub changed: [Marks; 2],
    pub stage: Stage,
}

/// Known distances of a batch: the rows of the distance matrix above the batch's own rows, possibly no rows.
#[derive(Clone, Copy)]
pub(super) struct Known<'a> {
    /// Rows of the matrix, one after another.
    pub rows: &'a [f32],
    /// Number of rows whose distances are reused (eq. 20). They give the distances from the batch's sources at the
    /// first `count` points, in row-major order.
    pub count: usize,
    /// The first source of the batch.
    pub column: usize,
}

impl Known<'_> {
    pub(super) const NOTHING: Self = Self { rows: &[], count: 0, column: 0 };
}

impl Maps {
    pub(super) fn new(chart: Chart, farther: Arc<Farther>) -> Self {
        Self {
            points: vec![Lanes::UNREACHED; chart.bordered_points()],
            pending: Pending::new(chart, farther),
            outward: None,
            changed: [Lines::Rows, Lines::Cols].map(|lines| Marks::none(line_of(chart.by(lines)))),
            stage: Stage::new(chart),
        }
    }

    pub(super) fn bytes(chart: Chart) -> usize {
        let points = chart.bordered_points() * size_of::<Lanes>();
        let lines = [chart, chart.transposed()].map(|lines| Marks::bytes(line_of(lines)));
        points + Pending::bytes(chart) + lines.iter().sum::<usize>() + Stage::bytes(chart)
    }

    /// Sets the distances at the sources and the known distances.
    pub(super) fn start(&mut self, chart: Chart, sources: &[Option<usize>], known: Known) {
        self.pending.start(known.count);
        self.outward = Outward::new(chart, sources);
        for (point, row) in known.rows.chunks_exact(chart.points()).enumerate() {
            let times = &mut self.points[chart.bordered_point(point)].0;
            let found = &row[known.column..][..sources.len()];
            for (time, distance) in times.iter_mut().zip(found) {
                *time = distance.min(f32::FAR);
            }
        }
        for (lane, source) in sources.iter().enumerate() {
            let Some((row, col)) = source.map(|point| chart.position(point)) else { continue };
            self.points[chart.bordered(row, col)].0[lane] = 0.0;
            self.pending.touch(row, col);
        }
    }
}

/// Returns a chart with one line of `lines`, a chart whose rows are the lines.
fn line_of(lines: Chart) -> Chart {
    Chart { rows: 1, ..lines }
}
