//! Represents traced paths and the parts that many paths share.

use std::collections::HashMap;
use std::sync::{Arc, PoisonError, RwLock};

use glam::DVec2;

use super::place::Stuck;

/// A path to its source. Its last part may be shared with other paths.
#[derive(Clone, Debug)]
pub(super) struct LinkedPath {
    /// The vertices from the start to the source, or to the corner at which the shared part begins.
    pub vertices: Vec<DVec2>,
    /// The arrival time at the start.
    pub time: f64,
    /// The length of the whole path, from the start to the source.
    pub length: f64,
    pub source: usize,
    /// The initial value of the source.
    pub initial: f64,
    pub rest: Option<Arc<LinkedPath>>,
}

/// The key of a shared part: the corner at which the part starts, and the time that is subtracted before
/// times are squared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Key {
    /// The corner of a hole, a point of the bordered array.
    pub corner: usize,
    /// The bits of the time that is subtracted before times are squared.
    zero_time: u64,
}

pub(super) type SharedPart = Result<Arc<LinkedPath>, Stuck>;

/// The paths from corners of holes that have been traced so far.
#[derive(Clone, Debug, Default)]
pub(super) struct SharedParts(Arc<RwLock<HashMap<Key, SharedPart>>>);

impl SharedParts {
    pub(super) fn get(&self, key: Key) -> Option<SharedPart> {
        self.0.read().unwrap_or_else(PoisonError::into_inner).get(&key).cloned()
    }

    pub(super) fn keep(&self, key: Key, rest: SharedPart) {
        self.0.write().unwrap_or_else(PoisonError::into_inner).insert(key, rest);
    }
}

impl Key {
    pub(super) fn new(corner: usize, zero_time: f64) -> Self {
        Self { corner, zero_time: zero_time.to_bits() }
    }

    pub(super) fn zero_time(self) -> f64 {
        f64::from_bits(self.zero_time)
    }
}

impl LinkedPath {
    /// Returns the path with the vertices of its shared parts appended, which no longer has a shared part.
    pub(super) fn whole(mut self) -> Self {
        let rest = self.rest.take();
        let shared_parts = || std::iter::successors(rest.as_deref(), |rest| rest.rest.as_deref());
        self.vertices.reserve_exact(shared_parts().map(|rest| rest.vertices.len() - 1).sum());
        for rest in shared_parts() {
            self.vertices.extend_from_slice(&rest.vertices[1..]);
        }
        self
    }
}
