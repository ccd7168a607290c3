//! Headless solving: uploads a surface, iterates and reads the distances back.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ash::vk;

use super::grid_images::{GridImages, bands, transfer_bytes};
use super::headless::{CommandBuffer, Context, Submitter, Unwatched};
use super::passes::{COMMON, Variant};
use super::pipeline_store::PipelineStore;
use super::pipelines::Cache;
use super::plan::{self, Reached, Step};
use super::profile::{Capabilities, Capability, Detail, Executable, Session, SolveProfile};
use super::record::{Commands, Recorder};
use super::schedules;
use super::surface_on_device::{Start, SurfaceOnDevice};
use super::upload::{SeedTexel, seed_texels};
use super::{Schedule, Tuning, ValidationLog, VulkanError, embed, tile_lanes};
use crate::Stop;
use crate::surface::Seed;
use crate::update::Wavefront;
use crate::vulkan::DeviceChoice;

/// Name of the environment variable that turns the validation layers on in every [`Solver`], if its value is
/// not 0.
const VALIDATION_VARIABLE: &str = "GEOSWEEP_VALIDATION";

/// A Vulkan device with its pipelines, for use without a renderer.
///
/// ```no_run
/// use geosweep::Stop;
/// use geosweep::vulkan::{Method, Solver};
/// use geosweep::{DeviceChoice, Sources, Spacing, Surface, Wavefront};
/// let surface = Surface::from_heights(2, 2, vec![0.0; 4], Spacing::square(1.0))?;
/// let mut solver = Solver::new(&DeviceChoice::Any)?;
/// let mut on_device = solver.upload(&surface)?;
/// let stop = Stop { tolerance: 1e-6, iterations: 100 };
/// let method = Method { wavefront: Wavefront::Circular, schedule: None, stop };
/// for row in 0..2 {
///     let seeds = Sources::point(row as f64, 0.0).seeds(&surface)?;
///     let solution = solver.solve(&mut on_device, &seeds, method)?;
///     println!("{:?} after {:?}", solution.distances, solution.time);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Solver {
    /// Solver on the device, with the passes of the schedules and wavefronts used so far.
    pub(super) for_device: embed::Solver,
    pub(super) context: Arc<Context>,
    /// Store that keeps pipelines between processes, if there is one.
    store: Option<PipelineStore>,
}

/// Parameters of solving a map on a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// Front assumed inside a triangle. [`Wavefront::Anchored`] requires a floor plan
    /// ([`crate::Surface::is_floor_plan`]) of at most 33 million points, and at most 4096 sources inside
    /// cells. All other maps are solved with [`Wavefront::Curved`] in its place.
    pub wavefront: Wavefront,
    /// Order of updates. `None` selects [`Schedule::best_on`] the device.
    pub schedule: Option<Schedule>,
    /// Stopping criterion. It counts the iterations of the schedule.
    pub stop: Stop,
}

/// Distance map computed by the Vulkan engine.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Distances in row-major order; +infinity where no source reaches.
    pub distances: Vec<f32>,
    /// Front assumed. It is [`Wavefront::Anchored`] only where that was possible, see [`Method::wavefront`].
    pub wavefront: Wavefront,
    /// Order of updates that was used.
    pub schedule: Schedule,
    /// Number of iterations, each of four scans or of two updates of all points, or number of rounds of tiles.
    pub iterations: u32,
    /// Largest relative change of a front in the last iteration.
    pub residual: f64,
    /// Time from the first submission, which forgets the previous map, to the end of the last.
    pub time: Duration,
}

impl Solver {
    /// Opens a device. If the environment variable `GEOSWEEP_VALIDATION` is set to anything but 0, the
    /// validation layers are on, as with [`Solver::with_validation`].
    pub fn new(choice: &DeviceChoice) -> Result<Self, VulkanError> {
        Self::open(choice, is_validation_wanted())
    }

