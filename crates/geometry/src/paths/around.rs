//! Shortens paths that start where wavefronts meet, with a map of the surroundings of the start.
//!
//! Beside the cut locus some values of the map come from the wavefront on the other side and are too early. A
//! path that starts there therefore runs along the cut locus and becomes too long. A few cells further on,
//! the shortest path has left the cut locus: shortest paths lead away from it to one side or the other, and
//! no path from elsewhere comes near it.
//!
//! So if a path is longer than the map's value, a map of the distances from the path's start is computed. It
//! gives the shortest paths to places some cells away. From those places the path is traced further on the
//! original map.

use std::iter::once;

use glam::DVec2;

use super::corners::Corners;
use super::goals::Goals;
use super::linked_path::{LinkedPath, SharedParts};
use super::place::Place;
use super::seams::SourcePart;
use super::tracer::Tracer;
use crate::copies::Copies;
use geosweep_cpu::RotatedScan;
use geosweep_surface::Stop;
use geosweep_surface::update::Wavefront;
use geosweep_surface::{Block, EdgeLengths, Seed, Sources};

/// The relative excess over the map's value up to which a path is accepted: a quarter of the tolerated error.
const TOO_LONG: f64 = 5e-4;
/// The extent of the map around a start, in cells.
const REACH: usize = 16;
/// The number of places on the map's rim from which the rest of the path is traced.
const TRIED: usize = 12;
/// The offsets, in cells, of further places that are tried beside the best of these places.
const BESIDE: [f64; 6] = [-0.75, -0.5, -0.25, 0.25, 0.5, 0.75];
/// The condition on which the solver stops: convergence to about the rounding of single precision.
const STOP: Stop = Stop::within(1e-6).or_after(100);

/// Returns places on the outermost lines of a block beside the point `at`, which lies on such a line. All
/// places are in the rows and columns of the block.
fn beside(block: &Block, at: DVec2) -> impl Iterator<Item = DVec2> {
    let chart = block.chart();
    let is_row = at.x == 0.0 || at.x == chart.last().0 as f64;
    let along = if is_row { DVec2::Y } else { DVec2::X };
    let places = BESIDE.into_iter().map(move |share| at + share * along);
    places.filter(move |&place| chart.holds(place))
}

/// A path that passes through the place `at` of a window.
pub struct Way {
    at: DVec2,
    /// The path from `at` back to the start, in the window.
    first: LinkedPath,
    rest: LinkedPath,
}

impl Way {
    fn time(&self) -> f64 {
        self.first.length + self.rest.arrival()
    }
}

impl LinkedPath {
    /// Returns the arrival time at the start along this path.
    fn arrival(&self) -> f64 {
        self.initial + self.length
    }

    pub(super) fn is_too_long(&self) -> bool {
        self.length > (1.0 + TOO_LONG) * (self.time - self.initial)
    }
}

