//! Pulls paths taut around the corners of holes.
//!
//! Behind a corner around which shortest paths bend, arrival times grow with the distance from the corner as
//! from a source. But the time that is subtracted before squaring is not the time at the corner, and cubics
//! do not reproduce the tip of a cone. In the last cells before the corner a traced path deviates by some
//! hundredths of a cell. At each corner the path is therefore too long by a fraction of a cell, which is an
//! error of first order.
//!
//! So a path that passes a corner is led through the corner, on lines that are straight in rows and columns,
//! if that makes it shorter as measured in the cells' own lengths. These lines are lengthened while that
//! saves more. On a flat floor they reach from corner to corner and are exact. On a curved surface a line is
//! longer than the shortest path by an amount that grows with the third power of the line's length, so it
//! replaces only the cells near the corner. Further away the interpolation by cubics is more accurate: its
//! error falls with the sixth power of the distance from the corner.

use std::sync::Arc;

use glam::DVec2;

use super::cell::CellLengths;
use super::linked_path::LinkedPath;
use super::tracer::Tracer;
use geosweep_surface::{corner_weights, grid_crossings};

/// The number of vertices on each side of a corner that decide whether the path is led through the corner.
const NEAR: usize = 8;
/// The smallest saving, as a fraction of the length. Smaller ones are ignored, since edges are measured in
/// single precision.
const LEAST: f64 = 1e-7;
/// The distance, in cells, up to which a place counts as lying on a grid line, and two places count as one.
const ON_LINE: f64 = 1e-9;

/// A straight line between a corner and a vertex before or after it.
#[derive(Clone, Copy, Debug)]
struct CornerLine {
    /// The index of the vertex.
    end: usize,
    length: f64,
    /// The length of the part of the path that the line replaces: from the vertex nearest to the corner on
    /// that side to the vertex `end`.
    way: f64,
}

impl CornerLine {
    fn saves(&self) -> f64 {
        self.way - self.length
    }
}

/// One or two straight lines that are shorter than a part of a path.
struct Shortcut {
    /// The indices of the vertices at both ends of that part.
    ends: [usize; 2],
    /// The corner at which the shortcut bends, if it does.
    corner: Option<DVec2>,
    saves: f64,
}

/// A shared path that has been appended to another path.
struct Shared {
    rest: Arc<LinkedPath>,
    /// The number of vertices at the end of the path that still belong to the shared path.
    left: usize,
}

/// A path that passes a corner.
struct BesideCorner<'a> {
    tracer: &'a Tracer<'a>,
    vertices: &'a [DVec2],
    corner: DVec2,
}

