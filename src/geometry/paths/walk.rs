//! Paths on their way from cell to cell, several side by side.

use std::ops::ControlFlow::{self, Break, Continue};

use glam::DVec2;

use super::ahead::{Ahead, Crossed, Entry, LANES};
use super::trace::{End, Field, Place, Stuck, Trace};

/// Bands of times from the latest start to the source: of 1200 x 1200 points each is some fifty
/// cells wide, so that nearby paths read the same few kilobytes. One band would take an eighth more.
const BANDS: f64 = 24.0;

/// A path under way.
struct Walk {
    /// Squares of times count from here.
    moment: f64,
    place: Place,
    /// Arrival time there.
    time: f64,
    /// The cell that it has come through.
    from: usize,
    /// Where it enters the next cell, and from which direction, if it has one.
    entry: Option<(Entry, DVec2)>,
    /// The earliest of the grid points passed, and left, not for a later one.
    lowest: f64,
    trace: Trace,
    /// From the start to each vertex.
    lengths: Vec<f64>,
    lines: usize,
    /// The path that squares of times since the smallest initial value lead on.
    before: Option<Trace>,
}

impl Walk {
    fn new(field: &Field, start: DVec2, moment: f64) -> Result<Self, Stuck> {
        let place = field.place(start).ok_or(Stuck(start))?;
        let time = match place {
            Place::Point(point) => field.time(point),
            _ => f64::INFINITY,
        };
        Ok(Self {
            moment,
            place,
            time,
            from: usize::MAX,
            entry: None,
            lowest: f64::INFINITY,
            trace: Trace { vertices: vec![start], time, length: 0.0, source: 0, initial: 0.0 },
            lengths: vec![0.0],
            lines: 0,
            before: None,
        })
    }

    /// Follows a line across the cell ahead.
    #[inline(always)]
    fn advance(&mut self, field: &Field, line: &Crossed) -> Result<(), Stuck> {
        self.count(field)?;
        self.trace.length += line.length;
        let (before, at) = (self.trace.vertices.last(), line.end.at());
        self.entry = before.map(|&before| (line.end, at - before));
        self.trace.vertices.push(at);
        self.lengths.push(self.trace.length);
        self.place = line.end.place(field.chart());
        (self.time, self.from) = (line.time, line.cell);
        Ok(())
    }

    /// Every line falls, so that none can be taken twice; a path that takes more lines than there
    /// are edges falls by less and less.
    fn count(&mut self, field: &Field) -> Result<(), Stuck> {
        self.lines += 1;
        let is_lost = self.lines > 4 * field.chart().points() + 64;
        if is_lost { Err(Stuck(field.position(self.place))) } else { Ok(()) }
    }

    /// Goes one line further, found by a search; at the end returns the source's initial value.
    fn go_on(&mut self, field: &Field) -> Result<Option<f64>, Stuck> {
        self.count(field)?;
        if let Place::Point(point) = self.place {
            self.lowest = self.lowest.min(field.time(point));
        }
        let Some(line) = field.line(self.moment, self.place, self.time, self.from) else {
            self.detour(field)?;
            self.head(field);
            return Ok(None);
        };
        if self.trace.time == f64::INFINITY {
            self.trace.time = line.arrival();
        }
        self.trace.length += line.length;
        match line.end {
            End::Source(source, at) => {
                // A path that starts at its source is a single place.
                if self.trace.vertices.last() != Some(&at) {
                    self.trace.vertices.push(at);
                }
                self.trace.source = source;
                self.trace.initial = line.time;
                return Ok(Some(line.time));
            }
            End::Place(next) => {
                self.trace.vertices.push(field.position(next));
                self.lengths.push(self.trace.length);
                (self.place, self.time, self.from) = (next, line.time, line.cell);
                self.head(field);
            }
        }
        Ok(None)
    }

    /// Where the path now enters a cell.
    fn head(&mut self, field: &Field) {
        self.entry = match self.trace.vertices[..] {
            [.., before, at] => {
                field.entry(self.place, self.from).map(|entry| (entry, at - before))
            }
            _ => None,
        };
    }

