//! Fronts that carry their ray, where fronts of several sources meet, or a front meets itself.

use geosweep::cpu::Order;
use geosweep::glam::DVec3;
use geosweep::surface::Instructions;
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{EdgeLengths, Real};
use geosweep::vulkan::DeviceChoice;
use geosweep::{
    Engine, Options, Sources, Spacing, Stop, Surface, Wavefront, cpu, distance_map,
    distance_map_f64,
};

use crate::common::closed::{angle, flat, globe, octahedral, shapes, torus};
use crate::common::{Random, points};

const STOP: Stop = Stop::within(1e-6).or_after(500);

/// Returns a map with rays, from seeds of the sources.
fn rays<R: Real>(surface: &Surface, sources: &Sources) -> Vec<f64> {
    let seeds = sources.seeds_with_origins(surface).unwrap();
    let seeds = cpu::seeds_for(Wavefront::Rays, surface, seeds);
    let grid = surface.solver_grid();
    let seeds: Vec<_> = seeds.into_iter().map(|seed| grid.seed(seed)).collect();
    let edges = EdgeLengths::<R>::new(grid.surface()).unwrap();
    let map = cpu::rotated_scan(&edges, &seeds, Wavefront::Rays, STOP).distances();
    grid.crop(map).into_iter().map(R::wide).collect()
}

/// Returns how much a map is early and late at most.
fn errors(map: &[f64], exact: impl Fn(usize) -> f64) -> [f64; 2] {
    let late: Vec<_> = map.iter().enumerate().map(|(index, d)| d - exact(index)).collect();
    let most = |sign: f64| late.iter().map(|late| sign * late).fold(0.0, f64::max);
    [most(-1.0), most(1.0)]
}

/// Returns places that are `apart` from each other in rows or columns, and away from the sides.
fn places(
    random: &mut Random,
    rows: usize,
    cols: usize,
    count: usize,
    apart: f64,
) -> Vec<[f64; 2]> {
    let mut found: Vec<[f64; 2]> = Vec::new();
    while found.len() < count {
        let at = [rows, cols].map(|points| 1.5 + random.next() * (points as f64 - 4.0));
        let at = if found.len().is_multiple_of(2) { at } else { at.map(f64::round) };
        let is_apart =
            |other: &[f64; 2]| (at[0] - other[0]).abs().max((at[1] - other[1]).abs()) > apart;
        if found.iter().all(is_apart) {
            found.push(at);
        }
    }
    found
}

/// Sources are three cells apart, since a region narrower than a cell may contain no grid point.
#[test]
fn sources_on_planes_of_square_and_long_cells_are_exact() {
    let mut random = Random::new(3);
    for (number, long) in [1.0, 1.0, 3.0, 5.0, 9.0].into_iter().enumerate() {
        let (rows, cols) = (40 + 3 * number, 55);
        let spacing = Spacing { dx: long, dy: 1.0 };
        let plane = Surface::from_heights(rows, cols, vec![0.0; rows * cols], spacing).unwrap();
        let sources = places(&mut random, rows, cols, 2 + 2 * number, 3.0);
        let exact = |index: usize| {
            let away = |at: &[f64; 2]| {
                let (row, col) = ((index / cols) as f64, (index % cols) as f64);
                (row - at[0]).hypot(long * (col - at[1]))
            };
            sources.iter().map(away).fold(f64::INFINITY, f64::min)
        };
        // Directions have 16 digits in single precision, and 32 in double precision.
        for (map, tolerance) in [
            (rays::<f32>(&plane, &points(&sources)), 2e-3),
            (rays::<f64>(&plane, &points(&sources)), 2e-6),
        ] {
            let [early, late] = errors(&map, exact);
            assert!(early < tolerance && late < tolerance, "{long}: {early:e} {late:e}");
        }
    }
}

