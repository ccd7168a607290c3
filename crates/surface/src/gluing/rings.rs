//! Lists the cells around the copies of each point, so that a shader can tell whether they form a closed ring.
//!
//! [`super::curvature`] collects the sides of these cells that do not meet the point: the ring is closed if every
//! point on it lies on two sides. Which cells exist is known on the device only. So each cell has a number that is
//! made from the ends of its sides, such that the numbers of the cells of a closed ring cancel out: their
//! exclusive or is 0, as each point on the ring occurs twice.

use std::collections::BTreeSet;

use super::super::{Chart, Direction};
use super::Glued;

/// Copies of a point, and the cells around them.
pub struct Ring {
    /// The copies, by their row-major indices.
    #[doc(hidden)]
    pub members: Vec<u32>,
    /// For each member, the cells beside it that are not beside an earlier member.
    #[doc(hidden)]
    pub cells: Vec<Vec<RingCell>>,
}

/// Cell of a ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RingCell {
    /// Row and column of the cell's first point.
    #[doc(hidden)]
    pub first: (usize, usize),
    /// Exclusive or of the numbers of all ends of the cell's sides on the ring.
    #[doc(hidden)]
    pub ends: u32,
}

/// Name of a point that all its copies share.
type Name = (u8, u32);

impl Glued {
    /// Returns a ring for each group, in the order of the groups. A ring follows for each point without copies that
    /// lies between two copies of another point, as in the middle of a folded side. Such a point may lie inside the
    /// glued surface, although it lies at the border of the grid.
    #[doc(hidden)]
    pub fn rings(&self, chart: Chart) -> Vec<Ring> {
        let groups = self.groups.iter().map(<[u32]>::to_vec);
        groups.chain(self.middles(chart)).map(|members| self.ring(chart, members)).collect()
    }

    fn middles(&self, chart: Chart) -> Vec<Vec<u32>> {
        let axes = [Direction::East, Direction::North, Direction::West, Direction::South];
        let is_middle = |&(row, col): &(usize, usize)| {
            let around = axes.iter().filter_map(|&to| chart.neighbour(row, col, to));
            let numbers = around.filter_map(|(row, col)| self.groups.number(chart.index(row, col)));
            let mut numbers: Vec<_> = numbers.collect();
            numbers.sort_unstable();
            numbers.windows(2).any(|pair| pair[0] == pair[1])
        };
        let mut beside: Vec<_> = (self.groups.members().iter())
            .flat_map(|&index| {
                let (row, col) = chart.position(index as usize);
                axes.into_iter().filter_map(move |to| chart.neighbour(row, col, to))
            })
            .filter(|&(row, col)| self.groups.number(chart.index(row, col)).is_none())
            .filter(is_middle)
            .map(|(row, col)| vec![chart.index(row, col) as u32])
            .collect();
        beside.sort_unstable();
        beside.dedup();
        beside
    }

    fn name(&self, index: u32) -> Name {
        self.groups.number(index as usize).map_or((1, index), |number| (0, number))
    }

    fn ring(&self, chart: Chart, members: Vec<u32>) -> Ring {
        let own = self.name(members[0]);
        let (mut cells, mut sides) = (BTreeSet::new(), BTreeSet::new());
        let of_member = |&member: &u32| {
            let place = chart.position(member as usize);
            let around = DIAGONALS.iter().filter_map(|&to| corners(chart, place, to));
            let mut own_cells = Vec::new();
            for (first, corners) in around.filter(|&(first, _)| cells.insert(first)) {
                let names = corners.map(|(row, col)| self.name(chart.index(row, col) as u32));
                let new = names.windows(2).filter(|side| {
                    side[0] != side[1]
                        && !side.contains(&own)
                        && sides.insert([side[0].min(side[1]), side[0].max(side[1])])
                });
                let ends = new.flatten().fold(0, |ends, &name| ends ^ number_of(name));
                own_cells.push(RingCell { first, ends });
            }
            own_cells
        };
        let cells = members.iter().map(of_member).collect();
        Ring { members, cells }
    }
}

const DIAGONALS: [Direction; 4] =
    [Direction::NorthEast, Direction::NorthWest, Direction::SouthWest, Direction::SouthEast];

/// Row and column.
type Place = (usize, usize);

/// Returns the first point of the cell that lies in the direction `to` from a point, and the three corners other than
/// this point in order around it, if the grid has the cell.
fn corners(chart: Chart, (row, col): Place, to: Direction) -> Option<(Place, [Place; 3])> {
    let (far_row, far_col) = chart.neighbour(row, col, to)?;
    let beside = |way| chart.neighbour(row, col, way);
    let corners = [beside(to.previous())?, (far_row, far_col), beside(to.next())?];
    Some(((row.min(far_row), col.min(far_col)), corners))
}

/// Returns a number of 32 bits that stands for a name. Numbers of different names are unrelated.
fn number_of((kind, index): Name) -> u32 {
    let mut bits = u64::from(index) << 1 | u64::from(kind);
    for factor in [0x9e37_79b9_7f4a_7c15, 0xbf58_476d_1ce4_e5b9, 0x94d0_49bb_1331_11eb] {
        bits = (bits ^ bits >> 31).wrapping_add(1).wrapping_mul(factor);
    }
    (bits >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::super::Gluing;
    use super::*;

    /// Returns the members of each ring, and whether the ring is closed. `exists` tells whether a cell exists.
    fn closed(
        chart: Chart,
        gluing: &Gluing,
        exists: impl Fn(Place) -> bool,
    ) -> Vec<(Vec<u32>, bool)> {
        let glued = Glued::of_grid(chart, gluing).unwrap();
        let is_closed = |ring: Ring| {
            let there = ring.cells.iter().flatten().filter(|cell| exists(cell.first));
            let ends = there.clone().fold(0, |ends, cell| ends ^ cell.ends);
            (ring.members, there.count() > 0 && ends == 0)
        };
        glued.rings(chart).into_iter().map(is_closed).collect()
    }

    #[test]
    fn rings_close_inside_the_glued_surface() {
        let chart = Chart { rows: 6, cols: 9 };
        for (members, is_closed) in closed(chart, &Gluing::columns(), |_| true) {
            let is_inside = !members.contains(&0) && !members.contains(&45);
            assert_eq!(is_closed, is_inside, "{members:?}");
        }
        assert!(closed(chart, &Gluing::globe(), |_| true).iter().all(|(_, closed)| *closed));
        assert!(closed(chart, &Gluing::both(), |_| true).iter().all(|(_, closed)| *closed));
    }

    #[test]
    fn a_missing_cell_opens_the_rings_around_it() {
        let chart = Chart { rows: 6, cols: 9 };
        let open: Vec<_> = closed(chart, &Gluing::both(), |first| first != (2, 7))
            .into_iter()
            .filter(|(_, closed)| !closed)
            .map(|(members, _)| members)
            .collect();
        assert_eq!(open, [[18, 26], [27, 35]]);
    }

    #[test]
    fn the_middles_of_folded_sides_have_rings() {
        let chart = Chart { rows: 9, cols: 9 };
        let rings = closed(chart, &Gluing::Octahedral, |_| true);
        let middles: Vec<_> = rings.iter().filter(|(members, _)| members.len() == 1).collect();
        assert_eq!(middles.len(), 4);
        assert!(middles.iter().all(|(_, closed)| *closed), "{rings:?}");
    }
}
