//! A device with its pipelines, for use without a renderer.

use std::sync::Arc;

use ash::vk;

use super::context::Context;
use crate::Monitor;
use crate::vulkan::DeviceChoice;
use crate::vulkan::device::pipeline_store::PipelineStore;
use crate::vulkan::device::pipelines::Cache;
use crate::vulkan::profile::{Capabilities, Capability, Executable};
use crate::vulkan::{Tuning, ValidationLog, VulkanError, embed};

/// Name of the environment variable that turns the validation layers on in every [`HeadlessSolver`], if its
/// value is not 0.
const VALIDATION_VARIABLE: &str = "GEOSWEEP_VALIDATION";

/// A Vulkan device with its pipelines, for use without a renderer.
///
/// ```no_run
/// use geosweep::Stop;
/// use geosweep::vulkan::{Method, HeadlessSolver};
/// use geosweep::{DeviceChoice, Sources, Spacing, Surface, Wavefront};
/// let surface = Surface::from_heights(2, 2, vec![0.0; 4], Spacing::square(1.0))?;
/// let mut solver = HeadlessSolver::new(&DeviceChoice::Any)?;
/// let mut on_device = solver.upload(&surface)?;
/// let stop = Stop::within(1e-6).or_after(100);
/// let method = Method::new(Wavefront::Circular, stop);
/// for row in 0..2 {
///     let seeds = Sources::point(row as f64, 0.0).seeds(&surface)?;
///     let solution = solver.solve(&mut on_device, &seeds, method)?;
///     println!("{:?} after {:?}", solution.distances, solution.time);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct HeadlessSolver {
    /// Solver on the device, with the passes of the schedules and wavefronts used so far.
    pub(in crate::vulkan) for_device: embed::Solver,
    pub(in crate::vulkan) context: Arc<Context>,
    /// Store that keeps pipelines between processes, if there is one.
    store: Option<PipelineStore>,
    /// Number of pipelines that had been created when the store was saved.
    saved: usize,
    pub(in crate::vulkan) monitor: Monitor,
}

impl HeadlessSolver {
    /// Opens a device. If the environment variable `GEOSWEEP_VALIDATION` is set to anything but 0, the
    /// validation layers are on, as with [`HeadlessSolver::with_validation`].
    pub fn new(choice: &DeviceChoice) -> Result<Self, VulkanError> {
        Self::open(choice, is_validation_wanted())
    }

    /// Opens a device under the Khronos validation layers, with synchronization and GPU-assisted validation.
    /// Every call that leaves a message in the log then fails. The checks of shaders take most of the time. The
    /// layers' own variable `VK_LAYER_DISABLES=VK_VALIDATION_FEATURE_DISABLE_SHADERS_EXT` turns the checks of
    /// shaders off, and GPU-assisted validation with them.
    pub fn with_validation(choice: &DeviceChoice) -> Result<Self, VulkanError> {
        Self::open(choice, true)
    }

    /// Opens a device and enables everything that it offers for [`HeadlessSolver::profile`], except for the
    /// capabilities in `left_out`. Those behave as on a device that lacks them. The variable
    /// `GEOSWEEP_VALIDATION` counts as in [`HeadlessSolver::new`].
    ///
    /// # Errors
    /// As [`HeadlessSolver::new`]. A capability that the device lacks is not an error.
    pub fn for_profiling(
        choice: &DeviceChoice,
        left_out: &[Capability],
    ) -> Result<Self, VulkanError> {
        Self::with(Context::open(choice, is_validation_wanted(), Some(left_out))?)
    }

    fn open(choice: &DeviceChoice, validate: bool) -> Result<Self, VulkanError> {
        Self::with(Context::new(choice, validate)?)
    }