impl Tracer<'_> {
    /// Returns `trace`, or a shorter path from the same start if `trace` is longer than the map's value.
    pub(super) fn shortest(&self, trace: LinkedPath) -> LinkedPath {
        if !trace.is_too_long() {
            return trace;
        }
        match self.around(&trace).map(|other| self.slid(self.taut(other).whole())) {
            Some(other) if other.arrival() < trace.arrival() => other,
            _ => trace,
        }
    }

    /// Returns the shortest path that crosses the rim of a window around the start of `trace`. Returns `None`
    /// if the source lies in the window.
    fn around(&self, trace: &LinkedPath) -> Option<LinkedPath> {
        let (&start, &end) = (trace.vertices.first()?, trace.vertices.last()?);
        let chart = self.chart();
        let window = chart.around_place(start, REACH);
        if window.holds(end) {
            return None;
        }
        let edges = self.edges.window(&window);
        let near = self.near(start, &window, &edges)?;
        let time = |(row, col): (usize, usize)| {
            let (r, c) = window.local((row, col));
            near.time(near.chart().bordered(r, c)) + self.time(chart.bordered(row, col))
        };
        let mut rim: Vec<_> = window.rim(chart).map(|at| (time(at), window.local(at))).collect();
        rim.retain(|(time, _)| *time < f64::INFINITY);
        rim.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        rim.truncate(TRIED);
        let points: Vec<_> =
            rim.iter().map(|&(_, (r, c))| DVec2::new(r as f64, c as f64)).collect();
        let by_point = self.over(&near, window.origin(), &points)?;
        let places: Vec<_> = beside(&window, by_point.at).collect();
        let by_place = self.over(&near, window.origin(), &places);
        let Way { at: _, first, rest } = match by_place {
            Some(way) if way.time() < by_point.time() => way,
            _ => by_point,
        };
        // The start within the window is skipped, since the caller's start is exact.
        let back = first.vertices.iter().rev().skip(1).map(|&vertex| vertex + window.origin());
        Some(LinkedPath {
            vertices: once(start).chain(back).chain(rest.vertices.into_iter().skip(1)).collect(),
            length: first.length + rest.length,
            time: trace.time,
            ..rest
        })
    }

    /// Returns the shortest path through one of several places in a window.
    fn over(&self, near: &Tracer, origin: DVec2, places: &[DVec2]) -> Option<Way> {
        let starts: Vec<_> = places.iter().map(|&at| at + origin).collect();
        let ways = near.traces(places).into_iter().zip(self.traces(&starts)).zip(places);
        ways.filter_map(|((first, rest), &at)| {
            Some(Way { at, first: first.ok()?, rest: rest.ok()? })
        })
        .min_by(|a, b| a.time().total_cmp(&b.time()))
    }

    /// Computes the map of the distances from the place `start` within a window.
    fn near<'a>(
        &self,
        start: DVec2,
        window: &Block,
        edges: &'a EdgeLengths<f32>,
    ) -> Option<Tracer<'a>> {
        let at = start - window.origin();
        let local = |point| window.local(self.chart().bordered_position(point));
        let seeds: Vec<_> = match self.place(start)? {
            Place::Point(point) => {
                let (row, col) = local(point);
                vec![Seed::at_source(row, col, 0.0)]
            }
            place => self
                .corners(place)
                .map(|(point, away)| {
                    let (row, col) = local(point);
                    let curvature = (1.0 / away).min(Seed::AT_SOURCE);
                    Seed {
                        row,
                        col,
                        time: away,
                        curvature,
                        from: None,
                        origin: None,
                        exact: false,
                        heading: geosweep_surface::Heading::Everywhere,
                        source: 0,
                    }
                })
                .collect(),
        };
        let mut solver = RotatedScan::new(edges, Wavefront::Curved);
        solver.solve(&seeds, STOP);
        let chart = window.chart();
        let times = chart.with_border(&solver.distances(), f32::INFINITY);
        let there = |point: usize| times[point] < f32::INFINITY;
        let part = |own| vec![SourcePart { ends: own, own }];
        let goals = Goals::new(chart, &Sources::point(at.x, at.y), there, part);
        Some(Tracer {
            edges,
            times,
            start: 0.0,
            goals,
            corners: Corners::default(),
            shortens: false,
            shared_parts: SharedParts::default(),
            seams: Copies::default(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PathTracer;
    use geosweep_surface::builtin::Builtin;

    /// A path with a detour is replaced by the straight one, and a straight path stays.
    #[test]
    fn a_detour_is_cut_short() {
        const POINTS: usize = 81;
        let surface = Builtin::Plane.surface(POINTS, POINTS).unwrap();
        let edges = EdgeLengths::new(&surface).unwrap();
        let (source, start) = (DVec2::new(5.0, 7.0), DVec2::new(60.25, 66.5));
        let sources = Sources::point(source.x, source.y);
        let map = Builtin::Plane.exact_distances(POINTS, POINTS, source.to_array()).unwrap();
        let map: Vec<_> = map.into_iter().map(|distance| distance as f32).collect();
        let paths = PathTracer::new(&surface, &edges, &sources, &map).unwrap();
        let exact = start.distance(source) / (POINTS - 1) as f64;
        let trace = |length| LinkedPath {
            vertices: vec![start, source],
            time: exact,
            length,
            source: 0,
            initial: 0.0,
            rest: None,
        };
        let kept = paths.tracer.shortest(trace((1.0 + 0.9 * TOO_LONG) * exact));
        assert_eq!(kept.vertices, [start, source]);
        let shorter = paths.tracer.shortest(trace(1.01 * exact));
        let (first, last) = (shorter.vertices[0], shorter.vertices[shorter.vertices.len() - 1]);
        assert_eq!((first, last), (start, source));
        assert!((shorter.length - exact).abs() < 1e-5 * exact, "{} {exact}", shorter.length);
        for vertex in &shorter.vertices[1..] {
            let on_line =
                (vertex.x - vertex.x.round()).abs().min((vertex.y - vertex.y.round()).abs());
            assert!(on_line < 1e-12, "{vertex}");
        }
    }
}
