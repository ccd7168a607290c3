//! Defines the record of a pass as plain values, which can be stored, compared and forwarded.

use std::ffi::CStr;
use std::ops::Range;

use super::work::Work;
use crate::vulkan::schedules::plan::{Scan, ScanPair};

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
    /// Takes back what lies beyond the radius or the targets of a map.
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
    /// Copies the device's decisions to where a [`super::Profile`] finds them. It is recorded only while
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

impl PassKind {
    /// Returns the name used in reports and as the label of the pass.
    pub fn name(self) -> &'static str {
        self.label().to_str().expect("labels are ASCII")
    }

    /// Returns whether a pass of this kind is a dispatch, as opposed to copies and clears.
    pub fn is_dispatch(self) -> bool {
        use PassKind::*;
        !matches!(self, Prepare | Forget | Start | Resume | Decisions | Outcome)
    }

    pub(crate) fn label(self) -> &'static CStr {
        match self {
            Self::Prepare => c"prepare",
            Self::Points => c"points",
            Self::Edges => c"edges",
            Self::Curvature => c"curvature",
            Self::Forget => c"forget",
            Self::Start => c"start",
            Self::Resume => c"resume",
            Self::Sources => c"sources",
            Self::Surroundings => c"surroundings",
            Self::Seed => c"seed",
            Self::Scan(Scan::Down) => c"scan down",
            Self::Scan(Scan::Up) => c"scan up",
            Self::Scan(Scan::Right) => c"scan right",
            Self::Scan(Scan::Left) => c"scan left",
            Self::Pair(ScanPair::DownUp) => c"scan down and up",
            Self::Pair(ScanPair::RightLeft) => c"scan right and left",
            Self::Tiles => c"tiles",
            Self::Settle => c"settle",
            Self::Exchange => c"exchange",
            Self::ExchangeOfTiles => c"exchange of tiles",
            Self::Count => c"count",
            Self::Targets => c"targets",
            Self::Trim => c"trim",
            Self::Iteration => c"iteration",
            Self::Portion => c"portion",
            Self::Fans => c"fans",
            Self::Workgroups => c"workgroups",
            Self::Decisions => c"decisions",
            Self::Outcome => c"outcome",
            Self::Distances => c"distances",
            Self::Unpack => c"unpack",
            Self::Lookup => c"lookup",
            Self::Contours => c"contours",
            Self::Paths => c"paths",
            Self::Lift => c"lift",
            Self::Regions => c"regions",
            Self::Directions => c"directions",
            Self::LogMap => c"log map",
        }
    }
}

/// Part of a map to which a pass belongs.
enum Part {
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
    /// Returns whether the pass is one of the steps that iterate a map.
    pub fn is_step(self) -> bool {
        match self.part() {
            Part::Iteration | Part::Rounds => true,
            Part::Start | Part::Notes | Part::Outside => false,
        }
    }

    fn part(self) -> Part {
        use PassKind::*;
        match self {
            Forget | Start | Resume | Sources | Surroundings | Seed => Part::Start,
            Scan(_) | Pair(_) | Exchange | Count => Part::Iteration,
            Tiles | ExchangeOfTiles | Settle => Part::Rounds,
            Decisions | Targets => Part::Notes,
            Prepare | Points | Edges | Curvature | Iteration | Portion | Fans | Workgroups
            | Trim | Outcome | Distances | Unpack | Lookup | Contours | Paths | Lift | Regions
            | Directions | LogMap => Part::Outside,
        }
    }
}

/// Coarseness of the records. A coarser grain writes fewer timestamps. A timestamp takes time by itself:
/// [`crate::vulkan::DeviceCeilings::timestamp`], 15 to 25 microseconds on lavapipe. `docs/profiling.md`
/// states how much that adds to maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Grain {
    /// A record for each portion: from the sources through all iterations or rounds of a recording. In
    /// headless solving it includes the outcome. For many maps at once, a record for each iteration.
    Portions,
    /// A record for each iteration: its scans, with the count that ends it.
    /// With tiles, a record for each round.
    Iterations,
    /// A record for each scan, or for each pair of scans that run at the same time. It includes all blocks of lines of
    /// the scan, which may be a hundred or more, and the barriers between them.
    #[default]
    Scans,
    /// A record for each dispatch.
    Blocks,
}

impl std::fmt::Display for Grain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl Grain {
    /// All grains, from the coarsest to the finest.
    pub const ALL: [Self; 4] = [Self::Portions, Self::Iterations, Self::Scans, Self::Blocks];

    /// Returns the name used on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portions => "portions",
            Self::Iterations => "iterations",
            Self::Scans => "scans",
            Self::Blocks => "blocks",
        }
    }

    /// Returns the kind of the record that contains a pass of kind `pass`.
    pub(crate) fn kind(self, pass: PassKind) -> PassKind {
        match (self, pass.part()) {
            (Self::Blocks | Self::Scans, _)
            | (Self::Iterations | Self::Portions, Part::Outside) => pass,
            (Self::Iterations, Part::Iteration) => PassKind::Iteration,
            (Self::Iterations, Part::Start | Part::Rounds | Part::Notes) => pass,
            (Self::Portions, Part::Start | Part::Iteration | Part::Rounds | Part::Notes) => {
                PassKind::Portion
            }
        }
    }

    /// Returns whether a record of this kind includes the following passes of the same kind and iteration.
    pub(crate) fn gathers(self, kind: PassKind) -> bool {
        match kind {
            PassKind::Iteration | PassKind::Portion => true,
            PassKind::Scan(_) | PassKind::Pair(_) => self != Self::Blocks,
            _ => false,
        }
    }
}

