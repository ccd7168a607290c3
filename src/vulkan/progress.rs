//! How a map's iterations go, as the device keeps it. The twin of `glsl/progress.glsl`.

use bytemuck::{AnyBitPattern, NoUninit};

use crate::Stop;
use crate::constants::{ROUNDS, VISIT_WORDS};

const SLOTS: usize = 3 * (ROUNDS as usize + 1);

/// What the host reads.
#[derive(Clone, Copy, Debug, AnyBitPattern, NoUninit)]
#[repr(C)]
pub(crate) struct Outcome {
    residual: u32,
    renews: u32,
    /// Of four scans, of updates of all points, or rounds of tiles.
    pub(crate) iterations: u32,
    /// Of the last iteration, in units of the last place.
    pub(crate) last_residual: u32,
    since_reached: u32,
    done: u32,
    tolerance: u32,
    most: u32,
}

/// All of it but the visits of scans, which follow.
#[derive(Clone, Copy, Debug, NoUninit)]
#[repr(C)]
pub(crate) struct DeviceProgress {
    outcome: Outcome,
    grid_groups: [u32; 3],
    rounds: [u32; SLOTS],
    unsettled: [u32; ROUNDS as usize],
    reached: u32,
    settled: u32,
}

impl Outcome {
    pub(crate) fn is_done(&self) -> bool {
        self.done != 0
    }

    /// Whether it is done because nothing changes any more.
    pub(crate) fn has_converged(&self) -> bool {
        self.is_done() && self.last_residual <= self.tolerance
    }

    /// Largest relative change in the last iteration.
    pub(crate) fn residual(&self) -> f64 {
        crate::surface::relative_change::<f32>(self.last_residual)
    }
}

/// Dispatches of scans in a recording of which profiles learn whether they have visited something.
pub(crate) const VISITS: u32 = 32 * VISIT_WORDS;
/// Bytes of all the progress.
pub(crate) const BYTES: u64 = offset::VISITS + VISITS as u64 / 8;

/// Where the parts lie, in bytes.
pub(crate) mod offset {
    use super::*;

    pub(crate) const GRID_GROUPS: u64 = size_of::<Outcome>() as u64;

    /// The tiles of a round.
    pub(crate) const fn round(round: u32) -> u64 {
        GRID_GROUPS + 12 + 12 * round as u64
    }

    /// The texels that were brought back to one image.
    pub(crate) const SETTLED: u64 = size_of::<DeviceProgress>() as u64 - 4;

    /// A bit for each dispatch of a scan.
    pub(crate) const VISITS: u64 = size_of::<DeviceProgress>() as u64;
}

impl DeviceProgress {
    /// Before the first iteration; the whole grid takes so many groups.
    pub(crate) fn start(stop: Stop, grid: [u32; 2]) -> Self {
        let mut rounds = [1; SLOTS];
        rounds.iter_mut().step_by(3).for_each(|tiles| *tiles = 0);
        Self {
            outcome: Outcome {
                residual: 0,
                renews: 1,
                iterations: 0,
                last_residual: u32::MAX,
                since_reached: 0,
                done: 0,
                tolerance: (stop.tolerance / f64::from(f32::EPSILON)) as u32,
                most: stop.iterations,
            },
            grid_groups: [grid[0], grid[1], 1],
            rounds,
            unsettled: [0; ROUNDS as usize],
            reached: 0,
            settled: 0,
        }
    }

    /// Before more rounds of tiles: all slots but the first, and what follows them, are to be
    /// written.
    pub(crate) fn before_rounds() -> Self {
        Self::start(Stop::after(1), [0; 2])
    }
}
