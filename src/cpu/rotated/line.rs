//! Describes lines of points side by side, and the lengths of their edges. Lines are rows of the grid, or
//! columns of it that a [`super::panel::Panel`] has transposed into rows.

use std::ops::Range;

use super::span::{Span, part};
use super::window::Fronts;
use crate::cpu::behind::Behind;
use crate::cpu::scan::Scan;
use crate::lanes::prefetch;
use crate::surface::{EdgeLengths, Real};
use crate::update::{Carried, Kept};

/// Bordered arrays of lines while a scan updates them; [`Self::at`] and [`Self::on_surface`] say where a point
/// lies in them. Lines are counted from the first line of the arrays, points from the first one inside the
/// grid's border.
pub(in crate::cpu) struct GridLines<'a, R, C, G> {
    pub stride: usize,
    /// The neighbours behind a point, where lines are rows.
    pub behind: Behind,
    pub times: &'a mut [R],
    /// The data that fronts carry, and the data of the surface.
    pub carried: &'a mut [C],
    pub surface_data: &'a [G],
    /// Lengths of the edges to the next point, to the point on the line before, and on that line to the next
    /// and to the previous point. Empty where edges are not needed.
    pub edges: [&'a [R]; 4],
    /// Distance between lines of the surface's data, and the number of lines of them before the first line.
    pub surface: (usize, usize),
    pub place: LinesInGrid<'a, R, C>,
}

/// The position of lines in the grid.
pub(in crate::cpu) struct LinesInGrid<'a, R, C> {
    /// All edges of the surface.
    pub edges: &'a EdgeLengths<R>,
    /// The row or column, counted from the border, of the first of these lines.
    pub first: usize,
    /// Number of the grid's points before the first one of a line.
    pub before: usize,
    /// Where the fronts at other points are, unless these lines have all.
    pub beyond: Option<Beyond<'a, R, C>>,
}

/// Fronts at points that are not in some lines.
pub(in crate::cpu) struct Beyond<'a, R, C> {
    /// The scan that passes the lines.
    pub scan: Scan,
    /// The entries of each line that are in the lines' arrays, and the lines, both counted from the border of
    /// the grid.
    pub points: Range<usize>,
    pub lines: Range<usize>,
    /// The fronts at other points: as the scan sees them, and those of the whole grid.
    pub near: Option<Fronts<'a, R, C>>,
    pub far: Option<Fronts<'a, R, C>>,
}

impl<R: Real, C: Carried, G> GridLines<'_, R, C, G> {
    /// Returns part of a line together with the line behind it.
    pub(in crate::cpu) fn line(
        &mut self,
        line: usize,
        points: &Range<usize>,
        scan: Scan,
    ) -> ScanLine<'_, R, C, G> {
        let count = points.len();
        let behind = self.line_behind(line, scan);
        // From the point before the first to the one after the last.
        let around = |first: usize| first - 1..first + count + 1;
        let (first, there) = (self.at(line, points.start), around(self.at(behind, points.start)));
        let here = first..first + count;
        let on_surface = self.on_surface(line, points.start);
        let surface_there = around(self.on_surface(behind, points.start));
        let (times, times_behind) = here_and_there(self.times, here.clone(), there.clone());
        let (carried, carried_behind) = here_and_there(self.carried, here.clone(), there.clone());
        let next = [self.stride, self.surface.0].map(|stride| stride as isize);
        ScanLine {
            times,
            carried,
            surface_data: &self.surface_data[on_surface..][..count],
            times_behind,
            carried_behind,
            ground_behind: &self.surface_data[surface_there],
            edges: self.behind.edges().map(|slot| slot.row(self.edges, on_surface, count)),
            bases: self.behind.bases()[0].row(self.edges, on_surface, count + 1),
            next: if scan.is_forward() { next } else { next.map(|stride| -stride) },
        }
    }

    /// Returns the index of a point in the arrays of fronts.
    #[inline(always)]
    pub(in crate::cpu) fn at(&self, line: usize, point: usize) -> usize {
        line * self.stride + point + 1 - self.place.before
    }

    /// Returns the index of a point in the arrays of the surface's data.
    #[inline(always)]
    pub(in crate::cpu) fn on_surface(&self, line: usize, point: usize) -> usize {
        let (stride, before) = self.surface;
        (line + before) * stride + point + 1
    }

    /// Returns the index in these arrays of a row or column of the grid.
    pub(in crate::cpu) fn number(&self, line: usize) -> usize {
        line + 1 - self.place.first
    }

    pub(in crate::cpu) fn line_behind(&self, line: usize, scan: Scan) -> usize {
        if scan.is_forward() { line - 1 } else { line + 1 }
    }

    /// Returns the front at a point of the grid.
    pub(in crate::cpu) fn front(&self, point: usize) -> Kept<R, C> {
        let LinesInGrid { edges, first, before, beyond } = &self.place;
        let Some(Beyond { scan, points, lines, near, far }) = beyond else {
            return Kept { time: self.times[point], carried: self.carried[point] };
        };
        let chart = edges.chart();
        let entry = match u32::try_from(point).map(|point| chart.short_entry(point)) {
            Ok((row, col)) => (row as usize, col as usize),
            Err(_) => chart.entry(point),
        };
        let (line, at) = scan.lines().place(entry.0, entry.1);
        if lines.contains(&line) && points.contains(&at) {
            let place = (line - first) * self.stride + at - before;
            return Kept { time: self.times[place], carried: self.carried[place] };
        }
        let found = [near, far].into_iter().flatten().find_map(|fronts| fronts.at(entry));
        found.expect("a window has the fronts around it, and the grid has all")
    }

    /// Returns the row and column, counted from the border, of point `point` of a line.
    #[inline(always)]
    pub(in crate::cpu) fn position(&self, line: usize, point: usize, scan: Scan) -> [usize; 2] {
        scan.lines().place(self.place.first + line, point + 1).into()
    }
}