#[test]
fn a_front_that_meets_itself_on_flat_closed_surfaces_is_exact() {
    let mut random = Random::new(5);
    for (name, gluing, shape) in shapes() {
        for _ in 0..3 {
            let surface = flat(41, 65).with_gluing(gluing.clone()).unwrap();
            let sources = places(&mut random, 41, 65, 2, 4.0);
            let found = rays::<f32>(&surface, &points(&sources));
            let exact = |index| {
                let (row, col) = surface.chart().position(index);
                let ways =
                    sources.iter().flat_map(|&from| shape.ways(from, [row as f64, col as f64]));
                ways.map(|way| way.length()).fold(f64::INFINITY, f64::min)
            };
            let [early, late] = errors(&found, exact);
            // The largest errors are where fronts meet at a small angle, so that both count as one in part.
            assert!(early < 0.01 && late < 0.02, "{name} {sources:?}: {early:e} {late:e}");
        }
    }
}

#[test]
fn several_sources_on_spheres_are_as_near_as_great_circles() {
    let mut random = Random::new(7);
    for (name, surface, cell) in
        [("globe", globe(46, 91), 0.07), ("octahedral", octahedral(24), 0.05)]
    {
        for count in [2, 3, 6, 12] {
            let (rows, cols) = (surface.rows(), surface.cols());
            let sources: Vec<_> = places(&mut random, rows - 8, cols, count, 3.0)
                .into_iter()
                .map(|at| [at[0].round() + 4.0, at[1].round()])
                .collect();
            let at = |index| surface.position(index / cols, index % cols).unwrap();
            let places: Vec<DVec3> = sources
                .iter()
                .map(|at| surface.position(at[0] as usize, at[1] as usize).unwrap())
                .collect();
            let exact = |index| {
                places.iter().map(|&from| angle(from, at(index))).fold(f64::INFINITY, f64::min)
            };
            let map = distance_map_f64(&surface, &points(&sources), &Options::default()).unwrap();
            assert_eq!(map.report.wavefront, Wavefront::Rays);
            let [early, late] = errors(&map.distances, exact);
            assert!(
                early < 0.02 * cell && late < 0.02 * cell,
                "{name} {count}: {early:e} {late:e}"
            );
        }
    }
}

/// A map of several sources is the least of their own maps.
#[test]
fn sources_together_are_as_near_as_the_nearest_of_them_alone() {
    let mut random = Random::new(11);
    let hills = |relief: f64| {
        let height = move |k: usize| {
            let [u, v] = [k / 61, k % 61].map(|at| at as f64 / 10.0);
            relief * u.sin() * (0.8 * v).cos()
        };
        let heights = (0..61 * 61).map(height).collect();
        Surface::from_heights(61, 61, heights, Spacing::square(0.1)).unwrap()
    };
    for (name, surface, cell) in
        [("hills", hills(0.3), 0.1), ("high hills", hills(0.5), 0.1), ("torus", torus(41, 61), 0.2)]
    {
        for _ in 0..3 {
            let sources = places(&mut random, surface.rows(), surface.cols(), 4, 3.0);
            let alone: Vec<_> =
                sources.iter().map(|&at| rays::<f64>(&surface, &points(&[at]))).collect();
            let least =
                |index: usize| alone.iter().map(|map| map[index]).fold(f64::INFINITY, f64::min);
            let [early, late] = errors(&rays::<f64>(&surface, &points(&sources)), least);
            assert!(early < 0.02 * cell && late < 0.02 * cell, "{name}: {early:e} {late:e}");
        }
    }
}

