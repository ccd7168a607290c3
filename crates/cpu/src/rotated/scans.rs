//! Defines the common interface of solvers of all kinds of fronts, in either order of updates.

use super::prepared::Settings;
use crate::limit::Limit;
use geosweep_surface::{Block, Seed};
use geosweep_surface::{Convergence, Stop};

/// A solver for the maps of one surface, of any kind of front. Kinds are types, so that scans are compiled
/// for each of them.
pub(crate) trait Scans<R>: std::fmt::Debug + Send + Sync {
    /// Computes the distance map of `seeds`.
    fn solve(&mut self, seeds: &[Seed], stop: Stop) -> Convergence;

    /// Adds sources to the last map, which is a warm start. Only tiles that the new fronts reach first are visited. If
    /// the last map has not converged, its iterations continue.
    fn add(&mut self, seeds: &[Seed], stop: Stop) -> Convergence;

    /// Continues the last map to a later limit. Returns `None` if fronts reach no further point.
    fn go_on(&mut self, seeds: &[Seed], stop: Stop, limit: Limit) -> Option<Convergence>;

    /// Returns blocks of the grid that hold all points that the last map has reached.
    fn used(&self) -> Vec<Block>;

    fn settings(&mut self) -> &mut Settings;

    /// Returns the arrival times of the last map, as a bordered array.
    fn times(&self) -> &[R];

    fn into_times(self: Box<Self>) -> Vec<R>;

    /// Returns the number of point visits of the last map.
    fn visits(&self) -> u64;

    /// Returns the number of points that the last map has updated.
    fn updates(&self) -> u64;

    /// Returns the number of bytes held, without the edge lengths and the data stored with them.
    fn bytes(&self) -> usize;

    /// Returns the rounds and visits of the last map, if it was solved by patches.
    fn patches(&self) -> Option<PatchCounts> {
        None
    }

    /// Returns whether points are updated in the order of their times, so that a map ends once it has reached its targets.
    fn is_in_order_of_time(&self) -> bool {
        false
    }

    fn boxed(&self) -> Box<dyn Scans<R>>;
}

/// The number of rounds and visits that a map took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PatchCounts {
    /// Number of patches of the grid.
    pub patches: u64,
    /// Number of visits to patches.
    pub visits: u64,
    /// Number of rounds. A round's visits do not depend on one another.
    pub rounds: u64,
    /// Number of iterations of four scans in all visits.
    pub iterations: u64,
}
