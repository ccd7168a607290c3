//! Writes the last frame to a file.

use geosweep::ash::vk;
use geosweep::gpu_allocator::MemoryLocation;
use geosweep::io::OutputFile;

use crate::Result;
use crate::gpu::Gpu;
use crate::memory::{Buffer, whole, whole_copy};
use crate::swapchain::Swapchain;

pub struct Picture {
    pixels: Buffer,
    size: vk::Extent2D,
    /// Whether blue is the first channel.
    blue_first: bool,
}

impl Picture {
    /// Records a copy of an image of the window that has been drawn and not yet presented.
    pub fn record(
        gpu: &mut Gpu,
        commands: vk::CommandBuffer,
        swapchain: &Swapchain,
        image: vk::Image,
        format: vk::Format,
    ) -> Result<Self> {
        if !swapchain.copies {
            return Err("the window's images cannot be copied; leave --picture out".into());
        }
        let size = swapchain.size;
        let bytes = 4 * u64::from(size.width) * u64::from(size.height);
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let pixels = Buffer::new(gpu, "picture", bytes, usage, MemoryLocation::GpuToCpu)?;
        let shown = vk::ImageLayout::PRESENT_SRC_KHR;
        let copied = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        let (colors, transfer, host) = (
            (
                vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT,
                vk::AccessFlags::COLOR_ATTACHMENT_WRITE,
            ),
            (vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_READ),
            (vk::PipelineStageFlags::HOST, vk::AccessFlags::HOST_READ),
        );
        type Side = (vk::PipelineStageFlags, vk::AccessFlags);
        let turn = |from, to, before: Side, after: Side| {
            let barrier = vk::ImageMemoryBarrier::default()
                .image(image)
                .subresource_range(whole(vk::ImageAspectFlags::COLOR))
                .old_layout(from)
                .new_layout(to)
                .src_access_mask(before.1)
                .dst_access_mask(after.1);
            let none = vk::DependencyFlags::empty();
            // SAFETY: the commands are being recorded, outside a render pass.
            unsafe {
                gpu.device.cmd_pipeline_barrier(
                    commands,
                    before.0,
                    after.0,
                    none,
                    &[],
                    &[],
                    &[barrier],
                );
            }
        };
        turn(shown, copied, colors, transfer);
        let copy = whole_copy(size);
        // SAFETY: as above.
        unsafe {
            gpu.device.cmd_copy_image_to_buffer(commands, image, copied, pixels.handle, &[copy]);
        }
        turn(
            copied,
            shown,
            transfer,
            (vk::PipelineStageFlags::BOTTOM_OF_PIPE, vk::AccessFlags::NONE),
        );
        let written = vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(host.1);
        let none = vk::DependencyFlags::empty();
        // SAFETY: as above.
        unsafe {
            let (from, to) = (transfer.0, host.0);
            gpu.device.cmd_pipeline_barrier(commands, from, to, none, &[written], &[], &[]);
        }
        Ok(Self { pixels, size, blue_first: format == vk::Format::B8G8R8A8_SRGB })
    }

    /// Writes the file, after the device has finished the frame.
    pub fn write(&self, file: &OutputFile) -> Result<()> {
        let vk::Extent2D { width, height } = self.size;
        let pixels = &self.pixels.bytes()[..4 * width as usize * height as usize];
        let rgb = |pixel: &[u8]| match self.blue_first {
            true => [pixel[2], pixel[1], pixel[0]],
            false => [pixel[0], pixel[1], pixel[2]],
        };
        let colors: Vec<_> = pixels.chunks_exact(4).flat_map(rgb).collect();
        let staged = file.clone().stage(|writer| {
            let mut encoder = png::Encoder::new(writer, width, height);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
            encoder.set_compression(png::Compression::High);
            let mut writer = encoder.write_header()?;
            writer.write_image_data(&colors)?;
            Ok(writer.finish()?)
        })?;
        Ok(staged.commit()?)
    }

    pub fn destroy(&mut self, gpu: &mut Gpu) {
        self.pixels.destroy(gpu);
    }
}
