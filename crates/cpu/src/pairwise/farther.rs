//! Finds the points that changes of distant points affect: points with obtuse triangles, whose parts reach beyond the
//! three neighbours on the line behind.

use super::marks::WORD;
use crate::scan::Scan;
use geosweep_surface::{EdgeLengths, Lines};

/// Points whose changes affect distant points, which are not beside them on the next line. All other changes are
/// propagated without this table.
#[derive(Clone, Debug, Default)]
pub(super) struct Farther {
    /// The affected points, by rows and by columns.
    kinds: [Concerns; 2],
}

#[derive(Clone, Debug, Default)]
struct Concerns {
    /// Start of each line's entries; empty if there are no entries.
    starts: Vec<u32>,
    concerns: Vec<Concern>,
}

/// A point of a line whose change affects another point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Concern {
    changed: u32,
    scan: u8,
    pub line: u32,
    pub point: u32,
}

impl Concern {
    pub(super) fn scan(&self) -> Scan {
        Scan(self.scan)
    }
}

impl Farther {
    /// Finds the affected points of a surface whose parts of obtuse triangles are stored.
    pub(super) fn new(edges: &EdgeLengths<f32>) -> Self {
        Self { kinds: [Lines::Rows, Lines::Cols].map(|lines| Concerns::of(edges, lines)) }
    }

    pub(super) fn bytes(&self) -> usize {
        let bytes = |of: &Concerns| {
            of.starts.len() * size_of::<u32>() + of.concerns.len() * size_of::<Concern>()
        };
        self.kinds.iter().map(bytes).sum()
    }

    /// Returns the points that the changed points of a line affect. The changed points are given as marks.
    pub(super) fn of(
        &self,
        lines: Lines,
        line: usize,
        changed: &[u64],
    ) -> impl Iterator<Item = Concern> {
        let Concerns { starts, concerns } = &self.kinds[lines as usize];
        let of_line = match starts.get(line..line + 2) {
            Some(&[start, end]) => &concerns[start as usize..end as usize],
            _ => &[],
        };
        let has_changed = |at: usize| changed[at / WORD] >> (at % WORD) & 1 != 0;
        of_line.iter().copied().filter(move |concern| has_changed(concern.changed as usize))
    }
}

impl Concerns {
    fn of(edges: &EdgeLengths<f32>, lines: Lines) -> Self {
        let chart = edges.chart();
        let turned = chart.by(lines);
        let mut found = Vec::new();
        for scan in Scan::ALL.into_iter().filter(|scan| scan.lines() == lines) {
            let Some(parts) = edges.parts_on_side(scan.back()) else { continue };
            for line in 0..turned.rows {
                for (place, parts) in parts.within(line + 1, 1..turned.cols + 1).parts() {
                    let point = place - 1;
                    for corner in parts.flat_map(|part| part.corners) {
                        let (row, col) = chart.bordered_position(corner);
                        let (of_corner, changed) = lines.place(row, col);
                        let behind = match scan.is_forward() {
                            true => of_corner + 1 == line,
                            false => of_corner == line + 1,
                        };
                        if !(behind && changed.abs_diff(point) <= 1) {
                            let (changed, line, point) =
                                (changed as u32, line as u32, point as u32);
                            found.push((of_corner, Concern { changed, scan: scan.0, line, point }));
                        }
                    }
                }
            }
        }
        if found.is_empty() {
            return Self::default();
        }
        found.sort_unstable();
        found.dedup();
        let before = |line: usize| found.partition_point(|&(of, _)| of < line) as u32;
        let starts = (0..=turned.rows).map(before).collect();
        Self { starts, concerns: found.into_iter().map(|(_, concern)| concern).collect() }
    }
}
