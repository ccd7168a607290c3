//! Shares the Gaussian curvature among the copies of a point. The twin of `glsl/passes/share_curvature.comp`.

use rayon::prelude::*;

use super::super::chart::{Direction, EdgeSlot};
use super::super::tag::{TAG, Tagged};
use super::super::{Chart, DIFFRACTS, EdgeLengths, LACKING, Real};
use super::Groups;
use crate::constants::COPIES_TOGETHER;

/// Names of points, equal for all copies of a point, that distinguish the points of a ring.
struct Names {
    /// For each copy in the bordered array, the first of its group; 0 for other points. Index 0 is a point of the
    /// border.
    first: Vec<u32>,
}

impl Names {
    fn of(groups: &Groups, points: usize) -> Self {
        let mut first = vec![0; points];
        groups.iter().for_each(|group| {
            group.iter().for_each(|&point| first[point as usize] = group[0]);
        });
        Self { first }
    }

    fn get(&self, point: usize) -> u32 {
        if self.is_copy(point) { self.first[point] } else { point as u32 }
    }

    fn is_copy(&self, point: usize) -> bool {
        self.first[point] != 0
    }
}

/// Working memory for the sides and ends of a ring.
#[derive(Default)]
struct RingSides {
    sides: Vec<[u32; 2]>,
    ends: Vec<u32>,
}

impl<R: Real> EdgeLengths<R> {
    /// Gives the copies of each point the mean of their curvatures. A point inside the glued surface lacks no triangle,
    /// although each of its copies lacks some. Its copies lose their tags, since fronts that come from beyond the seam
    /// do not turn there. `curvature` is a bordered array.
    pub(in super::super) fn share_curvature(&self, curvature: &mut [R]) {
        self.complete_beside_poles(curvature);
        let Some(groups) = self.copies() else { return };
        let (names, mut ring) = (Names::of(groups, curvature.len()), RingSides::default());
        for group in groups.iter() {
            // The sum is taken part by part as in the shader, which has an invocation for each part of a group.
            let of_part = |part: &[u32]| {
                part.iter().fold(R::zero(), |sum, &point| sum + curvature[point as usize])
            };
            let parts = group.chunks(COPIES_TOGETHER as usize).map(of_part);
            let sum = parts.fold(R::zero(), |sum, part| sum + part);
            let mean = sum / R::of(group.len() as f64);
            let tags = group.iter().map(|&point| tag_of(curvature[point as usize]));
            let tag = tags.fold(0, |all, tag| all | tag);
            let tag = if tag != 0 && self.goes_round(group, &names, &mut ring) { 0 } else { tag };
            for &point in group {
                curvature[point as usize] = mean.with_tag(tag);
            }
        }
        // The middle of a folded side has no copy but itself.
        let chart = self.chart();
        let beside = |&copy: &u32| {
            let (row, col) = chart.bordered_position(copy as usize);
            Direction::ALL.into_iter().filter_map(move |to| chart.neighbour(row, col, to))
        };
        for (row, col) in groups.members().iter().flat_map(beside) {
            let point = chart.bordered(row, col);
            if tag_of(curvature[point]) != 0
                && !names.is_copy(point)
                && self.goes_round(&[point as u32], &names, &mut ring)
            {
                curvature[point] = curvature[point].with_tag(0);
            }
        }
    }

    /// Removes the tags of points whose fan has all its edges. At a pole some triangles have no area. The fan counts
    /// them as missing, but a front that passes the pole does not turn there.
    fn complete_beside_poles(&self, curvature: &mut [R]) {
        let chart = self.chart();
        let exists = |from: usize, to: Direction| self.at(from, EdgeSlot::of(chart, to)) < R::FAR;
        let is_complete = |point: usize| {
            Direction::ALL
                .into_iter()
                .all(|to| exists(point, to) && exists(chart.beside(point, to), to.base()))
        };
        chart.rows_mut(curvature).enumerate().for_each(|(row, line)| {
            for (point, curvature) in (chart.bordered(row, 0)..).zip(line) {
                if tag_of(*curvature) != 0 && is_complete(point) {
                    *curvature = curvature.with_tag(0);
                }
            }
        });
    }

    /// Returns whether the cells around the copies of a point form a closed ring. Each cell contributes the two sides
    /// that do not meet the point; the ring is closed if every point on it lies on two sides.
    fn goes_round(&self, group: &[u32], names: &Names, ring: &mut RingSides) -> bool {
        const CELLS: [Direction; 4] = [
            Direction::NorthEast,
            Direction::NorthWest,
            Direction::SouthWest,
            Direction::SouthEast,
        ];
        let own = names.get(group[0] as usize);
        let RingSides { sides, ends } = ring;
        sides.clear();
        ends.clear();
        for &point in group {
            let cells = CELLS.iter().filter_map(|&to| self.cell(self.chart(), point as usize, to));
            for corners in cells {
                let [a, b, c] = corners.map(|corner| names.get(corner));
                let between = [[a.min(b), a.max(b)], [b.min(c), b.max(c)]];
                sides.extend(
                    between.iter().filter(|side| side[0] != side[1] && !side.contains(&own)),
                );
            }
        }
        // Copies on a folded side have cells in common.
        sides.sort_unstable();
        sides.dedup();
        ends.extend(sides.iter().flatten());
        ends.sort_unstable();
        !ends.is_empty() && ends.chunk_by(|a, b| a == b).all(|copies| copies.len() == 2)
    }

    /// Returns the other three corners of a point's cell, in order around it, if all are present.
    fn cell(&self, chart: Chart, point: usize, to: Direction) -> Option<[usize; 3]> {
        let ways = [to.previous(), to, to.next()];
        let exist = ways.iter().all(|&way| self.at(point, EdgeSlot::of(chart, way)) < R::FAR);
        exist.then(|| ways.map(|way| chart.beside(point, way)))
    }
}

fn tag_of<R: Real>(curvature: R) -> u8 {
    [LACKING, DIFFRACTS].into_iter().filter(|&tag| curvature.tag_has(tag, tag)).fold(
        0,
        |all, tag| {
            debug_assert!(tag & TAG == tag);
            all | tag
        },
    )
}
