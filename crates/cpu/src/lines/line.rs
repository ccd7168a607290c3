//! Adjacent lines of points, and the lengths of their edges. Lines are rows of the grid, or columns that a
//! [`Panel`](crate::rotated::panel::Panel) has transposed into rows.

use std::ops::Range;

use super::span::{Span, part};
use super::window::Fronts;
use crate::behind::Behind;
use crate::scan::Scan;
use geosweep_surface::lanes::prefetch;
use geosweep_surface::update::{Carried, StoredFront};
use geosweep_surface::{EdgeLengths, Real};

/// Bordered arrays of lines while a scan updates them. [`Self::place`] converts positions in the grid to positions in
/// these arrays. Lines are counted from the first line of the arrays, points from the first one inside the grid's
/// border.
pub(crate) struct GridLines<'a, R, C, G> {
    /// The neighbours behind a point, in arrays whose rows are the lines.
    pub behind: Behind,
    pub times: &'a mut [R],
    /// The data that fronts carry, and the data of the surface.
    pub carried: &'a mut [C],
    pub surface_data: &'a [G],
    /// Lengths of the edges from each point to the next point of its line, and to three points of the line before: the
    /// one beside it, the next and the previous one. Empty where edges are not needed.
    pub edges: [&'a [R]; 4],
    /// Layout of the surface's data: the distance in memory from a line to the next, and the number of its lines before
    /// the first line of the arrays of fronts.
    pub surface: (usize, usize),
    pub place: LinesInGrid<'a, R, C>,
}

/// The position of lines in the grid.
pub(crate) struct LinesInGrid<'a, R, C> {
    /// All edges of the surface.
    pub edges: &'a EdgeLengths<R>,
    /// The scan that passes the lines.
    pub scan: Scan,
    /// Distance between lines in the arrays of fronts.
    pub stride: usize,
    /// The row or column, counted from the border, of the first of these lines.
    pub first: usize,
    /// Number of the grid's points on a line before the first one in the arrays.
    pub before: usize,
    /// The fronts of the whole grid, if these lines lack some of its points.
    pub beyond: Option<Beyond<'a, R, C>>,
}

/// Fronts at points outside the arrays of some lines.
pub(crate) struct Beyond<'a, R, C> {
    /// Range of the points of each line in the arrays, and range of the lines. Both are counted from the border of the
    /// grid.
    pub points: Range<usize>,
    pub lines: Range<usize>,
    /// Fronts at all other points: first those in the scan's window, then those of the whole grid.
    pub near: Option<Fronts<'a, R, C>>,
    pub far: Option<Fronts<'a, R, C>>,
}

impl<'a, R: Real, C: Carried, G> GridLines<'a, R, C, G> {
    /// Returns the `points` of a line together with the points behind them. Edge lengths are included if `need_edges`
    /// is set.
    pub(crate) fn line(
        &mut self,
        line: usize,
        points: &Range<usize>,
        need_edges: bool,
    ) -> ScanLine<'_, 'a, R, C, G> {
        let count = points.len();
        let Self { behind, times, carried, surface_data, edges, place, .. } = self;
        let (stride, lines_before) = self.surface;
        let behind_it = place.scan.line_behind(line);
        // The first point and the one before it, counted from the border.
        let (before, first) = (points.start, points.start + 1);
        let at = |line: usize, point: usize| line * place.stride + point - place.before;
        let on_surface = |line: usize, point: usize| (line + lines_before) * stride + point;
        let here = on_surface(line, first);
        let next = [place.stride, stride].map(|stride| stride as isize);
        ScanLine {
            times,
            carried,
            here: at(line, first),
            behind: at(behind_it, before),
            points: count,
            surface_data: &surface_data[here..][..count],
            surface_behind: &surface_data[on_surface(behind_it, before)..][..count + 2],
            edges: match need_edges {
                true => behind.edges().map(|slot| slot.row(*edges, here, count)),
                false => [&[]; 3],
            },
            bases: match need_edges {
                true => behind.bases()[0].row(*edges, here, count + 1),
                false => &[],
            },
            next: if place.scan.is_forward() { next } else { next.map(|stride| -stride) },
            first: place.position(line, points.start),
            place,
        }
    }

    /// Returns the front at a point of the grid.
    pub(crate) fn front(&self, point: usize) -> StoredFront<R, C> {
        self.place.front((self.times, self.carried), point)
    }
}

