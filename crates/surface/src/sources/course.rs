//! Follows the course of a curve from vertex to vertex, also over seams of closed surfaces.

use glam::{DVec2, DVec3};

use super::Origin;
use crate::{Geometry, Sample, Surface};

/// The course of a curve through one of its vertices, as seen from one of its segments there.
#[derive(Clone, Copy, Debug)]
pub(super) enum Vertex {
    /// The curve ends or turns sharply: the front fans out as from a point.
    Corner,
    /// The curve bends gently. The value is its curvature vector, towards the centre of the bend.
    Smooth(DVec3),
}

/// Cosine of the largest turn at a smooth vertex, 30 degrees. At least one of the two segments there must also be
/// shorter than [`SMOOTH_SEGMENT`].
const SMOOTH_TURN_COSINE: f64 = 0.866;
/// Length in cells below which a segment counts as a sample of a smooth curve. A curve of longer segments is taken as a
/// polygon.
const SMOOTH_SEGMENT: f64 = 2.0;

/// A straight segment of a source, or a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// The places of both ends, and the course of the curve there.
    pub ends: [(DVec2, Vertex); 2],
    /// The straight source of which the segment is a part, if there is one.
    pub origin: Option<Origin>,
}

impl Segment {
    /// Returns a point source.
    pub(super) fn point(at: DVec2, origin: Origin) -> Self {
        Self { ends: [(at, Vertex::Corner); 2], origin: Some(origin) }
    }

    /// Returns this segment with its ends at other places.
    pub(super) fn between(self, places: [DVec2; 2]) -> Self {
        let [(_, from), (_, to)] = self.ends;
        Self { ends: [(places[0], from), (places[1], to)], ..self }
    }
}

/// A vertex of a curve: the place at which the curve arrives, and the place at which it goes on. They differ where
/// the curve jumps over a seam.
#[derive(Clone, Copy, Debug)]
struct Joint {
    into: DVec2,
    out: DVec2,
    /// The factors for rows and columns that convert a step after the vertex to the same step at the place of arrival.
    /// `None` if the grid does not go on there.
    turn: Option<DVec2>,
}

impl Joint {
    fn new(surface: &Surface, into: DVec2, out: DVec2) -> Self {
        let turn = if into == out { Some(DVec2::ONE) } else { surface.turn_at_copy(out, into) };
        Self { into, out, turn }
    }

    fn jumps(&self) -> bool {
        self.into != self.out
    }
}

/// Returns the parts of a curve between its jumps over seams, each as a list of segments.
pub(super) fn parts(surface: &Surface, vertices: &[DVec2], start: f64) -> Vec<Vec<Segment>> {
    let joints = joints(surface, vertices);
    let [Some(first), Some(last)] = [joints.first(), joints.last()] else { return Vec::new() };
    let courses = courses(surface, &joints);
    let origins: Vec<_> = straight_runs(&joints, &courses)
        .into_iter()
        .map(|run| run.map(|ends| Origin { ends, start }))
        .collect();
    let segment = |index: usize| {
        let (from, to) = (joints[index].out, joints[index + 1].into);
        let ends = [(from, courses[index][1]), (to, courses[index + 1][0])];
        Segment { ends, origin: origins[index] }
    };
    let numbers: Vec<_> = (0..origins.len()).collect();
    let between_jumps = numbers.chunk_by(|_, &next| !joints[next].jumps());
    let mut parts: Vec<Vec<_>> =
        between_jumps.map(|part| part.iter().map(|&index| segment(index)).collect()).collect();
    if parts.is_empty() {
        parts.push(Vec::new());
    }
    // An end of the curve that lies on a side of a cell also touches the cell beyond this side.
    if !is_closed(&joints) {
        let end = |at: DVec2, origin: Option<&Option<Origin>>| Segment {
            ends: [(at, Vertex::Corner); 2],
            origin: origin.copied().flatten(),
        };
        let of_last = parts.len() - 1;
        parts[of_last].insert(0, end(last.into, origins.last()));
        parts[0].insert(0, end(first.out, origins.first()));
    }
    parts
}

/// Returns the vertices of a curve. Successive places that are copies of one place are one vertex, and so are the ends
/// of a closed curve.
fn joints(surface: &Surface, vertices: &[DVec2]) -> Vec<Joint> {
    let runs = vertices.chunk_by(|&a, &b| surface.are_copies(a, b));
    let mut joints: Vec<_> =
        runs.map(|run| Joint::new(surface, run[0], run[run.len() - 1])).collect();
    if let [first, .., last] = &mut joints[..]
        && surface.are_copies(first.out, last.into)
    {
        let joint = Joint::new(surface, last.into, first.out);
        (*first, *last) = (joint, joint);
    }
    joints
}

fn is_closed(joints: &[Joint]) -> bool {
    match joints {
        [first, .., last] => {
            first.into == last.into && first.out == last.out || first.out == last.into
        }
        _ => false,
    }
}

