//! What paths have in common: from the corner of a hole on, all that come to it are one.
//!
//! Around holes many paths bend at few corners, and on winding ways most of each path is also most of the
//! others. So a path is followed to the first corner that it comes to. What comes after that is traced and
//! drawn taut once, from corner to corner down to the source, and kept.

use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, PoisonError, RwLock};

use glam::DVec2;

use super::trace::{Field, Place, Stuck, Trace};
use super::walk::{Goal, Head};

/// A path to its source, the last part of which may be that of other paths too.
#[derive(Clone, Debug)]
pub(super) struct Course {
    /// From the start to the source, or to the corner where the rest begins.
    pub vertices: Vec<DVec2>,
    /// Arrival time at the start.
    pub time: f64,
    /// From the start to the source.
    pub length: f64,
    pub source: usize,
    /// The source's initial value.
    pub initial: f64,
    pub rest: Option<Arc<Course>>,
}

/// A corner, as a point of the bordered array, and the bits of the moment that squares of times count from.
type Key = (usize, u64);

type Rest = Result<Arc<Course>, Stuck>;

/// The paths from corners of holes that have been traced.
#[derive(Clone, Debug, Default)]
pub(super) struct Rests(Arc<RwLock<HashMap<Key, Rest>>>);

impl Rests {
    fn get(&self, key: Key) -> Option<Rest> {
        self.0.read().unwrap_or_else(PoisonError::into_inner).get(&key).cloned()
    }

    fn keep(&self, key: Key, rest: Rest) {
        self.0.write().unwrap_or_else(PoisonError::into_inner).insert(key, rest);
    }
}

impl Course {
    /// All its vertices, with those of the rest.
    pub(super) fn trace(self) -> Trace {
        let Self { mut vertices, time, length, source, initial, rest } = self;
        let rests = || std::iter::successors(rest.as_deref(), |rest| rest.rest.as_deref());
        vertices.reserve_exact(rests().map(|rest| rest.vertices.len() - 1).sum());
        for rest in rests() {
            vertices.extend_from_slice(&rest.vertices[1..]);
        }
        Trace { vertices, time, length, source, initial }
    }
}

impl From<Trace> for Course {
    fn from(Trace { vertices, time, length, source, initial }: Trace) -> Self {
        Self { vertices, time, length, source, initial, rest: None }
    }
}

impl Field<'_> {
    /// The paths from some places to their sources, drawn taut if the field's are. Each is what it
    /// would be alone.
    pub(super) fn traces(&self, starts: &[DVec2]) -> Vec<Result<Trace, Stuck>> {
        let walks: Vec<_> = starts.iter().map(|&start| (start, self.start)).collect();
        let mut courses = self.courses(&walks);
        // Squares of times are smooth at a source if they count from its own initial value, which is
        // known once a path has found it.
        let later = |(_, course): &(usize, &Result<Course, Stuck>)| {
            course.as_ref().is_ok_and(|course| course.initial != self.start)
        };
        let numbers: Vec<_> =
            courses.iter().enumerate().filter(later).map(|(number, _)| number).collect();
        let moment = |&number: &usize| {
            courses[number].as_ref().ok().map(|course| (starts[number], course.initial))
        };
        let walks: Vec<_> = numbers.iter().filter_map(moment).collect();
        for (number, again) in numbers.into_iter().zip(self.courses(&walks)) {
            let first = courses[number].as_ref().ok().map(|course| course.source);
            if let Ok(again) = again
                && Some(again.source) == first
            {
                courses[number] = Ok(again);
            }
        }
        courses.into_iter().map(|course| course.map(Course::trace)).collect()
    }

    /// The paths from some places, by squares of times that count from some moments.
    fn courses(&self, walks: &[(DVec2, f64)]) -> Vec<Result<Course, Stuck>> {
        let heads = self.heads(walks);
        let moments = walks.iter().map(|&(_, moment)| moment);
        self.trace_rests(heads.iter().zip(moments.clone()).filter_map(corner).collect());
        heads.into_iter().zip(moments).map(|(head, moment)| self.course(head?, moment)).collect()
    }

    /// Sees that the paths from some corners are kept.
    fn trace_rests(&self, mut corners: BTreeSet<Key>) {
        let mut heads = HashMap::new();
        loop {
            corners.retain(|key| !heads.contains_key(key) && self.rests.get(*key).is_none());
            if corners.is_empty() {
                break;
            }
            let walk = |&(point, moment): &Key| {
                (self.position(Place::Point(point)), f64::from_bits(moment))
            };
            let walks: Vec<_> = corners.iter().map(walk).collect();
            heads.extend(corners.iter().copied().zip(self.heads(&walks)));
            let moment = |key: &Key| f64::from_bits(key.1);
            corners = corners.iter().filter_map(|key| corner((&heads[key], moment(key)))).collect();
        }
        let mut heads: Vec<_> = heads.into_iter().collect();
        // The times fall from corner to corner.
        heads.sort_by(|((a, _), _), ((b, _), _)| self.time(*a).total_cmp(&self.time(*b)));
        for (key, head) in heads {
            let course = head.and_then(|head| self.course(head, f64::from_bits(key.1)));
            self.rests.keep(key, course.map(Arc::new));
        }
    }

    /// The whole path, if that from the corner where its head ends is kept.
    fn course(&self, head: Head, moment: f64) -> Result<Course, Stuck> {
        let Head { vertices, time, length, goal } = head;
        let course = match goal {
            Goal::Source { source, initial } => {
                Course { vertices, time, length, source, initial, rest: None }
            }
            Goal::Corner(point) => {
                let stuck = Stuck(self.position(Place::Point(point)));
                let rest = self.rests.get((point, moment.to_bits())).ok_or(stuck)??;
                let (length, source, initial) = (length + rest.length, rest.source, rest.initial);
                Course { vertices, time, length, source, initial, rest: Some(rest) }
            }
        };
        Ok(if self.shortens { self.taut(course) } else { course })
    }
}

/// The corner that a path comes to.
fn corner((head, moment): (&Result<Head, Stuck>, f64)) -> Option<Key> {
    match head.as_ref().ok()?.goal {
        Goal::Corner(point) => Some((point, moment.to_bits())),
        Goal::Source { .. } => None,
    }
}
