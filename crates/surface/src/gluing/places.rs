//! Finds the copies of places on seams.

use glam::DVec2;

use super::super::Surface;
use super::lattice::Lattice;
use super::{Gluing, GluingError, UNGLUED};

/// The distance, in cells, up to which two places of the grid count as one.
const SAME: f64 = 1e-6;

impl Surface {
    /// Returns the steps of the chart after which the surface repeats, which are none on an open surface. The result is
    /// `None` if it has seams that are no such steps.
    #[doc(hidden)]
    pub fn periods(&self) -> Option<Vec<DVec2>> {
        let Some(glued) = &self.glued else { return Some(Vec::new()) };
        let gluing = match (glued.lattice.cols, glued.lattice.rows) {
            (Some(false), None) => Gluing::columns(),
            (None, Some(false)) => Gluing::rows(),
            (Some(false), Some(false)) => Gluing::both(),
            _ => return None,
        };
        let (last_row, last_col) = self.chart.last();
        let along_rows = glued.lattice.cols.map(|_| DVec2::new(0.0, last_col as f64));
        let along_cols = glued.lattice.rows.map(|_| DVec2::new(last_row as f64, 0.0));
        self.is_glued_by(&gluing).then(|| along_rows.into_iter().chain(along_cols).collect())
    }

    /// Returns all copies of a place of a glued surface, the place itself included, in ascending order of rows and
    /// columns. A place between two neighbouring points of a seam has its copies between copies of these points.
    #[doc(hidden)]
    pub fn copies_of(&self, at: DVec2) -> Vec<DVec2> {
        let mut all = vec![at];
        if !self.is_glued() || !self.chart.holds(at) {
            return all;
        }
        let (low, high) = (at.floor(), at.ceil());
        if low == high {
            all.extend(self.copies_of_point(at));
        } else if (low - high).abs().element_sum() == 1.0 {
            let share = (at - low).element_sum();
            // The middle of a folded side has no copy but itself, and edges of both halves end there.
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

    /// Returns all copies of a grid point, the point itself included. The result is empty if it has no other copy.
    fn copies_of_point(&self, at: DVec2) -> impl Iterator<Item = DVec2> {
        let index = self.chart.index(at.x as usize, at.y as usize);
        let group = self.copies().and_then(|groups| groups.around(index));
        group.into_iter().flatten().map(|&index| {
            let (row, col) = self.chart.position(index as usize);
            DVec2::new(row as f64, col as f64)
        })
    }

    /// Returns the grid point at a row and column, which may lie beyond a side where the grid goes on.
    #[doc(hidden)]
    pub fn continued(&self, row: isize, col: isize) -> Option<(usize, usize)> {
        match &self.glued {
            Some(glued) => glued.lattice.at(self.chart, row, col),
            None => self.chart.at(row, col),
        }
    }

    /// Returns the place on the grid of a fractional row and column, which may lie beyond a side where the grid goes
    /// on.
    #[doc(hidden)]
    pub fn continued_place(&self, at: DVec2) -> Option<DVec2> {
        if self.chart.holds(at) {
            return Some(at);
        }
        let Lattice { cols, rows, .. } = self.glued.as_ref()?.lattice;
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
    #[doc(hidden)]
    pub fn step_at_copy(
        &self,
        from: (usize, usize),
        copy: (usize, usize),
        step: DVec2,
    ) -> Option<DVec2> {
        let [from, copy] = [from, copy].map(|(row, col)| DVec2::new(row as f64, col as f64));
        self.turn_at_copy(from, copy).map(|turn| turn * step)
    }

    /// Returns the factors for rows and columns, 1 or -1, that convert a step at a place to the same step at its copy.
    /// Returns `None` if the grid does not go on from one to the other.
    #[doc(hidden)]
    pub fn turn_at_copy(&self, from: DVec2, copy: DVec2) -> Option<DVec2> {
        let mut images = self.turned_images(from, SAME).into_iter();
        images.find(|(at, _)| at.distance(copy) <= SAME).map(|(_, turn)| turn)
    }

    /// Returns an error if directions cannot be converted from each point to its copies. Where the grid does not go on
    /// over the seam, this needs positions.
    #[doc(hidden)]
    pub fn check_directions(&self, what: &'static str) -> Result<(), GluingError> {
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

    /// Returns whether a grid point has copies to which the grid does not go on, as at a pole or a fold.
    #[doc(hidden)]
    pub fn is_broken(&self, (row, col): (usize, usize)) -> bool {
        let at = DVec2::new(row as f64, col as f64);
        self.copies_of_point(at).any(|copy| copy != at && self.turn_at_copy(at, copy).is_none())
    }

    /// Returns the first of the copies of a grid point, the point itself included.
    #[doc(hidden)]
    pub fn first_copy(&self, (row, col): (usize, usize)) -> (usize, usize) {
        let group = self.copies().and_then(|groups| groups.around(self.chart.index(row, col)));
        group.map_or((row, col), |group| self.chart.position(group[0] as usize))
    }

    /// Returns the images of a place over the sides where the grid goes on, at most `reach` rows and columns beyond
    /// these sides.
    #[doc(hidden)]
    pub fn images_beyond(&self, at: DVec2, reach: f64) -> Vec<DVec2> {
        self.turned_images(at, reach).into_iter().map(|(image, _)| image).collect()
    }

    /// Returns the places of [`Self::images_beyond`], each with the factors for rows and columns, 1 or -1, that convert
    /// a step at the place to the same step at the image.
    #[doc(hidden)]
    pub fn turned_images(&self, at: DVec2, reach: f64) -> Vec<(DVec2, DVec2)> {
        let Some(Lattice { cols, rows, .. }) = self.glued.as_ref().map(|glued| glued.lattice)
        else {
            return Vec::new();
        };
        let (last_row, last_col) = self.chart.last();
        let last = DVec2::new(last_row as f64, last_col as f64);
        let over_cols = |(at, turn): (DVec2, DVec2), by: f64| match cols {
            _ if by == 0.0 => (at, turn),
            Some(true) => {
                (DVec2::new(last.x - at.x, at.y + by * last.y), DVec2::new(-turn.x, turn.y))
            }
            _ => (DVec2::new(at.x, at.y + by * last.y), turn),
        };
        let over_rows = |(at, turn): (DVec2, DVec2), by: f64| match rows {
            _ if by == 0.0 => (at, turn),
            Some(true) => {
                (DVec2::new(at.x + by * last.x, last.y - at.y), DVec2::new(turn.x, -turn.y))
            }
            _ => (DVec2::new(at.x + by * last.x, at.y), turn),
        };
        let turns = |goes_on: Option<bool>| {
            [0.0, -1.0, 1.0].into_iter().take(if goes_on.is_some() { 3 } else { 1 })
        };
        let all = turns(rows)
            .flat_map(|down| turns(cols).map(move |right| (down, right)))
            .filter(|by| *by != (0.0, 0.0))
            .map(|(down, right)| over_rows(over_cols((at, DVec2::ONE), right), down));
        let is_near = |(at, _): &(DVec2, DVec2)| {
            at.cmpge(DVec2::splat(-reach)).all() && at.cmple(last + reach).all()
        };
        all.filter(is_near).collect()
    }

    /// Returns whether two places of the grid are copies of one place of the surface.
    #[doc(hidden)]
    pub fn are_copies(&self, a: DVec2, b: DVec2) -> bool {
        self.is_glued() && a != b && self.copies_of(a).iter().any(|copy| copy.distance(b) <= SAME)
    }
}
