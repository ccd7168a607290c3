//! Glues coarser grids like the finer grid from which they are taken.

use std::collections::HashMap;

use super::super::{Chart, Direction, Surface, SurfaceError};
use super::{Glued, Groups};

impl Surface {
    /// Returns whether the grid of some rows and columns keeps the seams of the surface: points of each seam stay, both
    /// points of a pair stay or neither does, and no seam collapses ([`Self::has_collapsed`]).
    pub(in super::super) fn seams_meet(&self, lines: &[Vec<usize>; 2]) -> bool {
        let Some(glued) = &self.glued else { return true };
        let chart = self.chart();
        let [rows, cols] = [(0, chart.rows), (1, chart.cols)].map(|(axis, points)| {
            let mut stays = vec![false; points];
            lines[axis].iter().for_each(|&line| stays[line] = true);
            stays
        });
        let stays = |index: usize| {
            let (row, col) = chart.position(index);
            rows[row] && cols[col]
        };
        let count = |group: &[u32]| group.iter().filter(|&&index| stays(index as usize)).count();
        let meets = |group: &[u32]| match (count(group), group.len()) {
            (0, _) => group.iter().any(|&index| glued.is_between(chart, index as usize, stays)),
            (1, 2) => false,
            _ => true,
        };
        glued.groups.iter().all(meets) && !self.has_collapsed(glued, lines)
    }

    /// Returns whether two neighbours on the grid of some rows and columns are copies of one point although the point
    /// between them is no copy of it, like the middle of a folded side.
    fn has_collapsed(&self, glued: &Glued, [rows, cols]: &[Vec<usize>; 2]) -> bool {
        let chart = self.chart();
        let group = |row, col| glued.groups.number(chart.index(row, col));
        let is_lost = |a: (usize, usize), b: (usize, usize)| {
            let middle = (a.0.midpoint(b.0), a.1.midpoint(b.1));
            let of_a = group(a.0, a.1);
            of_a.is_some() && of_a == group(b.0, b.1) && of_a != group(middle.0, middle.1)
        };
        let along_rows = || {
            rows.iter()
                .any(|&row| cols.windows(2).any(|pair| is_lost((row, pair[0]), (row, pair[1]))))
        };
        let along_cols = || {
            cols.iter()
                .any(|&col| rows.windows(2).any(|pair| is_lost((pair[0], col), (pair[1], col))))
        };
        along_rows() || along_cols()
    }

    /// Glues this surface as `fine` is glued. This surface consists of the points of `fine` with the indices `kept`.
    pub(in super::super) fn glued_like(
        self,
        fine: &Surface,
        kept: &[usize],
    ) -> Result<Self, SurfaceError> {
        let Some(glued) = &fine.glued else { return Ok(self) };
        let numbers: HashMap<u32, usize> =
            kept.iter().zip(0..).map(|(&index, number)| (index as u32, number)).collect();
        let pairs = glued.groups.iter().flat_map(|group| {
            let left: Vec<usize> =
                group.iter().filter_map(|index| numbers.get(index).copied()).collect();
            left.windows(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>()
        });
        self.glued_by(Groups::of(pairs), glued.lattice)
    }
}

impl Glued {
    /// Returns whether a point has a neighbour, along its row or column, that stays and lies on a seam.
    fn is_between(&self, chart: Chart, index: usize, stays: impl Fn(usize) -> bool) -> bool {
        let (row, col) = chart.position(index);
        let ways = [Direction::North, Direction::South, Direction::East, Direction::West];
        let neighbours = ways.into_iter().filter_map(|to| chart.neighbour(row, col, to));
        neighbours
            .map(|(row, col)| chart.index(row, col))
            .any(|other| stays(other) && self.groups.number(other).is_some())
    }
}
