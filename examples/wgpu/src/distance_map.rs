//! A distance map of geosweep's on a device of wgpu's: recorded into wgpu's command encoders, its image sampled
//! by wgpu's pipelines where it lies. A renderer copies this file and changes it.

use std::error::Error;
use std::sync::{Arc, Mutex, PoisonError};

use geosweep::ash::{self, ext, vk};
use geosweep::gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    Access, Frame, Outcome, Plan, PointSource, Points, Reader, Solver, SourceInput, Surface,
    SurfaceInfo, Tools,
};
use geosweep::vulkan::{Method, Schedule, requirements};
use geosweep::{Stop, Wavefront};
use wgpu::hal::api::Vulkan;

/// How wgpu reads a texture that is sampled: in any shader, whichever it will be.
pub const READER: Reader = Reader::sampled(Access::new(
    vk::PipelineStageFlags::from_raw(
        vk::PipelineStageFlags::VERTEX_SHADER.as_raw()
            | vk::PipelineStageFlags::FRAGMENT_SHADER.as_raw()
            | vk::PipelineStageFlags::COMPUTE_SHADER.as_raw(),
    ),
    vk::AccessFlags::SHADER_READ,
));

/// What an adapter lacks for maps; an empty list means that they run on it. No feature and no limit beyond wgpu's
/// own has to be asked for when the device is made.
pub fn unmet(adapter: &wgpu::Adapter) -> Vec<String> {
    // SAFETY: nothing of wgpu's is destroyed.
    match unsafe { adapter.as_hal::<Vulkan>() } {
        Some(adapter) => requirements::unmet(
            adapter.shared_instance().raw_instance(),
            adapter.raw_physical_device(),
        ),
        None => vec!["wgpu does not drive it by Vulkan".into()],
    }
}

/// The pipelines of a device, and the memory of its maps: one for all maps.
pub struct MapDevice {
    solver: Solver,
    allocator: Mutex<Allocator>,
    raw: ash::Device,
    /// Last, since the others go before the device does.
    device: wgpu::Device,
}

impl MapDevice {
    /// The one call that takes long: it may run on a thread of its own.
    ///
    /// # Errors
    /// If wgpu does not drive the device by Vulkan, or a call of Vulkan's fails.
    pub fn new(device: &wgpu::Device) -> Result<Arc<Self>, Box<dyn Error>> {
        // SAFETY: nothing of wgpu's is destroyed.
        let hal = unsafe { device.as_hal::<Vulkan>() }.ok_or("wgpu does not use Vulkan")?;
        let (instance, physical_device) = (hal.shared_instance(), hal.raw_physical_device());
        let raw = hal.raw_device().clone();
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw_instance().clone(),
            device: raw.clone(),
            physical_device,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: Default::default(),
        })?;
        let labels = instance.extensions().contains(&ext::debug_utils::NAME);
        let tools = Tools { labels, ..Tools::default() };
        let passes = [(Schedule::Raster, Wavefront::Curved)];
        let solver = instance.raw_instance();
        let solver = Solver::with_tools(solver, physical_device, &raw, &passes, tools)?;
        let device = device.clone();
        Ok(Arc::new(Self { solver, allocator: Mutex::new(allocator), raw, device }))
    }

    fn allocator(&self) -> std::sync::MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for MapDevice {
    fn drop(&mut self) {
        self.solver.destroy(&self.raw);
    }
}

/// The map of a surface with vertices in a buffer of wgpu's.
pub struct DistanceMap {
    texture: wgpu::Texture,
    plan: Plan,
    images: Arc<Images>,
}

/// What is freed when neither the map nor wgpu, which may draw a last frame, uses the image any more.
struct Images {
    surface: Surface,
    on: Arc<MapDevice>,
    /// Read by our passes, of which wgpu knows nothing.
    _vertices: wgpu::Buffer,
}

impl Drop for Images {
    fn drop(&mut self) {
        self.surface.destroy(&self.on.raw, &mut self.on.allocator());
    }
}

