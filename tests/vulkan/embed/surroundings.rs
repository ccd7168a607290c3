//! Sources between grid points, whose surroundings are solved before the whole grid.

use geosweep::Stop;
use geosweep::cpu::twins;
use geosweep::glam::DVec2;
use geosweep::surface::{Chart, EdgeLengths};
use geosweep::vulkan::embed::{Outcome, PointSource, SourceInput};
use geosweep::vulkan::{Method, Schedule};
use geosweep::{Engine, Options, Sources, Spacing, Surface, Wavefront, distance_map};

use crate::common::{Random, difference, vulkan_solver};
use crate::embed::stage::{Kept, RASTER, STOP, Stage, positions_of};

/// Wavefronts with surroundings.
const ROUND: [Wavefront; 2] = [Wavefront::Circular, Wavefront::Curved];

/// Iterations of a plan, enough for all maps here.
const ITERATIONS: u32 = 12;

/// Returns bumps with holes where `is_hole` says so.
fn bumps(chart: Chart, is_hole: impl Fn(usize, usize) -> bool) -> Surface {
    let (mut heights, mut mask) = (Vec::new(), Vec::new());
    for (row, col) in (0..chart.points()).map(|index| chart.position(index)) {
        heights.push(f64::from((3.0 * (0.05 * col as f32).sin()) * (0.04 * row as f32).cos()));
        mask.push(!is_hole(row, col));
    }
    let spacing = Spacing { dx: 1.0, dy: 1.2 };
    let surface = Surface::from_heights(chart.rows, chart.cols, heights, spacing).unwrap();
    surface.with_mask(&mask).unwrap()
}

/// Returns the surface with a slowness from 1 to `contrast` in blocks of `side` points.
fn in_blocks(surface: Surface, side: usize, contrast: f64) -> Surface {
    let mut random = Random::new(3);
    let Chart { rows, cols } = surface.chart();
    let blocks: Vec<_> = (0..rows * cols).map(|_| contrast.powf(random.next())).collect();
    let of = |index: usize| blocks[index / cols / side * cols + index % cols / side];
    surface.with_slowness((0..rows * cols).map(of).collect()).unwrap()
}

/// Returns a stage with the surface.
fn stage_of(surface: &Surface, passes: &[(Schedule, Wavefront)]) -> Stage {
    Stage::on(Kept::watched(), passes, (surface, None), positions_of(surface))
}

/// Returns the map of some sources and its outcome.
fn map(stage: &Stage, sources: &[PointSource], method: Method) -> (Vec<f32>, Outcome) {
    // With tiles, a front needs a round for each tile on its way.
    let iterations = if method.schedule == Some(Schedule::Raster) { ITERATIONS } else { 300 };
    let plan = stage.solver.plan(stage.surface.chart(), method, iterations).unwrap();
    stage.solve(SourceInput::Inline(sources), &plan);
    (stage.read(), stage.surface.outcome(0).unwrap())
}

fn raster(wavefront: Wavefront, stop: Stop) -> Method {
    Method::new(wavefront, stop).with_schedule(Schedule::Raster)
}

