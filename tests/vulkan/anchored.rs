//! Anchored fronts on a Vulkan device, compared with the CPU engine and exact distances, under the validation
//! layers.

use geosweep::pairwise::Pairwise;
use geosweep::surface::Seed;
use geosweep::vulkan::{Method, Schedule, VulkanError};
use geosweep::{DeviceChoice, Engine, Options, Sources, Spacing, Surface, Wavefront};

use crate::common::closed::flat;
use crate::common::*;

/// Largest difference relative to the largest distance: the rounding errors along a path from corner to
/// corner.
const AGREEMENT: f64 = 2e-6;

fn anchored(schedule: Schedule) -> Method {
    Method::new(Wavefront::Anchored, CONVERGED).with_schedule(schedule)
}

/// Returns a plane with boxes and walls as holes, and some of its points.
fn floor_plan(number: u64, rows: usize, cols: usize) -> (Surface, Vec<[usize; 2]>) {
    let mut random = Random::new(number);
    let mut below = |most: usize| (random.next() * most as f64) as usize;
    let mut floor = vec![true; rows * cols];
    let mut clear = |row: usize, col: usize, down: usize, right: usize| {
        for row in row..(row + down).min(rows) {
            floor[row * cols + col..row * cols + (col + right).min(cols)].fill(false);
        }
    };
    for _ in 0..1 + number % 7 {
        let (row, col) = (below(rows), below(cols));
        clear(row, col, 2 + below(rows / 4), 2 + below(cols / 4));
    }
    for _ in 0..number % 5 {
        let (row, col) = (below(rows), below(cols));
        if below(2) == 0 {
            clear(row, col, 1, 2 + below(cols / 2));
        } else {
            clear(row, col, 2 + below(rows / 2), 1);
        }
    }
    let free: Vec<_> = (0..rows * cols).filter(|&point| floor[point]).collect();
    let some = (0..8).map(|_| free[below(free.len())]).map(|point| [point / cols, point % cols]);
    let some = some.collect();
    let spacing = if number % 4 == 1 { Spacing { dx: 1.0, dy: 1.3 } } else { Spacing::square(0.7) };
    let plane = Surface::from_heights(rows, cols, vec![0.0; rows * cols], spacing).unwrap();
    (plane.with_mask(&floor).unwrap(), some)
}

/// Returns the seeds of sources with different start values. Half of them are inside cells beside the places, if
/// they are on the plan there. The others are at the places.
fn some_seeds(surface: &Surface, places: &[[usize; 2]], number: u64) -> Vec<Seed> {
    let mut random = Random::new(number + 1000);
    let mut all = Vec::new();
    for (k, &[row, col]) in places.iter().enumerate() {
        let (row, col) = (row as f64, col as f64);
        let time = if k == 0 { 0.0 } else { 3.0 * random.next() };
        let (down, right) = (0.9 * random.next(), 0.9 * random.next());
        let inside = Sources::default().and_point(row + down, col + right, time);
        let on_point = Sources::default().and_point(row, col, time);
        let wanted =
            if (number as usize + k).is_multiple_of(2) { inside } else { on_point.clone() };
        all.extend(wanted.seeds(surface).or_else(|_| on_point.seeds(surface)).unwrap());
    }
    all
}

/// Returns the plan with a number, and seeds on it.
fn seeded_plan(number: u64) -> (Surface, Vec<Seed>) {
    let (rows, cols) = (30 + number as usize % 40, 34 + 3 * (number as usize % 17));
    let (surface, places) = floor_plan(number, rows, cols);
    assert!(surface.is_floor_plan());
    let count = [1, 1, 3, 6][number as usize % 4];
    let seeds = some_seeds(&surface, &places[..count], number);
    (surface, seeds)
}

/// Maps over plans and rooms are those of the CPU, half of them on a device like a GPU.
#[test]
fn every_schedule_leads_to_the_map_of_the_cpu() {
    let mut solvers = [vulkan_solver(), gpu_like_solver()];
    let mut worst = 0.0f64;
    for (number, (surface, seeds)) in (0..8).map(seeded_plan).chain((0..6).map(rooms)).enumerate() {
        let solver = &mut solvers[number / 4 % 2];
        let cpu = on_cpu(&surface, &seeds, Wavefront::Anchored, CONVERGED);
        let mut on_device = solver.upload(&surface).unwrap();
        for schedule in Schedule::ALL {
            let solution = solver.solve(&mut on_device, &seeds, anchored(schedule)).unwrap();
            let difference = difference(&cpu, &solution.distances);
            let what = format!("plan {number}, {schedule}");
            assert!(difference < AGREEMENT, "{what}: {difference:e}");
            assert!(solution.residual <= CONVERGED.tolerance, "{what}");
            let again = solver.solve(&mut on_device, &seeds, anchored(schedule)).unwrap();
            assert!(again.distances == solution.distances, "{what}");
            worst = worst.max(difference);
        }
    }
    println!("{worst:.1e}");
}

/// Some of the added sources are inside cells. Their numbers continue those of the map.
#[test]
fn sources_can_be_added() {
    let mut solver = vulkan_solver();
    for number in [3, 7, 10, 14] {
        let (surface, seeds) = seeded_plan(number);
        let mut on_device = solver.upload(&surface).unwrap();
        let cpu = on_cpu(&surface, &seeds, Wavefront::Anchored, CONVERGED);
        let of_first = |seed: &&Seed| seed.from == seeds[0].from;
        let first = seeds.iter().take_while(of_first).count();
        let (first, rest) = seeds.split_at(first);
        assert!(!rest.is_empty());
        for schedule in Schedule::ALL {
            let one = solver.solve(&mut on_device, first, anchored(schedule)).unwrap();
            let all = solver.add(&mut on_device, rest, anchored(schedule)).unwrap();
            assert_ne!(one.distances, all.distances);
            let difference = difference(&cpu, &all.distances);
            assert!(difference < AGREEMENT, "plan {number}, {schedule}: {difference:e}");
        }
    }
}

