//! Finds the place on the surface under the pointer. Draws a picture of the single pixel under the pointer, whose
//! color is a source, and copies the source to the buffer that the distance passes read. The program never waits
//! for the source and never reads it.

use geosweep::ash::vk;
use geosweep::gpu_allocator::MemoryLocation;
use geosweep::vulkan::embed::Access;

use crate::Result;
use crate::gpu::Gpu;
use crate::memory::{Buffer, Image, ImageUse, whole, whole_copy};
use crate::shaders::{Draw, Layout};
use crate::stage::{Stage, barrier};

/// Format of a source: four floats.
const FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;
const DEPTH: vk::Format = vk::Format::D32_SFLOAT;
const SIZE: vk::Extent2D = vk::Extent2D { width: 1, height: 1 };
const COPIED: vk::ImageLayout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;

pub struct PickPass {
    pass: vk::RenderPass,
    pipeline: vk::Pipeline,
}

/// Picture of a surface under the pointer.
pub struct Pick {
    /// Last source, which stays if the pointer is beside the surface.
    color: Image,
    depth: Image,
    framebuffer: vk::Framebuffer,
    /// Source for the distance passes, or start for the passes that trace paths.
    pub source: Buffer,
}

impl PickPass {
    pub fn new(gpu: &Gpu, layout: &Layout) -> Result<Self> {
        let pass = render_pass(gpu)?;
        let pipeline = layout.graphics(
            gpu,
            &Draw {
                wgsl: include_str!("shaders/surface.wgsl"),
                vertex: c"pick_vertex",
                fragment: c"pick_fragment",
                curves: false,
                topology: vk::PrimitiveTopology::TRIANGLE_LIST,
                depth: true,
                blend: false,
                samples: vk::SampleCountFlags::TYPE_1,
                pass,
            },
        )?;
        Ok(Self { pass, pipeline })
    }

    pub fn destroy(&self, gpu: &Gpu) {
        // SAFETY: nothing is in flight.
        unsafe {
            gpu.device.destroy_pipeline(self.pipeline, None);
            gpu.device.destroy_render_pass(self.pass, None);
        }
    }

    /// Records the drawing of the picture, and its copy to the buffer of `pick`, which is one of the stage's picks.
    pub fn record(
        &self,
        gpu: &Gpu,
        layout: &Layout,
        (stage, pick): (&Stage, &Pick),
        commands: vk::CommandBuffer,
        frame: usize,
    ) {
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        let far = vk::ClearDepthStencilValue { depth: 1.0, stencil: 0 };
        let clear = [vk::ClearValue::default(), vk::ClearValue { depth_stencil: far }];
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(self.pass)
            .framebuffer(pick.framebuffer)
            .render_area(SIZE.into())
            .clear_values(&clear);
        let viewport =
            [vk::Viewport { width: 1.0, height: 1.0, max_depth: 1.0, ..Default::default() }];
        let sets = [stage.set(frame)];
        // SAFETY: the commands are being recorded, outside a render pass. All objects are alive.
        unsafe {
            gpu.device.cmd_begin_render_pass(commands, &info, vk::SubpassContents::INLINE);
            gpu.device.cmd_set_viewport(commands, 0, &viewport);
            gpu.device.cmd_set_scissor(commands, 0, &[SIZE.into()]);
            gpu.device.cmd_bind_pipeline(commands, graphics, self.pipeline);
            gpu.device.cmd_bind_descriptor_sets(commands, graphics, layout.pipeline, 0, &sets, &[]);
            let indices = stage.indices.handle;
            gpu.device.cmd_bind_index_buffer(commands, indices, 0, vk::IndexType::UINT32);
            gpu.device.cmd_draw_indexed(commands, stage.index_count, 1, 0, 0, 0);
            gpu.device.cmd_end_render_pass(commands);
        }
        pick.copy(gpu, commands);
    }
}

impl Pick {
    pub fn new(gpu: &mut Gpu, pass: &PickPass) -> Result<Self> {
        let samples = vk::SampleCountFlags::TYPE_1;
        let color = ImageUse {
            format: FORMAT,
            usage: vk::ImageUsageFlags::COLOR_ATTACHMENT
                | vk::ImageUsageFlags::TRANSFER_SRC
                | vk::ImageUsageFlags::TRANSFER_DST,
            aspect: vk::ImageAspectFlags::COLOR,
            samples,
        };
        let color = Image::new(gpu, "picked source", SIZE, &color)?;
        let depth = ImageUse {
            format: DEPTH,
            usage: vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
            aspect: vk::ImageAspectFlags::DEPTH,
            samples,
        };
        let depth = Image::new(gpu, "picked depth", SIZE, &depth)?;
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let source = Buffer::new(gpu, "source", 16, usage, MemoryLocation::GpuOnly)?;
        let views = [color.view, depth.view];
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(pass.pass)
            .attachments(&views)
            .width(1)
            .height(1)
            .layers(1);
        // SAFETY: views and render pass are alive.
        let framebuffer = unsafe { gpu.device.create_framebuffer(&info, None)? };
        Ok(Self { color, depth, framebuffer, source })
    }