/// The surfaces are as small as the surroundings of sources, so that the following iteration changes nothing.
#[test]
fn surroundings_are_those_of_the_twin() {
    // The cases are a wall with fronts around both ends, a grid smaller than the surroundings, and two
    // sources on an island in a grid that is large enough for the surroundings of two.
    let wall = |row: usize, col: usize| row == 12 && (5..14).contains(&col);
    let sea = |row: usize, col: usize| !((30..50).contains(&row) && (40..60).contains(&col));
    let square = |points| Chart { rows: points, cols: points };
    let cases: [(Surface, &[[f64; 2]]); 6] = [
        (in_blocks(bumps(square(20), wall), 3, 10.0), &[[9.3, 8.75]]),
        (in_blocks(bumps(square(20), wall), 5, 3.0), &[[9.0, 9.25]]),
        (bumps(square(20), wall), &[[9.3, 8.75]]),
        (bumps(Chart { rows: 19, cols: 20 }, wall), &[[9.5, 9.0]]),
        (bumps(Chart { rows: 11, cols: 7 }, wall), &[[3.75, 0.25]]),
        (bumps(square(90), sea), &[[38.3, 48.75], [39.5, 49.25]]),
    ];
    for (surface, places) in cases {
        let stage = stage_of(&surface, &RASTER);
        // Over a slowness, circular fronts are updated as curved ones.
        let is_slowed = surface.slowness().is_some();
        for wavefront in ROUND.into_iter().filter(|other| other.is_curved() || !is_slowed) {
            let source = |&[row, col]: &[f64; 2]| PointSource::at(row as f32, col as f32);
            let sources: Vec<_> = places.iter().map(source).collect();
            let (found, outcome) = map(&stage, &sources, raster(wavefront, Stop::after(1)));
            // Sources that are solved alone are solved only within some cells, so the iteration may change the map.
            let are_alone = wavefront.is_curved() && places.len() > 1;
            let residual = if are_alone { outcome.residual } else { 0.0 };
            assert_eq!((outcome.iterations, outcome.residual), (1, residual), "{places:?}");
            let edges = EdgeLengths::<f32>::new(&surface).unwrap();
            let own = |&[row, col]: &[f64; 2]| twins::CentralSource {
                at: DVec2::new(row, col),
                start: 0.0,
                seeds: Sources::point(row, col).seeds(&surface).unwrap(),
            };
            let sources: Vec<_> = places.iter().map(own).collect();
            let twin = twins::surroundings(&edges, &sources, wavefront);
            let twin = twin.distances();
            let reached =
                |value: f32, index: usize| if twin[index] < f32::INFINITY { value } else { 0.0 };
            let [twin_there, found_there] = [&twin, &found].map(|map| -> Vec<f32> {
                map.iter().enumerate().map(|(index, &value)| reached(value, index)).collect()
            });
            let difference = match are_alone {
                true => difference(&twin_there, &found_there),
                false => difference(&twin, &found),
            };
            assert!(difference < 1e-5, "{places:?} {wavefront}: {difference}");
        }
        stage.end([]);
    }
}

/// Over a slowness that changes within a cell, maps in frames are those of the CPU, with lines from sources inside cells to
/// the points around them. Without the lines, points beside a source would be late by up to a third.
#[test]
fn sources_inside_cells_over_a_slowness_have_lines() {
    let passes: Vec<_> = [Wavefront::Planar, Wavefront::Curved]
        .into_iter()
        .flat_map(|wavefront| Schedule::ALL.map(|schedule| (schedule, wavefront)))
        .collect();
    for (side, contrast) in [(1, 10.0), (3, 100.0)] {
        let flat = Surface::from_heights(60, 70, vec![0.0; 60 * 70], Spacing::square(1.0)).unwrap();
        let surface = in_blocks(flat, side, contrast);
        let stage = stage_of(&surface, &passes);
        for &(schedule, wavefront) in &passes {
            for place in [[30.4, 25.25], [11.5, 40.0], [58.75, 68.3]] {
                let sources = Sources::point(place[0], place[1]);
                let options = Options::default().with_engine(Engine::Cpu).with_wavefront(wavefront);
                let expected = distance_map(&surface, &sources, &options).unwrap().distances;
                let source = PointSource::at(place[0] as f32, place[1] as f32);
                let method = raster(wavefront, STOP).with_schedule(schedule);
                let (found, outcome) = map(&stage, &[source], method);
                assert!(outcome.converged, "{schedule} {wavefront} {place:?}");
                let apart = found.iter().zip(&expected).map(|(a, b)| (a - b).abs() / b.max(1e-3));
                let apart = apart.fold(0.0, f32::max);
                // Where curved fronts meet, the order of updates decides between them.
                let most = if wavefront.is_curved() { 2e-2 } else { 3e-5 };
                assert!(apart < most, "{schedule} {wavefront} {side} {place:?}: {apart}");
            }
        }
        stage.end([]);
    }
}

#[test]
fn frames_from_inside_cells_take_about_as_many_iterations_as_from_grid_points() {
    let surface = bumps(Chart { rows: 140, cols: 150 }, |_, _| false);
    let stage = stage_of(&surface, &RASTER);
    for wavefront in ROUND {
        let iterations = |row, col, times| {
            let sources = vec![PointSource::at(row, col); times];
            let (_, outcome) = map(&stage, &sources, raster(wavefront, STOP));
            assert!(outcome.converged);
            outcome.iterations
        };
        let at_point = iterations(50.0, 60.0, 1);
        let mut saved = 0;
        for (row, col) in [(50.0, 60.25), (50.3, 60.9), (51.75, 60.625)] {
            let with = iterations(row, col, 1);
            // One more iteration is allowed, or two if the map from a grid point takes one iteration and a second that
            // confirms it.
            assert!(with <= at_point.max(3) + 1, "{wavefront} {row} {col}: {with}, {at_point}");
            // A crowd has no surroundings, even if all its sources are at one place. On this grid, more than eight
            // sources are a crowd.
            saved += iterations(row, col, 9) - with;
        }
        assert!(saved >= 3, "{wavefront}: {saved} of three maps");
    }
    stage.end([]);
}

