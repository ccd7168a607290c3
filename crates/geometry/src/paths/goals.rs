//! Stores the sources, where paths end, by grid cell.

use std::collections::HashMap;

use glam::DVec2;

use super::cell::{CellLengths, Weights};
use super::seams::SourcePart;
use geosweep_surface::{Chart, Source, Sources, corner_weights, grid_crossings};

/// The part of a source that lies in one cell: a straight segment or a point.
#[derive(Clone, Debug)]
struct Goal {
    source: usize,
    initial: f64,
    part: SourcePart,
    /// The weights of both ends in the cell.
    weights: [Weights; 2],
}

/// The place of a source in a cell that is nearest to a given place.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearestSource {
    /// The index of the source.
    pub source: usize,
    /// The row and column of the place.
    pub at: DVec2,
    /// The row and column of this place on the source that the caller gave. On a seam of a closed surface,
    /// `at` may be a copy of it.
    pub own: DVec2,
    /// The arrival time at the source, which is its initial value.
    pub time: f64,
    pub distance: f64,
}

/// The sources, indexed by the cells that they touch.
#[derive(Clone, Debug)]
pub(super) struct Goals {
    /// Whether a source touches each cell. Cells are given by their north-western corners in a bordered
    /// array.
    touched: Vec<bool>,
    /// The first and the last cell that a source touches.
    range: [usize; 2],
    by_cell: HashMap<usize, Vec<Goal>>,
}

/// The distance, in cells, up to which a place counts as lying on a grid line.
const ON_LINE: f64 = 1e-9;

impl Goals {
    /// Distributes the sources over the cells. `there` tells which points of the bordered array are points of
    /// the surface. `parts` returns a segment and its copies on a closed surface.
    pub(super) fn new(
        chart: Chart,
        sources: &Sources,
        there: impl Fn(usize) -> bool,
        parts: impl Fn([DVec2; 2]) -> Vec<SourcePart>,
    ) -> Self {
        let mut goals = Self {
            touched: vec![false; chart.bordered_points()],
            range: [usize::MAX, 0],
            by_cell: HashMap::new(),
        };
        for (index, source) in sources.iter().enumerate() {
            let (vertices, initial) = match source {
                Source::Point { at, initial } => (std::slice::from_ref(at), *initial),
                Source::Curve { vertices, initial } => (vertices.as_slice(), *initial),
            };
            let mut add = |own| {
                parts(own).iter().for_each(|part| goals.add(chart, index, initial, part, &there));
            };
            if let [single] = vertices {
                add([*single; 2]);
            }
            for ends in vertices.windows(2) {
                let cuts = grid_crossings(ends[0], ends[1]);
                for cut in cuts.windows(2) {
                    add([ends[0].lerp(ends[1], cut[0]), ends[0].lerp(ends[1], cut[1])]);
                }
            }
        }
        goals
    }

    fn add(
        &mut self,
        chart: Chart,
        source: usize,
        initial: f64,
        &SourcePart { ends, own }: &SourcePart,
        there: impl Fn(usize) -> bool,
    ) {
        let middle = 0.5 * (ends[0] + ends[1]);
        for row in before(middle.x) {
            for col in before(middle.y) {
                let corner = DVec2::new(row, col);
                let north_west = chart.bordered_at(corner);
                let there = chart.bordered_corners(north_west).map(&there);
                let weights = ends.map(|end| corner_weights(there, end - corner));
                let [Some(first), Some(last)] = weights else { continue };
                let goal = Goal {
                    source,
                    initial,
                    part: SourcePart { ends, own },
                    weights: [first, last],
                };
                self.by_cell.entry(north_west).or_default().push(goal);
                self.touched[north_west] = true;
                let [first, last] = self.range;
                self.range = [first.min(north_west), last.max(north_west)];
            }
        }
    }

    /// Returns whether a source touches a cell.
    pub(super) fn touches(&self, north_west: usize) -> bool {
        let [first, last] = self.range;
        (first..=last).contains(&north_west) && self.touched[north_west]
    }

    /// Returns the place of a source in a cell from which the wavefront arrives first at `place`, along a
    /// straight line.
    pub(super) fn nearest(
        &self,
        north_west: usize,
        cell: &CellLengths,
        place: &Weights,
    ) -> Option<NearestSource> {
        if !self.touches(north_west) {
            return None;
        }
        let goals = self.by_cell.get(&north_west)?.iter();
        let nearest = goals.map(|goal| goal.nearest(cell, place));
        nearest.min_by(|a, b| (a.time + a.distance).total_cmp(&(b.time + b.distance)))
    }

    /// Returns the point sources in a cell, at a distance that is not known yet.
    pub(super) fn points(&self, north_west: usize) -> impl Iterator<Item = NearestSource> {
        let goals = self.touches(north_west).then(|| self.by_cell.get(&north_west)).flatten();
        let points =
            goals.into_iter().flatten().filter(|goal| goal.part.ends[0] == goal.part.ends[1]);
        points.map(|&Goal { source, initial, part: SourcePart { ends, own }, .. }| NearestSource {
            source,
            at: ends[0],
            own: own[0],
            time: initial,
            distance: f64::INFINITY,
        })
    }
}

impl Goal {
    fn nearest(&self, cell: &CellLengths, place: &Weights) -> NearestSource {
        let [first, last] = self.weights.map(|end| cell.square(place, &end));
        let along = cell.square(&self.weights[0], &self.weights[1]);
        let foot =
            if along > 0.0 { (0.5 + 0.5 * (first - last) / along).clamp(0.0, 1.0) } else { 0.0 };
        let square = first + foot * (last - first - (1.0 - foot) * along);
        let [a, b] = &self.weights;
        let there = std::array::from_fn(|k| a[k] + foot * (b[k] - a[k]));
        NearestSource {
            source: self.source,
            at: self.part.ends[0].lerp(self.part.ends[1], foot),
            own: self.part.own[0].lerp(self.part.own[1], foot),
            time: self.initial,
            distance: cell.cost(square, place, &there),
        }
    }
}

/// Returns the grid line before a coordinate. For a coordinate on a grid line, returns the starts of both
/// adjoining cells.
fn before(x: f64) -> impl Iterator<Item = f64> {
    let line = x.round();
    let lines = if (x - line).abs() < ON_LINE {
        [Some(line - 1.0), Some(line)]
    } else {
        [Some(x.floor()), None]
    };
    lines.into_iter().flatten()
}
