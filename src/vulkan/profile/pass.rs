//! The record of one pass: plain values, to be kept, compared and forwarded.

use std::ffi::CStr;
use std::ops::Range;

use super::work::Work;
use crate::vulkan::plan::Scan;

/// What a pass does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PassKind {
    /// Brings new images into their layouts, with no edge and no point reached.
    Prepare,
    /// Reads a band of the host's points.
    Points,
    /// Measures the edges of a band of rows, or copies them from the program's memory.
    Edges,
    /// Computes the surface's Gaussian curvature, in two passes.
    Curvature,
    /// Forgets the last map.
    Forget,
    /// Sets the progress to its beginning: of all maps of a batch with their sources.
    Start,
    /// Sets the lists of tiles for more rounds.
    Resume,
    /// Takes sources that come with the recording, or finds the texels around them.
    Sources,
    /// Solves what a source inside a cell reaches first.
    Surroundings,
    /// Sets the texels with sources, or with what they reach first; for maps of a batch all others, too.
    Seed,
    /// One of the four rotated scans, or a block of its lines.
    Scan(Scan),
    /// An update of all points at once.
    AllPoints,
    /// The tiles on the list of a round.
    Tiles,
    /// Brings all tiles back to one image, and decides whether more rounds follow.
    Settle,
    /// Decides whether another iteration follows.
    Count,
    /// An iteration with its count, where no finer records are wanted: [`Grain::Iterations`].
    Iteration,
    /// From the sources, or from where the last recording has ended, through all iterations or rounds
    /// of a recording, where no finer records are wanted: [`Grain::Portions`]. Headless, it takes the
    /// next [`PassKind::Outcome`] in.
    Portion,
    /// Puts the lengths around a surface's points into the order of the scans, for maps in shared
    /// memory.
    Fans,
    /// Iterations of maps in shared memory, a workgroup each.
    Workgroups,
    /// Copies what the device has decided to where a [`super::Profile`] finds it: only recorded
    /// while profiling.
    Decisions,
    /// Copies how the iterations have gone.
    Outcome,
    /// Unpacks the map into an image of distances.
    Distances,
    /// Unpacks a band of the map into the read-back buffer.
    Unpack,
    /// Looks distances up at places of the host's.
    Lookup,
    /// Finds contours, in three passes.
    Contours,
    /// Traces paths, some steps of each in a pass.
    Paths,
    /// Lifts contours or paths to the surface in space.
    Lift,
    /// Finds the regions nearest to each source, in passes over all points.
    Regions,
}

impl PassKind {
    /// The name used in reports, and as the label of the pass.
    pub fn name(self) -> &'static str {
        self.label().to_str().expect("labels are ASCII")
    }

    /// Whether a pass of this kind is a dispatch, rather than copies and clears.
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
            Self::AllPoints => c"all points",
            Self::Tiles => c"tiles",
            Self::Settle => c"settle",
            Self::Count => c"count",
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
        }
    }
}

/// Where in a map a pass belongs.
enum Part {
    /// Before its steps.
    Start,
    /// Within an iteration, which ends with a count.
    Iteration,
    /// Rounds of tiles, each a record of its own, and what settles them.
    Rounds,
    /// Between portions of steps.
    Notes,
    /// Before or after a map, or of many maps at once; or it stands for several passes.
    Outside,
}

impl PassKind {
    /// Whether it is one of the steps that iterate a map.
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
            Scan(_) | AllPoints | Count => Part::Iteration,
            Tiles | Settle => Part::Rounds,
            Decisions => Part::Notes,
            Prepare | Points | Edges | Curvature | Iteration | Portion | Fans | Workgroups
            | Outcome | Distances | Unpack | Lookup | Contours | Paths | Lift | Regions => {
                Part::Outside
            }
        }
    }
}

