//! Measures angles around the points of glued surfaces, in the triangles on all sides of seams.
//!
//! All triangles around a point, or around all copies of it, form a fan: each lies beside the next one along a common
//! edge. Angles are measured in the fan, beginning at the ray that arrives first. They need no rows and columns, so
//! poles, folds and seams between charts are no special cases.

use std::f64::consts::{PI, TAU};

use glam::{DMat2, DVec2};
use rayon::prelude::*;

use super::kink::AtEnds;
use crate::copies::Copies;
use crate::neighbourhood::Neighbourhood;
use geosweep_surface::{Real, ring};

/// The first ray at a point: its time, its base, and where it crosses the base.
type FirstRay = (f64, usize, f64);

/// A triangle around a point.
#[derive(Clone, Copy)]
struct Sector {
    /// The first copies of its two other corners.
    spokes: [usize; 2],
    /// The lengths of the edges to them.
    lengths: [f64; 2],
    /// The angle between these edges.
    angle: f64,
}

/// The neighbours around a point whose angles from the first ray are known.
#[derive(Clone, Debug, Default)]
struct Fan {
    /// The first copy of each neighbour, and its angle. Angles grow in one direction around the point.
    spokes: Vec<(u32, f32)>,
    /// The sum of all angles, if the fan goes all the way round the point.
    round: Option<f64>,
}

/// The fans of all points, by the indices of their first copies in bordered arrays.
pub(super) struct Fans(Vec<Fan>);

impl Fans {
    /// Measures all fans. `first_ray` returns the first ray that arrives at a copy of a point, if there is one.
    pub(super) fn new(
        neighbourhood: &Neighbourhood,
        copies: &Copies,
        first_ray: impl Fn(usize) -> Option<FirstRay> + Sync,
    ) -> Self {
        let fan = |point: usize| {
            if copies.first(point) != point {
                return Fan::default();
            }
            let rays = copies.all(point).filter_map(|copy| Some((first_ray(copy)?, copy)));
            let first = rays.min_by(|(a, _), (b, _)| a.0.total_cmp(&b.0));
            let Some(((_, to, share), copy)) = first else { return Fan::default() };
            let spokes = spokes(neighbourhood, copies, copy, to);
            Fan::around(&sectors(neighbourhood, copies, point), spokes, share)
        };
        let points = (0..neighbourhood.chart().bordered_points()).into_par_iter();
        Self(points.with_min_len(4096).map(fan).collect())
    }

    /// Returns the directions of first arrivals at both ends of an edge of the given length, in the plane of a triangle
    /// with this edge whose other corner is `third`. Returns `None` if an angle is not known.
    pub(super) fn at_ends(
        &self,
        copies: &Copies,
        ends: [usize; 2],
        third: usize,
        length: f64,
    ) -> Option<AtEnds> {
        let ([from, to], third) = (ends.map(|end| copies.first(end)), copies.first(third));
        let [at_from, at_to] = [(from, to), (to, from)]
            .map(|(point, other)| self.0[point].bearing(other as u32, third as u32));
        // A wavefront moves in the direction opposite to the one from which its ray comes.
        let [back, ahead] = [at_from?, at_to?].map(DVec2::from_angle);
        let directions = [-back, DVec2::new(ahead.x, -ahead.y)];
        Some(AtEnds { directions, metric: DMat2::IDENTITY, step: DVec2::new(length, 0.0) })
    }
}

impl Fan {
    /// Puts the sectors around a point in order. The first ray crosses the base between the two `spokes`, at the
    /// fraction `share` from the first to the second.
    fn around(sectors: &[Sector], spokes: [usize; 2], share: f64) -> Self {
        let along = match share {
            0.0 => Some(spokes[0]),
            1.0 => Some(spokes[1]),
            _ => None,
        };
        let is_first = |sector: &Sector| match along {
            Some(spoke) => sector.spokes.contains(&spoke),
            None => sector.has(spokes),
        };
        let Some(number) = sectors.iter().position(is_first) else { return Self::default() };
        let first = sectors[number];
        let ray = match along {
            Some(spoke) if spoke == first.spokes[0] => 0.0,
            Some(_) => first.angle,
            None if first.spokes == spokes => first.angle_at(share),
            None => first.angle_at(1.0 - share),
        };
        let mut left: Vec<Sector> = sectors.to_vec();
        left.swap_remove(number);
        let [start, end] = first.spokes;
        let mut found = vec![(start, -ray)];
        let (last, angle) = follow(&mut left, end, first.angle - ray, 1.0, &mut found);
        let round = (last == start).then_some(angle + ray);
        if round.is_none() {
            found.push((last, angle));
            found.remove(0);
            let (last, angle) = follow(&mut left, start, -ray, -1.0, &mut found);
            found.push((last, angle));
        }
        let spokes = found.into_iter().map(|(spoke, angle)| (spoke as u32, angle as f32));
        Self { spokes: spokes.collect(), round }
    }

