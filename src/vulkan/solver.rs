//! Headless solving: upload, iterate, read back.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::grid_images::{POINT_BYTES, band_rows};
use super::headless::Context;
use super::plan::{self, Reached, Step};
use super::upload::{SeedTexel, seed_texels, write_points};
use super::{
    GridImages, Pipelines, ScanPipelines, TexelChart, ValidationLog, VulkanError, record,
    requirements,
};
use crate::DeviceChoice;
use crate::cpu::{Progress, Stop};
use crate::surface::{Chart, Seed, Surface};
use crate::update::Wavefront;

/// Turns the validation layers on in every [`Solver`], if set to anything but 0.
const VALIDATION_VARIABLE: &str = "GEOSWEEP_VALIDATION";

/// A Vulkan device with the pipelines, for use without a renderer.
///
/// ```no_run
/// use geosweep::{DeviceChoice, Sources, Spacing, Surface, Wavefront, cpu::Stop, vulkan::Solver};
/// let surface = Surface::from_heights(2, 2, vec![0.0; 4], Spacing::square(1.0))?;
/// let mut solver = Solver::new(&DeviceChoice::Any)?;
/// let mut on_device = solver.upload(&surface)?;
/// for row in 0..2 {
///     let seeds = Sources::point(row as f64, 0.0).seeds(&surface)?;
///     let stop = Stop { tolerance: 1e-6, iterations: 100 };
///     let solution = solver.solve(&mut on_device, &seeds, Wavefront::PointSource, stop)?;
///     println!("{:?} after {:?}", solution.distances, solution.time);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Solver {
    pipelines: Pipelines,
    /// Made when a wavefront is first used.
    scans: [Option<ScanPipelines>; Wavefront::ALL.len()],
    context: Arc<Context>,
}

/// A surface's edge lengths on a device, ready for any number of maps.
///
/// Must not outlive its solver's last use of it; memory is freed when it is dropped.
pub struct SurfaceOnDevice {
    images: GridImages,
    context: Arc<Context>,
}

/// A distance map as the Vulkan engine leaves it.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Distances, row-major, +infinity where the sources do not reach.
    pub distances: Vec<f32>,
    /// Iterations of four scans.
    pub iterations: u32,
    /// Largest relative change of an arrival time in the last iteration.
    pub residual: f64,
    /// From the first submission of an iteration to the end of the last.
    pub time: Duration,
}

impl Solver {
    /// Opens a device. With the environment variable `GEOSWEEP_VALIDATION` set to anything but
    /// 0, the validation layers are on, as with [`Solver::with_validation`].
    pub fn new(choice: &DeviceChoice) -> Result<Self, VulkanError> {
        let validate = std::env::var_os(VALIDATION_VARIABLE).is_some_and(|value| value != "0");
        Self::open(choice, validate)
    }

    /// Opens a device under the Khronos validation layers, with synchronization and GPU-assisted
    /// validation. Every call then fails that leaves a message in the log.
    pub fn with_validation(choice: &DeviceChoice) -> Result<Self, VulkanError> {
        Self::open(choice, true)
    }

    fn open(choice: &DeviceChoice, validate: bool) -> Result<Self, VulkanError> {
        let context = Arc::new(Context::new(choice, validate)?);
        let pipelines = Pipelines::new(&context.device)?;
        Ok(Self { pipelines, scans: [const { None }; Wavefront::ALL.len()], context })
    }

    /// The device's name.
    pub fn device_name(&self) -> &str {
        &self.context.info.name
    }

    /// What the validation layers have said; `None` if they are off.
    pub fn validation_log(&self) -> Option<&ValidationLog> {
        self.context.instance.validation_log()
    }

    /// Uploads a surface and measures its edges on the device.
    ///
    /// # Errors
    /// If an edge is too long or too short for single precision, or the grid is too large for
    /// the device's images or memory.
    pub fn upload(&self, surface: &Surface) -> Result<SurfaceOnDevice, VulkanError> {
        surface.check_edges()?;
        let chart = surface.chart();
        let texels = self.check_size(chart)?;
        let context = Arc::clone(&self.context);
        let images = GridImages::new(
            &context.device,
            &mut context.allocator(),
            &self.pipelines,
            chart,
            texels,
        )?;
        let mut on_device = SurfaceOnDevice { images, context };
        let images = &mut on_device.images;
        self.context.run(|device, commands| record::prepare(device, commands, images))?;
        let origin = surface.origin();
        for rows in bands(chart, POINT_BYTES) {
            let around = record::rows_around(&rows, chart);
            write_points(surface, around, origin, images.upload.mapped());
            self.context.run(|device, commands| {
                record::measure_edges(device, commands, &self.pipelines, images, surface, rows);
            })?;
        }
        self.context.run(|device, commands| {
            record::bend(device, commands, &self.pipelines, images, surface.edge_rule());
        })?;
        self.context.check_validation()?;
        Ok(on_device)
    }