/// Rectangle of texels. Rows and columns include the border of the images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Area {
    /// First row, and the row after the last.
    pub rows: [u32; 2],
    /// First column, and the column after the last.
    pub cols: [u32; 2],
}

impl Area {
    pub(crate) fn new(rows: Range<u32>, cols: Range<u32>) -> Self {
        Self { rows: [rows.start, rows.end], cols: [cols.start, cols.end] }
    }

    /// Returns the smallest rectangle around both.
    fn around(self, other: Self) -> Self {
        let around = |a: [u32; 2], b: [u32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self { rows: around(self.rows, other.rows), cols: around(self.cols, other.cols) }
    }
}

/// Record of a pass, of all blocks of a scan, or of all passes of an iteration.
///
/// A field that is `None` is unknown: it was not measured, or the device decided it and nothing was read
/// back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassRecord {
    /// Kind of the pass.
    pub kind: PassKind,
    /// Iteration or round of tiles to which the pass belongs. It counts from 0 at the start of the map. If
    /// the device's decisions are unknown, it counts from the start of the portion of steps. It is also
    /// `None` for passes outside the iterations.
    pub iteration: Option<u32>,
    /// Rectangle around the texels for which the pass was recorded. It is also `None` for passes without such
    /// a rectangle.
    pub area: Option<Area>,
    /// Number of dispatches in this record; 0 for copies and clears.
    pub dispatches: u32,
    /// Number of workgroups in all dispatches together. It is zero if the map converged before the pass, except for
    /// scans in which one workgroup takes several blocks of lines. It is also `None` for copies and clears.
    pub groups: Option<[u32; 3]>,
    /// Data that the pass moved, and updates that it computed.
    pub work: Work,
    /// Start of the pass in nanoseconds since the start of the recording.
    pub begin: Option<u64>,
    /// Time on the device in nanoseconds, from the end of the previous pass to the end of this one. It
    /// includes the barrier between them.
    pub nanoseconds: Option<u64>,
    /// Invocations of compute shaders, as counted by the device.
    pub invocations: Option<u64>,
}

impl PassRecord {
    pub(crate) fn new(kind: PassKind) -> Self {
        Self {
            kind,
            iteration: None,
            area: None,
            dispatches: kind.is_dispatch().into(),
            groups: None,
            work: Work::default(),
            begin: None,
            nanoseconds: None,
            invocations: None,
        }
    }

    /// Adds the next pass of the same scan or iteration to this record.
    pub(crate) fn absorb(&mut self, next: &Self) {
        // A count visits no texels.
        self.area = self.area.zip(next.area).map(|(a, b)| a.around(b)).or(self.area);
        self.dispatches += next.dispatches;
        self.groups = self.groups.zip(next.groups).map(|(a, b)| match a[1..] == b[1..] {
            true => [a[0] + b[0], a[1], a[2]],
            false => [a.iter().product::<u32>() + b.iter().product::<u32>(), 1, 1],
        });
        self.work = self.work.and(next.work);
    }

    /// Returns one record for all passes of a portion, with what is known of the work of each.
    pub(super) fn of_portion(passes: &[Self]) -> Self {
        let mut all = Self { dispatches: 0, ..Self::new(PassKind::Portion) };
        let visits: Vec<_> = passes.iter().filter(|pass| pass.area.is_some()).collect();
        let sum = |of: fn(&Work) -> Option<u64>| -> Option<u64> {
            visits.iter().map(|pass| of(&pass.work)).sum()
        };
        // Passes without texels only add to the bytes.
        let bytes = |of: fn(&Work) -> Option<u64>| {
            let others = passes.iter().filter(|pass| pass.area.is_none());
            let others: u64 = others.filter_map(|pass| of(&pass.work)).sum();
            sum(of).map(|bytes| bytes + others)
        };
        all.work = Work {
            texels: sum(|work| work.texels),
            skipped: sum(|work| work.skipped),
            bytes_read: bytes(|work| work.bytes_read),
            bytes_written: bytes(|work| work.bytes_written),
            triangles: sum(|work| work.triangles),
        };
        let groups = |pass: &Self| Some(pass.groups?.iter().product::<u32>());
        let dispatched = passes.iter().filter(|pass| pass.dispatches > 0);
        all.groups = dispatched.map(groups).sum::<Option<u32>>().map(|groups| [groups, 1, 1]);
        all.dispatches = passes.iter().map(|pass| pass.dispatches).sum();
        all.invocations = passes.iter().map(|pass| pass.invocations).sum();
        all.area = visits.iter().filter_map(|pass| pass.area).reduce(Area::around);
        all
    }

    /// Returns whether the pass was dispatched and visited nothing: it lies beyond convergence, or no block
    /// of its scan was due, or its list of tiles was empty.
    pub fn is_idle(&self) -> bool {
        let is_scan = matches!(self.kind, PassKind::Scan(_) | PassKind::Pair(_));
        let has_no_groups = self.groups.is_some_and(|groups| groups.contains(&0));
        has_no_groups || is_scan && self.work.texels == Some(0)
    }
}
