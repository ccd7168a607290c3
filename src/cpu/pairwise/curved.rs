//! The curved wavefront in lanes: the update of single maps, with the surface's part shared.

use bytemuck::{Pod, Zeroable};

use super::kernel::{Fan, How, Kernel, LANES, Lanes};
use crate::cpu::bend_units;
use crate::cpu::state::{SEED, accept, front};
use crate::surface::{Real, Seed};
use crate::update::{Bends, Front, Triangle, curved};

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
            let (_, brought_by) = front(here.times.0[lane], here.curvatures.0[lane]);
            renewed |= how.renews & (brought_by == how.scan.0);
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
        let Fan { edges, bases, gaussian } = fan;
        let mut wakes = !TRACKS;
        for (lane, largest) in largest.iter_mut().enumerate() {
            let [a, b, c] = behind.map(|fronts| (fronts.times.0[lane], fronts.curvatures.0[lane]));
            let side = |near: (f32, f32), far: (f32, f32), k: usize| {
                let triangle =
                    Triangle { t1: near.0, t2: far.0, l1: edges[k], l2: edges[k + 1], c: bases[k] };
                let surface = [gaussian[0], gaussian[k + 1], gaussian[k + 2]];
                curved(triangle, Bends { fronts: [near.1, far.1], surface })
            };
            let first = Front::first(side(a, b, 0), side(b, c, 1));
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