    /// Computes a map from seeds, which must lie on the surface.
    pub fn solve(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        wavefront: Wavefront,
        stop: Stop,
    ) -> Result<Solution, VulkanError> {
        self.solve_planned(surface, seeds, wavefront, stop, plan::iteration)
    }

    fn solve_planned(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        wavefront: Wavefront,
        stop: Stop,
        plan: impl Fn(TexelChart, &mut Reached) -> Vec<Step>,
    ) -> Result<Solution, VulkanError> {
        let context = Arc::clone(&self.context);
        let scans = match &mut self.scans[wavefront as usize] {
            Some(scans) => scans,
            empty => empty.insert(ScanPipelines::new(&context.device, &self.pipelines, wavefront)?),
        };
        let (pipelines, images) = (&self.pipelines, &mut surface.images);

        context.run(|device, commands| {
            record::forget(device, commands, images);
            record::warm_up(device, commands, pipelines, scans, images);
        })?;
        let texels = seed_texels(seeds);
        for part in texels.chunks(images.upload.mapped().len() / size_of::<SeedTexel>()) {
            let bytes = bytemuck::cast_slice(part);
            images.upload.mapped()[..bytes.len()].copy_from_slice(bytes);
            let count = part.len() as u32;
            context.run(|device, commands| {
                record::seed(device, commands, pipelines, images, count);
            })?;
        }

        let places = texels.iter().map(|seed| (seed.texel[1] as u32, seed.texel[0] as u32));
        let everywhere = Reached::everywhere(images.texels);
        let bounds = Reached::around(places).unwrap_or_else(|| everywhere.clone());
        let record = |mut reached: Reached, renews: bool, images: &GridImages| {
            let steps = plan(images.texels, &mut reached);
            context.record(|device, commands| {
                record::iterate(device, commands, pipelines, scans, images, &steps, renews);
            })
        };
        let mut progress = Progress::new(stop);
        let mut commands = record(bounds, progress.renews(), images)?;
        let start = Instant::now();
        loop {
            commands.submit_and_wait()?;
            let residual = images.residual_on_host.mapped();
            let renews = progress.renews();
            if progress.is_done::<f32>(*bytemuck::from_bytes(&residual[..size_of::<u32>()])) {
                break;
            }
            // One recording serves all iterations but the first, which may have reached all, and
            // those that no longer renew.
            if progress.iterations == 1 || progress.renews() != renews {
                commands = record(everywhere.clone(), progress.renews(), images)?;
            }
        }
        let time = start.elapsed();
        drop(commands);

        let distances = self.read_back(images)?;
        context.check_validation()?;
        let Progress { iterations, residual, .. } = progress;
        Ok(Solution { distances, iterations, residual, time })
    }

    fn read_back(&self, images: &mut GridImages) -> Result<Vec<f32>, VulkanError> {
        let mut distances = vec![0.0f32; images.chart.points()];
        for rows in bands(images.chart, size_of::<f32>()) {
            self.context.run(|device, commands| {
                record::unpack(device, commands, &self.pipelines, images, rows.clone());
            })?;
            let part =
                &mut distances[images.chart.index(rows.start, 0)..images.chart.index(rows.end, 0)];
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(part);
            bytes.copy_from_slice(&images.download.mapped()[..bytes.len()]);
        }
        Ok(distances)
    }

    /// The texels of a grid that fits the device.
    fn check_size(&self, chart: Chart) -> Result<TexelChart, VulkanError> {
        let Context { instance, info, physical_device, .. } = &*self.context;
        let (rows, cols, device) = (chart.rows, chart.cols, info.name.clone());
        let (side, largest_image) = requirements::largest_side(&instance.handle, *physical_device)
            .expect("a chosen device meets the requirements");
        let texels = TexelChart::new(chart).filter(|texels| {
            let extent = texels.edges_extent();
            extent.width <= side && extent.height <= side
        });
        let border = 4 * crate::constants::BORDER;
        let Some(texels) = texels else {
            let limit = side.saturating_sub(border) as usize;
            return Err(VulkanError::TooLarge { rows, cols, device, limit });
        };
        let bytes =
            |extent: ash::vk::Extent3D| u64::from(extent.width) * u64::from(extent.height) * 16;
        let edges = bytes(texels.edges_extent());
        let fronts = u64::from(crate::constants::LAYERS) * bytes(texels.fronts_extent());
        // SAFETY: the physical device is from this instance.
        let memory =
            unsafe { instance.handle.get_physical_device_memory_properties(*physical_device) };
        let heap = memory.memory_heaps_as_slice().iter().map(|heap| heap.size).max().unwrap_or(0);
        let needed = edges + 2 * fronts;
        // Not all drivers refuse what does not fit: on some the system ends the process instead.
        if needed > heap || edges > largest_image {
            let available =
                heap.min(if edges > largest_image { largest_image } else { heap }) >> 20;
            return Err(VulkanError::TooMuchMemory {
                rows,
                cols,
                device,
                needed: needed >> 20,
                available,
            });
        }
        Ok(texels)
    }
}

