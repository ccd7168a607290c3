//! Maps that are solved point by point in the order of arrival times, compared with maps by scans.

use geosweep::cpu::{Order, RotatedScan};
use geosweep::surface::builtin::{Builtin, Closed};
use geosweep::surface::{EdgeLengths, Real};
use geosweep::{Options, Sources, Spacing, Stop, Surface, Targets, Wavefront, distance_map};

use crate::common::closed::globe;
use crate::common::{CONVERGED, CONVERGED_F64, Random, at, difference, off_centre, points};

/// Returns a surface with blocks of `side` points, whose slownesses are random powers of ten up to 10^`power`.
fn in_blocks(surface: Surface, side: usize, power: f64) -> Surface {
    let (rows, cols) = (surface.rows(), surface.cols());
    let mut random = Random::new(7);
    let across = cols.div_ceil(side);
    let blocks: Vec<f64> =
        (0..rows.div_ceil(side) * across).map(|_| 10f64.powf(power * random.next())).collect();
    let slowness = (0..rows * cols).map(|k| blocks[k / cols / side * across + k % cols / side]);
    let slowness = slowness.collect();
    surface.with_slowness(slowness).unwrap()
}

/// Returns surfaces with a slowness that jumps: flat, curved, with obtuse triangles, with holes, with free travel.
fn slowed_surfaces() -> Vec<(&'static str, Surface)> {
    let built = |builtin: Builtin, rows, cols| builtin.surface(rows, cols).unwrap();
    let plane = |rows, cols| built(Builtin::Plane, rows, cols);
    let mut mask = vec![true; 90 * 75];
    (10..60).for_each(|row| mask[row * 75 + 33] = false);
    let free = (0..70 * 80).map(|k| [0.0, 1.0, 3.0][k / 80 / 10 % 3]).collect();
    vec![
        ("blocks", in_blocks(plane(100, 131), 13, 1.0)),
        ("rough", in_blocks(plane(80, 90), 1, 0.5)),
        ("steep contrast", in_blocks(plane(80, 90), 9, 3.0)),
        ("peaks", in_blocks(built(Builtin::Peaks, 97, 96), 17, 0.7)),
        ("sheared", in_blocks(built(Builtin::ShearedPlane { degrees: 60.0 }, 60, 70), 11, 0.5)),
        ("a wall", in_blocks(plane(90, 75), 8, 1.0).with_mask(&mask).unwrap()),
        ("free travel", plane(70, 80).with_slowness(free).unwrap()),
        ("a line", in_blocks(plane(1, 50), 3, 1.0)),
    ]
}

/// Patches in the order of time.
const PATCHES: Order = Order::TimesInPatches { side: 96 };

/// Returns surfaces of several patches, with the same features.
fn large_surfaces() -> Vec<(&'static str, Surface)> {
    let built = |builtin: Builtin, rows, cols| builtin.surface(rows, cols).unwrap();
    let plane = |rows, cols| built(Builtin::Plane, rows, cols);
    let flat = |rows: usize, cols: usize| {
        Surface::from_heights(rows, cols, vec![0.0; rows * cols], Spacing::square(1.0)).unwrap()
    };
    let mut mask = vec![true; 260 * 231];
    (10..200).for_each(|row| mask[row * 231 + 97] = false);
    let free = (0..200 * 200).map(|k| [0.0, 1.0, 3.0][k / 200 / 20 % 3]).collect();
    vec![
        ("blocks", in_blocks(plane(201, 290), 13, 1.0)),
        ("rough", in_blocks(plane(300, 193), 1, 0.5)),
        ("steep contrast", in_blocks(plane(220, 230), 9, 3.0)),
        ("peaks", in_blocks(built(Builtin::Peaks, 257, 240), 17, 0.7)),
        ("sheared", in_blocks(built(Builtin::ShearedPlane { degrees: 60.0 }, 210, 240), 11, 0.5)),
        ("a wall", in_blocks(plane(260, 231), 8, 1.0).with_mask(&mask).unwrap()),
        ("free travel", plane(200, 200).with_slowness(free).unwrap()),
        ("a strip", in_blocks(flat(3, 14_000), 30, 1.0)),
    ]
}

fn solved<R: Real>(
    surface: &Surface,
    sources: &Sources,
    wavefront: Wavefront,
    order: Order,
    stop: Stop,
) -> Vec<R> {
    let edges = EdgeLengths::<R>::new(surface).unwrap();
    let mut solver = RotatedScan::in_order(&edges, wavefront, order);
    let convergence = solver.solve(&sources.seeds(surface).unwrap(), stop);
    assert!(convergence.residual <= stop.tolerance, "{wavefront}: {convergence:?}");
    solver.distances()
}