    /// Leaves a place from which no line falls.
    fn detour(&mut self, field: &Field) -> Result<(), Stuck> {
        let (trace, lengths) = (&mut self.trace, &mut self.lengths);
        let stuck = || Stuck(field.position(self.place));
        let point = field.lower_end(self.place);
        let detour = field.detour(point, self.lowest).ok_or_else(stuck)?;
        let at = field.position(Place::Point(point));
        // Back at a point that it has passed, a path goes on from there without the loop.
        if let Some(passed) = trace.vertices.iter().position(|vertex| *vertex == at) {
            trace.vertices.truncate(passed + 1);
            lengths.truncate(passed + 1);
            trace.length = lengths[passed];
        } else if let Place::Edge { first, step, share } = self.place {
            let length = field.length(first, first + step);
            trace.length += length * if point == first { share } else { 1.0 - share };
            trace.vertices.push(at);
        }
        lengths.resize(trace.vertices.len(), trace.length);
        for ends in detour.windows(2) {
            trace.length += field.length(ends[0], ends[1]);
            trace.vertices.push(field.position(Place::Point(ends[1])));
            lengths.push(trace.length);
        }
        let end = detour.last().copied().unwrap_or(point);
        (self.place, self.time) = (Place::Point(end), field.time(end));
        Ok(())
    }

    /// What comes after the end of a path: its trace, or a walk once more.
    ///
    /// Squares of times are smooth at a source if they count from its own initial value, which is
    /// known once a path has found it.
    fn end(
        self,
        field: &Field,
        end: Result<f64, Stuck>,
    ) -> ControlFlow<Result<Trace, Stuck>, Self> {
        let trace = match (self.before, end) {
            (None, Ok(initial)) if initial != field.start => {
                match Self::new(field, self.trace.vertices[0], initial) {
                    Ok(again) => return Continue(Self { before: Some(self.trace), ..again }),
                    Err(_) => Ok(self.trace),
                }
            }
            (Some(before), Ok(_)) if before.source == self.trace.source => Ok(self.trace),
            (Some(before), _) => Ok(before),
            (None, Ok(_)) => Ok(self.trace),
            (None, Err(stuck)) => Err(stuck),
        };
        Break(trace)
    }
}

impl Field<'_> {
    /// The paths from some places to their sources. Each is what it would be alone.
    ///
    /// They go down together, the latest first and a band of times after the other, so that what one
    /// of them has read is at hand for those beside it.
    pub(super) fn traces(&self, starts: &[DVec2]) -> Vec<Result<Trace, Stuck>> {
        let mut traces: Vec<_> = starts.iter().map(|&start| Err(Stuck(start))).collect();
        let walk = |&start| Walk::new(self, start, self.start).ok();
        let mut walks: Vec<_> = starts.iter().map(walk).collect();
        let (mut ahead, mut band) = (Ahead::default(), None);
        let time = |walk: &Walk| walk.time;
        while let Some(latest) = walks.iter().flatten().map(time).max_by(f64::total_cmp) {
            let until = if latest < f64::INFINITY {
                latest - *band.get_or_insert((latest - self.start) / BANDS)
            } else {
                latest
            };
            self.descend(&mut walks, until, &mut ahead, &mut traces);
        }
        traces
    }

    /// Takes those that are no earlier down to a time, or to their ends.
    fn descend(
        &self,
        walks: &mut [Option<Walk>],
        until: f64,
        ahead: &mut Ahead,
        traces: &mut [Result<Trace, Stuck>],
    ) {
        let is_late = |walk: &Option<Walk>| walk.as_ref().is_some_and(|walk| walk.time >= until);
        let late: Vec<usize> = (0..walks.len()).filter(|&path| is_late(&walks[path])).collect();
        let mut waiting = late.into_iter();
        let mut lanes: [Option<usize>; LANES] = std::array::from_fn(|_| waiting.next());
        while lanes.iter().any(Option::is_some) {
            for (lane, path) in lanes.iter().enumerate() {
                if let Some(Walk { entry: Some((entry, heading)), moment, time, .. }) =
                    path.and_then(|path| walks[path].as_ref())
                {
                    ahead.enter(lane, *entry, *heading, [*moment, *time]);
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
                    if let Some(end) = gone.transpose() {
                        match walks[path].take().map(|walk| walk.end(self, end)) {
                            Some(Continue(again)) => walks[path] = Some(again),
                            Some(Break(trace)) => traces[path] = trace,
                            None => {}
                        }
                    }
                }
                if !is_late(&walks[path]) {
                    *slot = waiting.next();
                }
            }
        }
    }
}
