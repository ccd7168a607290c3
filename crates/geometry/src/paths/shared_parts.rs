//! Shares the parts that paths have in common. All paths that reach the corner of a hole are identical from
//! there on.
//!
//! Around holes many paths bend at few corners, and on winding paths most of a path is shared with the others. So a
//! path is followed to the first corner that it reaches. The part after the corner is traced and pulled taut once, from
//! corner to corner down to the source, and stored.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use glam::DVec2;

use super::linked_path::{Key, LinkedPath};
use super::place::{Place, Stuck};
use super::tracer::Tracer;
use super::walk::{Head, HeadEnd};

/// Returns the key of the corner that a path reaches. `zero_time` is the time that is subtracted before times are
/// squared.
fn corner((head, zero_time): (&Result<Head, Stuck>, f64)) -> Option<Key> {
    match head.as_ref().ok()?.end {
        HeadEnd::Corner(corner) => Some(Key::new(corner, zero_time)),
        HeadEnd::Source { .. } => None,
    }
}

impl Tracer<'_> {
    /// Traces the paths from some places to their sources, and pulls them taut if `shortens` is set. Each
    /// result is the same as if the path were traced alone.
    pub(super) fn traces(&self, starts: &[DVec2]) -> Vec<Result<LinkedPath, Stuck>> {
        let walks: Vec<_> = starts.iter().map(|&start| (start, self.start)).collect();
        let mut linked_paths = self.linked_paths(&walks);
        // Squared times are smooth at a source if the source's own initial value is subtracted before squaring. The
        // first trace subtracts the smallest initial value of all sources. Paths to a source with another initial value
        // are traced again. The second trace counts if it leads to the same source.
        let later = |(number, linked): (usize, &Result<LinkedPath, Stuck>)| {
            let LinkedPath { source, initial, .. } = linked.as_ref().ok()?;
            (*initial != self.start).then_some((number, *source, (starts[number], *initial)))
        };
        let later: Vec<_> = linked_paths.iter().enumerate().filter_map(later).collect();
        let walks: Vec<_> = later.iter().map(|&(.., walk)| walk).collect();
        for ((number, source, _), again) in later.into_iter().zip(self.linked_paths(&walks)) {
            if again.as_ref().is_ok_and(|again| again.source == source) {
                linked_paths[number] = again;
            }
        }
        linked_paths.into_iter().map(|linked| linked.map(LinkedPath::whole)).collect()
    }

    /// Traces the paths from some places. Each walk is given by its start and the time that is subtracted before times
    /// are squared.
    fn linked_paths(&self, walks: &[(DVec2, f64)]) -> Vec<Result<LinkedPath, Stuck>> {
        let heads = self.heads(walks);
        let zero_times = walks.iter().map(|&(_, zero_time)| zero_time);
        self.trace_shared_parts(heads.iter().zip(zero_times.clone()).filter_map(corner).collect());
        heads
            .into_iter()
            .zip(zero_times)
            .map(|(head, zero_time)| self.link(head?, zero_time))
            .collect()
    }

    /// Traces and stores the paths from the given corners.
    fn trace_shared_parts(&self, mut keys: BTreeSet<Key>) {
        let mut heads = HashMap::new();
        loop {
            keys.retain(|key| !heads.contains_key(key) && self.shared_parts.get(*key).is_none());
            if keys.is_empty() {
                break;
            }
            let walk = |key: &Key| (self.at(Place::Point(key.corner)), key.zero_time());
            let walks: Vec<_> = keys.iter().map(walk).collect();
            heads.extend(keys.iter().copied().zip(self.heads(&walks)));
            keys = keys.iter().filter_map(|key| corner((&heads[key], key.zero_time()))).collect();
        }
        let mut heads: Vec<_> = heads.into_iter().collect();
        // Arrival times decrease from corner to corner, so the rest of each path is stored before the path needs it.
        heads.sort_by(|(a, _), (b, _)| self.time(a.corner).total_cmp(&self.time(b.corner)));
        for (key, head) in heads {
            let linked = head.and_then(|head| self.link(head, key.zero_time()));
            self.shared_parts.keep(key, linked.map(Arc::new));
        }
    }

    /// Completes a path from its head. The path from the corner at which the head ends must be stored already.
    fn link(&self, head: Head, zero_time: f64) -> Result<LinkedPath, Stuck> {
        let Head { vertices, time, length, end } = head;
        let linked = match end {
            HeadEnd::Source { source, initial } => {
                LinkedPath { vertices, time, length, source, initial, rest: None }
            }
            HeadEnd::Corner(point) => {
                let stuck = Stuck(self.at(Place::Point(point)));
                let rest = self.shared_parts.get(Key::new(point, zero_time)).ok_or(stuck)??;
                let (length, source, initial) = (length + rest.length, rest.source, rest.initial);
                LinkedPath { vertices, time, length, source, initial, rest: Some(rest) }
            }
        };
        Ok(if self.shortens { self.taut(linked) } else { linked })
    }
}