/// Determines the course of a curve through its vertices, as seen from the segment before and from the one after. The
/// size of a bend follows from positions only. On a surface given by its metric, smooth vertices have a bend of zero,
/// as if the curve were straight there.
fn courses(surface: &Surface, joints: &[Joint]) -> Vec<[Vertex; 2]> {
    let closed = joints.len() > 2 && is_closed(joints);
    let last = joints.len().saturating_sub(1);
    let around = |index: usize| match index {
        _ if index > 0 && index < last => Some([index - 1, index, index + 1]),
        _ if closed => Some([last - 1, index, 1]),
        _ => None,
    };
    let course = |index| match around(index) {
        Some(around) => course(surface, around.map(|index| joints[index])),
        None => [Vertex::Corner; 2],
    };
    (0..joints.len()).map(course).collect()
}

/// Returns the course through the second of three vertices.
fn course(surface: &Surface, [before, here, after]: [Joint; 3]) -> [Vertex; 2] {
    let [into, out] = [here.into - before.out, after.into - here.out];
    // The step out, converted to the rows and columns at the place at which the curve arrives.
    let onwards = here.turn.map(|turn| turn * out);
    let is_short = |step: DVec2| step.abs().max_element() < SMOOTH_SEGMENT;
    let is_straight = onwards.is_some_and(|onwards| is_straight(into, onwards));
    let steps = [[before.out, here.into], [here.out, after.into]].map(|ends| step(surface, ends));
    let [Some(in_space), Some(out_in_space)] = steps else {
        let cosine = onwards.map_or(-1.0, |out| turn_cosine(surface, here.into, into, out));
        let is_smooth = cosine >= SMOOTH_TURN_COSINE && (is_short(into) || is_short(out));
        let is_smooth = is_smooth || is_straight;
        return [if is_smooth { Vertex::Smooth(DVec3::ZERO) } else { Vertex::Corner }; 2];
    };
    let is_fine = is_short(into) || is_short(out) || is_straight;
    let Some(mirror) = mirror(surface, here.turn) else { return [Vertex::Corner; 2] };
    let out_in_space = mirror * out_in_space;
    let directions = [in_space, out_in_space].map(DVec3::try_normalize);
    let [Some(into), Some(out)] = directions else { return [Vertex::Smooth(DVec3::ZERO); 2] };
    if into.dot(out) < SMOOTH_TURN_COSINE || !is_fine {
        return [Vertex::Corner; 2];
    }
    let bend = (out - into) / (0.5 * (in_space.length() + out_in_space.length()));
    [Vertex::Smooth(bend), Vertex::Smooth(mirror * bend)]
}

/// Returns the vector in space from one point to another, or `None` if the surface has no positions there.
fn step(surface: &Surface, ends: [DVec2; 2]) -> Option<DVec3> {
    match ends.map(|at| surface.place(at)) {
        [Some(Sample::Position(from)), Some(Sample::Position(to))] => Some(to - from),
        _ => None,
    }
}

/// Returns the factors that convert a vector in space after a vertex to the axes before the vertex. The x and y axes of
/// heights follow rows and columns, which may be reversed beyond a seam. The result is `None` where the factors are not
/// known.
fn mirror(surface: &Surface, turn: Option<DVec2>) -> Option<DVec3> {
    match surface.geometry() {
        Geometry::Heights { .. } => turn.map(|turn| DVec3::new(turn.y, turn.x, 1.0)),
        _ => Some(DVec3::ONE),
    }
}

/// Returns whether a curve continues straight in the chart from one step to the next.
fn is_straight(into: DVec2, out: DVec2) -> bool {
    let across = into.perp_dot(out).abs();
    into.dot(out) >= 0.0 && across <= 1e-9 * into.length() * out.length()
}

/// Returns the cosine of the angle by which a curve turns at a place of a surface given by its metric.
fn turn_cosine(surface: &Surface, at: DVec2, into: DVec2, out: DVec2) -> f64 {
    let Some(Sample::Metric { tensor, .. }) = surface.place(at) else { return 1.0 };
    let dot = |a: DVec2, b: DVec2| a.dot(tensor * b);
    let lengths = (dot(into, into) * dot(out, out)).sqrt();
    if lengths > 0.0 { dot(into, out) / lengths } else { 1.0 }
}

/// Returns, for each segment of a curve, the ends of the straight line of which it is a part. The result is `None`
/// unless the curve ends or turns sharply at each end of that line.
fn straight_runs(joints: &[Joint], courses: &[[Vertex; 2]]) -> Vec<Option<[DVec2; 2]>> {
    let step = |segment: usize| joints[segment + 1].into - joints[segment].out;
    let segments = joints.len().saturating_sub(1);
    let goes_on = |next: usize| {
        let is_smooth = matches!(courses[next][0], Vertex::Smooth(_));
        is_smooth && !joints[next].jumps() && is_straight(step(next - 1), step(next))
    };
    let mut runs = Vec::with_capacity(segments);
    while runs.len() < segments {
        let first = runs.len();
        let end = (first + 1..segments).find(|&next| !goes_on(next)).unwrap_or(segments);
        let ends = [courses[first][1], courses[end][0]];
        let is_whole = ends.iter().all(|vertex| matches!(vertex, Vertex::Corner));
        let run = is_whole.then(|| [joints[first].out, joints[end].into]);
        runs.resize(end, run);
    }
    runs
}
