//! Finds the copies of places on seams.

use glam::DVec2;

use super::super::Surface;

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
            let ends: Vec<_> = self.copies_of_point(high).collect();
            for from in self.copies_of_point(low) {
                let is_beside = |to: &&DVec2| (**to - from).abs().element_sum() == 1.0;
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
