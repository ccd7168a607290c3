//! Finds the direction of the shortest path at each grid point.
//!
//! The first line of a traced path gives the direction to first order in the cell's size, and is right
//! wherever fronts meet and paths bend. Where the map is smooth, the gradient of the squared arrival time
//! gives it to fourth order. So the gradient is taken if it has the length that the eikonal equation demands
//! and agrees with the line, and the line otherwise.
//!
//! Squared times are counted from the time at which the front started: at the source, or behind the corner
//! of a hole at that corner. They are smooth there, as they are around a source.

use glam::{DVec2, Vec2};
use rayon::prelude::*;

use super::frame::Frame;
use super::stencil::{SIDE, Samples, derivative};
use crate::geometry::order::by_arrival;
use crate::geometry::paths::{FirstLine, LineEnd, PathTracer};
use crate::surface::{Direction, Real, Sources, Surface};

/// The way back from one grid point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Way {
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

/// A map with the paths through it.
pub(super) struct Ways<'a> {
    pub surface: &'a Surface,
    pub paths: &'a PathTracer<'a>,
    /// The arrival times in a bordered array, [`Real::FAR`] where no front arrives.
    pub times: &'a [f32],
    pub sources: &'a Sources,
}

impl Ways<'_> {
    /// Returns the way back at each grid point, row-major.
    pub(super) fn find(&self) -> Vec<Way> {
        let chart = self.surface.chart();
        let start = self.sources.start();
        let lines: Vec<Option<FirstLine>> = self.at_points(|point| {
            self.is_reached(point).then(|| self.paths.first_line(point, start))?
        });
        let moments = self.moments(&lines, start);
        let way = |index: usize| {
            let (row, col) = chart.position(index);
            let point = chart.bordered(row, col);
            if !self.is_reached(point) {
                return Way::Unreached;
            }
            let moment = moments.as_ref().map_or(start, |moments| moments[index]);
            let line = match lines[index] {
                line if moment == start => line,
                line => self.paths.first_line(point, moment).or(line),
            };
            self.way(point, line, moment)
        };
        (0..chart.points()).into_par_iter().map(way).collect()
    }

    fn at_points<T: Send>(&self, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
        let chart = self.surface.chart();
        let at = |index| {
            let (row, col) = chart.position(index);
            of(chart.bordered(row, col))
        };
        (0..chart.points()).into_par_iter().map(at).collect()
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

    /// Returns for each grid point when its front started: at its source, or at the last corner around which
    /// its path bends. Returns `None` if all fronts started at `start`.
    fn moments(&self, lines: &[Option<FirstLine>], start: f64) -> Option<Vec<f64>> {
        let chart = self.surface.chart();
        let initials: Vec<f64> = self.sources.iter().map(|source| source.initial()).collect();
        let is_corner = |index| {
            let (row, col) = chart.position(index);
            self.paths.is_corner(chart.bordered(row, col))
        };
        if initials.iter().all(|&initial| initial == start) && !(0..chart.points()).any(is_corner) {
            return None;
        }
        let index = |point: usize| {
            let (row, col) = chart.bordered_position(point);
            chart.index(row, col)
        };
        let mut moments = vec![start; chart.points()];
        for point in by_arrival(self.times) {
            let point = point as usize;
            let Some(line) = lines[index(point)] else { continue };
            let moment = match line.end {
                LineEnd::Source(source) => initials[source],
                LineEnd::Point(end)
                    if self.paths.is_corner(end) && self.bends(point, end, lines) =>
                {
                    self.time(end)
                }
                LineEnd::Point(end) => moments[index(end)],
                LineEnd::Edge(ends) => {
                    let [a, b] = ends;
                    moments[index(if self.times[a] <= self.times[b] { a } else { b })]
                }
            };
            moments[index(point)] = moment.min(self.time(point));
        }
        Some(moments)
    }

    /// Returns whether the path from a point to a corner turns at the corner.
    fn bends(&self, point: usize, corner: usize, lines: &[Option<FirstLine>]) -> bool {
        let chart = self.surface.chart();
        let (row, col) = chart.bordered_position(corner);
        let Some(next) = lines[chart.index(row, col)] else { return false };
        let at = chart.bordered_place(corner);
        let (before, after) = (at - chart.bordered_place(point), next.to - at);
        after != DVec2::ZERO && self.frame(corner).cosine(before, after) < BENT
    }

    fn way(&self, point: usize, line: Option<FirstLine>, moment: f64) -> Way {
        let chart = self.surface.chart();
        let here = chart.bordered_place(point);
        let Some(FirstLine { to, end }) = line else {
            // Points that coincide, and minima by rounding.
            let next = self.paths.first_of_detour(point);
            return next.map_or(Way::AtSource, |next| Way::Along {
                step: (chart.bordered_place(next) - here).as_vec2(),
                to_source: false,
            });
        };
        let step = to - here;
        if step == DVec2::ZERO {
            return Way::AtSource;
        }
        let to_corner = matches!(end, LineEnd::Point(end) if self.paths.is_corner(end));
        let tangent = match end {
            LineEnd::Source(_) => None,
            _ if to_corner || self.paths.is_beside_source(point) => None,
            _ => self.gradient(point, step, moment),
        };
        Way::Along {
            step: tangent.unwrap_or(step).as_vec2(),
            to_source: matches!(end, LineEnd::Source(_)),
        }
    }

    /// Returns the direction of steepest descent at a point as a step of rows and columns, if the map is
    /// smooth there and the direction is close to that of `line`.
    fn gradient(&self, point: usize, line: DVec2, moment: f64) -> Option<DVec2> {
        let frame = self.frame(point);
        let (row, col) = self.surface.chart().bordered_position(point);
        let index = self.surface.chart().index(row, col);
        let slowness = self.surface.slowness().map_or(1.0, |slowness| slowness[index]);
        let since = self.time(point) - moment;
        let noise = 2.0 * since * self.time(point).abs() * f64::from(f32::EPSILON);
        let along = |to: Direction, square: f64, toward: f64| {
            let samples = self.samples(point, to, moment);
            derivative(samples, square * slowness * slowness, noise, toward)
        };
        let gradient = DVec2::new(
            along(Direction::South, frame.metric.x_axis.x, line.x)?,
            along(Direction::East, frame.metric.y_axis.y, line.y)?,
        );
        let step = -(frame.metric.inverse() * gradient);
        let length = frame.length(step) / (2.0 * since * slowness);
        let fits = (length - 1.0).abs() < OFF_LENGTH && frame.cosine(step, line) > ALIKE;
        fits.then_some(step / step.length())
    }

    /// Returns the squared times since `moment` along a grid line, up to the first point that is not reached.
    fn samples(&self, point: usize, to: Direction, moment: f64) -> Samples {
        let mut samples = Samples::default();
        for side in [to, to.opposite()] {
            let mut at = point;
            for k in 0..=SIDE {
                if !self.is_reached(at) {
                    break;
                }
                let slot = if side == to { SIDE + k } else { SIDE - k };
                samples[slot] = Some((self.time(at) - moment).powi(2));
                at = self.surface.chart().beside(at, side);
            }
        }
        samples
    }
}
