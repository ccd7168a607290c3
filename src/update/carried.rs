//! What the front at a point carries beside its arrival time.

use bytemuck::Pod;

use crate::surface::Seed;

/// What fronts of some kind carry, in an array of its own beside the arrival times. A type that owns its
/// tag bits; the default is carried where no front has arrived.
pub(crate) trait Carried: Pod + Default + PartialEq + Send + Sync + std::fmt::Debug {
    /// Whether fronts tell which scan has brought them, and are renewed by it.
    #[cfg_attr(not(feature = "twins"), expect(dead_code, reason = "twins alone ask"))]
    const TELLS_SCANS: bool;

    /// Whether this scan has brought the front, if fronts tell.
    fn is_from(self, scan: u8) -> bool;
}

/// Nothing.
impl Carried for () {
    const TELLS_SCANS: bool = false;

    #[inline(always)]
    fn is_from(self, _: u8) -> bool {
        false
    }
}

/// Stands for the scan of fronts that no scan has brought; scans are numbered from 1.
pub(crate) const SEED: u8 = 0;
/// The same of exact seeds ([`crate::surface::Seed::exact`]).
pub(crate) const EXACT: u8 = crate::constants::EXACT as u8;

/// The one that stands for a seed.
pub(crate) fn tag_of(seed: &Seed) -> u8 {
    if seed.exact { EXACT } else { SEED }
}

/// The front that a point keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kept<R, C> {
    /// When it has arrived; [`crate::surface::Real::FAR`] if none has.
    pub time: R,
    pub carried: C,
}
