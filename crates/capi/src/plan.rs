//! Passes of a recording, created once for many frames.

use std::sync::Arc;

use super::arguments::{Output, chart, reference, write};
use super::choices::{ScheduleNumber, WavefrontNumber, choose, number};
use super::objects::{hand_out, kind_of_object, object, object_named, take};
use super::shared::Made;
use super::solver::GeosweepSolver;
use super::status::{Failure, calls};
use super::surface::GeosweepSurface;
use geosweep::Stop;
use geosweep::vulkan::{Method, Schedule, embed};

/// Largest number of iterations in a recording. A plan lists their passes one by one.
const MOST_ITERATIONS: u32 = 256;

/// Method by which a map is computed.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepMethod {
    /// Shape of the wavefront.
    pub wavefront: WavefrontNumber,
    /// Order of updates.
    pub schedule: ScheduleNumber,
    /// Relative tolerance. The map has converged after an iteration in which no distance fell by more than
    /// this fraction. 1e-4 is below what a picture shows, and 1e-6 is the limit of single precision.
    pub tolerance: f64,
    /// Largest number of iterations of a map, in all its recordings together; at least 1.
    pub most_iterations: u32,
    /// Number of iterations in a recording, from 1 to 256. Iterations after convergence visit nothing. If
    /// there are too few, `geosweep_record_resume` continues the map. With tiles, iterations are rounds, and
    /// the grid's size limits their number in a recording: 10 at 48 x 48 points, 20 at 120 x 120, 36 at 256 x
    /// 256, and never more than 128. `geosweep_plan_iterations` returns the number in the plan.
    pub iterations: u32,
    /// 0 for surfaces without a gluing. Any other number is for surfaces with a `GeosweepSurfaceInfo::gluing`: fronts
    /// then pass seams after each scan, or each round of tiles.
    pub over_seams: u32,
}

/// Passes of a recording, for any surface of one size. Many recordings may use a plan at the same time, on
/// any thread.
pub struct GeosweepPlan(());

kind_of_object! { GeosweepPlan, plan: Made<embed::Plan> }

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
    let method = Method::new(
        choose(given.wavefront, "method->wavefront")?,
        Stop::within(tolerance).or_after(most_iterations),
    )
    .with_schedule(choose::<Option<Schedule>>(given.schedule, "method->schedule")?);
    Ok((method, iterations))
}

calls! {
    /// Creates a plan for surfaces of `rows` rows and `cols` columns. `geosweep_plan_destroy` destroys it.
    fn geosweep_plan_create(
        solver: *const GeosweepSolver,
        rows: u32,
        cols: u32,
        method: *const GeosweepMethod,
        plan: *mut *mut GeosweepPlan,
    ) {
        let output = Output::new(plan, "plan")?;
        let (shared, given) = (object(solver)?, reference(method, "method")?);
        let chart = chart(rows, cols)?;
        let (method, iterations) = self::method(given)?;
        let plan = shared.solver.plan(chart, method, iterations)?;
        let of = if given.over_seams == 0 { plan } else { plan.over_seams() };
        hand_out(output, Made { shared: Arc::clone(shared), of });
    }

    /// Returns the number of iterations, or rounds of tiles, in a recording of the plan. It is the number
    /// requested, but at most `GeosweepMethod::most_iterations`, and with tiles it may be smaller. Resume the map
    /// until it has converged.
    fn geosweep_plan_iterations(plan: *const GeosweepPlan, iterations: *mut u32) {
        write(iterations, "iterations", object(plan)?.of.iterations())?;
    }

    /// Returns the schedule of a plan, a `GeosweepSchedule`. For `GEOSWEEP_SCHEDULE_BEST`, it is the schedule
    /// that was chosen.
    fn geosweep_plan_schedule(plan: *const GeosweepPlan, schedule: *mut ScheduleNumber) {
        write(schedule, "schedule", number(Some(object(plan)?.of.schedule())))?;
    }

    /// Returns the wavefront of a plan's maps, a `GeosweepWavefront`. It may differ from the one requested.
    fn geosweep_plan_wavefront(plan: *const GeosweepPlan, wavefront: *mut WavefrontNumber) {
        write(wavefront, "wavefront", number(object(plan)?.of.wavefront()))?;
    }

    /// Destroys a plan. Recorded command buffers do not need it. Null is allowed.
    fn geosweep_plan_destroy(plan: *mut GeosweepPlan) {
        drop(take(plan, |_| Ok(()))?);
    }
}

/// Returns a plan of the surface's solver.
///
/// # Safety
/// The pointer is null or points to a plan.
pub(super) unsafe fn plan<'a>(
    plan: *const GeosweepPlan,
    surface: &GeosweepSurface,
    name: &str,
) -> Result<&'a embed::Plan, Failure> {
    // SAFETY: the caller's promise.
    let plan = unsafe { object_named(plan, name) }?;
    if !Arc::ptr_eq(&plan.shared, &surface.shared) {
        return Err(Failure::argument(name, "was made by another solver than the surface"));
    }
    Ok(&plan.of)
}