/// The cases are sources whose surroundings meet, sources beside the grid's corner and behind a wall, and sources that
/// start later. The maps are compared with the headless solver's, which computes its own surroundings.
#[test]
fn maps_with_surroundings_are_the_headless_solvers() {
    let surface = bumps(Chart { rows: 120, cols: 140 }, |row, col| row == 45 && col > 20);
    let stage = stage_of(&surface, &RASTER);
    let mut solver = vulkan_solver();
    let mut on_device = solver.upload(&surface).unwrap();
    let cases: [&[[f64; 3]]; 4] = [
        &[[40.3, 50.75, 0.0]],
        &[[0.25, 138.5, 0.0], [42.5, 21.75, 3.0]],
        &[[30.3, 50.75, 0.0], [34.5, 53.5, 1.0], [34.0, 47.0, 2.0]],
        &[[118.5, 0.5, 0.0], [118.75, 138.75, 10.0], [46.5, 60.25, 5.0], [50.0, 60.0, 6.0]],
    ];
    for wavefront in ROUND {
        let method = raster(wavefront, STOP);
        for case in cases {
            let add = |all: Sources, &[row, col, time]: &[f64; 3]| all.and_point(row, col, time);
            let sources = case.iter().fold(Sources::default(), add);
            let seeds =
                geosweep::cpu::seeds_for(wavefront, &surface, sources.seeds(&surface).unwrap());
            let expected = solver.solve(&mut on_device, &seeds, method).unwrap().distances;
            let source = |&[row, col, time]: &[f64; 3]| PointSource {
                time: time as f32,
                ..PointSource::at(row as f32, col as f32)
            };
            let sources: Vec<_> = case.iter().map(source).collect();
            let (all, outcome) = map(&stage, &sources, method);
            assert!(outcome.converged, "{wavefront} {case:?}");
            let apart = difference(&expected, &all);
            // Curved fronts are first solved alone if other sources are near.
            let most = if wavefront.is_curved() && case.len() > 1 { 2e-4 } else { 1e-5 };
            assert!(apart < most, "{wavefront} {case:?}: {apart}");
            // The last source starts later than the others.
            let (last, first) = sources.split_last().unwrap();
            map(&stage, first, method);
            let plan = stage.plan(Schedule::Raster, wavefront, ITERATIONS);
            let apart = difference(&expected, &stage.add(SourceInput::Inline(&[*last]), &plan));
            assert!(apart < most, "added, {wavefront} {case:?}: {apart}");
        }
    }
    stage.end([]);
}

/// Sources lie side by side at grid points and inside cells, in one case with another source far away. With every
/// schedule, the map is close to the minimum of the sources' own maps. Without surroundings, the maps would be early by
/// up to a third of a cell.
#[test]
fn sources_side_by_side_are_solved_alone_at_first() {
    let surface = bumps(Chart { rows: 60, cols: 64 }, |_, _| false);
    let passes = Schedule::ALL.map(|schedule| (schedule, Wavefront::Curved));
    let stage = stage_of(&surface, &passes);
    // The amount by which maps may be early. It grows with the square of a cluster's width.
    let cases: [(f32, &[[f32; 2]]); 3] = [
        (0.06, &[[30.0, 20.0], [31.0, 20.0]]),
        (0.1, &[[30.0, 20.0], [30.0, 21.0], [31.0, 22.0], [50.0, 60.0]]),
        (0.1, &[[12.25, 40.5], [13.0, 41.75], [12.0, 42.0]]),
    ];
    for (early, places) in cases {
        let sources: Vec<_> = places.iter().map(|&[row, col]| PointSource::at(row, col)).collect();
        for schedule in Schedule::ALL {
            let method = raster(Wavefront::Curved, STOP).with_schedule(schedule);
            let single: Vec<_> = sources.iter().map(|&one| map(&stage, &[one], method).0).collect();
            let (together, outcome) = map(&stage, &sources, method);
            assert!(outcome.converged, "{schedule} {places:?}");
            for (index, &found) in together.iter().enumerate() {
                let earliest = single.iter().map(|map| map[index]).fold(f32::INFINITY, f32::min);
                let late = found - earliest;
                assert!((-early..0.01).contains(&late), "{schedule} {places:?} {index}: {late}");
            }
        }
    }
    stage.end([]);
}