    /// Opens a device under the Khronos validation layers, with synchronization and GPU-assisted validation.
    /// Every call that leaves a message in the log then fails.
    pub fn with_validation(choice: &DeviceChoice) -> Result<Self, VulkanError> {
        Self::open(choice, true)
    }

    /// Opens a device and enables everything that it offers for [`Solver::profile`], except for the
    /// capabilities in `left_out`. Those behave as on a device that lacks them. The variable
    /// `GEOSWEEP_VALIDATION` counts as in [`Solver::new`].
    ///
    /// # Errors
    /// As [`Solver::new`]. A capability that the device lacks is not an error.
    pub fn for_profiling(
        choice: &DeviceChoice,
        left_out: &[Capability],
    ) -> Result<Self, VulkanError> {
        Self::with(Context::open(choice, is_validation_wanted(), Some(left_out))?)
    }

    fn open(choice: &DeviceChoice, validate: bool) -> Result<Self, VulkanError> {
        Self::with(Context::new(choice, validate)?)
    }

    pub(super) fn with(context: Context) -> Result<Self, VulkanError> {
        let context = Arc::new(context);
        let has =
            |found: fn(&Capabilities) -> bool| context.capabilities.as_ref().is_some_and(found);
        let tools = embed::Tools {
            labels: has(|found| found.labels.is_ok()),
            executables: has(|found| found.executables.is_ok()),
            checks: false,
        };
        let (instance, device) = (&context.instance.handle, &context.device);
        let physical_device = context.physical_device;
        // SAFETY: the physical device is from this instance.
        let properties = unsafe { instance.get_physical_device_properties(physical_device) };
        let mut store = PipelineStore::of_process(&properties, device)?;
        let cache = store.as_ref().map_or(vk::PipelineCache::null(), PipelineStore::cache);
        let cache = Cache::shared(cache);
        match embed::Solver::made_with(instance, physical_device, device, &[], tools, cache) {
            Ok(for_device) => Ok(Self { for_device, context, store }),
            Err(error) => {
                store.iter_mut().for_each(|store| store.destroy(device));
                Err(error)
            }
        }
    }

    /// Returns the device's name.
    pub fn device_name(&self) -> &str {
        &self.context.info.name
    }

    /// Returns the sizes of the portions in which the solver visits the grid.
    pub fn tuning(&self) -> Tuning {
        self.for_device.pipelines.tuning
    }

    /// Returns this solver with other sizes of portions than [`Tuning::of`] the device, to find out which are
    /// best. Surfaces that were uploaded before can no longer be used with it.
    ///
    /// # Errors
    /// [`VulkanError::Tuning`] if the device has no room for these sizes, or the error of a Vulkan call that
    /// fails.
    pub fn with_tuning(mut self, tuning: Tuning) -> Result<Self, VulkanError> {
        let (instance, device) = (&self.context.instance.handle, &self.context.device);
        // SAFETY: the physical device is from this instance.
        let properties =
            unsafe { instance.get_physical_device_properties(self.context.physical_device) };
        let shuffles = tile_lanes::shuffles(instance, self.context.physical_device);
        tuning.check(&properties.limits, shuffles)?;
        let pipelines = &mut self.for_device.pipelines;
        pipelines.set_tuning(device, tuning);
        pipelines.make_all(device, COMMON, Wavefront::Planar)?;
        Ok(self)
    }

    /// Returns the messages of the validation layers; `None` if the layers are off.
    pub fn validation_log(&self) -> Option<&ValidationLog> {
        self.context.instance.validation_log()
    }

    /// Computes a map from `seeds`, which must lie on the surface.
    pub fn solve(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        method: Method,
    ) -> Result<Solution, VulkanError> {
        let solution = self.solve_watched(surface, seeds, method, Start::Fresh, &mut Unwatched)?;
        self.restore(surface, seeds, method, solution)
    }