impl BesideCorner<'_> {
    /// Returns the straight lines through the corner, or past it, if they save anything. The path is beside
    /// the corner from the vertex `first` on. Only the part after the vertex `fixed` changes.
    fn shortcut(&self, fixed: usize, first: usize) -> Option<Shortcut> {
        let (tracer, vertices) = (self.tracer, self.vertices);
        let end = vertices.len() - 1;
        if self.corner == vertices[end] {
            return None;
        }
        let is_beside = |&at: &DVec2| tracer.corners_beside(at).any(|corner| corner == self.corner);
        let beside = vertices[first..].iter().take_while(|at| is_beside(at)).count();
        let own = (first..first + beside).find(|&at| vertices[at] == self.corner);
        let nearest = [first.saturating_sub(1), (first + beside).min(end)];
        // Most paths pass the corner on a straight line.
        let around = nearest[0].saturating_sub(NEAR).max(fixed)..=(nearest[1] + NEAR).min(end);
        let chord = vertices[*around.start()].distance(vertices[*around.end()]);
        if vertices[first] != self.corner && extent(&vertices[around]) <= (1.0 + LEAST) * chord {
            return None;
        }
        let way = self.way(nearest[0], nearest[1])?;
        let [mut before, mut after] = [self.line(nearest[0])?, self.line(nearest[1])?];
        for counts in [[1, NEAR], [2 * NEAR, usize::MAX]] {
            before = self.lengthen(before, nearest[0], fixed, counts);
            after = self.lengthen(after, nearest[1], end, counts);
            if way + before.saves() + after.saves() < -LEAST * (before.length + after.length) {
                return None;
            }
        }
        let (replaced, over) = (way + before.way + after.way, before.length + after.length);
        // Maps that are late beside the border of a shadow lead paths to corners that the paths need not
        // touch.
        let past = tracer.straight(vertices[before.end], vertices[after.end]);
        let past = past.filter(|past| *past < (1.0 - LEAST) * over);
        let length = past.unwrap_or(over);
        // Straight lines from or to the corner stay as they are.
        let kept =
            |line: CornerLine| own.filter(|&own| past.is_none() && self.is_straight(own, line.end));
        let ends = [before, after].map(|line| kept(line).unwrap_or(line.end));
        // If both lines stay, there is nothing to change, whatever rounding seems to save.
        let changes = ends[0] < ends[1];
        (changes && length < (1.0 - LEAST) * replaced).then_some(Shortcut {
            ends,
            corner: past.is_none().then_some(self.corner),
            saves: replaced - length,
        })
    }

    /// Returns the line between the corner and a vertex.
    fn line(&self, end: usize) -> Option<CornerLine> {
        let to = self.vertices[end];
        let length = if to == self.corner { 0.0 } else { self.tracer.straight(self.corner, to)? };
        Some(CornerLine { end, length, way: 0.0 })
    }

    /// Lengthens a line on one side of the corner. Its end moves from the vertex `nearest`, the one nearest
    /// to the corner on that side, towards the vertex `last`.
    ///
    /// The end first moves to the vertex that is `counts[0]` vertices away from `nearest`. This number then
    /// doubles, up to `counts[1]`. The lengthening stops when the line would leave the surface or save less.
    fn lengthen(
        &self,
        mut line: CornerLine,
        nearest: usize,
        last: usize,
        counts: [usize; 2],
    ) -> CornerLine {
        let [mut count, most] = counts;
        let reach = nearest.abs_diff(last);
        while count <= most {
            let far = count.min(reach);
            let end = if last < nearest { nearest - far } else { nearest + far };
            // On a straight part of the path nothing is saved.
            if !self.is_straight(line.end, end) {
                let (Some(longer), Some(way)) = (self.line(end), self.way(line.end, end)) else {
                    break;
                };
                let longer = CornerLine { way: line.way + way, ..longer };
                if longer.saves() - line.saves() < -LEAST * longer.length {
                    break;
                }
                line = longer;
            }
            if count >= reach {
                break;
            }
            count *= 2;
        }
        line
    }

    /// Returns the length of the path between two vertices.
    fn way(&self, a: usize, b: usize) -> Option<f64> {
        let vertices = &self.vertices[a.min(b)..=a.max(b)];
        vertices.windows(2).map(|ends| self.tracer.across(ends[0], ends[1])).sum()
    }

    /// Returns whether the line to the vertex `a` and the path from there to the vertex `b` form one straight
    /// line.
    fn is_straight(&self, a: usize, b: usize) -> bool {
        let to = |end: usize| self.corner.distance(self.vertices[end]);
        to(a) + extent(&self.vertices[a.min(b)..=a.max(b)]) <= (1.0 + LEAST) * to(b)
    }
}

/// Returns the length of a path in grid coordinates (rows and columns).
fn extent(vertices: &[DVec2]) -> f64 {
    vertices.windows(2).map(|ends| ends[0].distance(ends[1])).sum()
}

