//! Closed surfaces through the functions of C: a tube that moves, and the other gluings, against the CPU.

use std::f64::consts::TAU;
use std::ptr::null_mut;

use geosweep::Sources;
use geosweep::capi::*;
use geosweep::glam::DVec3;
use geosweep::surface::{Gluing, Surface};

use crate::common::closed::{globe, grid, octahedral};
use crate::common::{CONVERGED, difference, on_cpu};
use crate::host::Host;
use crate::session::{Session, frame, method, ok, surface_info, wrong, zero};

/// Rounding between engines.
const SAME: f64 = 1e-5;

fn floats(surface: &Surface) -> Vec<f32> {
    let chart = surface.chart();
    let at = |(row, col)| surface.position(row, col).unwrap().as_vec3().to_array();
    (0..chart.points()).map(|index| chart.position(index)).flat_map(at).collect()
}

fn points(data: &[f32]) -> [GeosweepPoints; 1] {
    [GeosweepPoints { data: data.as_ptr(), stride: 12, ..zero() }]
}

/// Returns a tube whose radius changes with time.
fn tube(time: f64) -> Surface {
    let tube = grid(25, 41, |row, col| {
        let (along, angle) = (0.15 * row as f64, TAU * (col % 40) as f64 / 40.0);
        let radius = 1.0 + 0.3 * (along + time).sin() * (2.0 * angle).cos();
        DVec3::new(radius * angle.cos(), radius * angle.sin(), along)
    });
    tube.with_gluing(Gluing::columns()).unwrap()
}

#[test]
fn a_moving_tube_stays_closed() {
    let mut session = Session::new(Host::new());
    let first = floats(&tube(0.0));
    let points = points(&first);
    let gluing = GeosweepGluing::Columns as i32;
    let info = GeosweepSurfaceInfo { gluing, ..surface_info(25, 41, &points) };
    let surface = session.surface(&info);
    let method = method(GeosweepWavefront::Curved, 16);
    let plan = session.plan(25, 41, &GeosweepMethod { over_seams: 1, ..method });
    let sources = [geosweep_source_at(9.0, 40.0)];
    for time in [0.0, 0.7, 1.4] {
        let truth = tube(time);
        let data = floats(&truth);
        ok(unsafe { geosweep_surface_write_points(surface, 0, data.as_ptr(), std::ptr::null()) });
        let map = session.map(surface, &frame(plan, &sources));
        assert!(session.outcome(surface).converged);
        let seeds = Sources::point(9.0, 40.0).seeds(&truth).unwrap();
        let exact = on_cpu(&truth, &seeds, geosweep::Wavefront::Curved, CONVERGED);
        let difference = difference(&map, &exact);
        assert!(difference < SAME, "{time}: {difference}");
    }
    let open = session.plan(25, 41, &method);
    let mut image = zero();
    session.host.run(|commands| unsafe {
        let frame = frame(open, &sources);
        wrong(
            geosweep_record_frame(surface, commands, &frame, &mut image),
            "set GeosweepMethod::over_seams to 1",
        );
    });
    let mut paths = null_mut();
    ok(unsafe { geosweep_paths_create(surface, 1, 100, &mut paths) });
    unsafe {
        ok(geosweep_paths_destroy(paths));
        ok(geosweep_plan_destroy(open));
        ok(geosweep_plan_destroy(plan));
        ok(geosweep_surface_destroy(surface));
    }
    session.end([]);
}

/// A globe and an octahedral map by name, and a tube by a pair of runs.
#[test]
fn gluings_have_numbers_and_runs() {
    let run = |col| GeosweepRun { row: 0, col, row_step: 1, col_step: 0 };
    let runs = [GeosweepRunPair { first: run(0), second: run(40), points: 25 }];
    let cases = [
        (globe(19, 37), GeosweepGluing::Globe, (5, 0)),
        (octahedral(12), GeosweepGluing::Octahedral, (0, 5)),
        (tube(0.0), GeosweepGluing::Runs, (9, 1)),
    ];
    let mut session = Session::new(Host::new());
    for (truth, gluing, (row, col)) in cases {
        let (rows, cols) = (truth.rows() as u32, truth.cols() as u32);
        let truth = match gluing {
            // From runs, neither the device nor the CPU knows that the grid continues over the seam. So the
            // surface for the CPU is glued by runs too.
            GeosweepGluing::Runs => {
                use geosweep::surface::{Direction, Run};
                let run = |col| Run { from: (0, col), to: Direction::South, points: 25 };
                let open = grid(25, 41, |row, col| truth.position(row, col).unwrap());
                open.with_gluing(Gluing::Runs(vec![[run(0), run(40)]])).unwrap()
            }
            _ => truth,
        };
        let data = floats(&truth);
        let points = points(&data);
        let info = GeosweepSurfaceInfo {
            gluing: gluing as i32,
            runs: runs.as_ptr(),
            run_count: 1,
            ..surface_info(rows, cols, &points)
        };
        let surface = session.surface(&info);
        let method = method(GeosweepWavefront::Curved, 30);
        let plan = session.plan(rows, cols, &GeosweepMethod { over_seams: 1, ..method });
        let sources = [geosweep_source_at(row as f32, col as f32)];
        let map = session.map(surface, &frame(plan, &sources));
        assert!(session.outcome(surface).converged, "{gluing:?}");
        let seeds = Sources::point(row as f64, col as f64).seeds(&truth).unwrap();
        let exact = on_cpu(&truth, &seeds, geosweep::Wavefront::Curved, CONVERGED);
        let difference = difference(&map, &exact);
        assert!(difference < SAME, "{gluing:?}: {difference}");
        unsafe {
            ok(geosweep_plan_destroy(plan));
            ok(geosweep_surface_destroy(surface));
        }
    }
    session.end([]);
}

#[test]
fn wrong_gluings_are_refused() {
    let session = Session::new(Host::new());
    let run = |row_step| GeosweepRun { row: 0, col: 0, row_step, col_step: 0 };
    let data = floats(&tube(0.0));
    let points = points(&data);
    let good = surface_info(25, 41, &points);
    let create = |info: &GeosweepSurfaceInfo| {
        let mut surface = null_mut();
        unsafe { geosweep_surface_create(session.solver, info, &mut surface) }
    };
    wrong(create(&GeosweepSurfaceInfo { gluing: 9, ..good }), "info->gluing is 9");
    let gluing = GeosweepGluing::Runs as i32;
    wrong(create(&GeosweepSurfaceInfo { gluing, run_count: 1, ..good }), "info->runs is null");
    let still = [GeosweepRunPair { first: run(0), second: run(1), points: 25 }];
    let (runs, run_count) = (still.as_ptr(), 1);
    wrong(
        create(&GeosweepSurfaceInfo { gluing, runs, run_count, ..good }),
        "info->runs[0] has the step 0, 0",
    );
    session.end([]);
}