impl<R: Real, C: Carried> LinesInGrid<'_, R, C> {
    /// Returns the index, among the lines of these arrays, of a row or column of the grid.
    pub(crate) fn number(&self, line: usize) -> usize {
        line + 1 - self.first
    }

    /// Returns the front at a point of the grid, given the lines' arrays.
    #[inline(always)]
    fn front(&self, (times, carried): (&[R], &[C]), point: usize) -> StoredFront<R, C> {
        let Self { edges, scan, stride, first, before, beyond } = self;
        let Some(Beyond { points, lines, near, far }) = beyond else {
            return StoredFront { time: times[point], carried: carried[point] };
        };
        let chart = edges.chart();
        let entry = match u32::try_from(point).map(|point| chart.short_entry(point)) {
            Ok((row, col)) => (row as usize, col as usize),
            Err(_) => chart.entry(point),
        };
        let (line, at) = scan.lines().place(entry.0, entry.1);
        if lines.contains(&line) && points.contains(&at) {
            let place = (line - first) * stride + at - before;
            return StoredFront { time: times[place], carried: carried[place] };
        }
        let found = [near, far].into_iter().flatten().find_map(|fronts| fronts.at(entry));
        found.expect("a window has the fronts around it, and the grid has all")
    }

    /// Returns the row and column, counted from the border, of point `point` of a line.
    #[inline(always)]
    pub(crate) fn position(&self, line: usize, point: usize) -> [usize; 2] {
        self.scan.lines().place(self.first + line, point + 1).into()
    }
}

/// A line of n points and the data that their update needs.
pub(crate) struct ScanLine<'l, 'g, R, C, G> {
    /// Arrival times and data carried by fronts, of all lines.
    times: &'l mut [R],
    carried: &'l mut [C],
    /// Indices in these arrays of the line's first point, and of the first of the n + 2 points behind the line.
    here: usize,
    behind: usize,
    /// The number of points, n.
    pub points: usize,
    /// Data of the surface at the n points, and at the n + 2 points behind: from the one before the first to
    /// the one after the last.
    surface_data: &'l [G],
    surface_behind: &'l [G],
    /// Lengths of the edges to the neighbours behind: the one before, the one beside, the one after.
    edges: [&'l [R]; 3],
    /// Lengths of the n + 1 edges between the points behind.
    bases: &'l [R],
    /// Offsets from a point to the one beside it on the line that is updated next: in the arrays of fronts, and in
    /// those of the surface's data.
    next: [isize; 2],
    /// Row and column of the first point, counted from the border.
    pub first: [usize; 2],
    pub place: &'l LinesInGrid<'g, R, C>,
}

impl<R: Real, C: Carried, G> ScanLine<'_, '_, R, C, G> {
    /// Returns the span of `points` points from `start` on.
    #[inline(always)]
    pub(crate) fn span(&self, start: usize, points: usize) -> Span<'_, R, C, G> {
        let bases = &self.bases[start..][..points + 1];
        Span {
            edges: [
                part(self.edges[0], start, points),
                part(self.edges[1], start, points),
                part(self.edges[2], start, points),
            ],
            bases: [&bases[..points], &bases[1..][..points]],
            ..self.span_without_edges(start, points)
        }
    }

    /// Returns the span of [`Self::span`] without lengths of edges.
    #[inline(always)]
    pub(crate) fn span_without_edges(&self, start: usize, points: usize) -> Span<'_, R, C, G> {
        Span {
            times: part(self.times, self.here + start, points),
            carried: part(self.carried, self.here + start, points),
            surface_data: part(self.surface_data, start, points),
            times_behind: threefold(self.times, self.behind + start, points),
            carried_behind: threefold(self.carried, self.behind + start, points),
            edges: [&[]; 3],
            bases: [&[]; 2],
        }
    }

    /// Returns the surface data behind some points: before, beside and after each of them.
    #[inline(always)]
    pub(crate) fn surface_behind(&self, start: usize, points: usize) -> [&[G]; 3] {
        threefold(self.surface_behind, start, points)
    }

    /// Replaces the fronts at the points from `start` on.
    #[inline(always)]
    pub(crate) fn set(&mut self, start: usize, times: &[R], carried: &[C]) {
        self.times[self.here + start..][..times.len()].copy_from_slice(times);
        if size_of::<C>() != 0 {
            self.carried[self.here + start..][..carried.len()].copy_from_slice(carried);
        }
    }

    /// Returns the front at a point of the grid. It is not inlined: callers query many points in turn, and each inlined
    /// call would load all fields that it reads.
    #[inline(never)]
    pub(crate) fn front(&self, point: usize) -> StoredFront<R, C> {
        self.place.front((self.times, self.carried), point)
    }

    /// Prefetches the data that the update of the next line needs, from the point `start` on. The hardware
    /// prefetcher stays within a page, and a line is about as long as a page.
    #[inline(always)]
    pub(crate) fn prefetch_next(&self, start: usize, needs_edges: bool) {
        let [place, on_surface] = self.next.map(|next| next + start as isize);
        let place = self.here as isize + place;
        prefetch(self.times, place);
        if needs_edges {
            self.edges.iter().for_each(|edges| prefetch(edges, on_surface));
            prefetch(self.bases, on_surface);
        }
        prefetch(self.carried, place);
        prefetch(self.surface_data, on_surface);
    }
}

/// Returns the entries behind points: before, beside and after each of them.
#[inline(always)]
fn threefold<T>(behind: &[T], start: usize, points: usize) -> [&[T]; 3] {
    if size_of::<T>() == 0 {
        return [behind; 3];
    }
    let behind = &behind[start..][..points + 2];
    [&behind[..points], &behind[1..][..points], &behind[2..][..points]]
}
