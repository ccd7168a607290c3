//! Implements rotated raster scans that skip blocks of lines in which nothing can change. The twin of
//! `glsl/passes/blocks.glsl`.

use super::behind;
use crate::Stop;
use crate::constants::SPLIT_REACH;
use crate::cpu::fronts::{PointKind, for_kind};
use crate::cpu::point_fronts::PointFronts;
use crate::cpu::scan::Scan;
use crate::cpu::{Progress, Solution};
use crate::surface::{Chart, EdgeLengths, Real, Seed, Tiling};
use crate::update::Wavefront;

/// The blocks that an iteration has visited. For each of the scans down, up, right and left, it lists the
/// blocks of rows or of columns, starting with the first.
pub type Visits = [Vec<bool>; 4];

/// Solves as [`super::scan_in_turn`] does, bit for bit, in blocks of `lines` lines of texels. A line of
/// texels is a pair of rows or columns. A scan visits a block if a point in it, or on the line of texels
/// behind it, has changed since the scan's last visit. Also returns the blocks that each iteration has
/// visited.
pub fn scan_due<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
    lines: usize,
) -> (Solution<R>, Vec<Visits>) {
    for_kind!(edges, wavefront, kind => {
        solve(PointFronts::start(edges, kind, seeds), seeds, stop, lines)
    })
}

fn solve<R: Real, K: PointKind<R>>(
    mut fronts: PointFronts<R, K>,
    seeds: &[Seed],
    stop: Stop,
    lines: usize,
) -> (Solution<R>, Vec<Visits>) {
    let chart = fronts.edges.chart();
    let behind = behind(chart);
    let mut progress = Progress::new(stop);
    let mut due = Due::new(chart, lines);
    for seed in seeds {
        due.changed((seed.row, seed.col), None);
    }
    let mut visits = Vec::new();
    loop {
        let (mut change, renews) = (R::Bits::default(), progress.renews());
        let mut visited: Visits = due.blocks.each_ref().map(|blocks| vec![false; blocks.len()]);
        for scan in 0..4 {
            let order = Scan::ALL[scan];
            let turned = chart.by(order.lines());
            for block in order.in_order(0..visited[scan].len()) {
                if !std::mem::take(&mut due.blocks[scan][block]) {
                    continue;
                }
                visited[scan][block] = true;
                let of_block = Tiling::new(turned, 2 * lines).rows(block..block + 1);
                for line in order.in_order(of_block) {
                    for along in 0..turned.cols {
                        let (row, col) = order.lines().place(line, along);
                        let point = chart.bordered(row, col);
                        let before = fronts.at(point);
                        let front = fronts.reach(point, &behind[scan]);
                        change = change.max(fronts.accept(point, front, scan as u8 + 1, renews));
                        if fronts.at(point) != before {
                            due.changed((row, col), Some(scan));
                        }
                    }
                }
            }
        }
        visits.push(visited);
        if progress.is_done::<R>(change) {
            return (fronts.finish(progress.iterations, progress.residual), visits);
        }
    }
}

/// The blocks that each scan has to visit.
struct Due {
    /// Number of lines of texels in a block.
    lines: usize,
    blocks: [Vec<bool>; 4],
}

impl Due {
    fn new(chart: Chart, lines: usize) -> Self {
        let tiles = Tiling::new(chart, 2 * lines).tiles();
        Self { lines, blocks: Scan::ALL.map(|scan| vec![false; tiles.by(scan.lines()).rows]) }
    }

    /// Records that a point, given by row and column, has changed. `by` is the scan that changed it, or
    /// `None` before the first iteration. That scan need not visit the block again for it.
    fn changed(&mut self, (row, col): (usize, usize), by: Option<usize>) {
        for (scan, order) in Scan::ALL.into_iter().enumerate() {
            let texel = order.lines().place(row, col).0 / 2;
            let (block, line) = (texel / self.lines, texel % self.lines);
            if by != Some(scan) {
                self.blocks[scan][block] = true;
            }
            // The last lines of the block, in the order of the scan, are seen by the blocks ahead.
            let forward = order.is_forward();
            let after = if forward { self.lines - 1 - line } else { line };
            let reach = (SPLIT_REACH as usize).div_ceil(2);
            for blocks in (1..).take_while(|blocks| after + (blocks - 1) * self.lines < reach) {
                let ahead =
                    if forward { block.checked_add(blocks) } else { block.checked_sub(blocks) };
                if let Some(due) = ahead.and_then(|ahead| self.blocks[scan].get_mut(ahead)) {
                    *due = true;
                }
            }
        }
    }
}
