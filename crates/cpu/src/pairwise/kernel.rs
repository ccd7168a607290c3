//! Defines the update of a point in SIMD lanes, for any kind of front.

use bytemuck::{Pod, Zeroable};

use crate::behind::{Behind, TriangleSlots};
use geosweep_surface::{EdgeLengths, Real, min};

/// Number of maps that are computed side by side: the number of single-precision lanes of AVX-512. With narrower
/// instructions the maps fill several vectors, which hides the latency of square roots.
pub(super) const LANES: usize = 16;

/// A number for each map, aligned to a cache line.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Lanes(pub [f32; LANES]);

impl Lanes {
    /// The times of a point that no front has reached.
    pub(super) const UNREACHED: Self = Self::all(f32::FAR);

    pub(super) const fn all(value: f32) -> Self {
        Self([value; LANES])
    }

    /// Replaces each time by the one in `times` if that is earlier. Returns whether a time has fallen by more than
    /// `wakes` units of its last place. If so, the neighbouring points have to be visited again. If `TRACKS` is set,
    /// the largest changes are noted in the same units; otherwise all changes count as large.
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
                // Times never increase.
                let change = old.to_bits() - new.to_bits();
                wakes_others |= change > wakes;
                *largest = (*largest).max(change);
            }
        }
        wakes_others
    }
}

/// Edge lengths of two adjacent triangles at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fan {
    /// Lengths of the edges to the neighbours behind: the one before, the one beside, the one after.
    pub edges: [f32; 3],
    /// Lengths of the edges between these neighbours.
    pub bases: [f32; 2],
}

impl Fan {
    /// Returns the sides of both triangles: the edge to the first neighbour on the line, the edge to the next one, and
    /// the base between these neighbours.
    pub(super) fn triangles(self) -> [[f32; 3]; 2] {
        let [before, beside, after] = self.edges;
        let [first, second] = self.bases;
        [[before, beside, first], [beside, after, second]]
    }
}

/// The update in SIMD lanes of a kind of front that carries nothing besides its arrival time.
pub(super) trait Kernel: 'static {
    /// Data that all maps share at a point, for one of the scans.
    type Coefficients: Copy + Send + Sync;

    fn coefficients(fan: Fan) -> Self::Coefficients;

    /// Returns whether, by a cheap test, a front from the three points behind could arrive earlier than the time `here`
    /// by more than rounding in at least one map.
    fn may_change(here: &Lanes, behind: [&Lanes; 3], coefficients: &Self::Coefficients) -> bool;

    /// Returns the times at which the fronts arrive from the three points behind.
    fn arrivals(behind: [&Lanes; 3], coefficients: &Self::Coefficients) -> Lanes;

    /// Data that all maps share for a part of an obtuse triangle.
    type Part: Copy + Send + Sync;

    /// Returns the data of a part with the given lengths of x0 x1, x0 x2 and x1 x2.
    fn part(lengths: [f32; 3]) -> Self::Part;

    /// Returns the times at which the fronts at x1 and x2 arrive through the part.
    fn through(ends: [&Lanes; 2], part: &Self::Part) -> Lanes;
}

/// Returns the new times of a point in maps whose scan passes the point, and the old times in all other maps.
#[inline(always)]
pub(super) fn merged(new: Lanes, old: Lanes, maps: [u32; LANES]) -> Lanes {
    let (mut new, old): ([u32; LANES], [u32; LANES]) = (bytemuck::cast(new), bytemuck::cast(old));
    for lane in 0..LANES {
        new[lane] = (new[lane] & maps[lane]) | (old[lane] & !maps[lane]);
    }
    bytemuck::cast(new)
}

impl Fan {
    /// Returns the fan behind a point of a bordered array. Of obtuse triangles it has only the edges.
    pub(super) fn of(behind: &Behind, edges: &EdgeLengths<f32>, point: usize) -> Self {
        let base =
            |slots: &TriangleSlots| slots.triangle(edges, point, [0.0; 2]).without_obtuse_face().c;
        Self {
            edges: behind.edges().map(|slot| edges.at(point, slot)),
            bases: behind.triangles().each_ref().map(base),
        }
    }
}