    /// Records the first place of the source.
    pub fn set(&self, gpu: &Gpu, commands: vk::CommandBuffer, source: [f32; 4]) {
        let range = whole(vk::ImageAspectFlags::COLOR);
        let (image, filled) = (self.color.image, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
        let barrier = |from, to, before, after| {
            let barrier = vk::ImageMemoryBarrier::default()
                .image(image)
                .subresource_range(range)
                .old_layout(from)
                .new_layout(to)
                .src_access_mask(before)
                .dst_access_mask(after);
            let (stage, none) = (vk::PipelineStageFlags::TRANSFER, vk::DependencyFlags::empty());
            // SAFETY: the commands are being recorded, outside a render pass.
            unsafe {
                gpu.device.cmd_pipeline_barrier(commands, stage, stage, none, &[], &[], &[barrier]);
            }
        };
        use vk::AccessFlags as Flags;
        barrier(vk::ImageLayout::UNDEFINED, filled, Flags::NONE, Flags::TRANSFER_WRITE);
        let color = vk::ClearColorValue { float32: source };
        // SAFETY: as above.
        unsafe { gpu.device.cmd_clear_color_image(commands, image, filled, &color, &[range]) };
        barrier(filled, COPIED, Flags::TRANSFER_WRITE, Flags::TRANSFER_READ);
        self.copy(gpu, commands);
    }

    fn copy(&self, gpu: &Gpu, commands: vk::CommandBuffer) {
        let copy = whole_copy(SIZE);
        let (from, to) = (self.color.image, self.source.handle);
        // The previous frame reads the source in shaders, and copies it if a path starts there.
        let readers = vk::PipelineStageFlags::COMPUTE_SHADER
            | vk::PipelineStageFlags::VERTEX_SHADER
            | vk::PipelineStageFlags::FRAGMENT_SHADER
            | vk::PipelineStageFlags::TRANSFER;
        let (copies, none) = (vk::PipelineStageFlags::TRANSFER, vk::DependencyFlags::empty());
        // SAFETY: the commands are being recorded, outside a render pass.
        unsafe {
            gpu.device.cmd_pipeline_barrier(commands, readers, copies, none, &[], &[], &[]);
            gpu.device.cmd_copy_image_to_buffer(commands, from, COPIED, to, &[copy]);
        }
        let reads = Access::COMPUTE_READ.and(Access::FRAGMENT_READ);
        barrier(gpu, commands, Access::TRANSFER_WRITE, reads);
    }

    pub fn destroy(&mut self, gpu: &mut Gpu) {
        // SAFETY: nothing is in flight.
        unsafe { gpu.device.destroy_framebuffer(self.framebuffer, None) };
        self.color.destroy(gpu);
        self.depth.destroy(gpu);
        self.source.destroy(gpu);
    }
}

/// Creates the render pass, which keeps the color, so that a miss leaves the source unchanged.
fn render_pass(gpu: &Gpu) -> Result<vk::RenderPass> {
    let depth_layout = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    let forget = vk::AttachmentStoreOp::DONT_CARE;
    let attachments = [
        vk::AttachmentDescription::default()
            .format(FORMAT)
            .samples(vk::SampleCountFlags::TYPE_1)
            .load_op(vk::AttachmentLoadOp::LOAD)
            .store_op(vk::AttachmentStoreOp::STORE)
            .initial_layout(COPIED)
            .final_layout(COPIED),
        vk::AttachmentDescription::default()
            .format(DEPTH)
            .samples(vk::SampleCountFlags::TYPE_1)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(forget)
            .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
            .stencil_store_op(forget)
            .final_layout(depth_layout),
    ];
    let color =
        [vk::AttachmentReference::default().layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)];
    let depth = vk::AttachmentReference::default().attachment(1).layout(depth_layout);
    let subpass = [vk::SubpassDescription::default()
        .color_attachments(&color)
        .depth_stencil_attachment(&depth)];
    let colors = vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT;
    let tests =
        vk::PipelineStageFlags::EARLY_FRAGMENT_TESTS | vk::PipelineStageFlags::LATE_FRAGMENT_TESTS;
    let transfer = vk::PipelineStageFlags::TRANSFER;
    let writes =
        vk::AccessFlags::COLOR_ATTACHMENT_WRITE | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE;
    let reads =
        vk::AccessFlags::COLOR_ATTACHMENT_READ | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_READ;
    let dependencies = [
        // The picture waits for the copy of the previous picture, and for the writes of that picture.
        vk::SubpassDependency::default()
            .src_subpass(vk::SUBPASS_EXTERNAL)
            .src_stage_mask(transfer | colors | tests)
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE | writes)
            .dst_stage_mask(colors | tests)
            .dst_access_mask(writes | reads),
        // The copy waits for the picture.
        vk::SubpassDependency::default()
            .dst_subpass(vk::SUBPASS_EXTERNAL)
            .src_stage_mask(colors)
            .src_access_mask(vk::AccessFlags::COLOR_ATTACHMENT_WRITE)
            .dst_stage_mask(transfer)
            .dst_access_mask(vk::AccessFlags::TRANSFER_READ),
    ];
    let info = vk::RenderPassCreateInfo::default()
        .attachments(&attachments)
        .subpasses(&subpass)
        .dependencies(&dependencies);
    // SAFETY: everything that the info points to is alive.
    Ok(unsafe { gpu.device.create_render_pass(&info, None)? })
}
