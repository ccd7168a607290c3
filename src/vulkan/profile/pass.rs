//! Defines the record of a pass as plain values, which can be stored, compared and forwarded.

use std::ops::Range;

use super::work::Work;
use crate::vulkan::record::{MapPart, PassKind};

/// Coarseness of the records. A coarser grain writes fewer timestamps. A timestamp takes time by itself:
/// [`crate::vulkan::DeviceCeilings::timestamp`], 15 to 25 microseconds on lavapipe. `docs/profiling.md`
/// states how much that adds to maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Grain {
    /// A record for each portion: from the sources through all iterations or rounds of a recording. In
    /// headless solving it includes the outcome. For many maps at once, a record for each iteration.
    Portions,
    /// A record for each iteration: its scans, with the count that ends it. Rounds of tiles have a record each.
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
    pub(super) fn kind(self, pass: PassKind) -> PassKind {
        match (self, pass.part()) {
            (Self::Blocks | Self::Scans, _) | (_, MapPart::Outside) => pass,
            (Self::Iterations, MapPart::Iteration) => PassKind::Iteration,
            (Self::Iterations, _) => pass,
            (Self::Portions, _) => PassKind::Portion,
        }
    }

    /// Returns whether a record of this kind includes the following passes of the same kind and iteration.
    pub(super) fn gathers(self, kind: PassKind) -> bool {
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
    pub(super) fn new(rows: Range<u32>, cols: Range<u32>) -> Self {
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
    /// Returns the record of a pass before its commands.
    pub(super) fn new(kind: PassKind) -> Self {
        Self {
            kind,
            iteration: None,
            area: None,
            dispatches: 0,
            groups: None,
            work: Work::default(),
            begin: None,
            nanoseconds: None,
            invocations: None,
        }
    }

    /// Adds the next pass of the same scan, iteration or portion to this record, or a command of this pass.
    pub(super) fn absorb(&mut self, next: &Self) {
        let product = |groups: [u32; 3]| groups.iter().product::<u32>();
        self.groups = match (self.dispatches, next.dispatches) {
            (0, _) => next.groups,
            (_, 0) => self.groups,
            _ => self.groups.zip(next.groups).map(|(a, b)| match a[1..] == b[1..] {
                true => [a[0] + b[0], a[1], a[2]],
                false => [product(a) + product(b), 1, 1],
            }),
        };
        self.dispatches += next.dispatches;
        self.work = match (self.area, next.area) {
            (Some(_), Some(_)) => self.work.and(next.work),
            (Some(_), None) => self.work.and_bytes(next.work),
            (None, Some(_)) => next.work.and_bytes(self.work),
            (None, None) => self.work.and_known_bytes(next.work),
        };
        self.area = match (self.area, next.area) {
            (Some(a), Some(b)) => Some(a.around(b)),
            (a, b) => a.or(b),
        };
        self.invocations = self.invocations.zip(next.invocations).map(|(a, b)| a + b);
    }

    /// Returns one record for all passes of a portion, with the known work of each.
    pub(super) fn of_portion(passes: &[Self]) -> Self {
        let mut all = Self { kind: PassKind::Portion, iteration: None, ..passes[0] };
        passes[1..].iter().for_each(|pass| all.absorb(pass));
        let groups = all.groups.map(|groups| [groups.iter().product(), 1, 1]);
        Self { groups, ..all }
    }

    /// Returns whether the pass was dispatched and visited nothing: it lies beyond convergence, or no block
    /// of its scan was due, or its list of tiles was empty.
    pub fn is_idle(&self) -> bool {
        let is_scan = matches!(self.kind, PassKind::Scan(_) | PassKind::Pair(_));
        let has_no_groups = self.groups.is_some_and(|groups| groups.contains(&0));
        has_no_groups || is_scan && self.work.texels == Some(0)
    }
}
