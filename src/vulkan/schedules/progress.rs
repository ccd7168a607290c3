//! Describes the progress of a map's iterations as the device stores it. The twin of `glsl/shared/progress.glsl`.

use std::mem::offset_of;
use std::ops::Range;

use bytemuck::{AnyBitPattern, NoUninit, Zeroable};

use crate::Stop;
use crate::constants::{FAR, GAP_GROUP_BITS, NO_LIMIT, ROUND_WORDS, VISIT_WORDS};
use crate::vulkan::device::limits::column_of;
pub(crate) use crate::vulkan::device::shaders::progress::Progress;

/// Outcome of a map's iterations: the first part of [`Progress`].
#[derive(Clone, Copy, Debug, AnyBitPattern, NoUninit)]
#[repr(C)]
pub(crate) struct Outcome {
    residual: u32,
    renews: u32,
    /// Number of iterations of four scans, or of rounds of tiles.
    pub(crate) iterations: u32,
    /// Largest change in the last iteration, in units of the last place.
    pub(crate) last_residual: u32,
    since_reached: u32,
    done: u32,
    tolerance: u32,
    most: u32,
    /// Number of workgroups that have visited a tile or a part of a block of lines.
    pub(crate) visited: u32,
}

macro_rules! assert_first_part {
    ($($member:ident),*) => {
        $(const _: () = assert!(offset_of!(Outcome, $member) == offset_of!(Progress, $member));)*
    };
}
assert_first_part!(
    residual,
    renews,
    iterations,
    last_residual,
    since_reached,
    done,
    tolerance,
    most,
    visited
);

impl Outcome {
    pub(crate) fn is_done(&self) -> bool {
        self.done != 0
    }

    /// Returns whether the map is done because nothing changes any more.
    pub(crate) fn has_converged(&self) -> bool {
        self.is_done() && self.last_residual <= self.tolerance
    }

    /// Returns the largest relative change in the last iteration.
    pub(crate) fn residual(&self) -> f64 {
        crate::surface::relative_change::<f32>(self.last_residual)
    }
}

/// Record of a slot, as a renderer reads it.
#[derive(Clone, Copy, Debug, AnyBitPattern, NoUninit)]
#[repr(C)]
pub(crate) struct Record {
    pub(crate) outcome: Outcome,
    /// Number of the surface's last preparation that has run.
    pub(crate) prepared: u32,
    pub(crate) passed_over: u32,
    pub(crate) holes: u32,
    pub(crate) no_length: u32,
    pub(crate) sharp: u32,
    pub(crate) compared: u32,
    pub(crate) continued: u32,
    pub(crate) turns: [u32; 2],
    pub(crate) skew: u32,
    seam_gap: u32,
    /// Serial of the recording that wrote the record; 0 if none has. It is written last.
    pub(crate) serial: u32,
}

impl Record {
    /// Returns the largest gap between copies of a point, relative to a cell, and the number of the group of copies, if
    /// there was room for it. The gap is rounded down by up to a sixteenth.
    pub(crate) fn seam_gap(&self) -> (f32, Option<usize>) {
        let largest = (1 << GAP_GROUP_BITS) - 1;
        let group = self.seam_gap & largest;
        // The bits of the gap begin after the sign.
        let bits = (self.seam_gap & !largest) >> 1;
        (f32::from_bits(bits), (group < largest).then_some(group as usize))
    }
}

/// Number of blocks of scans in a recording for which profiles learn whether the scan visited the block.
pub(crate) const VISITS: u32 = 32 * VISIT_WORDS;
/// Bytes of the whole progress.
pub(crate) const BYTES: u64 = size_of::<Progress>() as u64;

/// Offsets of parts of the progress, in bytes.
pub(crate) mod offset {
    use super::*;

    /// Returns the offset of a round: the arguments of its dispatch, then the number of tiles on its list.
    pub(crate) const fn round(round: u32) -> u64 {
        (offset_of!(Progress, rounds) + round as usize * ROUND_WORDS as usize * size_of::<u32>())
            as u64
    }

