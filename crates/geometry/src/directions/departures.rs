//! Finds the direction in which each point's shortest path leaves its source.
//!
//! If a source moves, the distance of a point changes by the cosine of the angle between the move and the
//! path's first direction (the first variation of length). So the derivative of half the squared distance by
//! the place of the source is the departure direction times the distance, with the opposite sign. The
//! derivative is computed from maps of the sources moved by one and two grid steps along rows and columns, in
//! double precision. This method needs no path, is of fourth order, and does not become less accurate with
//! the distance. It also holds behind holes.
//!
//! All sources move together. Where a move changes the front that arrives first, as at borders of regions and
//! at a cut locus, the squared distance has a kink ([`super::stencil`]).

use glam::{DMat2, DVec2};
use rayon::prelude::*;

use super::frame::Frame;
use super::stencil::{EVEN, Places, SIDE, Samples, derivative_beside_kink};
use crate::LogMapError;
use crate::NO_REGION;
use geosweep_cpu::{RotatedScan, seeds_for};
use geosweep_surface::update::{EngineKind, Setting, SourceKind, Wavefront};
use geosweep_surface::{
    DEFAULT_TOLERANCE_F64, Direction, EdgeLengths, Groups, Monitor, Real, Source, Sources, Stop,
    Surface,
};

/// The largest number of steps by which sources move to either side.
const MOVES: isize = 2;
/// The rounding of squared distances in double precision, as a fraction of them.
const ROUNDING: f64 = 1e-12;
/// The largest deviation of a source's places from even spacing, in steps, that counts as even. Where the grid's steps
/// change smoothly, differences by rows and columns are more accurate.
const UNEVEN: f64 = 0.05;
/// The largest relative difference between the derivative's length and the distance.
const OFF_LENGTH: f64 = 0.05;

/// A point source, with the surface around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    pub at: DVec2,
    pub initial: f64,
    pub frame: Frame,
    pub basis: [DVec2; 2],
    slowness: f64,
    /// The geodesic curvature of the grid lines along columns and rows, times the squared length of a step.
    turns: [f64; 2],
}

impl Start {
    /// Returns the source with the surface around it, or `None` if the surface has no tangent plane at the
    /// source.
    pub(super) fn new(surface: &Surface, at: DVec2, initial: f64) -> Option<Self> {
        let frame = Frame::at(surface, at);
        let slowness = surface.slowness().map_or(1.0, |slowness| {
            let index = |at: DVec2| surface.chart().index(at.x as usize, at.y as usize);
            let corners = [at.floor(), at.ceil()];
            // This is the bilinear mean of the four corners; missing corners do not count.
            let (mut sum, mut weights) = (0.0, 0.0);
            for row in corners.map(|corner| corner.x) {
                for col in corners.map(|corner| corner.y) {
                    let weight = (1.0 - (at.x - row).abs()) * (1.0 - (at.y - col).abs());
                    if surface.has(row as usize, col as usize) {
                        sum += weight * slowness[index(DVec2::new(row, col))];
                        weights += weight;
                    }
                }
            }
            sum / weights
        });
        let turns = AXES.map(|along| turn(surface, &frame, at, along));
        Some(Self { at, initial, frame, basis: frame.basis()?, slowness, turns })
    }

    /// Returns the places of the source as it moves along a grid line, in steps of the frame. On a grid with uneven
    /// steps, the squared distance as a function of the number of steps bends like the grid, which would look like a
    /// kink. As a function of the length it does not.
    fn places(&self, surface: &Surface, to: Direction) -> Places {
        let (mean, along) = (self.frame.length(to.vector()), to.vector());
        let at = self.at.dot(along);
        // The length of the step from one grid line to the next. Lines are counted along the move, over seams too.
        let step = |line: f64| {
            let middle = surface.continued_place(self.at + (line + 0.5 - at) * along)?;
            let across = DVec2::ONE - along;
            let end = |line: f64| surface.place(middle * across + line * along);
            let line = middle.dot(along);
            Some(end(line.floor())?.length_to(end(line.ceil())?))
        };
        let step = |line: f64| step(line).unwrap_or(mean) / mean;
        let (first, share) = (at.floor(), at.fract());
        let mut places = EVEN;
        let [mut back, mut ahead] = [0.0; 2];
        for k in 0..MOVES {
            let line = k as f64;
            ahead += (1.0 - share) * step(first + line) + share * step(first + line + 1.0);
            back += share * step(first - line) + (1.0 - share) * step(first - line - 1.0);
            places[SIDE + 1 + k as usize] = ahead;
            places[SIDE - 1 - k as usize] = -back;
        }
        let is_even = places.iter().zip(EVEN).all(|(at, even)| (at - even).abs() <= UNEVEN);
        if is_even { EVEN } else { places }
    }

