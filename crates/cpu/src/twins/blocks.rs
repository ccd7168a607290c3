//! Implements rotated raster scans in blocks of lines, in turn or in pairs, that skip blocks in which nothing
//! can change. The twin of `glsl/passes/blocks.glsl`.

use super::behind;
use super::phases::{ScanOrder, ScanPart};
use crate::fronts::{PointKind, for_kind};
use crate::points::PointFronts;
use crate::scan::Scan;
use crate::{Progress, Solution};
use geosweep_surface::Stop;
use geosweep_surface::constants::SPLIT_REACH;
use geosweep_surface::update::Wavefront;
use geosweep_surface::{Chart, EdgeLengths, Real, Seed, Tiling};

/// Flags of the blocks that an iteration has visited: for each of the scans down, up, right and left, one flag per
/// block of rows or columns, in ascending order.
pub type Visits = [Vec<bool>; 4];

/// Solves as [`super::scan_in_turn`] or [`super::scan_in_pairs`] does, bit for bit, in blocks of `lines`
/// lines of texels. A line of texels is a pair of rows or columns. A scan visits a block if a point in it, or
/// on the line of texels behind it, has changed since the scan's last visit. Fronts that come after the radius
/// change nothing. Also returns the blocks that each iteration has visited.
pub fn scan_due<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
    (order, lines): (ScanOrder, usize),
    radius: f64,
) -> (Solution<R>, Vec<Visits>) {
    for_kind!(edges, wavefront, kind => {
        let mut visits = Vec::new();
        let fronts = PointFronts::start_within(edges, kind, seeds, radius);
        let solution = solve(fronts, seeds, stop, (order, lines), Some(&mut visits));
        (solution, visits)
    })
}

/// Solves by scans in pairs ([`ScanOrder::InPairs`]), whose halves meet between blocks of `lines` lines of
/// texels. Each iteration equals that of the shader.
pub fn scan_in_pairs<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
    lines: usize,
) -> Solution<R> {
    for_kind!(edges, wavefront, kind => {
        let fronts = PointFronts::start(edges, kind, seeds);
        solve(fronts, seeds, stop, (ScanOrder::InPairs, lines), None)
    })
}

/// Solves from the fronts at seeds. If `visits` is given, visits only the blocks that are due.
fn solve<R: Real, K: PointKind<R>>(
    mut fronts: PointFronts<R, K>,
    seeds: &[Seed],
    stop: Stop,
    (order, lines): (ScanOrder, usize),
    mut visits: Option<&mut Vec<Visits>>,
) -> Solution<R> {
    let chart = fronts.edges.chart();
    let behind = behind(chart);
    let mut progress = Progress::new(stop);
    let mut due = Due::new(chart, lines, fronts.edges.reach());
    for seed in seeds {
        due.changed((seed.row, seed.col), None);
    }
    fronts.exchange(false, |place, _| due.changed(place, None));
    let phases = order.phases(chart, lines);
    loop {
        let (mut change, renews) = (R::Bits::default(), progress.renews());
        let mut visited: Visits = due.blocks.each_ref().map(|blocks| vec![false; blocks.len()]);
        for parts in &phases {
            let before = fronts.clone();
            for part in parts {
                let (scan, order) = (usize::from(part.scan.0) - 1, part.scan);
                let turned = chart.by(order.lines());
                for block in order.in_order(part.blocks.clone()) {
                    let is_due = std::mem::take(&mut due.blocks[scan][block]);
                    if visits.is_some() && !is_due {
                        continue;
                    }
                    visited[scan][block] = true;
                    let of_block = Tiling::new(turned, 2 * lines).rows(block..block + 1);
                    for line in order.in_order(of_block) {
                        for along in 0..turned.cols {
                            let (row, col) = order.lines().place(line, along);
                            let point = chart.bordered(row, col);
                            let own = fronts.at(point);
                            let seen = |x| part.sees(&fronts, &before, x);
                            let front = fronts.reach_seen(point, &behind[scan], seen);
                            change = change.max(fronts.accept(point, front, order.0, renews));
                            let now = fronts.at(point);
                            if now != own && now.time.min(own.time) <= fronts.limit() {
                                due.changed((row, col), Some(part));
                            }
                        }
                    }
                }
            }
            due.end_phase();
            change = change.max(fronts.exchange(renews, |place, _| due.changed(place, None)));
        }
        if let Some(visits) = &mut visits {
            visits.push(visited);
        }
        let is_done = progress.is_done::<R>(change);
        if is_done && (progress.is_last() || visits.is_some() || !fronts.restore(seeds)) {
            return fronts.finish(progress.iterations, progress.residual);
        }
    }
}

/// The blocks that each scan has to visit.
struct Due {
    /// Number of lines of texels in a block.
    lines: usize,
    /// Number of lines of texels behind a point that updates read.
    reach: usize,
    blocks: [Vec<bool>; 4],
    /// Blocks that see a line which the opposite scan has changed in the same phase. They become due at the end of the
    /// phase.
    after: Vec<(usize, usize)>,
}

impl Due {
    fn new(chart: Chart, lines: usize, reach: usize) -> Self {
        let tiles = Tiling::new(chart, 2 * lines).tiles();
        let blocks = Scan::ALL.map(|scan| vec![false; tiles.by(scan.lines()).rows]);
        let reach = reach.max(SPLIT_REACH as usize).div_ceil(2);
        Self { lines, reach, blocks, after: Vec::new() }
    }

    /// Marks the blocks in `after` as due, at the end of a phase.
    fn end_phase(&mut self) {
        for (scan, block) in self.after.drain(..) {
            self.blocks[scan][block] = true;
        }
    }

    /// Records that a point, given by row and column, has changed. `by` is the part that changed it, or `None` for
    /// a seed or an exchange between copies. The scan that changed the point need not visit the point's block again
    /// because of this change.
    fn changed(&mut self, (row, col): (usize, usize), by: Option<&ScanPart>) {
        for (scan, order) in Scan::ALL.into_iter().enumerate() {
            let texel = order.lines().place(row, col).0 / 2;
            let (block, line) = (texel / self.lines, texel % self.lines);
            if by.is_none_or(|part| part.scan != order) {
                self.blocks[scan][block] = true;
            }
            // In this phase the opposite scan visits blocks outside this part, and does not see what the part changes.
            // Such blocks become due after the phase.
            let is_across = |ahead: usize| {
                by.is_some_and(|part| part.scan.is_opposite(order) && !part.blocks.contains(&ahead))
            };
            // The last lines of the block, in the order of the scan, are seen by the blocks ahead.
            let forward = order.is_forward();
            let after = if forward { self.lines - 1 - line } else { line };
            let seen = |blocks: &usize| after + (blocks - 1) * self.lines < self.reach;
            for blocks in (1..).take_while(seen) {
                let ahead =
                    if forward { block.checked_add(blocks) } else { block.checked_sub(blocks) };
                let Some(ahead) = ahead.filter(|&ahead| ahead < self.blocks[scan].len()) else {
                    break;
                };
                if is_across(ahead) {
                    self.after.push((scan, ahead));
                } else {
                    self.blocks[scan][ahead] = true;
                }
            }
        }
    }
}
