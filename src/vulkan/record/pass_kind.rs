//! Lists the kinds of passes, with their names and their places in a map.

use std::ffi::CStr;

#[cfg(doc)]
use crate::vulkan::profile::{Grain, Profile};
use crate::vulkan::schedules::plan::{Scan, ScanPair, Step};

/// Kind of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PassKind {
    /// Transitions new images into their layouts, and clears them: no edge, and no point reached.
    Prepare,
    /// Reads a band of the host's points.
    Points,
    /// Measures the edges of a band of rows, or copies them from the program's memory.
    Edges,
    /// Computes the surface's Gaussian curvature, in two passes.
    Curvature,
    /// Clears the last map.
    Forget,
    /// Resets the progress. For a batch it resets the progress of all maps, which includes their sources.
    Start,
    /// Resets the lists of tiles for more rounds.
    Resume,
    /// Copies the sources that come with the recording, or finds the texels around sources.
    Sources,
    /// Solves the surroundings that a source inside a cell reaches first.
    Surroundings,
    /// Sets the texels with sources, or those that the sources reach first. For the maps of a batch it sets
    /// all other texels too.
    Seed,
    /// Runs one of the four rotated scans, or a block of its lines.
    Scan(Scan),
    /// Runs two opposite scans at the same time, or a block of lines of one of them.
    Pair(ScanPair),
    /// Updates the tiles on the list of a round.
    Tiles,
    /// Brings all tiles back to one image, and decides whether more rounds follow.
    Settle,
    /// Exchanges fronts between the copies of points of a glued surface, after a scan.
    Exchange,
    /// Exchanges fronts between the copies of points of a glued surface, after a round of tiles.
    ExchangeOfTiles,
    /// Decides whether another iteration follows.
    Count,
    /// Lowers the limit of a map to the time that its targets need.
    Targets,
    /// Resets points beyond the radius or the targets of a map to unreached.
    Trim,
    /// An iteration with its count, if no finer records are requested: [`Grain::Iterations`].
    Iteration,
    /// All iterations or rounds of a recording, if no finer records are requested: [`Grain::Portions`]. The
    /// portion begins with the sources, or where the last recording ended. In headless solving it includes
    /// the next [`PassKind::Outcome`].
    Portion,
    /// Arranges the lengths around a surface's points in the order of the scans, for maps in shared memory.
    Fans,
    /// Iterates maps in shared memory, one workgroup each.
    Workgroups,
    /// Copies the device's decisions to where a [`Profile`] finds them. It is recorded only while
    /// profiling.
    Decisions,
    /// Copies the outcome of the iterations.
    Outcome,
    /// Unpacks the map into an image of distances.
    Distances,
    /// Unpacks a band of the map into the read-back buffer.
    Unpack,
    /// Looks up distances at places given by the host.
    Lookup,
    /// Finds contours, in three passes.
    Contours,
    /// Traces paths. A pass takes some steps of each path.
    Paths,
    /// Lifts contours or paths to the surface in space.
    Lift,
    /// Finds the regions nearest to each source, in passes over all points.
    Regions,
    /// Finds the directions of the ways back.
    Directions,
    /// Computes a log map, in passes over all points.
    LogMap,
}

/// Part of a map to which a pass belongs.
#[derive(Clone, Copy)]
pub(crate) enum MapPart {
    /// Before the steps of the map.
    Start,
    /// Within an iteration, which ends with a count.
    Iteration,
    /// Rounds of tiles, each a record of its own, and the pass that settles them.
    Rounds,
    /// Between portions of steps.
    Notes,
    /// Before or after a map, or for many maps at once. Records that stand for several passes belong here
    /// too.
    Outside,
}

impl PassKind {
    /// Returns the name used in reports and as the label of the pass.
    pub fn name(self) -> &'static str {
        self.label().to_str().expect("labels are ASCII")
    }

    /// Returns whether the pass is one of the steps that iterate a map.
    pub fn is_step(self) -> bool {
        matches!(self.part(), MapPart::Iteration | MapPart::Rounds)
    }

    /// Returns the kind of a step.
    pub(crate) fn of(step: &Step) -> Self {
        match step {
            Step::Scan(pass) => pass.pair().map_or(Self::Scan(pass.scan), Self::Pair),
            Step::Tiles { .. } => Self::Tiles,
            Step::Settle { .. } => Self::Settle,
            Step::Exchange { next_round: Some(_), .. } => Self::ExchangeOfTiles,
            Step::Exchange { next_round: None, .. } => Self::Exchange,
            Step::Count => Self::Count,
        }
    }

    /// Returns the name of the pass in debugging tools.
    pub fn label(self) -> &'static CStr {
        self.row().0
    }

    pub(crate) fn part(self) -> MapPart {
        self.row().1
    }

    /// Returns the row of the kind: its name, and the part of a map to which it belongs.
    fn row(self) -> (&'static CStr, MapPart) {
        match self {
            Self::Prepare => (c"prepare", MapPart::Outside),
            Self::Points => (c"points", MapPart::Outside),
            Self::Edges => (c"edges", MapPart::Outside),
            Self::Curvature => (c"curvature", MapPart::Outside),
            Self::Forget => (c"forget", MapPart::Start),
            Self::Start => (c"start", MapPart::Start),
            Self::Resume => (c"resume", MapPart::Start),
            Self::Sources => (c"sources", MapPart::Start),
            Self::Surroundings => (c"surroundings", MapPart::Start),
            Self::Seed => (c"seed", MapPart::Start),
            Self::Scan(Scan::Down) => (c"scan down", MapPart::Iteration),
            Self::Scan(Scan::Up) => (c"scan up", MapPart::Iteration),
            Self::Scan(Scan::Right) => (c"scan right", MapPart::Iteration),
            Self::Scan(Scan::Left) => (c"scan left", MapPart::Iteration),
            Self::Pair(ScanPair::DownUp) => (c"scan down and up", MapPart::Iteration),
            Self::Pair(ScanPair::RightLeft) => (c"scan right and left", MapPart::Iteration),
            Self::Tiles => (c"tiles", MapPart::Rounds),
            Self::Settle => (c"settle", MapPart::Rounds),
            Self::Exchange => (c"exchange", MapPart::Iteration),
            Self::ExchangeOfTiles => (c"exchange of tiles", MapPart::Rounds),
            Self::Count => (c"count", MapPart::Iteration),
            Self::Targets => (c"targets", MapPart::Notes),
            Self::Trim => (c"trim", MapPart::Outside),
            Self::Iteration => (c"iteration", MapPart::Outside),
            Self::Portion => (c"portion", MapPart::Outside),
            Self::Fans => (c"fans", MapPart::Outside),
            Self::Workgroups => (c"workgroups", MapPart::Outside),
            Self::Decisions => (c"decisions", MapPart::Notes),
            Self::Outcome => (c"outcome", MapPart::Outside),
            Self::Distances => (c"distances", MapPart::Outside),
            Self::Unpack => (c"unpack", MapPart::Outside),
            Self::Lookup => (c"lookup", MapPart::Outside),
            Self::Contours => (c"contours", MapPart::Outside),
            Self::Paths => (c"paths", MapPart::Outside),
            Self::Lift => (c"lift", MapPart::Outside),
            Self::Regions => (c"regions", MapPart::Outside),
            Self::Directions => (c"directions", MapPart::Outside),
            Self::LogMap => (c"log map", MapPart::Outside),
        }
    }
}