    /// Returns the angle from the direction of `neighbour` to the direction from which the first ray comes. It is
    /// positive on the side of the neighbour `other`.
    fn bearing(&self, neighbour: u32, other: u32) -> Option<f64> {
        let [there, other] = [neighbour, other].map(|neighbour| {
            let of = |(_, angle): &(u32, f32)| f64::from(*angle);
            self.spokes.iter().find(|(spoke, _)| *spoke == neighbour).map(of)
        });
        let (there, other) = (there?, other?);
        Some(self.turn(-there) * self.turn(other - there).signum())
    }

    /// Converts an angle around the point into an angle in a plane. If the fan goes all the way round, the angle is
    /// scaled so that a full turn is 2 pi, and the shorter way round is taken.
    fn turn(&self, angle: f64) -> f64 {
        let Some(round) = self.round else { return angle };
        let angle = angle * TAU / round;
        angle - TAU * ((angle + PI) / TAU).floor()
    }
}

impl Sector {
    fn has(&self, spokes: [usize; 2]) -> bool {
        self.spokes == spokes || self.spokes == [spokes[1], spokes[0]]
    }

    /// Returns the angle from the first spoke to the place at the fraction `share` of the base.
    fn angle_at(&self, share: f64) -> f64 {
        let [first, last] = self.lengths;
        let place = DVec2::new(first, 0.0).lerp(last * DVec2::from_angle(self.angle), share);
        place.to_angle()
    }
}

/// Returns the triangles around a point and its copies. Triangles that several copies share, as at a pole, are listed
/// once. Triangles without an area are left out.
fn sectors(neighbourhood: &Neighbourhood, copies: &Copies, point: usize) -> Vec<Sector> {
    let mut sectors: Vec<Sector> = Vec::with_capacity(8);
    for copy in copies.all(point) {
        for to in 0..8 {
            let [a, b] = [to, ring::next(to)].map(|to| neighbourhood.length(copy, to));
            let base = neighbourhood.base(copy, to);
            let spokes = spokes(neighbourhood, copies, copy, to);
            let is_triangle = [a, b, base].iter().all(|&side| side > 0.0 && side < f64::FAR)
                && !spokes.contains(&point)
                && spokes[0] != spokes[1];
            if is_triangle && !sectors.iter().any(|sector| sector.has(spokes)) {
                let cosine = (a * a + b * b - base * base) / (2.0 * a * b);
                let angle = cosine.clamp(-1.0, 1.0).acos();
                sectors.push(Sector { spokes, lengths: [a, b], angle });
            }
        }
    }
    sectors
}

/// Returns the first copies of a neighbour and the next one.
fn spokes(neighbourhood: &Neighbourhood, copies: &Copies, point: usize, to: usize) -> [usize; 2] {
    [to, ring::next(to)].map(|to| copies.first(neighbourhood.neighbour(point, to)))
}

/// Follows adjacent sectors from `spoke` on. Removes them from `left` and appends their spokes, except the last, with
/// their angles to `found`. Angles grow if `sign` is 1 and fall if it is -1. Returns the last spoke and its angle.
fn follow(
    left: &mut Vec<Sector>,
    mut spoke: usize,
    mut angle: f64,
    sign: f64,
    found: &mut Vec<(usize, f64)>,
) -> (usize, f64) {
    while let Some(number) = left.iter().position(|sector| sector.spokes.contains(&spoke)) {
        found.push((spoke, angle));
        let sector = left.swap_remove(number);
        spoke = if sector.spokes[0] == spoke { sector.spokes[1] } else { sector.spokes[0] };
        angle += sign * sector.angle;
    }
    (spoke, angle)
}
