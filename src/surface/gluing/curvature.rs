//! Shares the Gaussian curvature among the copies of a point. The twin of `glsl/passes/share_curvature.comp`.

use std::collections::{BTreeMap, BTreeSet};

use super::super::chart::{Direction, EdgeSlot};
use super::super::tag::{TAG, Tagged};
use super::super::{Chart, DIFFRACTS, EdgeLengths, LACKING, Real};
use crate::constants::COPIES_TOGETHER;

impl<R: Real> EdgeLengths<R> {
    /// Gives the copies of each point the mean of their curvatures. A point inside the glued surface lacks no triangle,
    /// although each of its copies lacks some. Its copies lose their tags, since fronts that come from beyond the seam
    /// do not turn there. `curvature` is a bordered array.
    pub(in super::super) fn share_curvature(&self, curvature: &mut [R]) {
        self.complete_beside_poles(curvature);
        let Some(groups) = self.copies() else { return };
        let numbers = groups.numbers();
        let name =
            |point: u32| numbers.get(&point).map_or((1, point as usize), |&number| (0, number));
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
            let tag = if tag != 0 && self.goes_round(group, name) { 0 } else { tag };
            for &point in group {
                curvature[point as usize] = mean.with_tag(tag);
            }
        }
        // The middle of a folded side has no copy but itself.
        let chart = self.chart();
        for point in chart.places().map(|(row, col)| chart.bordered(row, col)) {
            let is_beside_copies = || {
                let around = Direction::ALL.map(|to| chart.beside(point, to) as u32);
                around.iter().any(|beside| numbers.contains_key(beside))
            };
            let own = point as u32;
            if tag_of(curvature[point]) != 0
                && !numbers.contains_key(&own)
                && is_beside_copies()
                && self.goes_round(&[own], name)
            {
                curvature[point] = curvature[point].with_tag(0);
            }
        }
    }

    /// Removes the tags of points whose fan has all its edges. At a pole some triangles have no area. The fan counts
    /// them as missing, but a front that passes the pole does not turn there.
    fn complete_beside_poles(&self, curvature: &mut [R]) {
        let chart = self.chart();
        for (row, col) in chart.places() {
            let point = chart.bordered(row, col);
            if tag_of(curvature[point]) == 0 {
                continue;
            }
            let exists =
                |from: usize, to: Direction| self.at(from, EdgeSlot::of(chart, to)) < R::FAR;
            let is_whole = Direction::ALL
                .into_iter()
                .all(|to| exists(point, to) && exists(chart.beside(point, to), to.base()));
            if is_whole {
                curvature[point] = curvature[point].with_tag(0);
            }
        }
    }

    /// Returns whether the cells around the copies of a point form a closed ring. `name` is the same for all copies of
    /// a point. Each cell contributes the two sides that do not meet the point; the ring is closed if every point on it
    /// lies on two sides.
    fn goes_round(&self, group: &[u32], name: impl Fn(u32) -> (u8, usize)) -> bool {
        let own = name(group[0]);
        let mut sides = BTreeSet::new();
        for &point in group {
            let cells = [
                Direction::NorthEast,
                Direction::NorthWest,
                Direction::SouthWest,
                Direction::SouthEast,
            ];
            for corners in
                cells.iter().filter_map(|&to| self.cell(self.chart(), point as usize, to))
            {
                let names = corners.map(|corner| name(corner as u32));
                for side in names.windows(2) {
                    if side[0] != side[1] && !side.contains(&own) {
                        sides.insert([side[0].min(side[1]), side[0].max(side[1])]);
                    }
                }
            }
        }
        let mut ends = BTreeMap::new();
        for end in sides.into_iter().flatten() {
            *ends.entry(end).or_insert(0) += 1;
        }
        !ends.is_empty() && ends.values().all(|&count| count == 2)
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
