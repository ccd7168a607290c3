//! Anchors on a Vulkan device against the CPU engine and exact distances, under the validation layers.

mod common;
mod measure;

use common::*;
use geosweep::accuracy::Errors;
use geosweep::cpu::PairwiseScan;
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{EdgeLengths, Seed};
use geosweep::vulkan::{Method, PairwiseSchedule, Schedule, Solver, VulkanError};
use geosweep::{Sources, Spacing, Surface, Wavefront};
use measure::Random;

/// Of the largest distance: what rounding leaves on the way from corner to corner.
const AGREEMENT: f32 = 2e-6;

fn anchored(schedule: Schedule) -> Method {
    Method { wavefront: Wavefront::Anchored, schedule: Some(schedule), stop: CONVERGED }
}

/// A plane with boxes, walls and strewn points left out, and some of its points.
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
        clear(row, col, 1 + below(rows / 4), 1 + below(cols / 4));
    }
    for _ in 0..number % 5 {
        let (row, col) = (below(rows), below(cols));
        if below(2) == 0 {
            clear(row, col, 1, 2 + below(cols / 2));
        } else {
            clear(row, col, 2 + below(rows / 2), 1);
        }
    }
    for _ in 0..(number % 3) * 6 {
        let (row, col) = (below(rows), below(cols));
        clear(row, col, 1, 1);
    }
    let free: Vec<_> = (0..rows * cols).filter(|&point| floor[point]).collect();
    let some = (0..8).map(|_| free[below(free.len())]).map(|point| [point / cols, point % cols]);
    let some = some.collect();
    let spacing = if number % 4 == 1 { Spacing { dx: 1.0, dy: 1.3 } } else { Spacing::square(0.7) };
    let plane = Surface::from_heights(rows, cols, vec![0.0; rows * cols], spacing).unwrap();
    (plane.with_mask(&floor).unwrap(), some)
}

/// Seeds of sources, some inside cells, as far as they lie on the plan, and with times of their own.
fn some_seeds(surface: &Surface, places: &[[usize; 2]], number: u64) -> Vec<Seed> {
    let mut random = Random::new(number + 1000);
    let mut all = Vec::new();
    for (k, &[row, col]) in places.iter().enumerate() {
        let (row, col) = (row as f64, col as f64);
        let time = if k == 0 { 0.0 } else { 3.0 * random.next() };
        let (down, right) = (0.9 * random.next(), 0.9 * random.next());
        let inside = Sources::default().and_point(row + down, col + right, time);
        let on_point = Sources::default().and_point(row, col, time);
        let wanted = if (number as usize + k) % 2 == 0 { inside } else { on_point.clone() };
        all.extend(wanted.seeds(surface).or_else(|_| on_point.seeds(surface)).unwrap());
    }
    all
}

fn plans() -> u64 {
    std::env::var("PLANS").map_or(24, |plans| plans.parse().unwrap())
}

#[test]
fn every_schedule_leads_to_the_map_of_the_cpu() {
    let mut solver = if std::env::var_os("FAST").is_some() { Solver::new(&geosweep::DeviceChoice::Any).unwrap() } else { vulkan_solver() };
    let mut worst = [0.0f32; 3];
    for number in 0..plans() {
        let (surface, places) = floor_plan(number, 30 + number as usize % 40, 34 + 3 * (number as usize % 17));
        assert!(surface.is_floor_plan());
        let count = [1, 1, 3, 6][number as usize % 4];
        let seeds = some_seeds(&surface, &places[..count], number);
        let cpu = on_cpu(&surface, &seeds, Wavefront::Anchored, CONVERGED);
        let mut on_device = solver.upload(&surface).unwrap();
        for (k, schedule) in Schedule::ALL.into_iter().enumerate() {
            let solution = solver.solve(&mut on_device, &seeds, anchored(schedule)).unwrap();
            assert!(solution.residual <= CONVERGED.tolerance, "plan {number}, {schedule}");
            let found = relative_difference(&cpu, &solution.distances);
            worst[k] = worst[k].max(found);
            if found > AGREEMENT || std::env::var_os("ALL").is_some() { println!("plan {number}, {schedule}: {found:e}, {} iterations, {:?}", solution.iterations, solution.time); }
        }
    }
    println!("{worst:?}");
    assert!(worst.iter().all(|&found| found < AGREEMENT), "{worst:?}");
}