    /// Returns whether the source stays on the surface when it moves by `steps` steps along a grid line.
    fn can_move(&self, surface: &Surface, to: Direction, steps: isize) -> bool {
        (1..=2 * steps.abs()).all(|half| {
            let moved = 0.5 * (half * steps.signum()) as f64 * to.vector();
            surface.continued_place(self.at + moved).is_some_and(|at| surface.contains(at))
        })
    }
}

/// Returns the geodesic curvature of a grid line at a place, times the squared length of a step, from the metric around
/// the place (Christoffel symbols). The result is 0 where the metric is not known on both sides.
fn turn(surface: &Surface, frame: &Frame, at: DVec2, along: Direction) -> f64 {
    let along = along.vector();
    let across = DVec2::ONE - along;
    let metric = |step: DVec2| {
        let place = surface.continued_place(at + step).filter(|&place| surface.contains(place))?;
        Some(Frame::at(surface, place).metric)
    };
    let change = |step: DVec2| Some(0.5 * (metric(step)? - metric(-step)?));
    let (Some(ahead), Some(aside)) = (change(along), change(across)) else { return 0.0 };
    // The acceleration of the line, by its scalar products with a step along it and a step across.
    let on_line = 0.5 * along.dot(ahead * along);
    let off_line = along.dot(ahead * across) - 0.5 * along.dot(aside * along);
    let square = along.dot(frame.metric * along);
    let mixed = along.dot(frame.metric * across);
    let normal = off_line - on_line * mixed / square;
    let height = (frame.metric.determinant() / square).sqrt();
    let turn = normal / height;
    if turn.is_finite() { turn.abs() } else { 0.0 }
}

/// Arrival times, row-major, less the smallest initial value of the sources.
type Times = Vec<f64>;

/// A solver for maps of sources that move.
pub(super) struct Departures<'a> {
    surface: &'a Surface,
    starts: &'a [Start],
    /// The smallest initial value.
    start: f64,
    /// The map of the sources before they move.
    pub times: Times,
    /// The maps of the moved sources: along columns and rows, by -2, -1, 1 and 2 steps.
    moved: [[Option<Times>; 2 * MOVES as usize + 1]; 2],
}

const AXES: [Direction; 2] = [Direction::South, Direction::East];

impl<'a> Departures<'a> {
    /// Computes the maps, unless `monitor` cancels them.
    pub(super) fn new(
        surface: &'a Surface,
        starts: &'a [Start],
        monitor: &Monitor,
    ) -> Result<Self, LogMapError> {
        let sources: Sources =
            starts.iter().map(|start| start.source(surface, DVec2::ZERO)).collect();
        let stop = Stop::settled(surface, DEFAULT_TOLERANCE_F64);
        let setting = Setting::new(surface, SourceKind::of(&sources), EngineKind::Map);
        // Directions are differences of maps, for which the curved front is smooth enough and faster.
        let wavefront = Wavefront::chosen(setting).without_rays();
        let grid = surface.solver_grid();
        let edges = EdgeLengths::<f64>::measured(grid.surface(), || {
            monitor.check().map_err(LogMapError::from)
        })?;
        let start = sources.start();
        let mut solver = RotatedScan::new(&edges, wavefront).with_monitor(monitor.clone());
        let mut solve = |sources: &Sources| -> Result<Times, LogMapError> {
            let mut seeds = sources.seeds_with_origins(surface)?;
            for seed in &mut seeds {
                seed.time -= start;
                seed.origin = seed.origin.map(|origin| origin.started_earlier(start));
            }
            let seeds =
                seeds_for(wavefront, surface, seeds).into_iter().map(|seed| grid.seed(seed));
            solver.solve(&seeds.collect::<Vec<_>>(), stop);
            monitor.check()?;
            Ok(grid.crop(solver.distances()))
        };
        let times = solve(&sources)?;
        let mut moved: [[Option<Times>; 2 * MOVES as usize + 1]; 2] = Default::default();
        for (axis, to) in AXES.into_iter().enumerate() {
            for steps in (-MOVES..=MOVES).filter(|&steps| steps != 0) {
                let there = starts.iter().filter(|start| start.can_move(surface, to, steps));
                let sources: Sources =
                    there.map(|start| start.source(surface, steps as f64 * to.vector())).collect();
                if sources.iter().next().is_some() {
                    moved[axis][(steps + MOVES) as usize] = Some(solve(&sources)?);
                }
            }
        }
        Ok(Self { surface, starts, start, times, moved })
    }

