//! Joins the fans of all copies of a point on a glued surface to one fan.
//!
//! Each copy holds some of the triangles around the point. Triangles with a common edge follow one another, also over
//! a seam. All copies measure angles from the same edge, so that a ray has the same angle at each copy. At copies whose
//! chart is mirrored, angles decrease from one direction to the next.

use std::collections::HashMap;

use super::{Fan, wedge};
use crate::chart::{Direction, EdgeSlot, ring};
use crate::edges::EdgeLengths;
use crate::gluing::Groups;
use crate::{Real, max};

/// A triangle around a point, by the names of the ends of its two edges.
struct Wedge<R> {
    ends: [u32; 2],
    angle: R,
}

/// Joins the fans of copies, and closes the fans of points between two copies of another point, as in the middle of a
/// folded side.
pub(super) fn join<R: Real>(edges: &EdgeLengths<R>, fans: &mut [Fan<R>]) {
    let Some(groups) = edges.copies() else { return };
    for group in groups.iter() {
        join_group(edges, groups, group, fans);
    }
    let chart = edges.chart();
    let mut middles: Vec<_> = groups
        .members()
        .iter()
        .flat_map(|&copy| {
            let (row, col) = chart.bordered_position(copy as usize);
            Direction::ALL.into_iter().filter_map(move |to| chart.neighbour(row, col, to))
        })
        .map(|(row, col)| chart.bordered(row, col) as u32)
        .filter(|&point| groups.number(point as usize).is_none() && is_middle(edges, groups, point))
        .collect();
    middles.sort_unstable();
    middles.dedup();
    for point in middles {
        join_group(edges, groups, &[point], fans);
    }
}

/// Returns a name that all copies of a point share.
fn name(groups: &Groups, point: usize) -> u32 {
    groups.around(point).map_or(point as u32, |copies| copies[0])
}

fn is_middle<R: Real>(edges: &EdgeLengths<R>, groups: &Groups, point: u32) -> bool {
    let beside = Direction::ALL.map(|to| name(groups, edges.chart().beside(point as usize, to)));
    (0..8).any(|to| {
        groups.number(beside[to] as usize).is_some() && beside[to + 1..].contains(&beside[to])
    })
}

fn join_group<R: Real>(
    edges: &EdgeLengths<R>,
    groups: &Groups,
    group: &[u32],
    fans: &mut [Fan<R>],
) {
    let chart = edges.chart();
    let own = name(groups, group[0] as usize);
    let mut wedges: Vec<Wedge<R>> = Vec::new();
    for &copy in group {
        let point = copy as usize;
        for k in 0..8 {
            let ends = [k, ring::next(k)];
            let ends = ends.map(|to| name(groups, chart.beside(point, Direction::ALL[to])));
            let [l1, l2, base] = edges.wedge(point, k);
            let is_there = max(max(l1, l2), base) < R::FAR;
            let is_known =
                |known: &Wedge<R>| known.ends == ends || known.ends == [ends[1], ends[0]];
            if is_there
                && ends[0] != ends[1]
                && !ends.contains(&own)
                && !wedges.iter().any(is_known)
            {
                wedges.push(Wedge { ends, angle: wedge(l1, l2, base) });
            }
        }
    }
    let angles = around(wedges);
    for &copy in group {
        let point = copy as usize;
        let known = Direction::ALL.map(|to| {
            let is_there = edges.at(point, EdgeSlot::of(chart, to)) < R::FAR;
            angles.get(&name(groups, chart.beside(point, to))).copied().filter(|_| is_there)
        });
        let words = [0, 1, 2, 3, 4, 5, 6, 7].map(|to| {
            R::angle_ahead(R::Bits::default(), known[to].unwrap_or_else(|| beside(known, to)))
        });
        fans[point] = Fan::new(fans[point].gaussian(), words);
    }
}

