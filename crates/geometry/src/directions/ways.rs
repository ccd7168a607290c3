//! Finds the direction of the shortest path at each grid point.
//!
//! The first line of a traced path gives the direction to first order in the cell's size, and is right
//! wherever fronts meet and paths bend. Where the map is smooth, the gradient of the squared arrival time
//! gives the direction to fourth order. So the gradient is taken if it has the length that the eikonal
//! equation demands and agrees with the line, and the line otherwise.
//!
//! Before times are squared, the time at which the front started is subtracted: the start at the source or,
//! for points behind the corner of a hole, the arrival at that corner. So squared times are smooth around
//! such a corner, as they are around a source.
//!
//! On surfaces whose cells are all alike, the straight line that explains a point's time is its path.

use std::collections::HashMap;

use glam::{DMat2, DMat3, DVec2, DVec3, Vec2};
use rayon::prelude::*;

use super::frame::{Frame, position};
use super::stencil::{SIDE, Samples, derivative};
use crate::copies::Copies;
use crate::order::by_arrival;
use crate::paths::{FirstLine, LineEnd, PathTracer};
use geosweep_cpu::{FirstArrival, StraightFronts, straight_parts};
use geosweep_surface::{Direction, Real, Sources, Surface, reduced_basis};

/// The back direction of one grid point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    Unreached,
    /// The point lies on a source.
    AtSource,
    /// The direction as a step of rows and columns. If `to_source` is set, the source is `step` away;
    /// otherwise the length of the step has no meaning.
    Along {
        step: Vec2,
        to_source: bool,
    },
}

/// The largest relative difference between the gradient's length and the one that the eikonal equation
/// demands.
const OFF_LENGTH: f64 = 0.1;
/// The least cosine of the angle between the gradient and the first line.
const ALIKE: f64 = 0.985;
/// The largest cosine of the angle between two lines that counts as a bend.
const BENT: f64 = 0.9995;

/// Largest difference between the length of a straight line and a time that it explains: a part of the length for errors
/// of the map, and a part of the time for rounding.
const EXPLAINED: [f64; 2] = [1e-5, 1e-6];

/// A map with the paths through it.
pub(super) struct Ways<'a> {
    pub surface: &'a Surface,
    pub paths: &'a PathTracer<'a>,
    pub copies: &'a Copies,
    /// The arrival times in a bordered array, [`Real::FAR`] where no front arrives.
    pub times: &'a [f32],
    pub sources: &'a Sources,
}