    /// Adds seeds to the last map of the surface, which must have converged with the same wavefront.
    ///
    /// # Errors
    /// As [`Solver::solve`], and [`VulkanError::TooManyAnchors`] if a map of anchored fronts has no room for
    /// more sources inside cells.
    pub fn add(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        method: Method,
    ) -> Result<Solution, VulkanError> {
        let solution =
            self.solve_watched(surface, seeds, method, Start::FromLast, &mut Unwatched)?;
        self.restore(surface, seeds, method, solution)
    }

    /// Solves again from the seeds that are lost ([`Seed::is_lost`]), until none is.
    fn restore(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        method: Method,
        mut solution: Solution,
    ) -> Result<Solution, VulkanError> {
        let chart = surface.images.chart;
        let is_lost = |seed: &Seed, distances: &[f32]| {
            seed.is_lost(distances[chart.index(seed.row, seed.col)])
        };
        // Only curved fronts are ever withdrawn.
        while solution.wavefront.is_curved()
            && solution.iterations < method.stop.iterations
            && seeds.iter().any(|seed| is_lost(seed, &solution.distances))
        {
            let left = method.stop.iterations - solution.iterations;
            let method = Method { stop: Stop { iterations: left, ..method.stop }, ..method };
            let further =
                self.solve_watched(surface, seeds, method, Start::FromLast, &mut Unwatched)?;
            solution = Solution {
                iterations: solution.iterations + further.iterations,
                time: solution.time + further.time,
                ..further
            };
        }
        Ok(solution)
    }

    /// Returns what the device offers for profiling; `None` unless the solver was made by
    /// [`Solver::for_profiling`].
    pub fn capabilities(&self) -> Option<&Capabilities> {
        self.context.capabilities.as_ref()
    }

    /// Returns the driver's statistics of the pipelines used so far. The list is empty if the device does not
    /// provide them.
    pub fn executables(&self) -> Result<Vec<Executable>, VulkanError> {
        match self.capabilities().is_some_and(|found| found.executables.is_ok()) {
            true => {
                self.for_device.executables(&self.context.instance.handle, &self.context.device)
            }
            false => Ok(Vec::new()),
        }
    }

    /// Computes the same map as [`Solver::solve`] and returns a record of every pass.
    ///
    /// # Errors
    /// As [`Solver::solve`], and [`VulkanError::NotForProfiling`] unless the solver was made by
    /// [`Solver::for_profiling`].
    pub fn profile(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        method: Method,
        detail: Detail,
    ) -> Result<(Solution, SolveProfile), VulkanError> {
        let capabilities = self.capabilities().ok_or(VulkanError::NotForProfiling)?;
        let schedule = self.schedule(&surface.images, method);
        let (texels, tuning) = (surface.images.texels, self.tuning());
        let portions = tuning.portions(method.wavefront, texels);
        let steps = schedule.plan(texels, portions, None, method.stop.iterations);
        let passes = schedules::records(&steps, detail.grain);
        let [cols, rows] = texels.tiles(tuning.tile);
        let tiles = cols as usize * rows as usize;
        let detail = Detail { tiles: detail.tiles && schedule.has_rounds(), ..detail };
        let room = passes + PASSES_AROUND;
        let mut session = Session::new(&self.context, capabilities, room, tiles, detail)?;
        // Command buffers that were recorded before contain no queries.
        surface.goes_on = None;
        let solved = self.solve_watched(surface, seeds, method, Start::Fresh, &mut session);
        surface.goes_on = None;
        let solution = solved?;
        let profile = session.finish(solution.time);
        Ok((solution, profile))
    }

    fn schedule(&self, images: &GridImages, method: Method) -> Schedule {
        let best = || Schedule::best_on(self.for_device.limits.kind, images.chart);
        method.schedule.unwrap_or_else(best)
    }

