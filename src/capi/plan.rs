//! The passes of a recording, made once for many frames.

use std::sync::Arc;

use super::arguments::{Output, reference};
use super::choices::{
    ScheduleNumber, WavefrontNumber, schedule, schedule_number, wavefront, wavefront_number,
};
use super::objects::{hand_out, object, take};
use super::solver::{GeosweepSolver, Shared};
use super::status::{Failure, GeosweepStatus, guard};
use crate::Stop;
use crate::surface::Chart;
use crate::vulkan::{Method, embed};

/// Iterations in a recording, at most: their passes are listed one by one.
const MOST_ITERATIONS: u32 = 256;

/// How a map is computed.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepMethod {
    /// The shape of fronts.
    pub wavefront: WavefrontNumber,
    /// The order of updates.
    pub schedule: ScheduleNumber,
    /// The map has converged after an iteration in which no distance fell by more than this
    /// fraction; 1e-4 is below what a picture shows, 1e-6 as low as single precision goes.
    pub tolerance: f64,
    /// Iterations of a map, at most, all its recordings together; at least 1.
    pub most_iterations: u32,
    /// Iterations in a recording: from 1 to 256. Those after convergence visit nothing; if they
    /// are too few, `geosweep_record_resume` goes on. Tiles count in rounds, of which a recording holds no
    /// more than the grid's size says: 8 at 48 x 48 points, 16 at 120 x 120, 32 at 256 x 256, 128 at most.
    /// `geosweep_plan_iterations` says how many it holds.
    pub iterations: u32,
}

/// The passes of a recording, for any surface of one size. It may be used by many recordings at
/// once, on any thread.
pub struct GeosweepPlan {
    pub(super) shared: Arc<Shared>,
    pub(super) plan: embed::Plan,
}

fn method(given: &GeosweepMethod) -> Result<(Method, u32), Failure> {
    let GeosweepMethod { tolerance, most_iterations, iterations, .. } = *given;
    if !(0.0..1.0).contains(&tolerance) {
        let reason = format!("is {tolerance}: it is a fraction, at least 0 and below 1");
        return Err(Failure::argument("method->tolerance", reason));
    }
    if most_iterations == 0 {
        return Err(Failure::argument("method->most_iterations", "is 0: at least 1 is needed"));
    }
    if !(1..=MOST_ITERATIONS).contains(&iterations) {
        let reason = format!("is {iterations}: a recording holds 1 to {MOST_ITERATIONS}");
        return Err(Failure::argument("method->iterations", reason));
    }
    let method = Method {
        wavefront: wavefront(given.wavefront, "method->wavefront")?,
        schedule: schedule(given.schedule, "method->schedule")?,
        stop: Stop { tolerance, iterations: most_iterations },
    };
    Ok((method, iterations))
}

/// Makes a plan for surfaces of so many rows and columns; `geosweep_plan_destroy` destroys it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_plan_create(
    solver: *const GeosweepSolver,
    rows: u32,
    cols: u32,
    method: *const GeosweepMethod,
    plan: *mut *mut GeosweepPlan,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (solver, given, output) = unsafe {
            let output = Output::new(plan, "plan")?;
            (object(solver, "solver")?, reference(method, "method")?, output)
        };
        let chart = chart(rows, cols)?;
        let shared = Arc::clone(solver.shared());
        let (method, iterations) = self::method(given)?;
        let plan = shared.solver.plan(chart, method, iterations)?;
        hand_out(output, GeosweepPlan { shared, plan });
        Ok(())
    })
}

/// Says how many iterations, or rounds of tiles, a recording of the plan holds: as many as were asked for, or
/// with tiles fewer. Resume as often as it takes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_plan_iterations(
    plan: *const GeosweepPlan,
    iterations: *mut u32,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (plan, output) =
            unsafe { (object(plan, "plan")?, Output::new(iterations, "iterations")?) };
        output.write(plan.plan.iterations());
        Ok(())
    })
}

/// Says in which schedule the maps of a plan are computed: a `GeosweepSchedule`, what `GEOSWEEP_SCHEDULE_BEST` has
/// come to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_plan_schedule(
    plan: *const GeosweepPlan,
    schedule: *mut ScheduleNumber,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (plan, output) = unsafe { (object(plan, "plan")?, Output::new(schedule, "schedule")?) };
        output.write(schedule_number(plan.plan.schedule()));
        Ok(())
    })
}

/// Says which wavefront the maps of a plan have: a `GeosweepWavefront`, and not always the one asked for.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_plan_wavefront(
    plan: *const GeosweepPlan,
    wavefront: *mut WavefrontNumber,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (plan, output) =
            unsafe { (object(plan, "plan")?, Output::new(wavefront, "wavefront")?) };
        output.write(wavefront_number(plan.plan.wavefront()));
        Ok(())
    })
}

/// Destroys a plan. Recorded command buffers do not need it. Null is fine.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_plan_destroy(plan: *mut GeosweepPlan) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        drop(unsafe { take(plan, "plan") }?);
        Ok(())
    })
}

/// The size of a grid.
pub(super) fn chart(rows: u32, cols: u32) -> Result<Chart, Failure> {
    for (name, size) in [("rows", rows), ("cols", cols)] {
        if size == 0 {
            return Err(Failure::argument(name, "is 0: a grid has at least one point"));
        }
    }
    Ok(Chart { rows: rows as usize, cols: cols as usize })
}
