//! Tells whether a straight line of the chart crosses a hole.

use glam::DVec2;

use geosweep_surface::{Chart, Surface};

/// The missing points of a surface, counted so that rectangles of points without any are found at once.
pub(in super::super) struct Holes {
    chart: Chart,
    /// The number of missing points above and left of each corner of the chart's (M + 1) x (N + 1) corners.
    before: Vec<u32>,
}

impl Holes {
    /// Returns `None` if no point is missing.
    pub(in super::super) fn of(surface: &Surface) -> Option<Self> {
        let chart = surface.chart();
        if surface.is_whole() {
            return None;
        }
        let width = chart.cols + 1;
        let mut before = vec![0; (chart.rows + 1) * width];
        for (row, col) in chart.places() {
            let corner = row * width + col;
            before[corner + width + 1] = before[corner + 1] + before[corner + width]
                - before[corner]
                + u32::from(!surface.has(row, col));
        }
        Some(Self { chart, before })
    }

    /// Returns whether a corner of a cell that the straight line between two places passes is missing.
    pub(in super::super) fn are_between(&self, a: DVec2, b: DVec2) -> bool {
        if !self.are_in(a, b) {
            return false;
        }
        // The line is cut where it crosses rows, or columns if these are fewer.
        let axis = usize::from((b - a).abs().x > (b - a).abs().y);
        let (first, last) = if a[axis] < b[axis] { (a, b) } else { (b, a) };
        let extent = last[axis] - first[axis];
        if extent < ON_LINE {
            return true;
        }
        let at = |line: f64| first.lerp(last, ((line - first[axis]) / extent).clamp(0.0, 1.0));
        let lines = first[axis].floor() as usize..(last[axis].ceil() as usize).max(1);
        lines.into_iter().any(|line| {
            let (from, to) = (at(line as f64), at((line + 1) as f64));
            self.are_in(from, to)
        })
    }

    /// Returns whether a corner of the cells that the rectangle between two places touches is missing.
    fn are_in(&self, a: DVec2, b: DVec2) -> bool {
        let [first, last] = [(a.min(b) + ON_LINE).floor(), (a.max(b) - ON_LINE).ceil()];
        let [top, left] = first.to_array().map(|at| at as usize);
        let bottom = (last.x as usize + 1).min(self.chart.rows);
        let right = (last.y as usize + 1).min(self.chart.cols);
        let at = |row: usize, col: usize| self.before[row * (self.chart.cols + 1) + col];
        at(bottom, right) + at(top, left) != at(top, right) + at(bottom, left)
    }
}

/// Rows and columns by which rounding may move a place off a line of the grid.
const ON_LINE: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use geosweep_surface::Spacing;

    fn surface(is_missing: impl Fn(usize, usize) -> bool) -> Surface {
        let chart = Chart { rows: 21, cols: 31 };
        let plane = Surface::from_heights(21, 31, vec![0.0; 21 * 31], Spacing::square(1.0));
        let mask: Vec<bool> = chart.places().map(|(row, col)| !is_missing(row, col)).collect();
        plane.unwrap().with_mask(&mask).unwrap()
    }

    #[test]
    fn a_line_past_a_hole_is_free() {
        let holes = Holes::of(&surface(|row, col| row == 10 && (9..20).contains(&col))).unwrap();
        let are_between = |a: [f64; 2], b: [f64; 2]| {
            let found = holes.are_between(a.into(), b.into());
            assert_eq!(holes.are_between(b.into(), a.into()), found, "{a:?} {b:?}");
            found
        };
        // Lines through the hole, along it, and through a cell that lacks a corner.
        assert!(are_between([5.0, 15.0], [15.0, 15.0]) && are_between([10.0, 0.0], [10.0, 30.0]));
        assert!(are_between([10.0, 15.0], [10.0, 15.0]) && are_between([9.5, 3.0], [9.5, 25.0]));
        assert!(are_between([2.0, 8.5], [18.0, 8.5]) && are_between([9.0, 20.0], [11.0, 19.5]));
        // Lines beside the hole, though it lies in the rectangle between both ends.
        assert!(!are_between([0.0, 2.0], [20.0, 8.0]) && !are_between([9.0, 0.0], [9.0, 30.0]));
        assert!(!are_between([20.0, 8.0], [4.0, 8.0]) && !are_between([0.0, 0.0], [8.5, 30.0]));
        assert!(!are_between([9.0, 12.0], [9.0, 12.0]));
    }

    /// The cells of a line are those in which some of many places on it lie.
    #[test]
    fn lines_meet_the_cells_that_they_pass() {
        let surface = surface(|row, col| (row * 7 + col * 11) % 53 == 5);
        let holes = Holes::of(&surface).unwrap();
        let mut hidden = 0;
        for k in 0..400 {
            let part = |by: f64, of: f64| (by * f64::from(k)).fract() * of;
            let a = DVec2::new(part(0.618, 20.0), part(0.414, 30.0));
            let b = DVec2::new(part(0.732, 20.0), part(0.236, 30.0));
            let is_missing = |at: DVec2| {
                let span =
                    |at: f64| [(at + ON_LINE).floor() as usize, (at - ON_LINE).ceil() as usize];
                let [rows, cols] = at.to_array().map(span);
                rows.iter().any(|&row| cols.iter().any(|&col| !surface.has(row, col)))
            };
            let found = (0..=20_000).any(|n| is_missing(a.lerp(b, f64::from(n) / 20_000.0)));
            // A line may pass a corner of a cell between two of the places.
            if found {
                assert!(holes.are_between(a, b), "{a} {b}");
            }
            hidden += usize::from(holes.are_between(a, b)) - usize::from(found);
        }
        assert!(hidden <= 4, "{hidden}");
    }

    #[test]
    fn whole_surfaces_have_none() {
        assert!(Holes::of(&surface(|_, _| false)).is_none());
    }
}
