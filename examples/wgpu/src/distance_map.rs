//! A distance map of geosweep on a device of wgpu. It is recorded into wgpu's command encoders, and wgpu's
//! pipelines sample its image without a copy. A renderer can copy and change this file.

use std::error::Error;
use std::sync::{Arc, Mutex, PoisonError};

use geosweep::ash::{self, ext, vk};
use geosweep::gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    Access, Frame, FrameSurface, Outcome, Plan, PointSource, Points, Reader, Solver, SourceInput,
    SurfaceInfo, Tools,
};
use geosweep::vulkan::{Method, Schedule, requirements};
use geosweep::{Stop, Wavefront};
use wgpu::hal::api::Vulkan;

/// Access by which wgpu samples a texture, in any shader.
pub const READER: Reader = Reader::sampled(Access::new(
    vk::PipelineStageFlags::from_raw(
        vk::PipelineStageFlags::VERTEX_SHADER.as_raw()
            | vk::PipelineStageFlags::FRAGMENT_SHADER.as_raw()
            | vk::PipelineStageFlags::COMPUTE_SHADER.as_raw(),
    ),
    vk::AccessFlags::SHADER_READ,
));

/// Returns the requirements of maps that an adapter does not meet. An empty list means that maps run on it.
/// The device needs no features or limits beyond wgpu's own.
pub fn unmet(adapter: &wgpu::Adapter) -> Vec<String> {
    // SAFETY: no object of wgpu is destroyed.
    match unsafe { adapter.as_hal::<Vulkan>() } {
        Some(adapter) => requirements::unmet(
            adapter.shared_instance().raw_instance(),
            adapter.raw_physical_device(),
        ),
        None => vec!["wgpu does not drive it by Vulkan".into()],
    }
}

/// The pipelines of a device, and the memory of its maps. All maps on the device share one `MapDevice`.
pub struct MapDevice {
    solver: Solver,
    allocator: Mutex<Allocator>,
    raw: ash::Device,
    /// Device of wgpu. It is the last member, so that the others are dropped before it.
    device: wgpu::Device,
}

impl MapDevice {
    /// Creates the pipelines. This call takes long, and may run on another thread.
    ///
    /// # Errors
    /// If wgpu does not drive the device through Vulkan, or a Vulkan call fails.
    pub fn new(device: &wgpu::Device) -> Result<Arc<Self>, Box<dyn Error>> {
        // SAFETY: no object of wgpu is destroyed.
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

/// The map of a surface with vertices in a buffer of wgpu.
pub struct DistanceMap {
    texture: wgpu::Texture,
    plan: Plan,
    images: Arc<Images>,
}

/// Resources that are freed when neither the map nor wgpu, which may draw a last frame, uses the image any
/// more.
struct Images {
    surface: FrameSurface,
    on: Arc<MapDevice>,
    /// Vertices that geosweep's passes read, of which wgpu knows nothing.
    _vertices: wgpu::Buffer,
}

impl Drop for Images {
    fn drop(&mut self) {
        self.surface.destroy(&self.on.raw, &mut self.on.allocator());
    }
}

impl DistanceMap {
    /// Creates a map over `chart.rows` rows and `chart.cols` columns of vertices. Each vertex begins with three
    /// floats. The vertices are `stride` bytes apart, in a buffer with usage `STORAGE`.
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
        let method = Method::new(Wavefront::Curved, Stop::within(1e-5).or_after(100));
        let plan = solver.plan(chart, method, 8)?;
        let buffer = {
            // SAFETY: the buffer is not destroyed.
            let hal = unsafe { vertices.as_hal::<Vulkan>() }.ok_or("the buffer is destroyed")?;
            unsafe { hal.raw_handle() }
        };
        let points = [Points::positions(buffer, stride)];
        // wgpu submits to one queue, on which frames wait for one another, so that one image is enough.
        let info = SurfaceInfo::new(chart).with_points(&points);
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
            // No other usage: wgpu would change the image's layout without the map's knowledge.
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
        // SAFETY: the image is as described, in the layout of a resource, and exists until wgpu has released
        // it.
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

    /// Records a new map from the vertices as they are when the map runs. The encoder is for maps alone: an
    /// encoder records either wgpu's own commands or those of others. Submit its commands after the commands that
    /// write the vertices, and before those that draw.
    ///
    /// # Errors
    /// If a source is off the grid.
    ///
    /// # Panics
    /// If the encoder has recorded commands of wgpu.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        sources: &[PointSource],
    ) -> Result<(), Box<dyn Error>> {
        self.record_for(READER, encoder, sources)
    }

    /// Records a new map as [`DistanceMap::record`] does, for another reader.
    ///
    /// # Errors
    /// As for [`DistanceMap::record`].
    ///
    /// # Panics
    /// As for [`DistanceMap::record`].
    pub fn record_for(
        &self,
        reader: Reader,
        encoder: &mut wgpu::CommandEncoder,
        sources: &[PointSource],
    ) -> Result<(), Box<dyn Error>> {
        let Images { surface, on, .. } = &*self.images;
        // The map waits for writes of wgpu's compute passes and copies in any case, so `before` stays at
        // NONE. Unreached points are not at infinity, which filters would turn to NaN.
        let frame = Frame::new(&self.plan, SourceInput::Inline(sources), reader)
            .with_points(0)
            .with_unreached(-1.0);
        with_commands(encoder, |commands| {
            on.solver.record(&on.raw, commands, surface).frame(&frame).map(drop)
        })??;
        Ok(())
    }

    /// Returns the image of distances, which pipelines can sample: x is the column, and y is the row.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }

    /// Returns the outcome of the last map, once it has run.
    ///
    /// # Errors
    /// If no map has run.
    pub fn outcome(&self) -> Result<Outcome, Box<dyn Error>> {
        Ok(self.images.surface.outcome(0)?)
    }
}

impl Drop for DistanceMap {
    /// Waits for submitted work, since wgpu does not know which images geosweep's passes use. A lost device
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
    // SAFETY: commands are only recorded into the command buffer, and wgpu ends it.
    unsafe {
        encoder.as_hal_mut::<Vulkan, _, _>(|hal| {
            Ok(record(hal.ok_or("the encoder does not record for Vulkan")?.raw_handle()))
        })
    }
}

/// Transitions the new image to the layout in which wgpu samples it.
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
    // SAFETY: the image is alive, and the command buffer is being recorded.
    unsafe { device.cmd_pipeline_barrier(commands, from, to, none, &[], &[], &[barrier]) };
}