impl Ways<'_> {
    /// Returns the back direction at each grid point, row-major. For points of poles, also returns the direction in
    /// space, by the row-major index of the point.
    pub(super) fn find(&self) -> (Vec<Way>, HashMap<usize, DVec3>) {
        let chart = self.surface.chart();
        let start = self.sources.start();
        let lines: Vec<Option<FirstLine>> = self.at_points(|point| {
            // The first copy of a point stands for all its copies.
            let counts = self.is_reached(point) && self.copies.first(point) == point;
            counts.then(|| self.paths.first_line(point, start))?
        });
        let zero_times = self.zero_times(&lines, start);
        let straight = self.straight_ways();
        let way = |index: usize| {
            let point = chart.bordered_point(index);
            if !self.is_reached(point) || self.copies.first(point) != point {
                return (point, Way::Unreached);
            }
            if let Some(way) = straight.as_ref().and_then(|ways| ways[index]) {
                return (point, way);
            }
            let zero_time = zero_times.as_ref().map_or(start, |zero_times| zero_times[index]);
            let line = match lines[index] {
                line if zero_time == start => line,
                line => self.paths.first_line(point, zero_time).or(line),
            };
            self.way(point, line, zero_time)
        };
        let found: Vec<(usize, Way)> = (0..chart.points()).into_par_iter().map(way).collect();
        let zero_time =
            |point| zero_times.as_ref().map_or(start, |zero_times| zero_times[self.index(point)]);
        let mut ways: Vec<Way> = found.iter().map(|&(_, way)| way).collect();
        let mut at_poles = HashMap::new();
        for group in self.copies.groups() {
            let (from, way) = found[self.index(group[0] as usize)];
            let in_space = self.at_pole(group, from, way, zero_time(group[0] as usize));
            for copy in group.iter().map(|&copy| copy as usize) {
                ways[self.index(copy)] = self.at_copy(from, copy, way);
                at_poles.extend(in_space.map(|way| (self.index(copy), way)));
            }
        }
        // The point in the middle of a folded side has no copy but itself, so no group contains it. The side has no
        // direction there.
        if self.surface.is_glued() {
            let (row, col) = chart.last();
            let middles = [(0, col / 2), (row, col / 2), (row / 2, 0), (row / 2, col)];
            for point in middles.map(|(row, col)| chart.bordered(row, col)) {
                if self.copies.has(point) {
                    continue;
                }
                let (from, way) = found[self.index(point)];
                let in_space = self.at_pole(&[point as u32], from, way, zero_time(point));
                at_poles.extend(in_space.map(|way| (self.index(point), way)));
            }
        }
        (ways, at_poles)
    }

    /// Returns the back directions along straight lines, row-major, at the points whose times these explain. Returns
    /// `None` if cells differ.
    fn straight_ways(&self) -> Option<Vec<Option<Way>>> {
        let parts: Vec<_> =
            self.sources.iter().map(|source| straight_parts(self.surface, source)).collect();
        let fronts = StraightFronts::new(self.surface, &parts)?;
        let time = |point| if self.is_reached(point) { self.times[point] } else { f32::INFINITY };
        let map = self.at_points(time);
        let arrivals = fronts.first_arrivals(Some(&map)).into_iter().enumerate();
        let way = |(index, first): (usize, Option<FirstArrival>)| {
            let (first, time) = (first?, f64::from(map[index]));
            let late = (time - first.time).abs();
            let [of_line, of_time] = EXPLAINED;
            let is_explained =
                late <= of_line * (first.time - first.origin.start) + of_time * time.abs();
            let (row, col) = self.surface.chart().position(index);
            let step = first.foot - DVec2::new(row as f64, col as f64);
            let along = Way::Along { step: step.as_vec2(), to_source: true };
            is_explained.then_some(if step == DVec2::ZERO { Way::AtSource } else { along })
        };
        Some(arrivals.map(way).collect())
    }

    /// Returns the back direction in space at a pole, where rows and columns have no common plane. It is the direction
    /// of steepest descent that fits the squared times since `zero_time` on the lines that meet there, or the direction
    /// of the path's first line if the two disagree. Returns `None` at other points, and where the direction is not
    /// known.
    fn at_pole(&self, group: &[u32], from: usize, way: Way, zero_time: f64) -> Option<DVec3> {
        let Way::Along { step, .. } = way else { return None };
        if self.frame(from).basis().is_some() {
            return None;
        }
        let lines: Vec<(DVec3, Option<f64>)> =
            group.iter().flat_map(|&copy| self.lines(copy as usize, zero_time)).collect();
        let own = lines.first()?.0;
        let normals = lines.iter().map(|(line, _)| own.cross(*line));
        let normal = normals.max_by(|a, b| a.length().total_cmp(&b.length()))?.normalize_or_zero();
        // Least squares of the derivatives along the lines. The gradient has no part along the normal.
        let (mut squares, mut sum) = (DMat3::ZERO, DVec3::ZERO);
        for (line, slope) in lines.iter().filter_map(|&(line, slope)| Some((line, slope?))) {
            let along = line - normal * line.dot(normal);
            squares += DMat3::from_cols(along * along.x, along * along.y, along * along.z);
            sum += along * slope;
        }
        let scale = squares.x_axis.x + squares.y_axis.y + squares.z_axis.z;
        squares +=
            DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z) * scale;
        let descent = (squares.inverse() * -sum).normalize_or_zero();
        let here = self.surface.chart().bordered_place(from);
        let [to, start] = [here + step.as_dvec2(), here].map(|at| position(self.surface, at));
        let line = to? - start?;
        let line = (line - normal * line.dot(normal)).normalize_or_zero();
        Some(if descent.dot(line) > ALIKE { descent } else { line })
    }

    /// Returns the tangent vectors of the grid lines at a point, except those of length zero. Each comes with the
    /// derivative of the squared time since `zero_time` along it.
    fn lines(&self, point: usize, zero_time: f64) -> impl Iterator<Item = (DVec3, Option<f64>)> {
        let tangents = self.frame(point).tangents.unwrap_or_default();
        let slowness = self.slowness(point);
        let (noise, since) = (self.noise(point, zero_time), self.time(point) - zero_time);
        [Direction::South, Direction::East].into_iter().zip(tangents).filter_map(
            move |(to, line)| {
                let square = line.length_squared() * slowness * slowness;
                let samples = self.samples(point, to.vector(), zero_time);
                let slope = derivative(samples, (square, since), noise, 1.0);
                (square > 0.0).then_some((line, slope))
            },
        )
    }

    fn slowness(&self, point: usize) -> f64 {
        self.surface.slowness().map_or(1.0, |slowness| slowness[self.index(point)])
    }

    /// Returns the rounding of the squared time since `zero_time`.
    fn noise(&self, point: usize, zero_time: f64) -> f64 {
        let time = self.time(point);
        2.0 * (time - zero_time) * time.abs() * f64::from(f32::EPSILON)
    }

    /// Returns the back direction at a copy of the point `from`. The direction at `from` is `way`.
    ///
    /// Where the grid goes on over a seam, the step is converted to the rows and columns at the copy. Elsewhere the
    /// direction in space is the same at both copies. At a pole the path leaves from one copy only, and the directions
    /// at the other copies lead along the pole to that copy.
    fn at_copy(&self, from: usize, copy: usize, way: Way) -> Way {
        let Way::Along { step, to_source } = way else { return way };
        if from == copy {
            return way;
        }
        let (chart, step) = (self.surface.chart(), step.as_dvec2());
        let [there, here] = [from, copy].map(|point| chart.bordered_position(point));
        let in_space = || self.frame(copy).step(self.frame(from).in_space(step)?);
        let along =
            || (chart.bordered_place(from) - chart.bordered_place(copy)).normalize_or_zero();
        let step = self.surface.step_at_copy(there, here, step).or_else(in_space);
        Way::Along { step: step.unwrap_or_else(along).as_vec2(), to_source }
    }

    /// Returns the row-major index of a point.
    fn index(&self, point: usize) -> usize {
        self.surface.chart().index_of(point)
    }

    fn at_points<T: Send>(&self, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
        let chart = self.surface.chart();
        (0..chart.points()).into_par_iter().map(|index| of(chart.bordered_point(index))).collect()
    }

    fn is_reached(&self, point: usize) -> bool {
        self.times[point] < f32::FAR
    }

    fn time(&self, point: usize) -> f64 {
        self.times[point].into()
    }

    fn frame(&self, point: usize) -> Frame {
        let (row, col) = self.surface.chart().bordered_position(point);
        Frame::at_point(self.surface, row, col)
    }

    /// Returns the start time of each grid point's front: the time at its source, or at the last corner around which
    /// its path bends. Returns `None` if all fronts started at `start`.
    fn zero_times(&self, lines: &[Option<FirstLine>], start: f64) -> Option<Vec<f64>> {
        let chart = self.surface.chart();
        let initials: Vec<f64> = self.sources.iter().map(|source| source.initial()).collect();
        let is_corner = |index| self.paths.is_corner(chart.bordered_point(index));
        if initials.iter().all(|&initial| initial == start) && !(0..chart.points()).any(is_corner) {
            return None;
        }
        let index = |point: usize| self.index(self.copies.first(point));
        let mut zero_times = vec![start; chart.points()];
        for point in by_arrival(self.times) {
            let point = point as usize;
            let Some(line) = lines[self.index(point)] else { continue };
            let zero_time = match line.end {
                LineEnd::Source(source) => initials[source],
                LineEnd::Point(end)
                    if self.paths.is_corner(end) && self.bends(point, end, lines) =>
                {
                    self.time(end)
                }
                LineEnd::Point(end) => zero_times[index(end)],
                LineEnd::Edge(ends) => {
                    let [a, b] = ends;
                    zero_times[index(if self.times[a] <= self.times[b] { a } else { b })]
                }
            };
            zero_times[index(point)] = zero_time.min(self.time(point));
        }
        Some(zero_times)
    }

    /// Returns whether the path from a point to a corner turns at the corner.
    fn bends(&self, point: usize, corner: usize, lines: &[Option<FirstLine>]) -> bool {
        let chart = self.surface.chart();
        // Beyond a seam, rows and columns may run in other directions. So a line that leaves from another copy of the
        // corner is not compared.
        let next = lines[self.index(corner)].filter(|next| next.from == corner);
        let Some(next) = next else { return false };
        let at = chart.bordered_place(corner);
        let (before, after) = (at - chart.bordered_place(point), next.to - at);
        after != DVec2::ZERO && self.frame(corner).cosine(before, after) < BENT
    }

    /// Returns the back direction of a point, and the copy of the point from which the path leaves.
    fn way(&self, point: usize, line: Option<FirstLine>, zero_time: f64) -> (usize, Way) {
        let chart = self.surface.chart();
        let Some(FirstLine { from, to, end }) = line else {
            // No line descends where points coincide, or from a minimum that rounding makes.
            let Some([from, next]) = self.paths.first_of_detour(point) else {
                return (point, Way::AtSource);
            };
            let step = (chart.bordered_place(next) - chart.bordered_place(from)).as_vec2();
            return (from, Way::Along { step, to_source: false });
        };
        let step = to - chart.bordered_place(from);
        if step == DVec2::ZERO {
            return (from, Way::AtSource);
        }
        let to_corner = matches!(end, LineEnd::Point(end) if self.paths.is_corner(end));
        let tangent = match end {
            LineEnd::Source(_) => None,
            _ if to_corner || self.paths.is_beside_source(from) => None,
            _ => self.gradient(from, step, zero_time),
        };
        let tangent = tangent.or_else(|| self.tangent_of_line(from, to));
        let way = Way::Along {
            step: tangent.unwrap_or(step).as_vec2(),
            to_source: matches!(end, LineEnd::Source(_)),
        };
        (from, way)
    }

    /// Returns the step with which the straight line in space to the place `to` leaves a point. Returns `None` unless
    /// the surface is glued and lies in space. Beside a pole such a line is far from straight in rows and columns.
    fn tangent_of_line(&self, point: usize, to: DVec2) -> Option<DVec2> {
        if !self.surface.is_glued() || !self.surface.geometry().is_in_space() {
            return None;
        }
        let here = position(self.surface, self.surface.chart().bordered_place(point))?;
        self.frame(point).step(position(self.surface, to)? - here)
    }

    /// Returns the direction of steepest descent at a point as a step of rows and columns, if the map is
    /// smooth there and the direction is close to that of `line`.
    fn gradient(&self, point: usize, line: DVec2, zero_time: f64) -> Option<DVec2> {
        let frame = self.frame(point);
        let (slowness, noise) = (self.slowness(point), self.noise(point, zero_time));
        let since = self.time(point) - zero_time;
        // In sheared cells, the nearest points lie along other steps than rows and columns.
        let [a, b] = reduced_basis(frame.metric);
        let steps = DMat2::from_cols(a, b);
        let toward = steps.inverse() * line;
        let along = |step: DVec2, toward: f64| {
            let samples = self.samples(point, step, zero_time);
            let square = step.dot(frame.metric * step);
            derivative(samples, (square * slowness * slowness, since), noise, toward)
        };
        let slopes = DVec2::new(along(a, toward.x)?, along(b, toward.y)?);
        let gradient = steps.transpose().inverse() * slopes;
        let step = -(frame.metric.inverse() * gradient);
        let length = frame.length(step) / (2.0 * since * slowness);
        let fits = (length - 1.0).abs() < OFF_LENGTH && frame.cosine(step, line) > ALIKE;
        fits.then_some(step / step.length())
    }

    /// Returns the squared times since `zero_time` at points that follow one another by a step of rows and columns, up to
    /// the first point that is not reached. The line of points goes on over seams where the grid does.
    fn samples(&self, point: usize, step: DVec2, zero_time: f64) -> Samples {
        let (chart, mut samples) = (self.surface.chart(), Samples::default());
        let (row, col) = chart.bordered_position(point);
        let along = |k: isize| {
            let (down, right) = (step.x as isize, step.y as isize);
            let (row, col) =
                self.surface.continued(row as isize + k * down, col as isize + k * right)?;
            Some(chart.bordered(row, col)).filter(|&at| self.is_reached(at))
        };
        for side in [1, -1] {
            for k in (0..=SIDE as isize).map(|k| side * k) {
                let Some(at) = along(k) else { break };
                samples[(SIDE as isize + k) as usize] = Some((self.time(at) - zero_time).powi(2));
            }
        }
        samples
    }
}