/// Returns the rows of some sources, solved at once.
fn rows(surface: &Surface, sources: &[Option<usize>], wavefront: Wavefront) -> Vec<f32> {
    let solver = vulkan_solver();
    let on_device = solver.upload(surface).unwrap();
    let mut pairwise = solver.pairwise(&on_device, wavefront, None).unwrap();
    let mut rows = vec![0.0; sources.len() * surface.chart().points()];
    pairwise.solve(&solver, &on_device, sources, CONVERGED, &mut rows).unwrap();
    rows
}

/// On surfaces without anchors, fronts are curved. Many maps at once have curved fronts on floor plans too.
#[test]
fn curved_fronts_take_the_place_of_anchored_ones() {
    let slowness = (0..30 * 40).map(|i| 1.0 + f64::from(i % 3)).collect();
    let plan = || floor_plan(5, 30, 40).0;
    let wavefronts = [Wavefront::Anchored, Wavefront::Curved];
    for surface in [rough(30, 40, 0), plan().with_slowness(slowness).unwrap()] {
        let seeds = seeds_at(&surface, some_point(&surface));
        let [anchored, curved] = wavefronts.map(|wavefront| {
            on_vulkan(&mut vulkan_solver(), &surface, &seeds, wavefront, CONVERGED)
        });
        assert_eq!(anchored, curved);
    }
    for surface in [rough(30, 40, 0), plan()] {
        let first = surface.present().iter().position(|&present| present);
        let sources = [first, None, Some(surface.chart().points() - 1)];
        let [anchored, curved] = wavefronts.map(|wavefront| rows(&surface, &sources, wavefront));
        assert!(anchored == curved && anchored.iter().any(|d| *d > 0.0));
    }
    let options = Options::default()
        .with_engine(Engine::Vulkan(DeviceChoice::Any))
        .with_wavefront(Wavefront::Anchored);
    assert!(Pairwise::new(&plan(), &options).is_err(), "the CPU has such matrices");
}

/// A table holds the sources inside cells. If there are more sources than the table holds, their map has curved
/// fronts, and sources that no longer fit cannot be added to a map.
#[test]
fn sources_inside_cells_are_as_many_as_there_is_room_for() {
    let mut solver = vulkan_solver();
    let surface = flat(70, 66);
    let sources = |count: usize| {
        let place = |i: usize| ((i / 64) as f64 + 0.5, (i % 64) as f64 + 0.25);
        let places = (0..count).map(place);
        let all = Sources::default();
        places.fold(all, |all, (row, col)| all.and_point(row, col, 0.01 * row)).seeds(&surface)
    };
    let (most, more) = (sources(4096).unwrap(), sources(4097).unwrap());
    let mut on_device = solver.upload(&surface).unwrap();
    let method = anchored(Schedule::Raster);
    let map = solver.solve(&mut on_device, &most, method).unwrap();
    let cpu = on_cpu(&surface, &most, Wavefront::Anchored, CONVERGED);
    assert!(difference(&cpu, &map.distances) < AGREEMENT);
    let error = solver.add(&mut on_device, &more[more.len() - 4..], method);
    assert!(matches!(error, Err(VulkanError::TooManyAnchors { most: 4096 })), "{error:?}");
    let map = solver.solve(&mut on_device, &more, method).unwrap();
    let curved = method.with_wavefront(Wavefront::Curved);
    assert_eq!(map.distances, solver.solve(&mut on_device, &more, curved).unwrap().distances);
    // A map continues with the wavefront with which it started.
    let alone = Sources::point(68.5, 3.25).seeds(&surface).unwrap();
    solver.solve(&mut on_device, &more, method).unwrap();
    solver.add(&mut on_device, &alone, method).unwrap();
    let fresh = solver.solve(&mut on_device, &alone, method).unwrap();
    let cpu = on_cpu(&surface, &alone, Wavefront::Anchored, CONVERGED);
    assert!(difference(&cpu, &fresh.distances) < AGREEMENT);
}

/// Returns rooms of 23 x 23 points with some doors between them, and the seeds of a source inside a cell of one room.
fn rooms(number: u64) -> (Surface, Vec<Seed>) {
    let (rows, cols) = (97, 73);
    let mut random = Random::new(number);
    let mut from = |low: f64, high: f64| low + (high - low) * random.next();
    let mut floor: Vec<_> = (0..rows * cols)
        .map(|point| ![point / cols, point % cols].iter().any(|line| line % 24 == 0))
        .collect();
    for (row, col) in
        (0..rows).step_by(24).flat_map(|row| (0..cols).step_by(24).map(move |col| (row, col)))
    {
        let (door, width) = (from(2.0, 16.0) as usize, from(3.0, 7.0) as usize);
        (row + door..(row + door + width).min(rows)).for_each(|row| floor[row * cols + col] = true);
        let (door, width) = (from(2.0, 16.0) as usize, from(3.0, 7.0) as usize);
        (col + door..(col + door + width).min(cols)).for_each(|col| floor[row * cols + col] = true);
    }
    let source = Sources::point(24.0 + from(2.0, 21.0), 24.0 + from(2.0, 21.0));
    let rooms = flat(rows, cols).with_mask(&floor).unwrap();
    assert!(rooms.is_floor_plan());
    let seeds = source.seeds(&rooms).unwrap();
    (rooms, seeds)
}
