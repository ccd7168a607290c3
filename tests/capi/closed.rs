//! Gluings of closed surfaces through the functions of C, against the CPU.

use std::ptr::{null, null_mut};

use geosweep::Sources;
use geosweep::surface::{Gluing, Surface};
use geosweep_capi::*;

use crate::common::closed::{globe, grid, octahedral, tube};
use crate::common::{CONVERGED, difference, on_cpu};
use crate::host::Host;
use crate::session::{Session, destroy, frame, method, ok, surface_info, wrong, zero};

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

/// A globe, an octahedral map and a tube by name, and a tube by a pair of runs.
#[test]
fn gluings_have_numbers_and_runs() {
    let run = |col| GeosweepRun { row: 0, col, row_step: 1, col_step: 0 };
    let runs = [GeosweepRunPair { first: run(0), second: run(40), points: 25 }];
    let cases = [
        (globe(19, 37), GeosweepGluing::Globe, (5, 0)),
        (octahedral(12), GeosweepGluing::Octahedral, (0, 5)),
        (tube(25, 41), GeosweepGluing::Columns, (9, 40)),
        (tube(25, 41), GeosweepGluing::Runs, (9, 1)),
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
            run_count: u32::from(matches!(gluing, GeosweepGluing::Runs)),
            ..surface_info(rows, cols, &points)
        };
        let surface = session.surface(&info);
        let method = method(GeosweepWavefront::Curved, 30);
        let [open, plan] = [0, 1]
            .map(|over_seams| session.plan(rows, cols, &GeosweepMethod { over_seams, ..method }));
        let sources = [geosweep_source_at(row as f32, col as f32)];
        session.host.run(|commands| unsafe {
            let refused =
                geosweep_record_frame(surface, commands, &frame(open, &sources), null_mut());
            wrong(refused, "set GeosweepMethod::over_seams to 1");
        });
        let map = session.map(surface, &frame(plan, &sources));
        let outcome = session.outcome(surface);
        assert!(outcome.converged && outcome.seam_gap < 1e-5, "{gluing:?}: {outcome:?}");
        let seeds = Sources::point(row as f64, col as f64).seeds(&truth).unwrap();
        let exact = on_cpu(&truth, &seeds, geosweep::Wavefront::Curved, CONVERGED);
        let difference = difference(&map, &exact);
        assert!(difference < SAME, "{gluing:?}: {difference}");
        destroy!(
            geosweep_plan_destroy(open),
            geosweep_plan_destroy(plan),
            geosweep_surface_destroy(surface),
        );
    }
    session.end([]);
}

#[test]
fn wrong_gluings_are_refused() {
    let session = Session::new(Host::new());
    let run = |row_step| GeosweepRun { row: 0, col: 0, row_step, col_step: 0 };
    let data = floats(&tube(25, 41));
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
    let gluing = GeosweepGluing::Columns as i32;
    wrong(
        create(&GeosweepSurfaceInfo { gluing, runs, run_count, ..good }),
        "info->run_count is not 0",
    );
    session.end([]);
}

/// A gluing that does not fit the points shows in the outcome. With checks it is an error, which names a place. A frame
/// over the same edges is refused then, and one with new points is not.
#[test]
fn gaps_between_copies_are_told() {
    use GeosweepGluing as G;
    let (round, cols) = (tube(25, 41), 41);
    // Moves the last column along the axis by a part of the edges there.
    let moved = |by: f32| {
        let mut data = floats(&round);
        let step: [f32; 3] =
            std::array::from_fn(|at| data[3 * (cols + cols - 1) + at] - data[3 * (cols - 1) + at]);
        for row in 0..25 {
            let last = 3 * (row * cols + cols - 1);
            (0..3).for_each(|at| data[last + at] += by * step[at]);
        }
        data
    };
    for checks in [false, true] {
        let mut session = match checks {
            true => Session::with_checks(Host::new()),
            false => Session::new(Host::new()),
        };
        let method = GeosweepMethod { over_seams: 1, ..method(GeosweepWavefront::Curved, 30) };
        let plan = session.plan(25, 41, &method);
        let sources = [geosweep_source_at(9.0, 3.0)];
        let good = floats(&round);
        for (data, gluing, least, most) in [
            (moved(0.04), G::Columns, 0.02, 0.08),
            (moved(0.5), G::Columns, 0.3, 1.0),
            (good.clone(), G::FlippedColumns, 1.0, 100.0),
            (good.clone(), G::Rows, 1.0, 100.0),
            (good.clone(), G::Globe, 1.0, 100.0),
        ] {
            let points = points(&data);
            let surface = session.surface(&GeosweepSurfaceInfo {
                gluing: gluing as i32,
                ..surface_info(25, 41, &points)
            });
            let of = frame(plan, &sources);
            session.map(surface, &of);
            let is_refused = checks && least > 0.1;
            let mut outcome = zero();
            let status = unsafe { geosweep_surface_outcome(surface, 0, &mut outcome) };
            if is_refused {
                wrong(status, "check which sides continue each other");
                wrong(status, "row ");
                let commands = session.host.commands();
                session.host.begin(commands);
                let record = |frame: &GeosweepFrame| unsafe {
                    geosweep_record_frame(surface, commands, frame, null_mut())
                };
                let points = GEOSWEEP_POINTS_UNCHANGED;
                wrong(record(&GeosweepFrame { points, ..of }), "of a cell apart");
                ok(unsafe { geosweep_surface_write_points(surface, 0, good.as_ptr(), null()) });
                ok(record(&of));
                ok(record(&GeosweepFrame { points, ..of }));
                session.host.end(commands);
                session.submit(commands);
                let status = unsafe { geosweep_surface_outcome(surface, 0, &mut outcome) };
                match gluing {
                    G::Columns => ok(status),
                    _ => wrong(status, "of a cell apart"),
                }
            } else {
                ok(status);
                let gap = outcome.seam_gap;
                assert!((least..most).contains(&gap), "{gluing:?}: {gap}");
            }
            destroy!(geosweep_surface_destroy(surface));
        }
        destroy!(geosweep_plan_destroy(plan));
        session.end([]);
    }
}
