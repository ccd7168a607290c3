//! The curved wavefront in lanes: the update of single maps, with the surface's part shared.

use bytemuck::{Pod, Zeroable};

use super::kernel::{Fan, How, Kernel, LANES, Lanes};
use crate::cpu::bend_units;
use crate::cpu::fronts::{self, FrontKind};
use crate::surface::{Real, Seed};
use crate::update::{Bends, Carried, Curvature, Front, Kept, SEED, Triangle, curved};

pub(super) struct Curved;

/// Arrival times, and curvatures of the fronts, tagged with the scans that brought them.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Fronts {
    times: Lanes,
    curvatures: Lanes,
}

impl Kernel for Curved {
    type State = Fronts;
    type Coefficients = Fan;

    const UNREACHED: Fronts = Fronts { times: Lanes::all(f32::FAR), curvatures: Lanes::all(0.0) };
    const BENDS: bool = true;

    fn coefficients(fan: Fan) -> Fan {
        fan
    }

    fn start(state: &mut Fronts, lane: usize, seed: Seed) {
        let front = Front { time: seed.time as f32, curvature: seed.curvature as f32, whole: true };
        let (time, curvature) = (&mut state.times.0[lane], &mut state.curvatures.0[lane]);
        (*time, *curvature) = accept(*time, *curvature, front, SEED, false);
    }

    #[inline(always)]
    fn may_change(here: &Fronts, behind: [&Fronts; 3], _: &Fan, how: How) -> bool {
        let mut renewed = false;
        for lane in 0..LANES {
            renewed |= how.renews & tagged(here.curvatures.0[lane]).is_from(how.scan.0);
        }
        renewed | here.times.some_after(behind.map(|fronts| &fronts.times))
    }

    #[inline(always)]
    fn update<const TRACKS: bool>(
        here: &mut Fronts,
        behind: [&Fronts; 3],
        fan: &Fan,
        how: How,
        largest: &mut [u32; LANES],
    ) -> bool {
        let mut wakes = !TRACKS;
        for (lane, largest) in largest.iter_mut().enumerate() {
            let [left, right] = [0, 1].map(|base| fan.side(base, behind, lane));
            let first = Front::first(curved(left.0, left.1), curved(right.0, right.1));
            let (time, curvature) = (here.times.0[lane], here.curvatures.0[lane]);
            let (new, bent) = accept(time, curvature, first, how.scan.0, how.renews);
            (here.times.0[lane], here.curvatures.0[lane]) = (new, bent);
            if TRACKS {
                let bend = bend_units((bent - curvature).abs() * new);
                let change = time.units_between(new).max(bend);
                wakes |= change.max(curvature.units_between(bent)) > how.wakes;
                *largest = (*largest).max(change);
            }
        }
        wakes
    }
}

impl Fan {
    /// One of the two triangles, and what is known at its corners.
    #[inline(always)]
    fn side(&self, base: usize, behind: [&Fronts; 3], lane: usize) -> (Triangle<f32>, Bends<f32>) {
        let [[t1, t2], fronts] = [
            [base, base + 1].map(|column| behind[column].times.0[lane]),
            [base, base + 1].map(|column| behind[column].curvatures.0[lane]),
        ];
        let [l1, l2] = [self.edges[base], self.edges[base + 1]];
        let surface = [self.gaussian[0], self.gaussian[base + 1], self.gaussian[base + 2]];
        let alone = self.edges[1] >= f32::FAR;
        (Triangle { t1, t2, l1, l2, c: self.bases[base] }, Bends { fronts, surface, alone })
    }
}

#[inline(always)]
fn tagged(curvature: f32) -> Curvature<f32> {
    bytemuck::cast(curvature)
}

#[inline(always)]
fn accept(time: f32, curvature: f32, front: Front<f32>, scan: u8, renews: bool) -> (f32, f32) {
    let kept = Kept { time, carried: tagged(curvature) };
    let kept = fronts::Curved::accept(kept, front, scan, renews);
    (kept.time, kept.carried.value())
}
