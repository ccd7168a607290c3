//! Measures the angles at which grid points lie near a source curve: a quarter turn to the left or to the right beside
//! the curve, and any angle between these two around an open end.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

use glam::{DMat2, DVec2};

use crate::MapError;
use geosweep_surface::{Source, Sources, Surface};

/// The number of rows and columns around each end of a curve in which angles are measured instead of propagated. The
/// curvature of the wavefront jumps at an open end, and the error of the map changes the directions of the rays
/// nearby. Angles are measured in the same way where a closed curve begins and ends.
const AROUND_END: usize = 8;
/// The number of rows and columns by which a point may lie outside the bounding box of a segment for its distance from
/// the segment to be measured.
const REACH: f64 = 2.0 + AROUND_END as f64;

/// A source curve.
pub(super) struct Line<'a> {
    surface: &'a Surface,
    vertices: &'a [DVec2],
    /// For each segment, whether its ends are copies of one place, one on each side of a seam.
    jumps: Vec<bool>,
    /// For each segment, 1, or -1 if seams have turned the grid over, so that the left side of the first segment goes
    /// on as the right side of this segment.
    signs: Vec<f64>,
    /// Whether the curve ends where it begins.
    closed: bool,
}

/// The place on a curve nearest to a point, given by its distance from the point and the point's angle there.
pub(super) struct Foot {
    pub(super) distance: f64,
    pub(super) angle: f64,
}

/// The place on a curve nearest to an image of a point, in the rows and columns of that image.
struct Nearest {
    square: f64,
    index: usize,
    share: f64,
    at: DVec2,
    metric: DMat2,
}

impl<'a> Line<'a> {
    /// Finds where a curve on a surface passes seams.
    pub(super) fn new(surface: &'a Surface, vertices: &'a [DVec2]) -> Self {
        let is_jump = |ends: &[DVec2]| surface.are_copies(ends[0], ends[1]);
        let jumps: Vec<bool> = vertices.windows(2).map(is_jump).collect();
        let mut sign = 1.0;
        let of_segment = |(ends, &is_jump): (&[DVec2], &bool)| {
            let turn = if is_jump { surface.turn_at_copy(ends[0], ends[1]) } else { None };
            sign *= turn.map_or(1.0, |turn| turn.x * turn.y);
            sign
        };
        let signs = vertices.windows(2).zip(&jumps).map(of_segment).collect();
        let (first, last) = (vertices[0], vertices[vertices.len() - 1]);
        let closed = first == last || surface.are_copies(first, last);
        Self { surface, vertices, jumps, signs, closed }
    }

    /// Returns the grid points at which the angle is measured: the points that the curve seeds (true), and points
    /// around its ends (false). The latter do not count if another source is nearer. `source` is the curve.
    pub(super) fn beside(
        &self,
        source: &Source,
    ) -> Result<BTreeMap<(usize, usize), bool>, MapError> {
        // Seeds come first, since their computation refuses vertices off the grid.
        let seeds = Sources::from_iter([source.clone()]).seeds(self.surface)?;
        let mut points = BTreeMap::new();
        for end in [self.vertices.first(), self.vertices.last()].into_iter().flatten() {
            let span = |at: f64| {
                let (low, high) = (at.floor() as isize, at.ceil() as isize);
                low - AROUND_END as isize..=high + AROUND_END as isize
            };
            let all = span(end.x).flat_map(|row| span(end.y).map(move |col| (row, col)));
            let all = all.filter_map(|(row, col)| self.surface.continued(row, col));
            let usable = all.filter(|&(row, col)| self.surface.has(row, col));
            points.extend(usable.map(|at| (at, false)));
        }
        points.extend(seeds.iter().map(|seed| ((seed.row, seed.col), true)));
        Ok(points)
    }

    /// Returns the place nearest to a point, as if the surface were flat around the point. `metric` is the metric at
    /// the point, in rows and columns. The place may lie beyond a seam over which the grid goes on.
    pub(super) fn nearest(&self, at: DVec2, metric: DMat2) -> Option<Foot> {
        let images = self.surface.turned_images(at, REACH);
        let all = [(at, DVec2::ONE)].into_iter().chain(images);
        let of_image = |(image, turn): (DVec2, DVec2)| self.nearest_to(image, turned(metric, turn));
        let nearest = all.filter_map(of_image).min_by(|a, b| a.square.total_cmp(&b.square))?;
        Some(self.foot(&nearest))
    }

