use geosweep::ash::{self, vk};
use geosweep::vulkan::embed::{Access, ResultImage};

/// Gives images of distances and buffers from a queue family to another: recorded last on the queue
/// that `gives`, with how they were written, and first on the other, with how they are read.
pub fn hand_over<const I: usize, const B: usize>(
    device: &ash::Device, commands: vk::CommandBuffer, gives: bool, access: Access,
    [from, to]: [u32; 2], images: [ResultImage; I], buffers: [vk::Buffer; B],
) {
    let (stages, none) = (access.stages, vk::AccessFlags::NONE);
    let (stages, [before, after]) = if gives {
        ([stages, vk::PipelineStageFlags::BOTTOM_OF_PIPE], [access.access, none])
    } else {
        ([stages, stages], [none, access.access]) // after the semaphore, which names these stages
    };
    let range = vk::ImageSubresourceRange::default()
        .aspect_mask(vk::ImageAspectFlags::COLOR).level_count(1).layer_count(1);
    let images = images.map(|image| vk::ImageMemoryBarrier::default()
        .image(image.image).subresource_range(range)
        .old_layout(image.layout).new_layout(image.layout)
        .src_queue_family_index(from).dst_queue_family_index(to)
        .src_access_mask(before).dst_access_mask(after));
    let buffers = buffers.map(|buffer| vk::BufferMemoryBarrier::default()
        .buffer(buffer).size(vk::WHOLE_SIZE)
        .src_queue_family_index(from).dst_queue_family_index(to)
        .src_access_mask(before).dst_access_mask(after));
    let flags = vk::DependencyFlags::empty();
    unsafe {
        device.cmd_pipeline_barrier(commands, stages[0], stages[1], flags, &[], &buffers, &images);
    }
}

/// A frame: the main queue moves the vertices, the other computes the map, and the main one draws it
/// in the stages `reads`.
pub fn submit(
    device: &ash::Device, [main, compute]: [vk::Queue; 2],
    [moving, mapping, drawing]: [vk::CommandBuffer; 3], [moved, mapped]: [vk::Semaphore; 2],
    reads: vk::PipelineStageFlags, fence: vk::Fence,
) -> Result<(), vk::Result> {
    let ours = [vk::PipelineStageFlags::COMPUTE_SHADER]; // in which we read the vertices
    let (moved, mapped, reads) = ([moved], [mapped], [reads]);
    let [moving, mapping, drawing] = [[moving], [mapping], [drawing]];
    let info = vk::SubmitInfo::default();
    let moving = info.command_buffers(&moving).signal_semaphores(&moved);
    let mapping = info.command_buffers(&mapping).signal_semaphores(&mapped)
        .wait_semaphores(&moved).wait_dst_stage_mask(&ours);
    let drawing = info.command_buffers(&drawing)
        .wait_semaphores(&mapped).wait_dst_stage_mask(&reads);
    unsafe {
        device.queue_submit(main, &[moving], vk::Fence::null())?;
        device.queue_submit(compute, &[mapping], vk::Fence::null())?;
        device.queue_submit(main, &[drawing], fence)
    }
}