    fn solve_watched(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        method: Method,
        start: Start,
        submitter: &mut impl Submitter,
    ) -> Result<Solution, VulkanError> {
        let stop = method.stop;
        let (wavefront, carried) = surface.begin(method.wavefront, seeds, start)?;
        let schedule = self.schedule(&surface.images, method);
        let variant = Variant {
            wavefront,
            splits: surface.splits,
            slowed: surface.slowed,
            named: surface.is_named(),
        };
        self.make_passes(&surface.images, schedule, variant)?;
        let causal = surface.origins.are_causal() || surface.splits;
        let SurfaceOnDevice { images, first, further, goes_on, .. } = surface;
        let (texels, portions) = (images.texels, self.tuning().portions(wavefront, images.texels));

        let begin = Instant::now();
        submitter.restart();
        let seeds = seed_texels(seeds, &carried, wavefront);
        let begin_map = |recorder: &Recorder| {
            if start == Start::Fresh {
                recorder.forget();
            }
            recorder.start(stop, schedule, causal, start == Start::FromLast);
        };
        // The upload buffer holds `most` seeds. All but the last part are seeded by submissions of their own.
        let most = images.staging().len() / size_of::<SeedTexel>();
        let (ahead, last) = seeds.split_at(seeds.len().saturating_sub(1) / most * most);
        if !ahead.is_empty() {
            self.run(submitter, images, |recorder| begin_map(&recorder))?;
        }
        for part in ahead.chunks(most) {
            let count = write_seeds(part, images);
            self.run(submitter, images, |recorder| recorder.seed(count, schedule.follows()))?;
        }
        let count = write_seeds(last, images);
        let places = seeds.iter().map(|seed| (seed.texel[1] as u32, seed.texel[0] as u32));
        let reached = Reached::around(places).filter(|_| start == Start::Fresh);
        let most = |left: u32| left.min(schedule.together(texels, portions));
        let steps = schedule.plan(texels, portions, reached, most(stop.iterations));
        let parts = plan::parts(&steps, texels, portions.visits);
        for number in 0..parts.len() {
            self.record(submitter, first, images, |recorder| {
                if number == 0 {
                    if ahead.is_empty() {
                        begin_map(&recorder);
                    }
                    recorder.seed(count, schedule.follows());
                }
                record_part(&recorder, variant, &parts, number);
            })?;
            submitter.submit(first)?;
        }
        let mut outcome = images.record(0).outcome;
        while !outcome.is_done() {
            // One recording serves all iterations but the last ones, of which fewer may be left.
            let left = stop.iterations - outcome.iterations;
            let wanted = (variant, schedule.plan(texels, portions, None, most(left)));
            let parts = plan::parts(&wanted.1, texels, portions.visits);
            // A submitter that watches passes knows only those of the last recording.
            let is_kept = parts.len() == 1 || !submitter.is_watching();
            let is_recorded = is_kept && goes_on.as_ref() == Some(&wanted);
            while further.len() < parts.len() {
                further.push(CommandBuffer::kept(&self.context)?);
            }
            for (number, commands) in further.iter().enumerate().take(parts.len()) {
                if !is_recorded {
                    *goes_on = None;
                    self.record(submitter, commands, images, |recorder| {
                        if number == 0 {
                            recorder.go_on(schedule);
                        }
                        record_part(&recorder, variant, &parts, number);
                    })?;
                }
                submitter.submit(commands)?;
            }
            *goes_on = Some(wanted);
            outcome = images.record(0).outcome;
        }
        let time = begin.elapsed();

        let distances = self.read_back(submitter, images)?;
        self.context.check_validation()?;
        let (iterations, residual) = (outcome.iterations, outcome.residual());
        Ok(Solution { distances, wavefront, schedule, iterations, residual, time })
    }

    /// Makes the passes of a schedule and a variant, unless they exist.
    fn make_passes(
        &mut self,
        images: &GridImages,
        schedule: Schedule,
        variant: Variant,
    ) -> Result<(), VulkanError> {
        if self.for_device.has_passes(schedule, variant) {
            return Ok(());
        }
        self.for_device.make_passes(&self.context.device, schedule, variant)?;
        self.run(&mut Unwatched, images, |recorder| recorder.warm_up_map(schedule, variant))
    }