/// Returns two ranges of an array that do not overlap. The first one is mutable.
fn here_and_there<T>(array: &mut [T], here: Range<usize>, there: Range<usize>) -> (&mut [T], &[T]) {
    if there.start >= here.end {
        let (low, high) = array.split_at_mut(there.start);
        (&mut low[here], &high[..there.len()])
    } else {
        let (low, high) = array.split_at_mut(there.end);
        (&mut high[here.start - there.end..here.end - there.end], &low[there])
    }
}

/// A line of n points and the data that their update needs.
pub(in crate::cpu) struct ScanLine<'a, R, C, G> {
    /// Arrival times, data carried by fronts, and data of the surface, n of each.
    pub times: &'a mut [R],
    pub carried: &'a mut [C],
    pub surface_data: &'a [G],
    /// Data of the line that the scan has just passed, from the point before the first to the one after the
    /// last: n + 2 of each.
    pub times_behind: &'a [R],
    pub carried_behind: &'a [C],
    pub ground_behind: &'a [G],
    /// Lengths of the edges to the neighbours behind: the one before, the one beside, the one after.
    pub edges: [&'a [R]; 3],
    /// Lengths of the n + 1 edges between the points behind.
    pub bases: &'a [R],
    /// Offsets from a point to the line that is updated next, of the fronts and of the surface's data.
    pub next: [isize; 2],
}

impl<R: Real, C: Carried, G> ScanLine<'_, R, C, G> {
    /// Returns the span of `points` points from `start` on.
    #[inline(always)]
    pub(in crate::cpu) fn span(&self, start: usize, points: usize) -> Span<'_, R, C, G> {
        let bases = &self.bases[start..][..points + 1];
        Span {
            times: part(self.times, start, points),
            carried: part(self.carried, start, points),
            surface_data: part(self.surface_data, start, points),
            times_behind: threefold(self.times_behind, start, points),
            carried_behind: threefold(self.carried_behind, start, points),
            edges: [
                part(self.edges[0], start, points),
                part(self.edges[1], start, points),
                part(self.edges[2], start, points),
            ],
            bases: [&bases[..points], &bases[1..][..points]],
        }
    }

    /// Returns the surface data behind some points: before, beside and after each of them.
    #[inline(always)]
    pub(in crate::cpu) fn ground_behind(&self, start: usize, points: usize) -> [&[G]; 3] {
        threefold(self.ground_behind, start, points)
    }

    /// Prefetches the data that the update of the next line needs, from the point `start` on. The hardware
    /// prefetcher stays within a page, and a line is about as long as a page.
    #[inline(always)]
    pub(in crate::cpu) fn prefetch_next(&self, start: usize) {
        let [place, on_surface] = self.next.map(|next| next + start as isize);
        prefetch(self.times, place);
        self.edges.iter().for_each(|edges| prefetch(edges, on_surface));
        prefetch(self.bases, on_surface);
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
