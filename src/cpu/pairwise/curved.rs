//! The curved wavefront in lanes: the update of single maps, with the surface's part shared.

use bytemuck::{Pod, Zeroable};

use super::kernel::{Beyond, Fan, How, Kernel, LANES, Lanes};
use crate::cpu::bend_units;
use crate::cpu::state::{SEED, accept, is_from};
use crate::surface::{Real, Seed};
use crate::update::{Across, Bends, Front, Triangle, are_two_arcs, curved, is_of_either, two_arcs};

pub(super) struct Curved<const ARCS: bool>;

/// Arrival times, and curvatures of the fronts, tagged with the scans that brought them.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Fronts {
    times: Lanes,
    curvatures: Lanes,
}

impl<const ARCS: bool> Kernel for Curved<ARCS> {
    type State = Fronts;
    type Coefficients = Fan;

    const UNREACHED: Fronts = Fronts { times: Lanes::all(f32::FAR), curvatures: Lanes::all(0.0) };
    const BENDS: bool = true;
    const ARCS: bool = ARCS;

    fn coefficients(fan: Fan) -> Fan {
        fan
    }

    fn start(state: &mut Fronts, lane: usize, seed: Seed) {
        let front = Front { time: seed.time as f32, curvature: seed.curvature as f32, whole: true };
        let (time, curvature) = (&mut state.times.0[lane], &mut state.curvatures.0[lane]);
        (*time, *curvature) = accept(*time, *curvature, front, SEED, false, ARCS);
    }

    #[inline(always)]
    fn may_change(here: &Fronts, behind: [&Fronts; 3], _: &Fan, how: How) -> bool {
        let mut renewed = false;
        for lane in 0..LANES {
            renewed |= how.renews & is_from(here.curvatures.0[lane], how.scan.0);
        }
        renewed | here.times.some_after(behind.map(|fronts| &fronts.times))
    }

    #[inline(always)]
    fn update<const TRACKS: bool>(
        here: &mut Fronts,
        behind: [&Fronts; 3],
        fan: &Fan,
        beyond: Beyond<Self>,
        how: How,
        largest: &mut [u32; LANES],
    ) -> bool {
        let mut first = First::NONE;
        let mut parts = [Lanes::all(0.0); 2];
        let mut any = false;
        for lane in 0..LANES {
            let [left, right] = [0, 1].map(|base| fan.side(base, behind, lane));
            first.set(lane, Front::first(curved(left.0, left.1), curved(right.0, right.1), ARCS));
            for (parts, (triangle, bends)) in parts.iter_mut().zip([left, right]) {
                let are_two = ARCS && are_two_arcs([triangle.t1, triangle.t2], bends.fronts);
                parts.0[lane] = if are_two { 1.0 } else { 0.0 };
                any |= are_two;
            }
        }
        if any && narrow(&mut parts, behind, &beyond) {
            part(&mut first, &parts, behind, fan, beyond);
        }
        let mut wakes = !TRACKS;
        for (lane, largest) in largest.iter_mut().enumerate() {
            let (time, curvature) = (here.times.0[lane], here.curvatures.0[lane]);
            let (new, bent) =
                accept(time, curvature, first.get(lane), how.scan.0, how.renews, ARCS);
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

/// The first fronts to arrive.
struct First {
    fronts: Fronts,
    /// One where it is whole, as wide as the others for the sake of lanes.
    whole: Lanes,
}

impl First {
    const NONE: Self = Self { fronts: Curved::<true>::UNREACHED, whole: Lanes::all(0.0) };

    #[inline(always)]
    fn get(&self, lane: usize) -> Front<f32> {
        let whole = self.whole.0[lane] > 0.0;
        let Fronts { times, curvatures } = &self.fronts;
        Front { time: times.0[lane], curvature: curvatures.0[lane], whole }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, front: Front<f32>) {
        let Fronts { times, curvatures } = &mut self.fronts;
        (times.0[lane], curvatures.0[lane]) = (front.time, front.curvature);
        self.whole.0[lane] = if front.whole { 1.0 } else { 0.0 };
    }
}

/// Leaves of bases only those on which two arcs may touch; returns whether there are any.
#[inline(always)]
fn narrow<K: Kernel<State = Fronts>>(
    parts: &mut [Lanes; 2],
    behind: [&Fronts; 3],
    beyond: &Beyond<K>,
) -> bool {
    let across = [0, 1, 2].map(|column| beyond.state(column));
    let mut any = false;
    for lane in 0..LANES {
        let [behind, across] = [behind, across].map(|fronts| {
            fronts.map(|Fronts { times, curvatures }| [times.0[lane], curvatures.0[lane]])
        });
        for (base, parts) in parts.iter_mut().enumerate() {
            let ends = [behind[base], behind[base + 1]];
            let may = is_of_either(ends, across[base]) | is_of_either(ends, across[base + 1]);
            let parts = &mut parts.0[lane];
            *parts = if may { *parts } else { 0.0 };
            any |= *parts > 0.0;
        }
    }
    any
}

/// Replaces the first fronts of maps with a base on which two arcs touch, as `parts` says of the left
/// and the right one. One after another, since few maps have such a base at a point.
#[inline(never)]
fn part<K: Kernel<State = Fronts, Coefficients = Fan>>(
    first: &mut First,
    parts: &[Lanes; 2],
    behind: [&Fronts; 3],
    fan: &Fan,
    beyond: Beyond<K>,
) {
    for lane in 0..LANES {
        let [left, right] = parts.each_ref().map(|parts| parts.0[lane] > 0.0);
        if !(left | right) {
            continue;
        }
        let sides = [0, 1].map(|base| fan.side(base, behind, lane));
        let parted = [(0, left), (1, right)].map(|(base, parts)| {
            let (triangle, bends) = sides[base];
            parts.then(|| two_arcs(triangle, bends, across(&beyond, base, lane))).flatten()
        });
        if parted.iter().any(Option::is_some) {
            let [left, right] = [0, 1].map(|base| {
                let (triangle, bends) = sides[base];
                parted[base].unwrap_or_else(|| curved(triangle, bends))
            });
            first.set(lane, Front::first(left, right, true));
        }
    }
}

/// The points across the left or the right base, that behind the neighbour beside the point first.
fn across<K: Kernel<State = Fronts, Coefficients = Fan>>(
    beyond: &Beyond<K>,
    base: usize,
    lane: usize,
) -> [Across<f32>; 2] {
    let [at_x1, at_x2] = [base, base + 1].map(|column| beyond.state(column));
    let [fan_of_x1, fan_of_x2] = [base, base + 1].map(|column| beyond.coefficients(column));
    let point = |fronts: &Fronts, sides: [f32; 2]| Across {
        time: fronts.times.0[lane],
        curvature: fronts.curvatures.0[lane],
        sides,
    };
    let of_x1 = point(at_x1, [fan_of_x1.edges[1], fan_of_x2.edges[0]]);
    let of_x2 = point(at_x2, [fan_of_x1.edges[2], fan_of_x2.edges[1]]);
    if base == 0 { [of_x2, of_x1] } else { [of_x1, of_x2] }
}