    /// Records a command buffer.
    fn record(
        &self,
        submitter: &impl Submitter,
        commands: &CommandBuffer,
        grid: &GridImages,
        append: impl FnOnce(Recorder),
    ) -> Result<(), VulkanError> {
        submitter.record(commands, |device, buffer, profile| {
            let pipelines = &self.for_device.pipelines;
            let commands = Commands { device, buffer, pipelines, profile, turn: None };
            append(Recorder { commands, grid });
        })
    }

    /// Records commands, submits them and waits for their end.
    pub(super) fn run(
        &self,
        submitter: &mut impl Submitter,
        grid: &GridImages,
        append: impl FnOnce(Recorder),
    ) -> Result<(), VulkanError> {
        let commands = CommandBuffer::new(&self.context)?;
        self.record(submitter, &commands, grid, append)?;
        submitter.submit(&commands)
    }

    fn read_back(
        &self,
        submitter: &mut impl Submitter,
        images: &mut GridImages,
    ) -> Result<Vec<f32>, VulkanError> {
        let mut distances = vec![0.0f32; images.chart.points()];
        for rows in bands(images.chart, size_of::<f32>(), transfer_bytes(images.chart)) {
            self.run(submitter, images, |recorder| recorder.unpack(rows.clone()))?;
            let part =
                &mut distances[images.chart.index(rows.start, 0)..images.chart.index(rows.end, 0)];
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(part);
            bytes.copy_from_slice(&images.download.mapped()[..bytes.len()]);
        }
        Ok(distances)
    }
}

/// Records part `number` of a plan's steps. After the last part it records the copy of the outcome.
fn record_part(recorder: &Recorder, variant: Variant, parts: &[&[Step]], number: usize) {
    let before = parts[..number].last().and_then(|part| part.last());
    recorder.steps_after(before, variant, parts[number]);
    if number + 1 == parts.len() {
        recorder.outcome(0);
    }
    recorder.end_portion();
}

/// Writes seeds to the buffer that `seed.comp` reads, and returns their number.
fn write_seeds(seeds: &[SeedTexel], images: &mut GridImages) -> u32 {
    let bytes = bytemuck::cast_slice(seeds);
    images.staging()[..bytes.len()].copy_from_slice(bytes);
    seeds.len() as u32
}

fn is_validation_wanted() -> bool {
    std::env::var_os(VALIDATION_VARIABLE).is_some_and(|value| value != "0")
}

/// Largest number of passes in a submission beside the steps of a plan: copies of the device's decisions, and
/// of the outcome of the iterations.
const PASSES_AROUND: u32 = 8;