impl Tracer<'_> {
    /// Pulls a path taut: leads it straight to and from the corners at which it bends. Over a slowness, vertices slide
    /// instead.
    pub(super) fn taut(&self, mut linked: LinkedPath) -> LinkedPath {
        if self.corners.is_none() || !self.seams.is_none() || self.edges.slowness().is_some() {
            return linked;
        }
        // The last corner through which the path has been led.
        let mut fixed = 0;
        let mut at = 0;
        let mut shared = None;
        while at < linked.vertices.len() {
            shared = self.join(&mut linked, at).or(shared);
            if let Some(shortcut) = self.shortcut(&linked.vertices, fixed, at) {
                if let Some(Shared { left, .. }) = &mut shared {
                    *left = (*left).min(linked.vertices.len() - shortcut.ends[1]);
                }
                let (bend, end) = self.take(&mut linked, &shortcut);
                fixed = bend.unwrap_or(fixed);
                at = bend.map_or(end, |bend| bend + 1);
            } else {
                let vertex = linked.vertices[at];
                if self.corners_beside(vertex).any(|corner| corner == vertex) {
                    fixed = at;
                }
                at += 1;
            }
            // The remaining vertices come from a shared path, which is taut already.
            if let Some(Shared { left, rest }) = &shared
                && fixed + left >= linked.vertices.len()
            {
                if *left == rest.vertices.len() && fixed + left == linked.vertices.len() {
                    linked.vertices.truncate(fixed + 1);
                    linked.rest = Some(rest.clone());
                }
                break;
            }
        }
        linked
    }

    /// Returns a shortcut at a corner that the path passes from the vertex `at` on. The path is fixed up to
    /// the vertex `fixed`.
    fn shortcut(&self, vertices: &[DVec2], fixed: usize, at: usize) -> Option<Shortcut> {
        let is_new = |corner: &DVec2| {
            at == 0 || self.corners_beside(vertices[at - 1]).all(|before| before != *corner)
        };
        let beside = |corner| BesideCorner { tracer: self, vertices, corner };
        let corners = self.corners_beside(vertices[at]).filter(is_new);
        corners.map(beside).find_map(|path| path.shortcut(fixed, at))
    }

    /// Replaces a part of a path by a shortcut. Returns the index of the vertex at which the shortcut bends,
    /// if it does, and the index of its end.
    fn take(&self, linked: &mut LinkedPath, shortcut: &Shortcut) -> (Option<usize>, usize) {
        let &Shortcut { ends: [first, last], corner, saves } = shortcut;
        let (from, to) = (linked.vertices[first], linked.vertices[last]);
        let mut way = self.cuts(from, corner.unwrap_or(to));
        let bend = corner.map(|corner| {
            let bend = if from == corner { first } else { first + 1 + way.len() };
            if from != corner && to != corner {
                way.push(corner);
            }
            way.extend(self.cuts(corner, to));
            bend
        });
        let end = first + 1 + way.len();
        linked.vertices.splice(first + 1..last, way);
        linked.length -= saves;
        (bend, end)
    }

    /// Appends the shared rest of a path if the rest begins at a corner beside the vertex `at`, so that the
    /// path can be pulled taut there.
    fn join(&self, linked: &mut LinkedPath, at: usize) -> Option<Shared> {
        let end = *linked.vertices.last()?;
        if self.corners_beside(linked.vertices[at]).all(|corner| corner != end) {
            return None;
        }
        let rest = linked.rest.take()?;
        linked.vertices.extend_from_slice(&rest.vertices[1..]);
        linked.rest = rest.rest.clone();
        Some(Shared { left: rest.vertices.len(), rest })
    }

    fn corners_beside(&self, at: DVec2) -> impl Iterator<Item = DVec2> {
        self.corners.beside(self.chart(), at)
    }

    /// Returns the places between `a` and `b` at which a line that is straight in rows and columns crosses
    /// the grid's lines.
    pub(super) fn cuts(&self, a: DVec2, b: DVec2) -> Vec<DVec2> {
        let on_line = |x: f64| if (x - x.round()).abs() < ON_LINE { x.round() } else { x };
        let mut cuts: Vec<_> = grid_crossings(a, b)
            .into_iter()
            .map(|share| a.lerp(b, share))
            .map(|at| DVec2::new(on_line(at.x), on_line(at.y)))
            .filter(|at| at.distance(a).min(at.distance(b)) > ON_LINE)
            .collect();
        cuts.dedup_by(|a, b| a.distance(*b) < ON_LINE);
        cuts
    }

    /// Returns the length of the line from `a` to `b` that is straight in rows and columns, if a wavefront
    /// reaches all of it.
    pub(super) fn straight(&self, a: DVec2, b: DVec2) -> Option<f64> {
        let cuts = grid_crossings(a, b);
        cuts.windows(2).map(|ends| self.across(a.lerp(b, ends[0]), a.lerp(b, ends[1]))).sum()
    }

    /// Returns the length of a line from `a` to `b` that lies in one cell, if a wavefront reaches it.
    fn across(&self, a: DVec2, b: DVec2) -> Option<f64> {
        let corner = (0.5 * (a + b)).floor();
        let north_west = self.chart().bordered_at(corner);
        let there = self.chart().bordered_corners(north_west).map(|point| self.is_reached(point));
        let weights = |at: DVec2| corner_weights(there, at - corner);
        let cell = CellLengths::new(self.edges, north_west);
        let [a, b] = [weights(a)?, weights(b)?];
        Some(cell.cost(cell.square(&a, &b), &a, &b))
    }
}
