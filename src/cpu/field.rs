//! Lines of points side by side, and the lengths between them: rows of the grid, or columns of it
//! that a [`super::panel::Panel`] has turned into rows.

use std::ops::Range;

use super::line::{Line, Times};
use super::line_update::{How, Update, Updated};
use crate::surface::Real;

/// Bordered arrays: point p of line l has index l * `stride` + p + 1, with lines counted from the
/// border and points from the first inside it. Curvatures are empty unless the wavefront is curved.
pub(super) struct Field<'a, R> {
    pub stride: usize,
    pub times: &'a mut [R],
    pub curvatures: &'a mut [R],
    pub gaussian: &'a [R],
    /// Lengths of the edges to the next point, to the line before, and there to the next and to
    /// the previous point.
    pub edges: [&'a [R]; 4],
}

impl<R: Real> Field<'_, R> {
    /// Updates points of a line from the line behind; see [`Update`].
    pub(super) fn update(
        &mut self,
        line: usize,
        points: Range<usize>,
        how: How,
        changed: &mut [bool],
    ) -> Updated<R::Bits> {
        let forward = how.scan.is_forward();
        let line_behind = if forward { line - 1 } else { line + 1 };
        let start = line * self.stride + points.start + 1;
        let here = start..start + points.len();
        // From the point before the first to the one after the last.
        let around = |line: usize| {
            let first = line * self.stride + points.start;
            first..first + points.len() + 2
        };
        let there = around(line_behind);

        let curved = how.wavefront.is_curved();
        let if_curved = |range: Range<usize>| if curved { range } else { 0..0 };
        let (times, behind) = here_and_there(self.times, here.clone(), there.clone());
        let (curvatures, curvatures_behind) =
            here_and_there(self.curvatures, if_curved(here.clone()), if_curved(there.clone()));
        let (edges, stride) = (self.edges, self.stride as isize);

        let line = Line {
            times: Times {
                here: times,
                behind,
                edges: edges_back(edges, self.stride, &here, forward),
                bases: &edges[0][there.start..there.end - 1],
            },
            curvatures,
            gaussian: &self.gaussian[if_curved(here)],
            curvatures_behind,
            gaussian_behind: &self.gaussian[if_curved(there)],
            next: if forward { stride } else { -stride },
        };
        how.instructions.run(Update { line, how, changed })
    }
}

/// Lengths of the edges of points to the line behind: to the point before, beside and after.
fn edges_back<'a, R>(
    [_, up, up_next, up_previous]: [&'a [R]; 4],
    stride: usize,
    points: &Range<usize>,
    forward: bool,
) -> [&'a [R]; 3] {
    if forward {
        return [&up_previous[points.clone()], &up[points.clone()], &up_next[points.clone()]];
    }
    let first = points.start + stride;
    [(up_next, first - 1), (up, first), (up_previous, first + 1)]
        .map(|(edges, first)| &edges[first..][..points.len()])
}

/// Two ranges of an array that do not overlap, the first for writing.
fn here_and_there<R>(array: &mut [R], here: Range<usize>, there: Range<usize>) -> (&mut [R], &[R]) {
    if there.start >= here.end {
        let (low, high) = array.split_at_mut(there.start);
        (&mut low[here], &high[..there.len()])
    } else {
        let (low, high) = array.split_at_mut(there.end);
        (&mut high[here.start - there.end..here.end - there.end], &low[there])
    }
}
