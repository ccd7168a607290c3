//! Order in which the scans of an iteration visit blocks of lines: in turn or in pairs. The twin of the plans of the
//! raster schedule.

use std::ops::Range;

use crate::fronts::PointKind;
use crate::points::PointFronts;
use crate::scan::Scan;
use geosweep_surface::update::StoredFront;
use geosweep_surface::{Chart, Real, Tiling};

/// Order of the four scans of an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ScanOrder {
    /// One scan after another: down, up, right, left.
    InTurn,
    /// Two opposite scans at the same time, on opposite halves of the grid: down with up, then right with left. Each
    /// pair has two phases. In the first one, both scans come from the ends of the grid to its middle. In the second
    /// one, they continue into the other half. No scan sees the other's changes in the same phase.
    InPairs,
}

/// Blocks of lines that one scan visits in a phase. Other scans of the phase visit other blocks.
#[derive(Clone, Debug)]
pub(super) struct ScanPart {
    pub scan: Scan,
    /// The blocks, counted from the start of the grid.
    pub blocks: Range<usize>,
    /// The rows or columns of points in these blocks.
    lines: Range<usize>,
}

impl ScanOrder {
    /// Returns the phases of an iteration in blocks of `lines` lines of texels, which are pairs of rows or columns. No
    /// part of a phase sees the changes of another part.
    pub(super) fn phases(self, chart: Chart, lines: usize) -> Vec<Vec<ScanPart>> {
        let part = |scan: Scan, half: Option<bool>| {
            let tiling = Tiling::new(chart.by(scan.lines()), 2 * lines);
            let count = tiling.tiles().rows;
            let middle = count.div_ceil(2);
            let blocks = half.map_or(0..count, |last| if last { middle..count } else { 0..middle });
            ScanPart { scan, lines: tiling.rows(blocks.clone()), blocks }
        };
        match self {
            Self::InTurn => Scan::ALL.map(|scan| vec![part(scan, None)]).into(),
            Self::InPairs => [[Scan::DOWN, Scan::UP], [Scan::RIGHT, Scan::LEFT]]
                .into_iter()
                .flat_map(|pair| {
                    [false, true].map(|second| {
                        let halves = [second, !second];
                        let parts = pair.into_iter().zip(halves);
                        parts.map(|(scan, last)| part(scan, Some(last))).collect()
                    })
                })
                .collect(),
        }
    }
}

impl ScanPart {
    /// Returns whether a point, given by its index in a bordered array, lies in the blocks, or on the border
    /// beside them.
    fn has(&self, chart: Chart, point: usize) -> bool {
        let (row, col) = chart.entry(point);
        let (line, _) = self.scan.lines().place(row, col);
        (self.lines.start + 1..self.lines.end + 1).contains(&line)
    }

    /// Returns the front that the scan sees at a point: the present front in the scan's own blocks, and elsewhere the
    /// front from before the phase.
    pub(super) fn sees<R: Real, K: PointKind<R>>(
        &self,
        fronts: &PointFronts<R, K>,
        before: &PointFronts<R, K>,
        point: usize,
    ) -> StoredFront<R, K::Carried> {
        let of = if self.has(fronts.edges.chart(), point) { fronts } else { before };
        of.at(point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thirteen rows are seven lines of texels, which make four blocks of two. Ten columns are five lines of texels,
    /// which make three blocks.
    #[test]
    fn parts_of_a_phase_have_no_block_in_common_and_those_of_an_iteration_have_all() {
        let chart = Chart { rows: 13, cols: 10 };
        for order in [ScanOrder::InTurn, ScanOrder::InPairs] {
            let phases = order.phases(chart, 2);
            assert_eq!(phases.len(), 4, "{order:?}");
            for (index, scan) in Scan::ALL.into_iter().enumerate() {
                let count = if scan.by_rows() { 4 } else { 3 };
                let parts = phases.iter().flatten().filter(|part| part.scan == scan);
                let visited = scan.in_order(0..count);
                let found = parts.flat_map(|part| scan.in_order(part.blocks.clone()));
                assert!(found.eq(visited), "{order:?}, scan {index}");
            }
            for parts in &phases {
                let points = |part: &ScanPart| {
                    (0..chart.bordered_points()).filter(|&x| part.has(chart, x)).collect::<Vec<_>>()
                };
                let all: Vec<_> = parts.iter().flat_map(points).collect();
                assert!(all.iter().all(|x| all.iter().filter(|y| x == *y).count() == 1));
            }
        }
    }
}