/// What a record stands for: the coarser, the fewer timestamps. They take time of their own:
/// [`crate::vulkan::Ceilings::timestamp`], 15 to 25 microseconds each on lavapipe;
/// `docs/profiling.md` says what that adds to maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Grain {
    /// A portion: from its sources through all iterations or rounds of a recording; headless, with
    /// how they have gone. Of maps at once, an iteration.
    Portions,
    /// An iteration: its scans, or its updates of all points, with the count that ends it; or a
    /// round of tiles.
    Iterations,
    /// A scan, with all its blocks of lines, of which there may be a hundred and more, and the
    /// barriers between them.
    #[default]
    Scans,
    /// Each dispatch.
    Blocks,
}

impl std::fmt::Display for Grain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl Grain {
    /// All of them, the coarsest first.
    pub const ALL: [Self; 4] = [Self::Portions, Self::Iterations, Self::Scans, Self::Blocks];

    /// The name used on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portions => "portions",
            Self::Iterations => "iterations",
            Self::Scans => "scans",
            Self::Blocks => "blocks",
        }
    }

    /// What the record of a pass of some kind is of.
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

    /// Whether a record takes in what follows in the same iteration and is of the same kind.
    pub(crate) fn gathers(self, kind: PassKind) -> bool {
        match kind {
            PassKind::Iteration | PassKind::Portion => true,
            PassKind::Scan(_) => self != Self::Blocks,
            _ => false,
        }
    }
}

/// A box of texels. Rows and columns of texels count the images' border.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Area {
    /// The first row, and the one after the last.
    pub rows: [u32; 2],
    /// The first column, and the one after the last.
    pub cols: [u32; 2],
}

impl Area {
    pub(crate) fn new(rows: Range<u32>, cols: Range<u32>) -> Self {
        Self { rows: [rows.start, rows.end], cols: [cols.start, cols.end] }
    }

    /// The smallest box around both.
    fn around(self, other: Self) -> Self {
        let around = |a: [u32; 2], b: [u32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self { rows: around(self.rows, other.rows), cols: around(self.cols, other.cols) }
    }
}

/// A pass of a recording, all blocks of a scan, or all passes of an iteration.
///
/// What is `None` is not known: it was not measured, or the device decided it and nothing was
/// read back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassRecord {
    /// What it does.
    pub kind: PassKind,
    /// The iteration that it belongs to, or the round of tiles: from 0 at the start of the map, or
    /// of the portion of steps where it is not known what the device has decided. `None` for passes
    /// outside the iterations too.
    pub iteration: Option<u32>,
    /// The box around the texels that it was recorded for; `None` for passes that visit no box, too.
    pub area: Option<Area>,
    /// Dispatches that it stands for; none for copies and clears.
    pub dispatches: u32,
    /// Workgroups dispatched, in all of them together; none where the map has converged before, but for scans that
    /// take blocks of lines in turn; `None` for copies and clears too.
    pub groups: Option<[u32; 3]>,
    /// What it had to move and to compute.
    pub work: Work,
    /// When it began, in nanoseconds since the start of the recording.
    pub begin: Option<u64>,
    /// Nanoseconds on the device from the end of the pass before to the end of this one, so that
    /// the barrier between them counts to this one.
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

    /// Takes the next pass of the same scan or iteration in.
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

    /// All passes of a portion, each with what is known of its work.
    pub(super) fn of_portion(passes: &[Self]) -> Self {
        let mut all = Self { dispatches: 0, ..Self::new(PassKind::Portion) };
        let visits: Vec<_> = passes.iter().filter(|pass| pass.area.is_some()).collect();
        let sum = |of: fn(&Work) -> Option<u64>| -> Option<u64> {
            visits.iter().map(|pass| of(&pass.work)).sum()
        };
        // What visits no texels only adds to the bytes.
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

    /// Whether the pass lies beyond convergence, or no block of its scan was due, or its list of tiles was empty:
    /// it was dispatched and visited nothing.
    pub fn is_idle(&self) -> bool {
        let is_scan = matches!(self.kind, PassKind::Scan(_));
        let has_no_groups = self.groups.is_some_and(|groups| groups.contains(&0));
        has_no_groups || is_scan && self.work.texels == Some(0)
    }
}
