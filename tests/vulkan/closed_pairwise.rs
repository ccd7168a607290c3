//! Matrices of closed surfaces on a device.

use geosweep::pairwise::Pairwise;
use geosweep::vulkan::PairwiseSchedule;
use geosweep::vulkan::profile::{Detail, Grain, PassKind};
use geosweep::{Engine, Options, Stop, Surface, Wavefront};

use crate::closed::closed_surfaces;
use crate::common::closed::*;
use crate::common::*;
use crate::pairwise::{assert_rows_agree, assert_twins, solve};
use crate::profile::bench::profiling_solver;

/// Returns the source that the list of surfaces names, and points of the grid far from it. Some are on seams.
fn sources(surface: &Surface, [row, col]: [f64; 2]) -> Vec<usize> {
    let chart = surface.chart();
    let first = chart.index(row as usize, col as usize);
    let others = [0, chart.cols - 1, chart.points() / 2 + 7, chart.points() - 2];
    let usable = |source: &usize| surface.present()[*source];
    [first].into_iter().chain(others).filter(usable).collect()
}

#[test]
fn matrices_pass_seams_as_on_the_cpu() {
    let solver = vulkan_solver();
    for (name, surface, source) in closed_surfaces() {
        let points = surface.chart().points();
        let mut sources: Vec<_> = sources(&surface, source).into_iter().map(Some).collect();
        sources.insert(1, None);
        let uploaded = solver.upload(&surface).unwrap();
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let mut pairwise = solver.pairwise(&uploaded, wavefront, None).unwrap();
            assert_eq!(pairwise.schedule(), PairwiseSchedule::Images);
            let device = (&*solver, &uploaded, points);
            let rows = solve(&mut pairwise, device, &sources, CONVERGED);
            let what = format!("{name}, {wavefront}");
            assert_rows_agree(&surface, wavefront, &sources, &rows, &what);
            for (source, row) in sources.iter().zip(rows.chunks_exact(points)) {
                let Some(source) = source else { continue };
                let group = surface
                    .copies()
                    .unwrap()
                    .iter()
                    .find(|group| group.contains(&(*source as u32)));
                let copies = group.into_iter().flatten();
                assert!(
                    copies.into_iter().all(|&copy| row[copy as usize] == 0.0),
                    "{what}, {source}"
                );
            }
            assert!(solve(&mut pairwise, device, &sources, CONVERGED) == rows, "{what}");
        }
    }
}

/// Before a map of an uneven slowness converges, the last digit may decide which of two curved fronts a point keeps.
/// From the corners of the hills nine points differ by 1.1e-3 after the fourth or fifth iteration, also on single maps.
#[test]
fn every_exchange_of_a_matrix_is_one_of_its_twin() {
    let solver = vulkan_solver();
    for (name, surface, source) in closed_surfaces() {
        let sources = sources(&surface, source);
        let count = if surface.slowness().is_some() { 2 } else { sources.len() };
        assert_twins(&solver, &surface, &sources[..count], PairwiseSchedule::Images, name);
    }
}

/// The rows of one call hold the lengths of the shortest ways on the plane, over all images of the target.
#[test]
fn matrices_of_flat_surfaces_are_exact() {
    let wavefronts = [Wavefront::Circular, Wavefront::Curved, Wavefront::Curved];
    for ((name, gluing, shape), wavefront) in shapes().into_iter().zip(wavefronts) {
        let surface = flat(41, 65).with_gluing(gluing).unwrap();
        let options = Options::default()
            .with_engine(Engine::Vulkan(device_choice()))
            .with_wavefront(wavefront);
        let mut pairwise = Pairwise::new(&surface, &options).unwrap();
        let chart = surface.chart();
        let sources = [[0, 64], [17, 1], [40, 30]].map(|[row, col]| chart.index(row, col));
        let mut largest = 0f64;
        let report = pairwise.rows(&sources, |rows| {
            for (source, row) in rows.iter() {
                let place = |index| {
                    let (row, col) = chart.position(index);
                    [row as f64, col as f64]
                };
                for (index, distance) in row.iter().enumerate() {
                    let exact = shape.way(place(source), place(index)).length();
                    largest = largest.max((f64::from(*distance) - exact).abs() / 64.0);
                }
            }
            Ok::<_, geosweep::Error>(())
        });
        assert!(report.unwrap().converged());
        println!("{name}, {wavefront}: {largest:.1e}");
        assert!(largest < 1e-6, "{name}, {wavefront}: {largest:e}");
    }
}

/// There is an exchange of the sources, and one after each scan.
#[test]
fn profiles_of_matrices_have_all_exchanges() {
    let solver = profiling_solver();
    let wavefront = Wavefront::Curved;
    let images = Some(PairwiseSchedule::Images);
    let sources = [Some(7), None, Some(300)];
    for surface in [globe(19, 31), flat(19, 31)] {
        let uploaded = solver.upload(&surface).unwrap();
        let mut pairwise = solver.pairwise(&uploaded, wavefront, images).unwrap();
        let mut alone = vec![0.0; 3 * 19 * 31];
        pairwise.solve(&solver, &uploaded, &sources, CONVERGED, &mut alone).unwrap();
        for grain in Grain::ALL {
            let detail = Detail { grain, ..Detail::default() };
            let mut rows = vec![0.0; alone.len()];
            let found =
                pairwise.profile(&solver, &uploaded, &sources, CONVERGED, &mut rows, detail);
            let (_, profile) = found.unwrap();
            assert_eq!(rows, alone, "{grain:?}");
            let count =
                |is: fn(PassKind) -> bool| profile.passes().filter(|pass| is(pass.kind)).count();
            let seeds = 1 + usize::from(surface.is_glued());
            assert_eq!(count(|kind| kind == PassKind::Seed), seeds);
            if grain == Grain::Scans {
                let scans = count(|kind| matches!(kind, PassKind::Scan(_)));
                let exchanges = if surface.is_glued() { scans } else { 0 };
                assert_eq!(count(|kind| kind == PassKind::Exchange), exchanges);
            }
        }
    }
}

/// A map that takes more iterations than one recording holds is continued in the next recording.
#[test]
fn maps_of_closed_mazes_take_several_recordings() {
    let solver = vulkan_solver();
    let (rows, cols) = (61, 21);
    let is_open = |index: usize| {
        let (row, col) = (index / cols, index % cols);
        row % 2 == 0 || col == if row % 4 == 1 { 9 } else { 0 } || row % 4 == 3 && col == cols - 1
    };
    let mask: Vec<_> = (0..rows * cols).map(is_open).collect();
    let maze = flat(rows, cols).with_mask(&mask).unwrap();
    let maze = maze.with_gluing(geosweep::surface::Gluing::columns()).unwrap();
    assert_twins(&solver, &maze, &[0, 30 * cols + 4], PairwiseSchedule::Images, "maze");
    let uploaded = solver.upload(&maze).unwrap();
    let mut pairwise = solver.pairwise(&uploaded, Wavefront::Planar, None).unwrap();
    let mut row = vec![0.0; rows * cols];
    let stop = Stop::within(1e-6).or_after(1000);
    let found = pairwise.solve(&solver, &uploaded, &[Some(0)], stop, &mut row).unwrap();
    assert!(found.iterations > 8, "{found:?}");
    // The way goes half around in each corridor, 30 times.
    assert!(row[(rows - 1) * cols] > 250.0, "{}", row[(rows - 1) * cols]);
}
