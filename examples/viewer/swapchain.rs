//! The window's images, and the images of colors and depths that are drawn first. All follow the window's size.

use geosweep::ash::vk;

use crate::Result;
use crate::gpu::Gpu;
use crate::memory::{Image, ImageUse, whole};

const DEPTH: vk::Format = vk::Format::D32_SFLOAT;

/// Parts that do not depend on the window's size.
pub struct Target {
    pub format: vk::SurfaceFormatKHR,
    pub samples: vk::SampleCountFlags,
    pub pass: vk::RenderPass,
}

pub struct Swapchain {
    pub handle: vk::SwapchainKHR,
    pub size: vk::Extent2D,
    pub images: Vec<WindowImage>,
    /// Whether pictures can be taken.
    pub copies: bool,
    color: Image,
    depth: Image,
}

pub struct WindowImage {
    pub handle: vk::Image,
    view: vk::ImageView,
    pub framebuffer: vk::Framebuffer,
    /// Signalled when the image has been drawn. Each image has a semaphore of its own, since nothing else tells when
    /// presenting has finished with the semaphore.
    pub drawn: vk::Semaphore,
}

impl Target {
    pub fn new(gpu: &Gpu) -> Result<Self> {
        // SAFETY: device and surface are alive.
        let formats = unsafe {
            gpu.surfaces.get_physical_device_surface_formats(gpu.physical_device, gpu.surface)?
        };
        let srgb = [vk::Format::B8G8R8A8_SRGB, vk::Format::R8G8B8A8_SRGB];
        let format = formats
            .into_iter()
            .find(|format| srgb.contains(&format.format))
            .ok_or("the window offers no format of 8-bit sRGB")?;
        let limits = &gpu.properties.limits;
        let counts =
            limits.framebuffer_color_sample_counts & limits.framebuffer_depth_sample_counts;
        // Every device supports four samples.
        let samples = counts & vk::SampleCountFlags::TYPE_4;
        let pass = render_pass(gpu, format.format, samples)?;
        Ok(Self { format, samples, pass })
    }

    pub fn destroy(&self, gpu: &Gpu) {
        // SAFETY: nothing is in flight.
        unsafe { gpu.device.destroy_render_pass(self.pass, None) };
    }
}

/// Creates the render pass. It draws with several samples and resolves them into the window's image.
fn render_pass(
    gpu: &Gpu,
    format: vk::Format,
    samples: vk::SampleCountFlags,
) -> Result<vk::RenderPass> {
    let color_layout = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
    let depth_layout = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    let attachment = |format, samples, load, store, layout| {
        vk::AttachmentDescription::default()
            .format(format)
            .samples(samples)
            .load_op(load)
            .store_op(store)
            .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
            .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
            .final_layout(layout)
    };
    use vk::{AttachmentLoadOp as Load, AttachmentStoreOp as Store};
    let one = vk::SampleCountFlags::TYPE_1;
    let present = vk::ImageLayout::PRESENT_SRC_KHR;
    // The background covers the whole picture, so only depths need to be cleared.
    let attachments = [
        attachment(format, samples, Load::DONT_CARE, Store::DONT_CARE, color_layout),
        attachment(DEPTH, samples, Load::CLEAR, Store::DONT_CARE, depth_layout),
        attachment(format, one, Load::DONT_CARE, Store::STORE, present),
    ];
    let reference = |attachment, layout| {
        vk::AttachmentReference::default().attachment(attachment).layout(layout)
    };
    let (color, resolve) = ([reference(0, color_layout)], [reference(2, color_layout)]);
    let depth = reference(1, depth_layout);
    let subpass = [vk::SubpassDescription::default()
        .color_attachments(&color)
        .resolve_attachments(&resolve)
        .depth_stencil_attachment(&depth)];
    // Frames in flight share the images of colors and depths, so a frame waits for the previous one. The wait for
    // the window's image is in the stage of colors, too.
    let tests =
        vk::PipelineStageFlags::EARLY_FRAGMENT_TESTS | vk::PipelineStageFlags::LATE_FRAGMENT_TESTS;
    let colors = vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT;
    let writes =
        vk::AccessFlags::COLOR_ATTACHMENT_WRITE | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE;
    let reads =
        vk::AccessFlags::COLOR_ATTACHMENT_READ | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_READ;
    let dependencies = [vk::SubpassDependency::default()
        .src_subpass(vk::SUBPASS_EXTERNAL)
        .src_stage_mask(tests | colors)
        .src_access_mask(writes)
        .dst_stage_mask(tests | colors)
        .dst_access_mask(writes | reads)];
    let info = vk::RenderPassCreateInfo::default()
        .attachments(&attachments)
        .subpasses(&subpass)
        .dependencies(&dependencies);
    // SAFETY: everything that the info points to is alive.
    Ok(unsafe { gpu.device.create_render_pass(&info, None)? })
}