    /// Returns the offset of the number of tiles on a round's list.
    pub(crate) const fn listed(of: u32) -> u64 {
        round(of) + size_of::<[u32; 3]>() as u64
    }

    /// Returns the offset of the number of tiles on a round's list that waited for the next round.
    pub(crate) const fn waited(of: u32) -> u64 {
        listed(of) + size_of::<u32>() as u64
    }

    /// Offset of the number of texels that were brought back to one image.
    pub(crate) const SETTLED: u64 = offset_of!(Progress, settled) as u64;

    /// Offset of the bits that say which blocks the scans have visited. Only profiles use them.
    pub(crate) const VISITS: u64 = offset_of!(Progress, visits) as u64;

    /// Offset of the number of the map's targets. The number of targets that are needed follows it.
    pub(crate) const TARGET_COUNT: u64 = offset_of!(Progress, target_count) as u64;
    /// Offset of the targets, which follow both numbers.
    pub(crate) const TARGETS: u64 = offset_of!(Progress, targets) as u64;

    /// Offset of the state of a renderer's input, which extends to the end of the progress. When a map starts, only the
    /// part [`PASSED_OVER`] of this state is set to zero.
    pub(crate) const INPUT: u64 = PREPARED.start;
    pub(crate) const PREPARED: Range<u64> =
        offset_of!(Progress, prepared) as u64..PASSED_OVER.start;
    pub(crate) const PASSED_OVER: Range<u64> =
        offset_of!(Progress, passed_over) as u64..POINTS.start;
    /// Bytes with the state of the input's points.
    pub(crate) const POINTS: Range<u64> = offset_of!(Progress, holes) as u64..BYTES;
    pub(crate) const INPUT_BYTES: u64 = BYTES - INPUT;
    pub(crate) const INPUT_IN_RECORD: u64 = offset_of!(Record, prepared) as u64;
    pub(crate) const SERIAL_IN_RECORD: u64 = offset_of!(Record, serial) as u64;
    const _: () = assert!(INPUT_IN_RECORD + INPUT_BYTES == SERIAL_IN_RECORD);
}

/// Rectangle of texels in which fronts may have changed, as the progress of a map with a limit stores it: the first and
/// the last column and row. Here the numbers are the same for columns and rows.
#[derive(Clone, Copy)]
pub(crate) struct Changed {
    first: i32,
    last: i32,
}

impl Changed {
    /// Empty rectangle: the value at the start of a map.
    pub(crate) const NOWHERE: Self = Self { first: i32::MAX, last: i32::MIN };
    /// Rectangle of all texels: the value on a map to which sources are added, or whose limit is set later.
    pub(crate) const ANYWHERE: Self = Self { first: 0, last: i32::MAX };
}

/// Returns the limit of times on a map, as the device stores it, for a radius that may be infinite.
fn limit_of(radius: f32) -> f32 {
    if radius < FAR as f32 { radius } else { NO_LIMIT as f32 }
}

/// Returns the progress before the first iteration of a map. `fronts_meet` says whether its fronts may meet
/// ([`crate::surface::Origins`]). The grid has `tiles` tiles. Visits need no initial value.
pub(crate) fn start(
    stop: Stop,
    radius: f32,
    (fronts_meet, changed): (u32, Changed),
    tiles: u32,
) -> Progress {
    let Changed { first, last } = changed;
    Progress {
        renews: 1,
        fronts_meet,
        limit: limit_of(radius),
        end: limit_of(radius),
        changed_first: [first; 2],
        changed_last: [last; 2],
        last_residual: u32::MAX,
        tolerance: (stop.tolerance / f64::from(f32::EPSILON)) as u32,
        most: stop.iterations,
        ..before_rounds(tiles)
    }
}

/// Returns the progress before further rounds, on a grid of `tiles` tiles of which none is listed. The caller writes it
/// from the second round up to the visits.
pub(crate) fn before_rounds(tiles: u32) -> Progress {
    let mut progress = Progress::zeroed();
    let (rounds, _) = progress.rounds.as_chunks_mut::<{ ROUND_WORDS as usize }>();
    rounds.fill([0, column_of(tiles), 1, 0, 0, 0]);
    progress
}
