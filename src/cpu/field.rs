//! Lines of points side by side, and the lengths between them: rows of the grid, or columns of it
//! that a [`super::panel::Panel`] has turned into rows.

use std::ops::Range;

use super::line::{How, Line, Times, Update, Updated};
use crate::surface::Real;
use crate::update::Wavefront;

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
        let first = line_behind * self.stride + points.start;
        let there = first..first + points.len() + 2;

        let curved = how.wavefront == Wavefront::Curved;
        let if_curved = |range: &Range<usize>| if curved { range.clone() } else { 0..0 };
        let (bent_here, bent_there) = (if_curved(&here), if_curved(&there));
        let (times, behind) = here_and_there(self.times, here.clone(), there.clone());
        let (curvatures, curvatures_behind) =
            here_and_there(self.curvatures, bent_here.clone(), bent_there.clone());

        let [next, up, up_next, up_previous] = self.edges;
        let shifted = |by: usize| first + by..first + by + points.len();
        let edges = if forward {
            [&up_previous[here.clone()], &up[here.clone()], &up_next[here]]
        } else {
            [&up_next[shifted(0)], &up[shifted(1)], &up_previous[shifted(2)]]
        };
        let line = Line {
            times: Times {
                here: times,
                behind,
                edges,
                bases: &next[first..first + points.len() + 1],
            },
            curvatures,
            gaussian: &self.gaussian[bent_here],
            curvatures_behind,
            gaussian_behind: &self.gaussian[bent_there],
        };
        how.instructions.run(Update { line, how, changed })
    }
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
