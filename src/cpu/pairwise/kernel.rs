//! What the update of a point in lanes needs, whatever the front.

use bytemuck::{Pod, Zeroable};

use crate::cpu::behind::Behind;
use crate::cpu::tiles::Scan;
use crate::surface::{Chart, EdgeLengths, Seed, min};

/// Maps that are computed side by side: as many as AVX-512 has lanes of single precision. With
/// narrower instructions a few vectors stand for them, which hides the latency of square roots.
pub(super) const LANES: usize = 16;

/// One number for each of the maps, on a cache line of its own.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Lanes(pub [f32; LANES]);

impl Lanes {
    pub(super) const fn all(value: f32) -> Self {
        Self([value; LANES])
    }

    /// Whether one of these is later than the earliest of three others.
    #[inline(always)]
    pub(super) fn some_after(&self, others: [&Self; 3]) -> bool {
        let mut some = false;
        for lane in 0..LANES {
            let [a, b, c] = others.map(|times| times.0[lane]);
            some |= min(min(a, b), c) < self.0[lane];
        }
        some
    }

    /// Takes the times that are earlier than these. Returns whether one of them is by more than
    /// `how` wants; the largest changes are noted if `TRACKS`, else all count as large.
    #[inline(always)]
    pub(super) fn lower<const TRACKS: bool>(
        &mut self,
        times: [f32; LANES],
        how: How,
        largest: &mut [u32; LANES],
    ) -> bool {
        let mut wakes = !TRACKS;
        for lane in 0..LANES {
            let old = self.0[lane];
            let new = min(old, times[lane]);
            self.0[lane] = new;
            if TRACKS {
                // No time grows.
                let change = old.to_bits() - new.to_bits();
                wakes |= change > how.wakes;
                largest[lane] = largest[lane].max(change);
            }
        }
        wakes
    }
}

/// Two triangles around a point and what lies at their corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fan {
    /// Lengths of the edges to the neighbours behind: the one before, the one beside, the one after.
    pub edges: [f32; 3],
    /// Lengths of the edges between them.
    pub bases: [f32; 2],
    /// Gaussian curvature at the point and at the three neighbours; zero unless it is needed.
    pub gaussian: [f32; 4],
}

/// How points are updated.
#[derive(Clone, Copy, Debug)]
pub(super) struct How {
    pub scan: Scan,
    /// Whether curved fronts that the scan has brought before are renewed.
    pub renews: bool,
    /// Changes above this, in units of the time's precision, are worth another visit beside them.
    pub wakes: u32,
}

/// A front in lanes.
pub(super) trait Kernel: Sized + 'static {
    /// The maps at a point; the first lanes are the arrival times.
    type State: Pod + Send + Sync;

    /// What all maps share at a point, for one of the scans.
    type Coefficients: Copy + Send + Sync;

    /// Where no front has arrived.
    const UNREACHED: Self::State;

    /// Whether [`Fan::gaussian`] is needed, and fronts are renewed.
    const BENDS: bool = false;

    fn coefficients(fan: Fan) -> Self::Coefficients;

    /// Makes a point the source of one of the maps.
    fn start(state: &mut Self::State, lane: usize, seed: Seed);

    /// Whether an update could change a point by more than rounding, as a cheap test sees it.
    fn may_change(
        here: &Self::State,
        behind: [&Self::State; 3],
        coefficients: &Self::Coefficients,
        how: How,
    ) -> bool;

    /// Updates a point from the three behind; returns whether a map has changed by more than `how`
    /// wants. The largest changes of arrival times, in units of their precision, are noted if
    /// `TRACKS`.
    fn update<const TRACKS: bool>(
        here: &mut Self::State,
        behind: [&Self::State; 3],
        coefficients: &Self::Coefficients,
        how: How,
        largest: &mut [u32; LANES],
    ) -> bool;
}

/// Where the two triangles of a scan lie, seen from their point.
#[derive(Clone, Copy, Debug)]
pub(super) struct FanSlots(Behind);

impl FanSlots {
    pub(super) fn new(chart: Chart, scan: Scan) -> Self {
        Self(Behind::of(chart, scan))
    }

    /// The fan of a point of a bordered array.
    pub(super) fn fan(&self, edges: &EdgeLengths<f32>, gaussian: &[f32], point: usize) -> Fan {
        let [a, b, c] = self.0.points();
        let at = |offset: isize| {
            gaussian.get(point.wrapping_add_signed(offset)).copied().unwrap_or_default()
        };
        Fan {
            edges: self.0.edges().map(|slot| edges.at(point, slot)),
            bases: self.0.bases().map(|slot| edges.at(point, slot)),
            gaussian: [at(0), at(a), at(b), at(c)],
        }
    }
}