    /// Returns the place nearest to an image of a point.
    fn nearest_to(&self, at: DVec2, metric: DMat2) -> Option<Nearest> {
        let dot = |a: DVec2, b: DVec2| a.dot(metric * b);
        let near = |a: &DVec2, b: &DVec2| {
            let (low, high) = (a.min(*b) - REACH, a.max(*b) + REACH);
            at.cmpge(low).all() && at.cmple(high).all()
        };
        let foot = |(index, ends): (usize, &[DVec2])| {
            let (along, from) = (ends[1] - ends[0], at - ends[0]);
            if self.jumps[index] || dot(along, along) <= 0.0 || !near(&ends[0], &ends[1]) {
                return None;
            }
            let share = (dot(from, along) / dot(along, along)).clamp(0.0, 1.0);
            let away = from - share * along;
            Some(Nearest { square: dot(away, away), index, share, at, metric })
        };
        let feet = self.vertices.windows(2).enumerate().filter_map(foot);
        feet.min_by(|a, b| a.square.total_cmp(&b.square))
    }

    /// Returns the distance and the angle at the nearest place.
    fn foot(&self, nearest: &Nearest) -> Foot {
        let &Nearest { square, index, share, at, metric } = nearest;
        let vertices = self.vertices;
        let dot = |a: DVec2, b: DVec2| a.dot(metric * b);
        let distance = square.max(0.0).sqrt();
        let direction = |index: usize| {
            let along = vertices[index + 1] - vertices[index];
            let length = dot(along, along).sqrt();
            if length > 0.0 { along / length } else { DVec2::ZERO }
        };
        // Positive to the left of `along`, with rows downwards.
        let left = |along: DVec2, away: DVec2| along.x * away.y - along.y * away.x;
        let here = direction(index);
        let away = at - vertices[index].lerp(vertices[index + 1], share);
        let other = match share {
            0.0 => self.before(index).map(direction),
            1.0 => self.after(index).map(direction),
            _ => Some(here),
        };
        let angle = match other {
            _ if distance == 0.0 => 0.0,
            // At a corner of the curve, the two adjoining segments together decide the side.
            Some(other) => FRAC_PI_2.copysign(left(here + other, away)),
            // The nearest place is an open end of the curve.
            None => {
                let outwards = if share == 0.0 { -here } else { here };
                let cosine = dot(outwards, away) / distance;
                cosine.clamp(0.0, 1.0).acos().copysign(left(here, away))
            }
        };
        Foot { distance, angle: self.signs[index] * angle }
    }

    /// Returns the segment before the segment `index`, or `None` at an open end. If the curve comes over a seam there,
    /// returns `index` itself.
    fn before(&self, index: usize) -> Option<usize> {
        let last = self.vertices.len() - 2;
        match index.checked_sub(1) {
            Some(before) if self.jumps[before] => Some(index),
            Some(before) => Some(before),
            None if !self.closed => None,
            // The curve may close by a step between copies of its first place.
            None => Some(if self.ends_meet() && !self.jumps[last] { last } else { index }),
        }
    }

    /// Returns the segment after the segment `index`, or `None` at an open end. If the curve leaves over a seam there,
    /// returns `index` itself.
    fn after(&self, index: usize) -> Option<usize> {
        match index + 1 {
            after if after + 1 < self.vertices.len() => {
                Some(if self.jumps[after] { index } else { after })
            }
            _ if !self.closed => None,
            _ => Some(if self.ends_meet() && !self.jumps[0] { 0 } else { index }),
        }
    }

    /// Returns whether the first and the last vertex are at one place of the grid.
    fn ends_meet(&self) -> bool {
        self.vertices[0] == self.vertices[self.vertices.len() - 1]
    }
}

/// Returns a metric for steps whose rows and columns are multiplied by factors of 1 or -1.
pub(super) fn turned(metric: DMat2, turn: DVec2) -> DMat2 {
    let [rr, rc, _, cc] = metric.to_cols_array();
    let rc = rc * turn.x * turn.y;
    DMat2::from_cols_array(&[rr, rc, rc, cc])
}
