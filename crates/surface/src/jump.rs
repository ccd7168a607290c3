//! Detects where a slowness or a metric jumps.

use super::real::{Real, max, min};
use super::tag::Tagged;
use crate::constants::{EVEN_SLOWNESS, JUMPS_PER_RATIO};

/// Tag ([`Tagged::with_tag`]) of a slowness at points around which it jumps.
pub(crate) const JUMPS: u8 = crate::constants::JUMPS as u8;

/// Returns whether a slowness carries the tag `JUMPS`.
#[inline(always)]
pub fn jumps<R: Real>(slowness: R) -> bool {
    slowness.tag_has(JUMPS, JUMPS)
}

/// Returns the jump of a quantity between some points, from its largest and its least value: 0 where it is smooth, 1
/// where the grid does not resolve it.
pub(super) fn jump<R: Real>(largest: R, least: R) -> R {
    let beyond = (largest - R::of(EVEN_SLOWNESS) * least) * R::of(JUMPS_PER_RATIO);
    min(max(beyond / least, R::zero()), R::one())
}
