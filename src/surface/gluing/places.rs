//! Finds the copies of places on seams.

use glam::DVec2;

use super::super::Surface;
use super::lattice::Lattice;
use super::{GluingError, UNGLUED};

/// The distance, in cells, up to which two places of the grid count as one.
const SAME: f64 = 1e-6;

impl Surface {
    /// Returns the places that are the same place of a glued surface, in ascending order of rows and columns,
    /// this one included. A place between two points of a seam has copies between their copies.
    pub(crate) fn copies_of(&self, at: DVec2) -> Vec<DVec2> {
        let mut all = vec![at];
        if !self.is_glued() || !self.chart.holds(at) {
            return all;
        }
        let (low, high) = (at.floor(), at.ceil());
        if low == high {
            all.extend(self.copies_of_point(at));
        } else if (low - high).abs().element_sum() == 1.0 {
            let share = (at - low).element_sum();
            // The middle of a folded side is its own only copy, and an end of edges to both halves.
            let of_end = |end| self.copies_of_point(end).chain([end]).collect::<Vec<_>>();
            let ends = of_end(high);
            for from in of_end(low) {
                let is_other = |to: DVec2| [from, to] != [low, high];
                let is_beside =
                    |to: &&DVec2| (**to - from).abs().element_sum() == 1.0 && is_other(**to);
                all.extend(ends.iter().filter(is_beside).map(|to| from.lerp(*to, share)));
            }
        }
        all.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        all.dedup();
        all
    }

    /// Returns all copies of a grid point, itself included, or none if it has no other.
    fn copies_of_point(&self, at: DVec2) -> impl Iterator<Item = DVec2> {
        let index = self.chart.index(at.x as usize, at.y as usize) as u32;
        let group = self.glued.iter().filter_map(move |glued| {
            let number = *glued.numbers.get(&index)?;
            Some(glued.groups.get(number))
        });
        group.flatten().map(|&index| {
            let (row, col) = self.chart.position(index as usize);
            DVec2::new(row as f64, col as f64)
        })
    }

    /// Returns the grid point at a row and column, which may lie beyond a side where the grid goes on.
    pub(crate) fn continued(&self, row: isize, col: isize) -> Option<(usize, usize)> {
        match &self.glued {
            Some(glued) => glued.lattice.at(self.chart, row, col),
            None => self.chart.at(row, col),
        }
    }

    /// Returns the place of a row and column, fractional, which may lie beyond a side where the grid goes on.
    pub(crate) fn continued_place(&self, at: DVec2) -> Option<DVec2> {
        if self.chart.holds(at) {
            return Some(at);
        }
        let Lattice { cols, rows } = self.glued.as_ref()?.lattice;
        let (last_row, last_col) = self.chart.last();
        let last = DVec2::new(last_row as f64, last_col as f64);
        let mut place = at;
        if let Some(reversed) = cols.filter(|_| !(0.0..=last.y).contains(&at.y)) {
            let row = if reversed { last.x - at.x } else { at.x };
            place = DVec2::new(row, at.y.rem_euclid(last.y));
        }
        if let Some(reversed) = rows.filter(|_| !(0.0..=last.x).contains(&place.x)) {
            let col = if reversed { last.y - place.y } else { place.y };
            place = DVec2::new(place.x.rem_euclid(last.x), col);
        }
        self.chart.holds(place).then_some(place)
    }

    /// Returns a step of rows and columns at `copy` that is the same as `step` at the grid point `from`. Returns
    /// `None` if the grid does not go on from one to the other, as at a pole or a fold.
    pub(crate) fn step_at_copy(
        &self,
        from: (usize, usize),
        copy: (usize, usize),
        step: DVec2,
    ) -> Option<DVec2> {
        let (last, lattice) = (self.chart.last(), self.glued.as_ref()?.lattice);
        let over_cols = |((row, col), step): ((usize, usize), DVec2)| {
            let is_side = col == 0 || col == last.1;
            let reversed = lattice.cols.filter(|_| is_side)?;
            let (row, down) = if reversed { (last.0 - row, -step.x) } else { (row, step.x) };
            Some(((row, last.1 - col), DVec2::new(down, step.y)))
        };
        let over_rows = |((row, col), step): ((usize, usize), DVec2)| {
            let is_side = row == 0 || row == last.0;
            let reversed = lattice.rows.filter(|_| is_side)?;
            let (col, right) = if reversed { (last.1 - col, -step.y) } else { (col, step.y) };
            Some(((last.0 - row, col), DVec2::new(step.x, right)))
        };
        let start = (from, step);
        let ways = [over_cols(start), over_rows(start), over_cols(start).and_then(over_rows)];
        ways.into_iter().flatten().find(|(at, _)| *at == copy).map(|(_, step)| step)
    }

    /// Returns an error if directions cannot be carried from each point to its copies: where the grid does not go
    /// on, positions are needed.
    pub(crate) fn check_directions(&self, what: &'static str) -> Result<(), GluingError> {
        let Some(groups) = self.copies().filter(|_| !self.geometry().is_in_space()) else {
            return Ok(());
        };
        let goes_on = |group: &[u32]| {
            let place = |index: u32| self.chart.position(index as usize);
            let first = place(group[0]);
            group[1..].iter().all(|&copy| self.step_at_copy(first, place(copy), DVec2::X).is_some())
        };
        match groups.iter().all(goes_on) {
            true => Ok(()),
            false => Err(GluingError::Unsupported { what, instead: UNGLUED }),
        }
    }

    /// Returns whether a grid point has copies.
    pub(crate) fn has_copies(&self, (row, col): (usize, usize)) -> bool {
        let index = self.chart.index(row, col) as u32;
        self.glued.as_ref().is_some_and(|glued| glued.numbers.contains_key(&index))
    }

    /// Returns whether two places of the grid are copies of one place of the surface.
    pub(crate) fn are_copies(&self, a: DVec2, b: DVec2) -> bool {
        self.is_glued() && a != b && self.copies_of(a).iter().any(|copy| copy.distance(b) <= SAME)
    }
}