#[test]
fn twins_print() {
    let mut solver = Solver::new(&geosweep::DeviceChoice::Any).unwrap();
    let one: Option<u64> = std::env::var("PLAN").ok().map(|p| p.parse().unwrap());
    for number in 0..plans() {
        if one.is_some_and(|one| one != number) { continue; }
        let (surface, places) = floor_plan(number, 30 + number as usize % 40, 34 + 3 * (number as usize % 17));
        let count = [1, 1, 3, 6][number as usize % 4];
        let seeds = some_seeds(&surface, &places[..count], number);
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let cpu = on_cpu(&surface, &seeds, Wavefront::Anchored, CONVERGED);
        let mut on_device = solver.upload(&surface).unwrap();
        let rounds = geosweep::cpu::Rounds { tile: 16, inner: 4, recorded: 16 };
        let w = Wavefront::Anchored;
        for schedule in Schedule::ALL {
            let twin = match schedule {
                Schedule::Raster => geosweep::cpu::scan_in_turn(&edges, &seeds, w, CONVERGED),
                Schedule::AllPoints => geosweep::cpu::all_points(&edges, &seeds, w, CONVERGED),
                Schedule::Tiles => geosweep::cpu::tile_rounds(&edges, &seeds, w, CONVERGED, rounds),
            };
            let solution = solver.solve(&mut on_device, &seeds, anchored(schedule)).unwrap();
            let [a, b, c] = [relative_difference(&cpu, &twin.distances()), relative_difference(&cpu, &solution.distances), relative_difference(&twin.distances(), &solution.distances)];
            if a.max(b).max(c) > 2e-6 || std::env::var_os("ALL").is_some() {
                println!("plan {number} {schedule}: cpu-twin {a:.1e} cpu-gpu {b:.1e} twin-gpu {c:.1e}; iterations {} {}", twin.iterations, solution.iterations);
            }
        }
    }
}

#[test]
fn first_difference() {
    let mut solver = Solver::new(&geosweep::DeviceChoice::Any).unwrap();
    let number: u64 = std::env::var("PLAN").ok().map(|p| p.parse().unwrap()).unwrap();
    let schedule = if std::env::var_os("RASTER").is_some() { Schedule::Raster } else { Schedule::AllPoints };
    let (surface, places) = floor_plan(number, 30 + number as usize % 40, 34 + 3 * (number as usize % 17));
    let count = [1, 1, 3, 6][number as usize % 4];
    let seeds = some_seeds(&surface, &places[..count], number);
    println!("{} x {}, {seeds:?}", surface.rows(), surface.cols());
    let edges = EdgeLengths::<f32>::new(&surface).unwrap();
    let mut on_device = solver.upload(&surface).unwrap();
    let w = Wavefront::Anchored;
    for iterations in 1..60 {
        let stop = geosweep::cpu::Stop::after(iterations);
        let twin = match schedule { Schedule::Raster => geosweep::cpu::scan_in_turn(&edges, &seeds, w, stop), _ => geosweep::cpu::all_points(&edges, &seeds, w, stop) }.distances();
        let gpu = solver.solve(&mut on_device, &seeds, Method { stop, ..anchored(schedule) }).unwrap().distances;
        let mut found = 0;
        for (i, (a, b)) in twin.iter().zip(&gpu).enumerate() {
            if a.is_finite() != b.is_finite() || a.is_finite() && (a - b).abs() > 1e-5 * a {
                found += 1;
                if found < 12 { println!("{iterations}: {:?} {a} {b}", surface.chart().position(i)); }
            }
        }
        if found > 0 {
            println!("{found}");
            for row in (0..surface.rows()).rev() { for col in 0..surface.cols() { let i = surface.chart().index(row, col); if (twin[i] - gpu[i]).abs() > 1e-5 * twin[i] && row > 26 { let s = seeds[0]; println!("{row} {col}: twin {} gpu {} straight {}", twin[i], gpu[i], f64::from(((row as f64 - s.row as f64)*1.3).hypot(col as f64 - s.col as f64))); } } }
            for row in 0..surface.rows() { println!("{row:3} {}", (0..surface.cols()).map(|col| { let i = surface.chart().index(row, col); if !surface.has(row, col) { '#' } else if seeds.iter().any(|s| s.row == row && s.col == col) { 'S' } else if (twin[i] - gpu[i]).abs() > 1e-5 * twin[i] || twin[i].is_finite() != gpu[i].is_finite() { 'X' } else { '.' } }).collect::<String>()); }
            break;
        }
    }
}
