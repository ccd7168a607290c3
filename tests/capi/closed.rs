//! Gluings of closed surfaces through the functions of C, against the CPU.

use std::ptr::null_mut;

use geosweep::Sources;
use geosweep::surface::{Gluing, Surface};
use geosweep_capi::*;

use crate::common::closed::{globe, grid, octahedral, tube};
use crate::common::{CONVERGED, difference, on_cpu};
use crate::host::Host;
use crate::session::{Session, destroy, frame, method, surface_info, wrong, zero};

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
            run_count: 1,
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
        assert!(session.outcome(surface).converged, "{gluing:?}");
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
    session.end([]);
}
