//! The outputs of a map beside its distances, and who reads them.

use geosweep::ash::{self, vk};
use geosweep::vulkan::VulkanError;
use geosweep::vulkan::embed::{
    Access, ContourFrame, Contours, DirectionFrame, Directions, FrameSurface, LogMapFrame,
    LogMapImage, Reader, Recording, RegionFrame, Regions, SourceInput,
};
use wgpu::BufferUsages as Usage;

use crate::hal::raw_buffer;
use crate::{Error, MapDevice, MapFrame, MapInfo};

/// Stages of wgpu's shaders. wgpu's state `RESOURCE` corresponds to them.
const SHADERS: vk::PipelineStageFlags = vk::PipelineStageFlags::from_raw(
    vk::PipelineStageFlags::VERTEX_SHADER.as_raw()
        | vk::PipelineStageFlags::FRAGMENT_SHADER.as_raw()
        | vk::PipelineStageFlags::COMPUTE_SHADER.as_raw(),
);

/// Access by which wgpu samples a texture, in any shader.
pub(crate) const READER: Reader =
    Reader::sampled(Access::new(SHADERS, vk::AccessFlags::SHADER_READ));

/// Accesses by which wgpu reads a buffer: in any shader, as vertices, as arguments of draws, and by copies.
const BUFFER_READER: Access = Access::new(
    vk::PipelineStageFlags::from_raw(
        SHADERS.as_raw() | Access::DRAW.stages.as_raw() | vk::PipelineStageFlags::TRANSFER.as_raw(),
    ),
    vk::AccessFlags::from_raw(
        vk::AccessFlags::SHADER_READ.as_raw()
            | Access::DRAW.access.as_raw()
            | vk::AccessFlags::TRANSFER_READ.as_raw(),
    ),
);

/// The outputs that a map was made with.
#[derive(Default)]
pub(crate) struct Outputs {
    pub contours: Option<(Contours, wgpu::Buffer)>,
    pub regions: Option<(Regions, wgpu::Buffer)>,
    pub directions: Option<Directions>,
    pub log_map: Option<LogMapImage>,
}

impl Outputs {
    /// Creates the outputs that `info` asks for. Those that were created before an error stay in `self`, for
    /// [`Outputs::destroy`].
    pub fn create(
        &mut self,
        on: &MapDevice,
        surface: &FrameSurface,
        info: &MapInfo<'_>,
    ) -> Result<(), Error> {
        let MapDevice { solver, raw, .. } = on;
        if info.contour_vertices > 0 {
            let usage = Usage::VERTEX | Usage::INDIRECT;
            let bytes = Contours::buffer_bytes(info.contour_vertices);
            let (buffer, handle) = buffer(on, "contours", bytes, usage)?;
            let vertices = info.contour_vertices;
            let output =
                solver.contours_into(raw, &mut *on.allocator(), surface, vertices, handle)?;
            self.contours = Some((output, buffer));
        }
        if info.regions {
            let bytes = Regions::buffer_bytes(info.chart);
            let (buffer, handle) = buffer(on, "regions", bytes, Usage::VERTEX)?;
            let wavefront = info.wavefront;
            let output =
                solver.regions_into(raw, &mut *on.allocator(), surface, wavefront, handle)?;
            self.regions = Some((output, buffer));
        }
        if info.directions {
            self.directions = Some(solver.directions(raw, &mut *on.allocator(), surface)?);
        }
        if info.log_map {
            self.log_map = Some(solver.log_map(raw, &mut *on.allocator(), surface)?);
        }
        Ok(())
    }

    /// Records all outputs of the map that was recorded before.
    pub fn record(
        &self,
        recording: &Recording<'_>,
        frame: &MapFrame<'_>,
    ) -> Result<(), VulkanError> {
        let sources = SourceInput::Inline(frame.sources);
        if let Some((contours, _)) = &self.contours {
            recording.contours(contours, &ContourFrame::new(frame.levels, BUFFER_READER))?;
        }
        if let Some((regions, _)) = &self.regions {
            recording.regions(regions, &RegionFrame::new(sources, BUFFER_READER))?;
        }
        if let Some(directions) = &self.directions {
            recording.directions(directions, &DirectionFrame::new(sources, READER))?;
        }
        if let Some(log_map) = &self.log_map {
            let frame = LogMapFrame::new(sources, READER)
                .with_radius(frame.log_map_radius)
                .with_unreached(frame.beyond);
            recording.log_map(log_map, &frame)?;
        }
        Ok(())
    }

    /// Buffers of wgpu that the passes write.
    pub fn buffers(&self) -> impl Iterator<Item = &wgpu::Buffer> {
        let contours = self.contours.as_ref().map(|(_, buffer)| buffer);
        contours.into_iter().chain(self.regions.as_ref().map(|(_, buffer)| buffer))
    }

    pub fn destroy(&mut self, on: &MapDevice) {
        let (raw, mut allocator) = (&on.raw, on.allocator());
        if let Some((contours, _)) = &mut self.contours {
            contours.destroy(raw, &mut *allocator);
        }
        if let Some((regions, _)) = &mut self.regions {
            regions.destroy(raw, &mut *allocator);
        }
        if let Some(directions) = &mut self.directions {
            directions.destroy(raw, &mut *allocator);
        }
        if let Some(log_map) = &mut self.log_map {
            log_map.destroy(raw, &mut *allocator);
        }
    }
}

/// Creates a buffer of wgpu that our passes write.
fn buffer(
    on: &MapDevice,
    label: &'static str,
    size: u64,
    usage: Usage,
) -> Result<(wgpu::Buffer, vk::Buffer), Error> {
    let buffer = on.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size.next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT),
        // Passes clear and copy into it. wgpu clears it before the first map, since it would before its first use.
        usage: usage | Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST,
        mapped_at_creation: false,
    });
    let handle = raw_buffer(&buffer, label)?;
    Ok((buffer, handle))
}

/// Transitions new images to the layout in which wgpu samples them.
pub(crate) fn bring_into_layout(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    images: &[vk::Image],
) {
    let range = vk::ImageSubresourceRange::default()
        .aspect_mask(vk::ImageAspectFlags::COLOR)
        .level_count(1)
        .layer_count(1);
    let barrier = |image: &vk::Image| {
        vk::ImageMemoryBarrier::default()
            .image(*image)
            .subresource_range(range)
            .new_layout(READER.layout)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_access_mask(READER.access.access)
    };
    let barriers: Vec<_> = images.iter().map(barrier).collect();
    let (from, to) = (vk::PipelineStageFlags::TOP_OF_PIPE, READER.access.stages);
    let none = vk::DependencyFlags::empty();
    // SAFETY: the images are alive, and the command buffer is being recorded.
    unsafe { device.cmd_pipeline_barrier(commands, from, to, none, &[], &[], &barriers) };
}