impl Drop for Solver {
    fn drop(&mut self) {
        let device = &self.context.device;
        self.for_device.destroy(device);
        if let Some(store) = &mut self.store {
            // A failed save is no error: the next process compiles the pipelines again.
            let _ = store.save(device);
            store.destroy(device);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::ffi::CStr;

    use ash::vk;

    use super::*;
    use crate::surface::{Sources, Spacing, Surface};
    use crate::vulkan::barrier::tests::without;
    use crate::vulkan::barrier::{Access, PASS};

    const STOP: Stop = Stop { tolerance: 1e-6, iterations: 100 };

    fn solver() -> Solver {
        let device = std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default();
        Solver::with_validation(&DeviceChoice::Name(device)).unwrap()
    }

    fn hill() -> Surface {
        let heights = (0..40 * 30).map(|i| f64::from(i % 7 + i / 90).sin()).collect();
        Surface::from_heights(40, 30, heights, Spacing::square(1.0)).unwrap()
    }

    fn method(wavefront: Wavefront, schedule: Schedule) -> Method {
        Method { wavefront, schedule: Some(schedule), stop: STOP }
    }

    fn seeds(surface: &Surface) -> Vec<Seed> {
        Sources::point(3.0, 20.5).seeds(surface).unwrap()
    }

    fn is_between_passes(before: Access, after: Access) -> bool {
        (before, after) == (PASS, PASS)
    }

    /// Checks that the validation layers are active. Without this a clean log would prove nothing.
    #[test]
    fn a_missing_barrier_is_reported() {
        let surface = hill();
        let seeds = seeds(&surface);
        for schedule in Schedule::ALL {
            let mut solver = self::solver();
            let mut on_device = solver.upload(&surface).unwrap();
            let method = method(Wavefront::Planar, schedule);
            let result =
                without(is_between_passes, || solver.solve(&mut on_device, &seeds, method));
            let Err(VulkanError::Validation(messages)) = result else { panic!("{result:?}") };
            assert!(messages.iter().any(|m| m.contains("SYNC-HAZARD-")), "{messages:?}");
        }
    }

    /// Names in the layers' messages about a fault are those that a host's tools see.
    #[test]
    fn pipelines_have_names_while_profiling() {
        let device = DeviceChoice::Name(std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default());
        let context = Context::open(&device, true, Some(&[])).unwrap();
        let mut solver = Solver::with(context).unwrap();
        let surface = hill();
        let mut on_device = solver.upload(&surface).unwrap();
        let (method, seeds) = (method(Wavefront::Planar, Schedule::Raster), seeds(&surface));
        let result = without(is_between_passes, || solver.solve(&mut on_device, &seeds, method));
        let Err(VulkanError::Validation(messages)) = result else { panic!("{result:?}") };
        assert!(messages.iter().any(|m| m.contains("[geosweep: scan ")), "{messages:?}");
    }

    #[test]
    fn all_barriers_in_place_leave_no_message_to_the_end() {
        let surface = hill();
        let mut solver = solver();
        let mut on_device = solver.upload(&surface).unwrap();
        let log = solver.validation_log().unwrap().clone();
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            for schedule in Schedule::ALL {
                let method = method(wavefront, schedule);
                solver.solve(&mut on_device, &seeds(&surface), method).unwrap();
                solver.add(&mut on_device, &seeds(&surface), method).unwrap();
            }
        }
        drop((on_device, solver));
        assert_eq!(log.messages(), Vec::<String>::new());
    }

    /// Returns a solver with one function of the device replaced by one that fails.
    fn with_failing(name: &'static CStr, result: extern "system" fn() -> vk::Result) -> Solver {
        // Validation is off, since the layers would rightly report what the fault leaves behind.
        let mut solver = Solver::open(&DeviceChoice::Any, false).unwrap();
        let context = Arc::get_mut(&mut solver.context).unwrap();
        let (instance, handle) = (&context.instance.handle, context.device.handle());
        // SAFETY: the replacement takes no arguments, which this calling convention allows, and
        // all other functions are the device's own.
        context.device = unsafe {
            let load = |wanted: &CStr| {
                if wanted == name {
                    result as *const std::ffi::c_void
                } else {
                    std::mem::transmute::<vk::PFN_vkVoidFunction, *const std::ffi::c_void>(
                        (instance.fp_v1_0().get_device_proc_addr)(handle, wanted.as_ptr()),
                    )
                }
            };
            ash::Device::load_with(load, handle)
        };
        solver
    }

    extern "system" fn lost() -> vk::Result {
        vk::Result::ERROR_DEVICE_LOST
    }

    extern "system" fn out_of_memory() -> vk::Result {
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY
    }

    #[test]
    fn a_lost_device_is_an_error() {
        let error = with_failing(c"vkQueueSubmit", lost).upload(&hill()).err().unwrap();
        assert!(error.to_string().starts_with("vkQueueSubmit failed"), "{error}");
        assert!(error.to_string().contains("CPU engine"), "{error}");
    }

    #[test]
    fn running_out_of_memory_is_an_error() {
        for call in [c"vkCreateImage", c"vkCreateBuffer", c"vkCreateDescriptorPool"] {
            let error = with_failing(call, out_of_memory).upload(&hill()).err().unwrap();
            let call = call.to_str().unwrap();
            assert!(error.to_string().starts_with(&format!("{call} failed")), "{error}");
        }
    }
}
