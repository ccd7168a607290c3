//! Maps and matrices on devices with memory of their own: shaders access that memory alone, and copies pass
//! inputs and results between that memory and the host's.

use geosweep::surface::builtin::Builtin;
use geosweep::vulkan::{HeadlessSolver, Method, PairwiseSchedule, Schedule, Tuning};
use geosweep::{MetricTensor, Sources, Spacing, Stop, Surface, Wavefront};

use crate::common::*;

/// Returns a solver whose shaders access the host's memory, and one whose shaders do not.
fn solvers() -> [Lent<HeadlessSolver>; 2] {
    [vulkan_solver(), tuned(|old| Tuning { staged: true, ..old }).into()]
}

/// The maps have every kind of input, several bands in each direction, anchors and numbered origins in the upload
/// buffer, and more sources than this buffer has room for.
#[test]
fn staged_maps_are_the_same_to_the_bit() {
    use Wavefront::{Anchored, Curved, Planar};
    let mut solvers = solvers();
    let plane = |rows, cols| {
        Surface::from_heights(rows, cols, vec![0.0; rows * cols], Spacing::square(0.7)).unwrap()
    };
    let holes = rough(301, 299, 5);
    let slowed = slowed(301, 253, 130);
    let metric = MetricTensor { rr: 1.0, rc: 0.2, cc: 1.5 };
    let metric = Surface::from_metric(270, 300, vec![metric; 270 * 300]).unwrap();
    let inside = Sources::point(3.25, 5.5).and_point(30.5, 41.0, 1.5);
    let many = (0..28_000).fold(Sources::default(), |sources, i| {
        sources.and_point(f64::from(2 * (i / 151)), f64::from(2 * (i % 151)), f64::from(i % 3))
    });
    let few = Stop::after(3);
    for (what, surface, sources, wavefront, stop) in [
        ("positions", Builtin::Sphere.surface(300, 302).unwrap(), &inside, Curved, few),
        ("heights with holes", holes.clone(), &middle(&holes), Planar, few),
        ("metric", metric, &inside, Curved, few),
        ("slowness", slowed.clone(), &middle(&slowed), Curved, few),
        ("anchors", plane(51, 43), &inside, Anchored, CONVERGED),
        ("origins", plane(300, 302), &inside, Curved, few),
        ("many sources", plane(400, 302), &many, Planar, few),
    ] {
        let seeds = match wavefront {
            Planar => sources.seeds(&surface).unwrap(),
            _ => sources.seeds_with_origins(&surface).unwrap(),
        };
        let further = middle(&surface).seeds(&surface).unwrap();
        for schedule in [Schedule::Raster, Schedule::Tiles] {
            let [direct, staged] = solvers.each_mut().map(|solver| {
                let mut on_device = solver.upload(&surface).unwrap();
                let method = Method::new(wavefront, stop).with_schedule(schedule);
                let solved = solver.solve(&mut on_device, &seeds, method).unwrap();
                let added = solver.add(&mut on_device, &further, method).unwrap();
                (solved.distances, added.distances)
            });
            assert!(direct == staged, "{what}, {schedule}");
        }
    }
    assert_nothing_said(&solvers[1]);
}

/// Matrices have several batches. The third has no sources, the last one is smaller, and sources are missing in
/// between.
#[test]
fn staged_matrices_are_the_same_to_the_bit() {
    let solvers = solvers();
    let surface = Builtin::Sphere.surface(40, 41).unwrap();
    let points = 40 * 41;
    for schedule in PairwiseSchedule::ALL {
        let [direct, staged] = solvers.each_ref().map(|solver| {
            let on_device = solver.upload(&surface).unwrap();
            let mut pairwise =
                solver.pairwise(&on_device, Wavefront::Curved, Some(schedule)).unwrap();
            let batch = pairwise.batch();
            let count = 4 * batch + 3;
            let is_there = |i: usize| i % 7 != 3 && i / batch != 2;
            let sources: Vec<_> =
                (0..count).map(|i| is_there(i).then_some(31 * i % points)).collect();
            let mut rows = vec![0.0; count * points];
            let stop = Stop::after(3);
            pairwise.solve(solver, &on_device, &sources, stop, &mut rows).unwrap();
            rows
        });
        assert!(direct == staged, "{schedule}");
    }
    assert_nothing_said(&solvers[1]);
}