/// Returns the largest differences of maps in order of time from maps by scans, relative to the largest distance, and
/// their mean.
fn apart<R: Real>(
    surface: &Surface,
    sources: &Sources,
    wavefront: Wavefront,
    order: Order,
    stop: Stop,
) -> [f64; 2] {
    let [times, lines] =
        [order, Order::Lines].map(|order| solved::<R>(surface, sources, wavefront, order, stop));
    let reached = |map: &[R]| map.iter().filter(|distance| distance.is_finite()).count();
    assert_eq!(reached(&times), reached(&lines));
    let largest = lines.iter().map(|d| d.wide()).filter(|d| d.is_finite()).fold(0.0, f64::max);
    let both = times.iter().zip(&lines).filter(|(_, b)| b.is_finite());
    let differences = both.map(|(a, b)| (a.wide() - b.wide()).abs() / largest);
    [difference(&times, &lines), differences.sum::<f64>() / times.len() as f64]
}

/// The front at a point depends on those at earlier points alone, so all orders converge to the same map.
#[test]
fn points_in_order_of_time_give_the_map_of_scans() {
    let mut all: Vec<(&str, Surface, Sources)> = Vec::new();
    for (name, surface) in slowed_surfaces() {
        let source = at(off_centre(surface.rows(), surface.cols()));
        all.push((name, surface, source));
    }
    let several = points(&[[5.0, 5.0], [60.5, 70.0], [90.3, 10.6]]);
    all.push((
        "several sources",
        in_blocks(Builtin::Plane.surface(100, 90).unwrap(), 10, 1.0),
        several,
    ));
    for (name, surface, sources) in &all {
        let planar = [
            apart::<f32>(surface, sources, Wavefront::Planar, Order::Times, CONVERGED)[0],
            apart::<f64>(surface, sources, Wavefront::Planar, Order::Times, CONVERGED_F64)[0],
        ];
        let curved = apart::<f64>(surface, sources, Wavefront::Curved, Order::Times, CONVERGED_F64);
        println!(
            "{name}: {:.1e} {:.1e}, curved {:.1e}, mean {:.1e}",
            planar[0], planar[1], curved[0], curved[1]
        );
        assert!(planar[0] < 1e-5 && planar[1] < 1e-9, "{name}: {planar:?}");
        assert!(curved[0] < 1e-6 && curved[1] < 1e-8, "{name}: {curved:?}");
    }
}

/// On large surfaces each patch has a queue of its own.
#[test]
fn patches_in_order_of_time_give_the_map_of_scans() {
    for (name, surface) in large_surfaces() {
        let [row, col] = off_centre(surface.rows(), surface.cols());
        let several = points(&[[row, col], [1.0, 2.0], [row / 2.0, col / 3.0 + 0.25]]);
        for (sources, side) in [(at([row, col]), 96), (several, 64)] {
            let order = Order::TimesInPatches { side };
            let single = apart::<f32>(&surface, &sources, Wavefront::Planar, order, CONVERGED)[0];
            let double =
                apart::<f64>(&surface, &sources, Wavefront::Planar, order, CONVERGED_F64)[0];
            let curved = apart::<f64>(&surface, &sources, Wavefront::Curved, order, CONVERGED_F64);
            println!(
                "{name}: {single:.1e} {double:.1e}, curved {:.1e} {:.1e}",
                curved[0], curved[1]
            );
            assert!(single < 1e-5 && double < 1e-9, "{name}: {single:e} {double:e}");
            assert!(curved[0] < 1e-6 && curved[1] < 1e-8, "{name}: {curved:?}");
        }
    }
}

#[test]
fn maps_in_order_of_time_are_the_same_on_any_number_of_threads() {
    for (name, surface) in large_surfaces() {
        let sources = at(off_centre(surface.rows(), surface.cols()));
        for wavefront in [Wavefront::Planar, Wavefront::Curved] {
            let on = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| solved::<f32>(&surface, &sources, wavefront, PATCHES, CONVERGED))
            };
            let one = on(1);
            assert!(one == on(2) && one == on(5), "{name} {wavefront}");
        }
    }
}

#[test]
fn fronts_pass_seams_in_order_of_time() {
    for (name, surface, sources) in [
        ("torus", Closed::Torus.surface(70, 101).unwrap(), at([0.0, 100.0])),
        ("globe", globe(61, 121), at([20.0, 2.0])),
    ] {
        // A block inside, so that the copies of a point agree.
        let cols = surface.cols();
        let in_block = |k: usize| (20..40).contains(&(k / cols)) && (30..60).contains(&(k % cols));
        let slowness = (0..surface.rows() * cols).map(|k| if in_block(k) { 3.0 } else { 1.0 });
        let slowness = slowness.collect();
        let surface = surface.with_slowness(slowness).unwrap();
        for order in [Order::Times, PATCHES] {
            let [largest, _] =
                apart::<f64>(&surface, &sources, Wavefront::Planar, order, CONVERGED_F64);
            assert!(largest < 1e-9, "{name}: {largest:e}");
        }
    }
}