impl Drop for Solver {
    fn drop(&mut self) {
        for scans in self.scans.iter_mut().flatten() {
            scans.destroy(&self.context.device);
        }
        self.pipelines.destroy(&self.context.device);
    }
}

impl SurfaceOnDevice {
    /// Bytes of device and staging memory held.
    pub fn bytes(&self) -> u64 {
        self.images.bytes()
    }
}

impl Drop for SurfaceOnDevice {
    fn drop(&mut self) {
        self.images.destroy(&self.context.device, &mut self.context.allocator());
    }
}

/// The grid's rows in bands that fit the transfer buffers.
fn bands(chart: Chart, point_bytes: usize) -> impl Iterator<Item = std::ops::Range<usize>> {
    let step = band_rows(chart, point_bytes);
    (0..chart.rows).step_by(step).map(move |row| row..(row + step).min(chart.rows))
}

#[cfg(test)]
mod tests {
    use std::ffi::CStr;

    use ash::vk;

    use super::*;
    use crate::surface::{Sources, Spacing};

    const STOP: Stop = Stop { tolerance: 1e-6, iterations: 100 };

    fn solver() -> Solver {
        let device = std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default();
        Solver::with_validation(&DeviceChoice::Name(device)).unwrap()
    }

    fn hill() -> Surface {
        let heights = (0..40 * 30).map(|i| f64::from(i % 7 + i / 90).sin()).collect();
        Surface::from_heights(40, 30, heights, Spacing::square(1.0)).unwrap()
    }

    fn seeds(surface: &Surface) -> Vec<Seed> {
        Sources::point(3.0, 20.5).seeds(surface).unwrap()
    }

    /// Shows that the validation layers are listening: without this, a clean log says nothing.
    #[test]
    fn a_missing_barrier_is_reported() {
        let surface = hill();
        let mut solver = solver();
        let mut on_device = solver.upload(&surface).unwrap();
        let seeds = seeds(&surface);
        let leaky = |texels, reached: &mut Reached| {
            let mut steps = plan::iteration(texels, reached);
            let barrier = steps.iter().position(|step| *step == Step::Barrier).unwrap();
            steps.remove(barrier);
            steps
        };
        let result = solver.solve_planned(&mut on_device, &seeds, Wavefront::Planar, STOP, leaky);
        let Err(VulkanError::Validation(messages)) = result else { panic!("{result:?}") };
        assert!(
            messages.iter().any(|m| m.contains("SYNC-HAZARD-READ-AFTER-WRITE")),
            "{messages:?}"
        );
    }

    #[test]
    fn all_barriers_in_place_leave_no_message_to_the_end() {
        let surface = hill();
        let mut solver = solver();
        let mut on_device = solver.upload(&surface).unwrap();
        let log = solver.validation_log().unwrap().clone();
        for wavefront in Wavefront::ALL {
            solver.solve(&mut on_device, &seeds(&surface), wavefront, STOP).unwrap();
        }
        drop((on_device, solver));
        assert_eq!(log.messages(), Vec::<String>::new());
    }

    /// Replaces one function of the device by one that fails.
    fn with_failing(name: &'static CStr, result: extern "system" fn() -> vk::Result) -> Solver {
        // Not under validation: the layers would rightly complain of what the fault leaves.
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

    #[test]
    fn bands_cover_every_row_once() {
        let chart = Chart { rows: 4099, cols: 3000 };
        let bands: Vec<_> = bands(chart, POINT_BYTES).collect();
        assert!(bands.len() > 2);
        assert!(bands.iter().all(|band| band.start.is_multiple_of(2)));
        assert_eq!(bands.iter().map(|band| band.len()).sum::<usize>(), chart.rows);
        assert!(bands.windows(2).all(|pair| pair[0].end == pair[1].start));
    }
}