    pub(in crate::vulkan) fn with(context: Context) -> Result<Self, VulkanError> {
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
            Ok(mut for_device) => {
                let is_validated = context.instance.validation_log().is_some();
                for_device.pipelines.separates_pairs = is_validated;
                Ok(Self { for_device, context, store, saved: 0, monitor: Monitor::default() })
            }
            Err(error) => {
                store.iter_mut().for_each(|store| store.destroy(device));
                Err(error)
            }
        }
    }

    /// Sets the monitor of the maps. If it cancels a map, no further iterations are submitted, and the map is
    /// incomplete.
    pub fn with_monitor(mut self, monitor: Monitor) -> Self {
        self.monitor = monitor;
        self
    }

    /// Saves the pipelines created since the last call, if there are any and a store keeps them.
    pub(super) fn save_pipelines(&mut self) {
        let created = self.for_device.pipelines.created();
        if created == self.saved {
            return;
        }
        self.saved = created;
        if let Some(store) = &mut self.store {
            // A failed save is no error: the next process compiles the pipelines again.
            let _ = store.save(&self.context.device);
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

    /// Returns this solver with other sizes of portions than those that [`Tuning::of`] returns for the
    /// device, to find out which sizes are best. Surfaces that were uploaded before can no longer be used
    /// with it.
    ///
    /// # Errors
    /// [`VulkanError::Tuning`] if the device has no room for these sizes, or the error of a Vulkan call that
    /// fails.
    pub fn with_tuning(mut self, tuning: Tuning) -> Result<Self, VulkanError> {
        let (instance, device) = (&self.context.instance.handle, &self.context.device);
        let physical_device = self.context.physical_device;
        self.for_device.start_with(instance, physical_device, device, tuning, &[])?;
        Ok(self)
    }

    /// Returns `tuning` with the best value of [`Tuning::tile_edges`] on this device: set if shared memory
    /// has room for the edges of tiles of this size.
    pub fn with_edges_placed(&self, tuning: Tuning) -> Tuning {
        let instance = &self.context.instance.handle;
        // SAFETY: the physical device is from this instance.
        let properties =
            unsafe { instance.get_physical_device_properties(self.context.physical_device) };
        tuning.with_edges_placed(properties.limits.max_compute_shared_memory_size)
    }

    /// Returns the messages of the validation layers; `None` if the layers are off.
    pub fn validation_log(&self) -> Option<&ValidationLog> {
        self.context.instance.validation_log()
    }

    /// Returns what the device offers for profiling; `None` unless the solver was made by
    /// [`HeadlessSolver::for_profiling`].
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
}

fn is_validation_wanted() -> bool {
    std::env::var_os(VALIDATION_VARIABLE).is_some_and(|value| value != "0")
}

impl Drop for HeadlessSolver {
    fn drop(&mut self) {
        self.for_device.destroy(&self.context.device);
        self.save_pipelines();
        if let Some(store) = &mut self.store {
            store.destroy(&self.context.device);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};
    use std::ffi::CStr;

    use ash::vk;
    use glam::DVec3;

    use super::super::testing::{self, is_between_passes, validated as solver};
    use super::*;
    use crate::Stop;
    use crate::surface::{Gluing, Seed, Sources, Surface};
    use crate::update::Wavefront;
    use crate::vulkan::copies;
    use crate::vulkan::copies::tests::GroupOrder;
    use crate::vulkan::device::barrier::tests::without;
    use crate::vulkan::device::barrier::{
        Access, SHADER, SHADER_WRITE, TRANSFER_READ, TRANSFER_WRITE,
    };
    use crate::vulkan::{Method, Schedule};

    const STOP: Stop = Stop::within(1e-6).or_after(100);

    fn hill() -> Surface {
        testing::hill(40, 30, |i| i)
    }

    fn method(wavefront: Wavefront, schedule: Schedule) -> Method {
        Method::new(wavefront, STOP).with_schedule(schedule)
    }

    fn seeds(surface: &Surface) -> Vec<Seed> {
        Sources::point(3.0, 20.5).seeds(surface).unwrap()
    }

    /// Checks that the validation layers are active. Without this a clean log would prove nothing.
    #[test]
    fn a_missing_barrier_is_reported() {
        let surface = hill();
        let seeds = seeds(&surface);
        for schedule in Schedule::ALL {
            let mut solver = solver();
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
        let mut solver = testing::profiling();
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

    fn in_pairs(scan_width: u32, scan_lines: u32) -> HeadlessSolver {
        let solver = solver();
        let sizes = Tuning { scan_width, scan_lines, scan_pairs: true, ..solver.tuning() };
        solver.with_tuning(sizes).unwrap()
    }

    /// Under the layers a barrier separates the scans of a pair. All other barriers are the same as without
    /// the layers.
    #[test]
    fn all_barriers_of_pairs_in_place_leave_no_message() {
        let surface = hill();
        for (width, lines) in [(16, 4), (64, 4)] {
            let mut solver = in_pairs(width, lines);
            let mut on_device = solver.upload(&surface).unwrap();
            for wavefront in Wavefront::FOR_ANY_SURFACE {
                let method = method(wavefront, Schedule::Raster);
                solver.solve(&mut on_device, &seeds(&surface), method).unwrap();
                solver.add(&mut on_device, &seeds(&surface), method).unwrap();
            }
            let log = solver.validation_log().unwrap().messages();
            assert_eq!(log, Vec::<String>::new());
            let result = without(is_between_passes, || {
                let method = method(Wavefront::Planar, Schedule::Raster);
                solver.solve(&mut on_device, &seeds(&surface), method)
            });
            assert!(matches!(result, Err(VulkanError::Validation(_))), "{result:?}");
        }
    }

    /// One workgroup exchanges fronts between copies, and reads all of them before it writes any.
    #[test]
    fn copies_of_points_can_be_listed_in_any_order() {
        let ball = |index: usize| {
            let (polar, angle) =
                (PI * (index / 61) as f64 / 30.0, TAU * (index % 61 % 60) as f64 / 60.0);
            DVec3::new(polar.sin() * angle.cos(), polar.sin() * angle.sin(), polar.cos())
        };
        let ball = Surface::from_positions(31, 61, (0..31 * 61).map(ball).collect()).unwrap();
        let ball = ball.with_gluing(Gluing::globe()).unwrap();
        let seeds = Sources::point(8.0, 1.0).seeds(&ball).unwrap();
        let mut solver = solver();
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            for schedule in Schedule::ALL {
                let orders = [GroupOrder::AsFound, GroupOrder::Reversed, GroupOrder::Scattered];
                let [found, reversed, scattered] = orders.map(|order| {
                    copies::tests::ORDER.set(order);
                    let on_device = solver.upload(&ball);
                    copies::tests::ORDER.set(GroupOrder::AsFound);
                    solver
                        .solve(&mut on_device.unwrap(), &seeds, method(wavefront, schedule))
                        .unwrap()
                });
                for other in [reversed, scattered] {
                    assert_eq!(found.distances, other.distances, "{wavefront}, {schedule}");
                    assert_eq!(found.iterations, other.iterations, "{wavefront}, {schedule}");
                }
            }
        }
    }

    #[test]
    fn a_missing_barrier_of_a_copy_is_reported() {
        let surface = hill();
        // The missing barrier follows the unpacking of distances, or the copy of sources. The latter is the
        // second of its kind: the barrier after clears comes first.
        for (missing, number) in [((SHADER_WRITE, TRANSFER_READ), 0), ((TRANSFER_WRITE, SHADER), 1)]
        {
            let solver = solver();
            let tuning = Tuning { staged: true, ..solver.tuning() };
            let mut solver = solver.with_tuning(tuning).unwrap();
            let mut on_device = solver.upload(&surface).unwrap();
            let (method, seeds) = (method(Wavefront::Planar, Schedule::Raster), seeds(&surface));
            solver.solve(&mut on_device, &seeds, method).unwrap();
            let mut numbers = 0..;
            let chosen = move |before: Access, after: Access| {
                (before, after) == missing && numbers.next() == Some(number)
            };
            let result = without(chosen, || solver.solve(&mut on_device, &seeds, method));
            let Err(VulkanError::Validation(messages)) = result else { panic!("{result:?}") };
            assert!(messages.iter().any(|m| m.contains("SYNC-HAZARD-")), "{messages:?}");
        }
    }

    /// Returns a solver with one function of the device replaced by one that fails.
    fn with_failing(
        name: &'static CStr,
        result: extern "system" fn() -> vk::Result,
    ) -> HeadlessSolver {
        // Validation is off, since the layers would rightly report what the fault leaves behind.
        let mut solver = HeadlessSolver::open(&DeviceChoice::Any, false).unwrap();
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
