//! Advances paths from cell to cell, several side by side.

use glam::DVec2;

use super::ahead::{Ahead, Crossed, LANES};
use super::entry::Entry;
use super::place::{Place, Stuck};
use super::search::End;
use super::tracer::Tracer;

/// The number of bands of times between the latest start and the source. At 1200 x 1200 points a band is some
/// fifty cells wide, so that nearby paths read the same few kilobytes. With a single band tracing takes an
/// eighth longer.
const BANDS: f64 = 24.0;

/// The traced part of a path, up to its end or its first corner.
#[derive(Debug)]
pub(super) struct Head {
    pub vertices: Vec<DVec2>,
    /// The arrival time at the start.
    pub time: f64,
    pub length: f64,
    pub end: HeadEnd,
}

/// The place at which the tracing of a path ends.
#[derive(Clone, Copy, Debug)]
pub(super) enum HeadEnd {
    Source {
        source: usize,
        /// The initial value of the source.
        initial: f64,
    },
    /// The corner of a hole, a point of the bordered array. From there on all paths are identical.
    Corner(usize),
}

/// A path that is being traced.
struct Walk {
    /// The time that is subtracted before times are squared.
    zero_time: f64,
    place: Place,
    /// The arrival time at the place.
    time: f64,
    /// The cell through which the path has come.
    from: usize,
    /// The entry into the next cell and the path's direction there. It is `None` unless the path is at a place on an
    /// edge.
    entry: Option<(Entry, DVec2)>,
    /// The earliest time of the grid points that the path has passed. The path does not go back to a later
    /// point.
    lowest: f64,
    /// The arrival time at the start.
    arrival: f64,
    vertices: Vec<DVec2>,
    length: f64,
    /// The length of the path from the start to each vertex.
    lengths: Vec<f64>,
    lines: usize,
}

impl Walk {
    fn new(tracer: &Tracer, start: DVec2, zero_time: f64) -> Result<Self, Stuck> {
        let place = tracer.place(start).ok_or(Stuck(start))?;
        let time = match place {
            Place::Point(point) => tracer.time(point),
            _ => f64::INFINITY,
        };
        Ok(Self {
            zero_time,
            place,
            time,
            from: usize::MAX,
            entry: None,
            lowest: f64::INFINITY,
            arrival: time,
            vertices: vec![start],
            length: 0.0,
            lengths: vec![0.0],
            lines: 0,
        })
    }

    /// Follows a line across the cell ahead.
    #[inline(always)]
    fn advance(&mut self, tracer: &Tracer, line: &Crossed) -> Result<(), Stuck> {
        self.count(tracer)?;
        self.length += line.length;
        let (before, at) = (self.vertices.last(), line.end.at());
        self.entry = before.map(|&before| (line.end, at - before));
        self.vertices.push(at);
        self.lengths.push(self.length);
        self.place = line.end.place(tracer.chart());
        (self.time, self.from) = (line.time, line.cell);
        Ok(())
    }

    /// Counts a line, and fails if there are too many. Every line descends, so none can be taken twice. A
    /// path with more lines than the grid has edges descends by less and less and is lost.
    fn count(&mut self, tracer: &Tracer) -> Result<(), Stuck> {
        self.lines += 1;
        let is_lost = self.lines > 4 * tracer.chart().points() + 64;
        if is_lost { Err(Stuck(tracer.at(self.place))) } else { Ok(()) }
    }

    /// Advances by one line, found by a search. Returns the end of the tracing, if it is reached.
    fn go_on(&mut self, tracer: &Tracer) -> Result<Option<HeadEnd>, Stuck> {
        self.count(tracer)?;
        if let Place::Point(point) = self.place {
            self.lowest = self.lowest.min(tracer.time(point));
        }
        let Some(line) = tracer.line(self.zero_time, self.place, self.time, self.from) else {
            self.detour(tracer)?;
            self.head(tracer);
            return Ok(None);
        };
        if self.arrival == f64::INFINITY {
            self.arrival = line.arrival();
        }
        if let Some(copy) = line.copy {
            self.vertices.push(tracer.at(copy));
            self.lengths.push(self.length);
        }
        self.length += line.length;
        match line.end {
            End::Source { source, at, own } => {
                if let Some(&from) = self.vertices.last() {
                    self.vertices.extend(tracer.cuts(from, at));
                }
                // A path that starts at its source has a single vertex.
                for at in [at, own] {
                    if self.vertices.last() != Some(&at) {
                        self.vertices.push(at);
                    }
                }
                Ok(Some(HeadEnd::Source { source, initial: line.time }))
            }
            End::Place(next) => {
                self.vertices.push(tracer.at(next));
                self.lengths.push(self.length);
                (self.place, self.time, self.from) = (next, line.time, line.cell);
                self.head(tracer);
                match next {
                    Place::Point(point) if tracer.corners.is_corner(point) => {
                        Ok(Some(HeadEnd::Corner(point)))
                    }
                    _ => Ok(None),
                }
            }
        }
    }

