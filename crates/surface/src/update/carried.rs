//! Defines the values that the front at a point carries beside its arrival time.

use bytemuck::Pod;

use crate::Seed;

/// The value that fronts of some kind carry, in an array of its own beside the arrival times. The type owns
/// its tag bits. Points that no front has reached hold the default.
pub trait Carried: Pod + Default + PartialEq + Send + Sync + std::fmt::Debug {
    /// Whether fronts record which scan brought them, so that this scan can renew them.
    const TELLS_SCANS: bool;

    /// Returns whether `scan` brought the front, if fronts record that.
    fn is_from(self, scan: u8) -> bool;
}

/// Fronts without further data.
impl Carried for () {
    const TELLS_SCANS: bool = false;

    #[inline(always)]
    fn is_from(self, _: u8) -> bool {
        false
    }
}

/// Scan number of fronts that no scan brought. Scans are numbered from 1.
pub const SEED: u8 = 0;
/// Scan number of exact seeds ([`crate::Seed::exact`]).
pub const EXACT: u8 = crate::constants::EXACT as u8;

/// Scan number of fronts that come from another copy of their point, on glued surfaces.
pub const EXCHANGED: u8 = crate::constants::EXCHANGED as u8;

/// Returns the scan number that stands for a seed.
pub fn tag_of(seed: &Seed) -> u8 {
    if seed.exact { EXACT } else { SEED }
}

/// A front stored at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(hidden)]
pub struct StoredFront<R, C> {
    /// Arrival time; [`crate::Real::FAR`] if no front has arrived.
    pub time: R,
    pub carried: C,
}
