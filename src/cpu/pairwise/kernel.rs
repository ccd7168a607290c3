//! What the update of a point in lanes needs, whatever the front.

use bytemuck::{Pod, Zeroable};

use crate::cpu::state::TriangleSlots;
use crate::cpu::tiles::Scan;
use crate::surface::{Chart, Direction, EdgeLengths, Seed};

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
}

/// The largest change in each lane since the line began.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Changes {
    /// In units of the time's precision, as the stop criterion counts.
    pub largest: [u32; LANES],
    /// The same, with everything that later updates depend on.
    pub any: [u32; LANES],
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
}

/// A front in lanes.
pub(super) trait Kernel: Sized + 'static {
    /// The maps at a point; the first lanes are the arrival times.
    type State: Pod + Send + Sync;

    /// What all maps share at a point, for one of the scans.
    type Coefficients: Copy + Send + Sync;

    /// Where no front has arrived.
    const UNREACHED: Self::State;

    /// Whether [`Fan::gaussian`] is needed.
    const BENDS: bool = false;

    fn coefficients(fan: Fan) -> Self::Coefficients;

    /// Makes a point the source of one of the maps.
    fn start(state: &mut Self::State, lane: usize, seed: Seed);

    /// Updates a point from the three behind. Changes are noted if `TRACKS`.
    fn update<const TRACKS: bool>(
        here: &mut Self::State,
        behind: [&Self::State; 3],
        coefficients: &Self::Coefficients,
        how: How,
        changes: &mut Changes,
    );
}

/// Where the two triangles of a scan lie, seen from their point.
#[derive(Clone, Copy, Debug)]
pub(super) struct FanSlots {
    triangles: [TriangleSlots; 2],
    neighbours: [isize; 3],
}

impl FanSlots {
    /// The neighbours that a scan has just passed, in the order of the points on its lines.
    pub(super) fn new(chart: Chart, scan: Scan) -> Self {
        use Direction::*;
        let neighbours = match scan {
            Scan::DOWN => [NorthWest, North, NorthEast],
            Scan::UP => [SouthWest, South, SouthEast],
            Scan::RIGHT => [NorthWest, West, SouthWest],
            _ => [NorthEast, East, SouthEast],
        };
        let [before, beside, after] = neighbours;
        Self {
            triangles: [
                TriangleSlots::new(chart, before, beside),
                TriangleSlots::new(chart, beside, after),
            ],
            neighbours: neighbours.map(|neighbour| chart.offset(neighbour)),
        }
    }

    /// The fan of a point of a bordered array.
    pub(super) fn fan(&self, edges: &EdgeLengths<f32>, gaussian: &[f32], point: usize) -> Fan {
        let [[before, beside, first], [_, after, second]] =
            self.triangles.each_ref().map(|slots| slots.lengths(edges, point));
        let [a, b, c] = self.neighbours;
        let at = |offset: isize| {
            gaussian.get(point.wrapping_add_signed(offset)).copied().unwrap_or_default()
        };
        Fan {
            edges: [before, beside, after],
            bases: [first, second],
            gaussian: [at(0), at(a), at(b), at(c)],
        }
    }
}
