//! Finds the copies of places on seams.

use glam::DVec2;

use super::super::Surface;

impl Surface {
    /// Returns the places that are the same place of a glued surface, in ascending order of rows and columns,
    /// this one included. A place between two points of a seam has copies between their copies.
    pub(crate) fn copies_of(&self, at: DVec2) -> Vec<DVec2> {
        let mut all = vec![at];
        let Some(glued) = self.glued.as_ref().filter(|_| self.chart.holds(at)) else { return all };
        let (low, high) = (at.floor(), at.ceil());
        let copies = |at: DVec2| -> Vec<DVec2> {
            let index = self.chart.index(at.x as usize, at.y as usize) as u32;
            let group = glued.groups.iter().find(|group| group.binary_search(&index).is_ok());
            let place = |index: u32| {
                let (row, col) = self.chart.position(index as usize);
                DVec2::new(row as f64, col as f64)
            };
            group.map_or_else(Vec::new, |group| group.iter().map(|&index| place(index)).collect())
        };
        if low == high {
            all.extend(copies(at));
        } else if (low - high).abs().element_sum() == 1.0 {
            let share = (at - low).element_sum();
            let ends = copies(high);
            for from in copies(low) {
                let is_beside = |to: &&DVec2| (**to - from).abs().element_sum() == 1.0;
                all.extend(ends.iter().filter(is_beside).map(|to| from.lerp(*to, share)));
            }
        }
        all.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        all.dedup();
        all
    }

    /// Returns whether a grid point has copies.
    pub(crate) fn has_copies(&self, (row, col): (usize, usize)) -> bool {
        let index = self.chart.index(row, col) as u32;
        self.glued.as_ref().is_some_and(|glued| glued.groups.members().contains(&index))
    }
}