impl DistanceMap {
    /// A map over so many rows and columns of vertices, which begin with three floats, `stride` bytes apart, in a
    /// buffer with usage `STORAGE`.
    ///
    /// # Errors
    /// If the vertices are too few, or memory runs out.
    pub fn new(
        on: &Arc<MapDevice>,
        queue: &wgpu::Queue,
        vertices: &wgpu::Buffer,
        stride: u64,
        chart: Chart,
    ) -> Result<Self, Box<dyn Error>> {
        let MapDevice { solver, raw, device, .. } = &**on;
        let method = Method {
            wavefront: Wavefront::Curved,
            schedule: None,
            stop: Stop { tolerance: 1e-5, iterations: 100 },
        };
        let plan = solver.plan(chart, method, 8)?;
        let buffer = {
            // SAFETY: the buffer is not destroyed.
            let hal = unsafe { vertices.as_hal::<Vulkan>() }.ok_or("the buffer is destroyed")?;
            unsafe { hal.raw_handle() }
        };
        let points = [Points::positions(buffer, stride)];
        // wgpu submits to one queue, where frames wait for one another: one image will do.
        let info = SurfaceInfo { points: &points, ..SurfaceInfo::new(chart) };
        let surface = solver.surface(raw, &mut on.allocator(), &info)?;
        let images = Arc::new(Images { surface, on: Arc::clone(on), _vertices: vertices.clone() });

        let image = images.surface.result(0, READER.layout)?.image;
        let mut encoder = device.create_command_encoder(&Default::default());
        with_commands(&mut encoder, |commands| {
            solver.record(raw, commands, &images.surface).prepare();
            bring_into_layout(raw, commands, image);
        })?;
        queue.submit([encoder.finish()]);

        let size = wgpu::Extent3d {
            width: chart.cols as u32,
            height: chart.rows as u32,
            depth_or_array_layers: 1,
        };
        let descriptor = wgpu::TextureDescriptor {
            label: Some("distances"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R32Float,
            // Nothing else: wgpu would bring the image into another layout, of which we know nothing.
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let hal_descriptor = wgpu::hal::TextureDescriptor {
            label: descriptor.label,
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: descriptor.dimension,
            format: descriptor.format,
            usage: wgpu::TextureUses::RESOURCE,
            memory_flags: wgpu::hal::MemoryFlags::empty(),
            view_formats: Vec::new(),
        };
        let kept = Arc::clone(&images);
        // SAFETY: the image is as described, in the layout of a resource, and stays until wgpu has let go of it.
        let texture = unsafe {
            let hal = device.as_hal::<Vulkan>().ok_or("wgpu does not use Vulkan")?;
            let hal_texture = hal.texture_from_raw(
                image,
                &hal_descriptor,
                Some(Box::new(move || drop(kept))),
                wgpu::hal::vulkan::TextureMemory::External,
            );
            drop(hal);
            device.create_texture_from_hal::<Vulkan>(
                hal_texture,
                &descriptor,
                wgpu::TextureUses::RESOURCE,
            )
        };
        Ok(Self { texture, plan, images })
    }

    /// Records a new map from the vertices as they are then. The encoder is for maps alone: wgpu lets an encoder
    /// record its own commands or others', not both. It is submitted after the commands that write the vertices,
    /// and before those that draw.
    ///
    /// # Errors
    /// If a source is off the grid.
    ///
    /// # Panics
    /// If the encoder has recorded commands of wgpu's own.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        sources: &[PointSource],
    ) -> Result<(), Box<dyn Error>> {
        self.record_for(READER, encoder, sources)
    }

    /// The same, for another reader.
    ///
    /// # Errors
    /// As [`DistanceMap::record`].
    ///
    /// # Panics
    /// As [`DistanceMap::record`].
    pub fn record_for(
        &self,
        reader: Reader,
        encoder: &mut wgpu::CommandEncoder,
        sources: &[PointSource],
    ) -> Result<(), Box<dyn Error>> {
        let Images { surface, on, .. } = &*self.images;
        let frame = Frame {
            // What wgpu's compute passes and copies have written is waited for anyway.
            before: Access::NONE,
            points: Some(0),
            sources: SourceInput::Inline(sources),
            plan: &self.plan,
            slot: 0,
            reader,
            // No infinity, which filters would make NaN of.
            unreached: -1.0,
        };
        with_commands(encoder, |commands| {
            on.solver.record(&on.raw, commands, surface).frame(&frame).map(drop)
        })??;
        Ok(())
    }

    /// The image of distances, for pipelines to sample: a column to the right, a row down.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }

    /// How the last map went, once it has run.
    ///
    /// # Errors
    /// If it has not run.
    pub fn outcome(&self) -> Result<Outcome, Box<dyn Error>> {
        Ok(self.images.surface.outcome(0)?)
    }
}

impl Drop for DistanceMap {
    /// Waits for what was submitted: wgpu does not know which images our passes use. A device that is lost
    /// runs nothing any more.
    fn drop(&mut self) {
        let _ = self.images.on.device.poll(wgpu::PollType::wait_indefinitely());
    }
}

/// Records into an encoder's command buffer.
fn with_commands<T>(
    encoder: &mut wgpu::CommandEncoder,
    record: impl FnOnce(vk::CommandBuffer) -> T,
) -> Result<T, Box<dyn Error>> {
    // SAFETY: commands are recorded into it, and wgpu ends it.
    unsafe {
        encoder.as_hal_mut::<Vulkan, _, _>(|hal| {
            Ok(record(hal.ok_or("the encoder does not record for Vulkan")?.raw_handle()))
        })
    }
}

/// Brings the image, of which nothing is known yet, into the layout in which wgpu samples it.
fn bring_into_layout(device: &ash::Device, commands: vk::CommandBuffer, image: vk::Image) {
    let range = vk::ImageSubresourceRange::default()
        .aspect_mask(vk::ImageAspectFlags::COLOR)
        .level_count(1)
        .layer_count(1);
    let barrier = vk::ImageMemoryBarrier::default()
        .image(image)
        .subresource_range(range)
        .new_layout(READER.layout)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_access_mask(READER.access.access);
    let (from, to) = (vk::PipelineStageFlags::TOP_OF_PIPE, READER.access.stages);
    let none = vk::DependencyFlags::empty();
    // SAFETY: the image is alive, and the command buffer is recorded.
    unsafe { device.cmd_pipeline_barrier(commands, from, to, none, &[], &[], &[barrier]) };
}
