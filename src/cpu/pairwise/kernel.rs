//! What the update of a point in lanes needs, whatever the front.

use bytemuck::{Pod, Zeroable};

use crate::cpu::behind::Behind;
use crate::cpu::scan::Scan;
use crate::surface::{Chart, EdgeLengths, Real, min};

/// Maps that are computed side by side: as many as AVX-512 has lanes of single precision. With
/// narrower instructions a few vectors stand for them, which hides the latency of square roots.
pub(super) const LANES: usize = 16;

/// One number for each of the maps, on a cache line of its own.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Lanes(pub [f32; LANES]);

impl Lanes {
    /// Where no front has arrived.
    pub(super) const UNREACHED: Self = Self::all(f32::FAR);

    pub(super) const fn all(value: f32) -> Self {
        Self([value; LANES])
    }

    /// Takes the times that are earlier than these. Returns whether one of them is by more than
    /// `wakes`, in units of its precision: then the points beside it are worth another visit. The
    /// largest changes, in the same units, are noted if `TRACKS`, else all count as large.
    #[inline(always)]
    pub(super) fn lower<const TRACKS: bool>(
        &mut self,
        times: Self,
        wakes: u32,
        largest: &mut [u32; LANES],
    ) -> bool {
        let mut wakes_others = !TRACKS;
        for (lane, largest) in largest.iter_mut().enumerate() {
            let old = self.0[lane];
            let new = min(old, times.0[lane]);
            self.0[lane] = new;
            if TRACKS {
                // No time grows.
                let change = old.to_bits() - new.to_bits();
                wakes_others |= change > wakes;
                *largest = (*largest).max(change);
            }
        }
        wakes_others
    }
}

/// The lengths of two triangles around a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fan {
    /// Lengths of the edges to the neighbours behind: the one before, the one beside, the one after.
    pub edges: [f32; 3],
    /// Lengths of the edges between them.
    pub bases: [f32; 2],
}

impl Fan {
    /// The sides of both triangles: the edges to the neighbour that comes first on the line and to
    /// the next one, and the base between these.
    pub(super) fn triangles(self) -> [[f32; 3]; 2] {
        let [before, beside, after] = self.edges;
        let [first, second] = self.bases;
        [[before, beside, first], [beside, after, second]]
    }
}

/// A front that its arrival times describe, in lanes.
pub(super) trait Kernel: 'static {
    /// What all maps share at a point, for one of the scans.
    type Coefficients: Copy + Send + Sync;

    fn coefficients(fan: Fan) -> Self::Coefficients;

    /// Whether a front from the three points behind could arrive before these times by more than
    /// rounding, in one of the maps, as a cheap test sees it.
    fn may_change(here: &Lanes, behind: [&Lanes; 3], coefficients: &Self::Coefficients) -> bool;

    /// When the fronts arrive from the three points behind.
    fn arrivals(behind: [&Lanes; 3], coefficients: &Self::Coefficients) -> Lanes;

    /// What all maps share of a part of an obtuse triangle.
    type Part: Copy + Send + Sync;

    /// That of one with such lengths of x0 x1, x0 x2 and x1 x2.
    fn part(lengths: [f32; 3]) -> Self::Part;

    /// When the fronts at x1 and x2 arrive through it.
    fn through(ends: [&Lanes; 2], part: &Self::Part) -> Lanes;
}

/// A point in the maps that pass it as it has become, in the others as it was.
#[inline(always)]
pub(super) fn merged(new: Lanes, old: Lanes, maps: [u32; LANES]) -> Lanes {
    let (mut new, old): ([u32; LANES], [u32; LANES]) = (bytemuck::cast(new), bytemuck::cast(old));
    for lane in 0..LANES {
        new[lane] = (new[lane] & maps[lane]) | (old[lane] & !maps[lane]);
    }
    bytemuck::cast(new)
}

/// Where the two triangles of a scan lie, seen from their point.
#[derive(Clone, Copy, Debug)]
pub(super) struct FanSlots(Behind);

impl FanSlots {
    pub(super) fn new(chart: Chart, scan: Scan) -> Self {
        Self(Behind::of(chart, scan))
    }

    /// The fan of a point of a bordered array, of obtuse triangles the edges alone.
    pub(super) fn fan(&self, edges: &EdgeLengths<f32>, point: usize) -> Fan {
        Fan {
            edges: self.0.edges().map(|slot| edges.at(point, slot)),
            bases: self
                .0
                .triangles()
                .each_ref()
                .map(|slots| slots.triangle(edges, point, [0.0; 2]).without_obtuse_face().c),
        }
    }
}