/// The order of updates depends on how the grid lies.
#[test]
fn maps_do_not_depend_on_how_the_grid_lies() {
    let (rows, cols) = (48, 57);
    let at = |row: usize, col: usize| {
        let [u, v] = [row, col].map(|at| at as f64 / 9.0);
        DVec3::new(v, u, 0.3 * u.sin() * v.cos())
    };
    let sources = [[8.0, 9.0], [11.5, 40.25], [40.0, 22.0], [33.3, 50.0]];
    let upright =
        |at: &dyn Fn(usize, usize) -> DVec3, [rows, cols]: [usize; 2], sources: &[[f64; 2]]| {
            let positions = (0..rows * cols).map(|k| at(k / cols, k % cols)).collect();
            let surface = Surface::from_positions(rows, cols, positions).unwrap();
            rays::<f64>(&surface, &points(sources))
        };
    let first = upright(&at, [rows, cols], &sources);
    let turned = upright(&|row, col| at(col, row), [cols, rows], &sources.map(|[r, c]| [c, r]));
    let mirrored = upright(
        &|row, col| at(row, cols - 1 - col),
        [rows, cols],
        &sources.map(|[r, c]| [r, (cols - 1) as f64 - c]),
    );
    let largest = first.iter().copied().fold(0.0, f64::max);
    for (index, own) in first.iter().enumerate() {
        let (row, col) = (index / cols, index % cols);
        for other in [turned[col * rows + row], mirrored[row * cols + cols - 1 - col]] {
            let off = (own - other).abs();
            assert!(off < 2e-4 * largest, "{row},{col}: {own} {other}");
        }
    }
}

#[test]
fn devices_have_no_rays_and_say_so() {
    let sphere = Builtin::Sphere.surface(20, 20).unwrap();
    let options = Options::default().with_wavefront(Wavefront::Rays);
    let on_device = options.clone().with_engine(Engine::Vulkan(DeviceChoice::Any));
    let refused = distance_map(&sphere, &Sources::point(3.0, 4.0), &on_device);
    let error = refused.unwrap_err().to_string();
    assert!(error.contains("runs on the CPU only"), "{error}");
    let map = distance_map(&sphere, &Sources::point(3.0, 4.0), &options).unwrap();
    assert_eq!(map.report.wavefront, Wavefront::Rays);
    let slowed = sphere.with_slowness((0..400).map(|k| 1.0 + f64::from(k) / 400.0).collect());
    let map = distance_map(&slowed.unwrap(), &Sources::point(3.0, 4.0), &options).unwrap();
    assert_eq!(map.report.wavefront, Wavefront::Curved);
}

/// Instructions change nothing. The order of updates changes a map where fronts that nearly meet settle in one of two
/// ways.
#[test]
fn all_orders_and_instructions_give_one_map() {
    let surface = torus(65, 81);
    let sources = points(&[[8.0, 9.0], [21.5, 40.25], [40.0, 22.0], [53.3, 70.0]]);
    let grid = surface.solver_grid();
    let edges = EdgeLengths::<f32>::new(grid.surface()).unwrap();
    let seeds = sources.seeds_with_origins(&surface).unwrap();
    let seeds: Vec<_> = seeds.into_iter().map(|seed| grid.seed(seed)).collect();
    let map = |solver: cpu::RotatedScan<f32>| {
        let mut solver = solver;
        assert!(solver.solve(&seeds, STOP).residual <= 1e-6);
        solver.distances()
    };
    let solver = || cpu::RotatedScan::new(&edges, Wavefront::Rays);
    let first = map(solver());
    for instructions in Instructions::available() {
        assert!(map(solver().with_instructions(instructions)) == first, "{instructions}");
    }
    let largest = first.iter().copied().fold(0.0, f32::max);
    let patches = cpu::RotatedScan::in_order(&edges, Wavefront::Rays, Order::Patches { side: 32 });
    let off = first.iter().zip(&map(patches)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off < 2e-4 * largest, "{off} of {largest}");
    // Scans along the grid's own directions do not pass seams.
    let open = Builtin::Sphere.surface(65, 81).unwrap();
    let edges = EdgeLengths::<f32>::new(&open).unwrap();
    let seeds = sources.seeds_with_origins(&open).unwrap();
    let [rotated, directed] = [cpu::rotated_scan, cpu::raster_scan]
        .map(|solve| solve(&edges, &seeds, Wavefront::Rays, STOP).distances());
    let off = rotated.iter().zip(&directed).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off < 1e-5, "{off}");
}