impl Swapchain {
    /// Creates a swapchain in place of an old one, which nothing in flight uses. Returns `None` while the
    /// window has no size.
    pub fn new(
        gpu: &mut Gpu,
        target: &Target,
        window: [u32; 2],
        old: Option<Self>,
    ) -> Result<Option<Self>> {
        // SAFETY: device and surface are alive.
        let capabilities = unsafe {
            gpu.surfaces
                .get_physical_device_surface_capabilities(gpu.physical_device, gpu.surface)?
        };
        let size = extent(&capabilities, window);
        if size.width == 0 || size.height == 0 {
            if let Some(mut old) = old {
                old.destroy(gpu);
            }
            return Ok(None);
        }
        let copies = capabilities.supported_usage_flags.contains(vk::ImageUsageFlags::TRANSFER_SRC);
        let mut usage = vk::ImageUsageFlags::COLOR_ATTACHMENT;
        if copies {
            usage |= vk::ImageUsageFlags::TRANSFER_SRC;
        }
        let most = if capabilities.max_image_count == 0 { 8 } else { capabilities.max_image_count };
        let opaque = vk::CompositeAlphaFlagsKHR::OPAQUE;
        let alpha = if capabilities.supported_composite_alpha.contains(opaque) {
            opaque
        } else {
            vk::CompositeAlphaFlagsKHR::INHERIT
        };
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(gpu.surface)
            .min_image_count((capabilities.min_image_count + 1).min(most))
            .image_format(target.format.format)
            .image_color_space(target.format.color_space)
            .image_extent(size)
            .image_array_layers(1)
            .image_usage(usage)
            .pre_transform(capabilities.current_transform)
            .composite_alpha(alpha)
            .present_mode(vk::PresentModeKHR::FIFO)
            .clipped(true)
            .old_swapchain(old.as_ref().map_or(vk::SwapchainKHR::null(), |old| old.handle));
        // SAFETY: the info is valid. The old swapchain is only retired by this.
        let handle = unsafe { gpu.swapchains.create_swapchain(&info, None)? };
        if let Some(mut old) = old {
            old.destroy(gpu);
        }
        let usage = vk::ImageUsageFlags::TRANSIENT_ATTACHMENT;
        let color = ImageUse {
            format: target.format.format,
            usage: usage | vk::ImageUsageFlags::COLOR_ATTACHMENT,
            aspect: vk::ImageAspectFlags::COLOR,
            samples: target.samples,
        };
        let color = Image::new(gpu, "colors", size, &color)?;
        let depth = ImageUse {
            format: DEPTH,
            usage: usage | vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
            aspect: vk::ImageAspectFlags::DEPTH,
            samples: target.samples,
        };
        let depth = Image::new(gpu, "depths", size, &depth)?;
        // SAFETY: the swapchain is alive.
        let images = unsafe { gpu.swapchains.get_swapchain_images(handle)? }
            .into_iter()
            .map(|image| WindowImage::new(gpu, target, image, [color.view, depth.view], size))
            .collect::<Result<_>>()?;
        Ok(Some(Self { handle, size, images, copies, color, depth }))
    }

    pub fn destroy(&mut self, gpu: &mut Gpu) {
        // SAFETY: nothing is in flight.
        unsafe {
            for image in self.images.drain(..) {
                gpu.device.destroy_semaphore(image.drawn, None);
                gpu.device.destroy_framebuffer(image.framebuffer, None);
                gpu.device.destroy_image_view(image.view, None);
            }
            gpu.swapchains.destroy_swapchain(self.handle, None);
        }
        self.color.destroy(gpu);
        self.depth.destroy(gpu);
    }
}

impl WindowImage {
    fn new(
        gpu: &Gpu,
        target: &Target,
        handle: vk::Image,
        [color, depth]: [vk::ImageView; 2],
        size: vk::Extent2D,
    ) -> Result<Self> {
        let info = vk::ImageViewCreateInfo::default()
            .image(handle)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(target.format.format)
            .subresource_range(whole(vk::ImageAspectFlags::COLOR));
        // SAFETY: everything that is pointed to is alive.
        unsafe {
            let view = gpu.device.create_image_view(&info, None)?;
            let attachments = [color, depth, view];
            let info = vk::FramebufferCreateInfo::default()
                .render_pass(target.pass)
                .attachments(&attachments)
                .width(size.width)
                .height(size.height)
                .layers(1);
            let framebuffer = gpu.device.create_framebuffer(&info, None)?;
            let drawn = gpu.device.create_semaphore(&Default::default(), None)?;
            Ok(Self { handle, view, framebuffer, drawn })
        }
    }
}

/// Returns the window's size. If the system leaves the size to the program, the requested one is taken, within the
/// limits.
fn extent(capabilities: &vk::SurfaceCapabilitiesKHR, [width, height]: [u32; 2]) -> vk::Extent2D {
    if capabilities.current_extent.width != u32::MAX {
        return capabilities.current_extent;
    }
    let (low, high) = (capabilities.min_image_extent, capabilities.max_image_extent);
    vk::Extent2D {
        width: width.clamp(low.width, high.width),
        height: height.clamp(low.height, high.height),
    }
}