/// Work ends with the radius or with the targets, and can go on.
#[test]
fn limited_maps_end_early() {
    let surface = in_blocks(Builtin::Plane.surface(200, 210).unwrap(), 20, 1.0);
    let edges = EdgeLengths::<f32>::new(&surface).unwrap();
    let seeds = at([100.0, 100.0]).seeds(&surface).unwrap();
    let wavefronts = [Wavefront::Planar, Wavefront::Curved];
    for (wavefront, order) in wavefronts
        .into_iter()
        .flat_map(|wavefront| [(wavefront, Order::Times), (wavefront, PATCHES)])
    {
        let is_one_queue = order == Order::Times;
        let mut whole = RotatedScan::in_order(&edges, wavefront, order);
        whole.solve(&seeds, CONVERGED);
        let (map, visits) = (whole.distances(), whole.visits());
        let mut sorted = map.clone();
        sorted.sort_by(f32::total_cmp);
        let radius = sorted[2000];
        let mut near = RotatedScan::in_order(&edges, wavefront, order);
        near.set_radius(f64::from(radius));
        near.solve(&seeds, CONVERGED);
        let expected = |&distance: &f32| if distance <= radius { distance } else { f32::INFINITY };
        assert_eq!(near.distances(), map.iter().map(expected).collect::<Vec<_>>(), "{wavefront}");
        assert!(near.visits() * 10 < visits, "{} of {visits}", near.visits());
        assert_eq!(near.reached().len(), map.iter().filter(|&&d| d <= radius).count());
        for target in [[110, 95], [180, 20]] {
            let mut to = RotatedScan::in_order(&edges, wavefront, order);
            to.solve_to(&seeds, &Targets::all([target]), CONVERGED);
            let index = target[0] * 210 + target[1];
            assert_eq!(to.distances()[index], map[index], "{wavefront}");
            let earlier = map.iter().filter(|&&distance| distance <= map[index]).count() as u64;
            // In patches, some points along the borders are computed again.
            let again = if is_one_queue { 0 } else { earlier / 10 };
            let most = earlier + again + 1000;
            assert!(to.visits() < most, "{} for {earlier}", to.visits());
            // Adding no source completes the map.
            to.add(&[], CONVERGED);
            let completed = to.distances();
            if is_one_queue {
                assert_eq!(completed, map, "{wavefront}");
            }
            // The rounds of patches are others now. Changes of up to two units in the last place are not passed on, and
            // add up over some points.
            let off = difference(&completed, &map);
            assert!(off < 8.0 * f64::from(f32::EPSILON), "{wavefront}: {off:e}");
        }
    }
}

#[test]
fn sources_are_added_to_a_map_in_order_of_time() {
    for order in [Order::Times, Order::TimesInPatches { side: 32 }] {
        let surface = in_blocks(Builtin::Plane.surface(120, 110).unwrap(), 15, 1.0);
        let edges = EdgeLengths::<f64>::new(&surface).unwrap();
        let seeds = |point| at(point).seeds(&surface).unwrap();
        let (first, second) = (seeds([20.0, 20.0]), seeds([100.0, 95.0]));
        let mut solver = RotatedScan::in_order(&edges, Wavefront::Planar, order);
        solver.solve(&first, CONVERGED_F64);
        let of_first = solver.visits();
        solver.add(&second, CONVERGED_F64);
        assert!(solver.visits() < 2 * of_first);
        let both = [first, second].concat();
        let mut fresh = RotatedScan::in_order(&edges, Wavefront::Planar, order);
        fresh.solve(&both, CONVERGED_F64);
        assert!(difference(&solver.distances(), &fresh.distances()) < 1e-12);
        // A solver forgets the map before.
        fresh.solve(&seeds([7.0, 90.0]), CONVERGED_F64);
        fresh.solve(&both, CONVERGED_F64);
        assert!(difference(&solver.distances(), &fresh.distances()) < 1e-12);
    }
}

/// The best order is that of time where the slowness changes much from point to point. Scans would visit points many
/// times there.
#[test]
fn rough_slownesses_are_solved_in_order_of_time() {
    let plane = || Builtin::Plane.surface(300, 300).unwrap();
    let visits = |surface: &Surface, order: Option<Order>| {
        let edges = EdgeLengths::<f32>::new(surface).unwrap();
        let mut solver = match order {
            Some(order) => RotatedScan::in_order(&edges, Wavefront::Planar, order),
            None => RotatedScan::new(&edges, Wavefront::Planar),
        };
        solver.solve(&at([70.0, 150.0]).seeds(surface).unwrap(), CONVERGED);
        solver.visits()
    };
    let smooth = |k: usize| 1.2 + 0.2 * (k as f64 / 300.0 / 60.0).sin();
    let smooth = plane().with_slowness((0..90_000).map(smooth).collect()).unwrap();
    for (surface, best) in [
        (in_blocks(plane(), 10, 1.0), Order::Times),
        (in_blocks(plane(), 1, 0.5), Order::Times),
        (smooth, Order::Lines),
        (plane(), Order::Lines),
    ] {
        assert_eq!(visits(&surface, None), visits(&surface, Some(best)), "{best:?}");
        let map = distance_map(&surface, &at([70.0, 150.0]), &Options::default()).unwrap();
        assert!(map.report.converged);
    }
}