    /// Returns for each grid point the direction of departure in its source's basis, times the distance from
    /// the source. `labels` are the indices of the sources, [`NO_REGION`] where there is none; points without
    /// a source are NaN.
    pub(super) fn find(&self, labels: &[u32]) -> Vec<DVec2> {
        let can_move: Vec<[[bool; 2 * MOVES as usize + 1]; 2]> = self
            .starts
            .iter()
            .map(|start| {
                AXES.map(|to| {
                    std::array::from_fn(|k| start.can_move(self.surface, to, k as isize - MOVES))
                })
            })
            .collect();
        let places = |start: &Start| AXES.map(|to| start.places(self.surface, to));
        let places: Vec<[Places; 2]> = self.starts.iter().map(places).collect();
        let of = |index: usize| match labels[index] {
            NO_REGION => Some(DVec2::NAN),
            label => {
                let label = label as usize;
                self.departure(index, &self.starts[label], &can_move[label], &places[label])
            }
        };
        let found: Vec<Option<DVec2>> = (0..labels.len()).into_par_iter().map(of).collect();
        self.filled(found, labels)
    }

    /// Returns the distance of a point from its source.
    pub(super) fn distance(&self, index: usize, start: &Start) -> f64 {
        (self.times[index] + self.start - start.initial).max(0.0)
    }

    fn departure(
        &self,
        index: usize,
        start: &Start,
        can_move: &[[bool; 2 * MOVES as usize + 1]; 2],
        places: &[Places; 2],
    ) -> Option<DVec2> {
        let distance = self.distance(index, start);
        if distance == 0.0 {
            return Some(DVec2::ZERO);
        }
        let squared = |time: f64| (time + self.start - start.initial).powi(2);
        let along = |axis: usize, square: f64| {
            let mut samples = Samples::default();
            samples[SIDE] = Some(squared(self.times[index]));
            for (k, times) in self.moved[axis].iter().enumerate() {
                let there = times.as_ref().filter(|_| can_move[axis][k]);
                let time = there.map(|times| times[index]).filter(|&time| time < f64::FAR);
                if let Some(time) = time {
                    samples[k + SIDE - MOVES as usize] = Some(squared(time));
                }
            }
            let scale = square * start.slowness * start.slowness;
            // A source that moves along a bent line turns away from its straight lines. The second derivative of the
            // squared distance is the distance times twice the curvature, and turns with the line.
            let turn = start.turns[axis];
            let bend = 4.0 * distance * start.slowness * turn * turn / square.sqrt();
            let noise = ROUNDING * distance * distance;
            derivative_beside_kink(samples, places[axis], scale, bend, noise)
        };
        let DMat2 { x_axis: rows, y_axis: cols } = start.frame.metric;
        let change = DVec2::new(along(0, rows.x)?, along(1, cols.y)?);
        let departure = start.basis.map(|side| -0.5 * change.dot(side) / start.slowness);
        let departure = DVec2::from_array(departure);
        let length = departure.length();
        ((length / distance - 1.0).abs() < OFF_LENGTH).then_some(departure * (distance / length))
    }

    /// Assigns the mean direction of the neighbours to each point without a direction, that is, where two kinks meet.
    /// The step is repeated, so that directions spread from point to point. Copies of a point get the direction of the
    /// first copy.
    fn filled(&self, mut found: Vec<Option<DVec2>>, labels: &[u32]) -> Vec<DVec2> {
        let chart = self.surface.chart();
        let mut missing: Vec<usize> =
            (0..found.len()).filter(|&index| found[index].is_none()).collect();
        while !missing.is_empty() {
            let mean = |&index: &usize| {
                let (row, col) = chart.position(index);
                let beside = Direction::ALL.into_iter().filter_map(|to| {
                    let (row, col) = chart.neighbour(row, col, to)?;
                    let there = chart.index(row, col);
                    found[there].filter(|_| labels[there] == labels[index])
                });
                let sum: DVec2 = beside.map(|way| way.normalize_or_zero()).sum();
                let start = &self.starts[labels[index] as usize];
                let mean = sum.normalize_or_zero() * self.distance(index, start);
                (sum != DVec2::ZERO).then_some((index, mean))
            };
            let new: Vec<(usize, DVec2)> = missing.iter().filter_map(mean).collect();
            if new.is_empty() {
                break;
            }
            for (index, way) in new {
                found[index] = Some(way);
            }
            missing.retain(|&index| found[index].is_none());
        }
        for group in self.surface.copies().into_iter().flat_map(Groups::iter) {
            let first = found[group[0] as usize];
            group.iter().for_each(|&copy| found[copy as usize] = first);
        }
        found.into_iter().map(|way| way.unwrap_or(DVec2::NAN)).collect()
    }
}

impl Start {
    /// Returns the source moved by a step, which may lead over a seam.
    fn source(&self, surface: &Surface, moved: DVec2) -> Source {
        let at = self.at + moved;
        Source::Point { at: surface.continued_place(at).unwrap_or(at), initial: self.initial }
    }
}