    /// Updates the entry into the next cell.
    fn head(&mut self, tracer: &Tracer) {
        self.entry = match self.vertices[..] {
            [.., before, at] => {
                let entry = Entry::beyond(tracer.chart(), self.place, self.from);
                entry.map(|entry| (entry, at - before))
            }
            _ => None,
        };
    }

    /// Leaves a place from which no line descends, on a path along edges.
    fn detour(&mut self, tracer: &Tracer) -> Result<(), Stuck> {
        let (vertices, lengths) = (&mut self.vertices, &mut self.lengths);
        let stuck = || Stuck(tracer.at(self.place));
        let point = tracer.lower_end(self.place);
        let detour = tracer.detour(point, self.lowest).ok_or_else(stuck)?;
        let at = tracer.at(Place::Point(point));
        // If the path returns to a point that it has passed, the loop is removed.
        if let Some(passed) = vertices.iter().position(|vertex| *vertex == at) {
            vertices.truncate(passed + 1);
            lengths.truncate(passed + 1);
            self.length = lengths[passed];
        } else if let Place::Edge { first, along, share } = self.place {
            let length = tracer.length(first, tracer.chart().beside(first, along));
            self.length += length * if point == first { share } else { 1.0 - share };
            vertices.push(at);
        }
        lengths.resize(vertices.len(), self.length);
        for ends in detour.windows(2) {
            self.length += tracer.length(ends[0], ends[1]);
            vertices.push(tracer.at(Place::Point(ends[1])));
            lengths.push(self.length);
        }
        let end = detour.last().copied().unwrap_or(point);
        (self.place, self.time) = (Place::Point(end), tracer.time(end));
        Ok(())
    }

    fn end(self, end: HeadEnd) -> Head {
        let Self { vertices, arrival: time, length, .. } = self;
        Head { vertices, time, length, end }
    }
}

impl Tracer<'_> {
    /// Traces the paths from some places to the first corner of a hole that they reach, or to their sources.
    /// Each start comes with the time that is subtracted before times are squared. Each result is the same as
    /// if the path were traced alone.
    ///
    /// The paths descend together, the latest first, one band of times after another. Data read for one path
    /// is then in the cache for the paths beside it.
    pub(super) fn heads(&self, starts: &[(DVec2, f64)]) -> Vec<Result<Head, Stuck>> {
        let mut heads: Vec<_> = starts.iter().map(|&(start, _)| Err(Stuck(start))).collect();
        let walk = |&(start, zero_time): &_| Walk::new(self, start, zero_time).ok();
        let mut walks: Vec<_> = starts.iter().map(walk).collect();
        let (mut ahead, mut band) = (Ahead::default(), None);
        let time = |walk: &Walk| walk.time;
        while let Some(latest) = walks.iter().flatten().map(time).max_by(f64::total_cmp) {
            let until = if latest < f64::INFINITY {
                // At a source, the map can be earlier than the initial value by rounding.
                latest - *band.get_or_insert(((latest - self.start) / BANDS).max(0.0))
            } else {
                latest
            };
            self.descend(&mut walks, until, &mut ahead, &mut heads);
        }
        heads
    }

    /// Traces all paths whose time is `until` or later, to times before `until` or to their ends.
    fn descend(
        &self,
        walks: &mut [Option<Walk>],
        until: f64,
        ahead: &mut Ahead,
        heads: &mut [Result<Head, Stuck>],
    ) {
        let is_late = |walk: &Option<Walk>| walk.as_ref().is_some_and(|walk| walk.time >= until);
        let late: Vec<usize> = (0..walks.len()).filter(|&path| is_late(&walks[path])).collect();
        let mut waiting = late.into_iter();
        let mut lanes: [Option<usize>; LANES] = std::array::from_fn(|_| waiting.next());
        while lanes.iter().any(Option::is_some) {
            for (lane, path) in lanes.iter().enumerate() {
                if let Some(Walk { entry: Some((entry, heading)), zero_time, time, .. }) =
                    path.and_then(|path| walks[path].as_ref())
                {
                    ahead.enter(lane, *entry, *heading, [*zero_time, *time]);
                }
            }
            ahead.look(self);
            for (lane, slot) in lanes.iter_mut().enumerate() {
                let Some(path) = *slot else { continue };
                if let Some(walk) = &mut walks[path] {
                    let gone = match ahead.take(self.chart(), lane) {
                        Some(line) => walk.advance(self, &line).map(|()| None),
                        None => walk.go_on(self),
                    };
                    if let Some(end) = gone.transpose()
                        && let Some(walk) = walks[path].take()
                    {
                        heads[path] = end.map(|end| walk.end(end));
                    }
                }
                if !is_late(&walks[path]) {
                    *slot = waiting.next();
                }
            }
        }
    }
}