/// Returns an angle for a direction without an edge, as far from the next edge as on an even grid. Rays of sources beyond
/// a seam may have such directions.
fn beside<R: Real>(known: [Option<R>; 8], to: usize) -> R {
    let eighth = R::of(std::f64::consts::FRAC_PI_4);
    let edges: Vec<_> = (1..8).filter_map(|by| Some((by, known[(to + by) % 8]?))).collect();
    let Some(&(by, angle)) = edges.first() else { return R::zero() };
    let rises = edges
        .windows(2)
        .filter(|pair| pair[1].0 == pair[0].0 + 1)
        .any(|pair| pair[1].1 > pair[0].1);
    let back = eighth * R::of(by as f64);
    if rises { angle - back } else { angle + back }
}

/// Returns the angle of each edge around a point, by the name of its end. Closed fans are scaled to a full turn. The
/// gaps of others share what is left of the turn.
fn around<R: Real>(mut wedges: Vec<Wedge<R>>) -> HashMap<u32, R> {
    let turn = R::of(std::f64::consts::TAU);
    let total = wedges.iter().fold(R::zero(), |sum, wedge| sum + wedge.angle);
    // The runs of triangles with common edges, each from one of its ends on.
    let mut runs = Vec::new();
    while !wedges.is_empty() {
        let ends_of = |name: u32| wedges.iter().filter(|wedge| wedge.ends.contains(&name)).count();
        let at_end = wedges.iter().enumerate().find_map(|(number, wedge)| {
            let end = wedge.ends.into_iter().find(|&end| ends_of(end) == 1)?;
            Some((number, end))
        });
        let is_closed = at_end.is_none();
        let (mut number, mut from) = at_end.unwrap_or((0, wedges[0].ends[0]));
        let mut run = vec![(from, R::zero())];
        let mut angle = R::zero();
        loop {
            let wedge = wedges.swap_remove(number);
            angle = angle + wedge.angle;
            from = if wedge.ends[0] == from { wedge.ends[1] } else { wedge.ends[0] };
            run.push((from, angle));
            match wedges.iter().position(|wedge| wedge.ends.contains(&from)) {
                Some(next) => number = next,
                None => break,
            }
        }
        runs.push((run, is_closed));
    }
    let is_closed = runs.len() == 1 && runs[0].1;
    let scale = if is_closed { turn / total } else { R::one() };
    let gap = max(turn - total, R::zero()) / R::of(runs.len().max(1) as f64);
    let mut angles = HashMap::new();
    let mut start = R::zero();
    for (run, _) in runs {
        let last = run.last().map_or(R::zero(), |(_, angle)| *angle);
        for (name, angle) in run {
            angles.entry(name).or_insert(start + angle * scale);
        }
        start = start + last + gap;
    }
    angles
}

#[cfg(test)]
mod tests {
    use crate::builtin::Closed;
    use crate::{EdgeLengths, LACKING, Real, Tagged};

    /// The angles between the edges of all copies together make a full turn, so each lies in one triangle only.
    #[test]
    fn copies_share_one_fan() {
        for (closed, size) in
            [(Closed::Torus, 24), (Closed::MoebiusStrip, 24), (Closed::OctahedralSphere, 25)]
        {
            let surface = closed.surface(size, size).unwrap();
            let grid = surface.solver_grid();
            let edges = EdgeLengths::<f64>::new(grid.surface()).unwrap();
            let (fans, chart) = (edges.shared_fans(), edges.chart());
            let groups = edges.copies().unwrap();
            let gaussian = edges.gaussian_curvature();
            let is_inside = |group: &[u32]| !gaussian[group[0] as usize].tag_has(LACKING, LACKING);
            for group in groups.iter().filter(|group| is_inside(group)) {
                let mut turn = 0.0;
                for &copy in group {
                    for k in 0..8 {
                        let [l1, l2, base] = edges.wedge(copy as usize, k);
                        if l1.max(l2).max(base) < f64::FAR {
                            let fan = &fans[copy as usize];
                            turn += f64::angle_between(fan.angle(k), fan.angle((k + 1) % 8)).abs();
                        }
                    }
                }
                let place = chart.bordered_position(group[0] as usize);
                assert!(
                    (turn - std::f64::consts::TAU).abs() < 1e-6,
                    "{} {place:?}: {turn}",
                    closed.name()
                );
            }
        }
    }
}
