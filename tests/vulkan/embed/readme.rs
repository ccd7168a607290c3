//! Code in the README for renderers.

use geosweep::ash::vk;
use geosweep::vulkan::embed::Access;

use crate::embed::stage::STOP;
use crate::host::Host;

#[expect(clippy::too_many_arguments, reason = "what a host has, in lines that README hides")]
mod snippet {
    // Code that README shows, with its hidden lines.
    include!("snippet.rs");
}

const SIDE: usize = 256;

#[test]
fn the_snippet_of_readme_is_the_one_that_runs() {
    let readme = include_str!("../../../README.md");
    let shown = |block: &&str| block.starts_with("rust\n") && block.contains("embed::*");
    let block = readme.split("```").find(shown).expect("README has lines for renderers");
    let lines = block.lines().skip(1).map(|line| line.strip_prefix("# ").unwrap_or(line));
    let copy = include_str!("snippet.rs").lines();
    assert!(lines.eq(copy), "copy the lines of README into tests/vulkan/embed/snippet.rs");
}

/// The surface is a tilted plane with known distances. Curved fronts are exact there, up to rounding.
#[test]
fn the_snippet_of_readme_runs() {
    let mut host = Host::new();
    let position = |index: usize| {
        let (row, col) = ((index / SIDE) as f32, (index % SIDE) as f32);
        [col, row, 0.5 * col]
    };
    let vertex = |index| {
        let [x, y, z] = position(index);
        [x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0]
    };
    let vertices: Vec<f32> = (0..SIDE * SIDE).flat_map(vertex).collect();
    let vertices = host.buffer_of(&vertices);
    let download = host.buffer(4 * (SIDE * SIDE) as u64, true);

    let (device, instance) = (host.device.clone(), host.instance.clone());
    let (load_commands, commands) = (host.commands(), host.commands());
    let (physical_device, buffer) = (host.physical_device, vertices.handle);
    host.begin(load_commands);
    host.begin(commands);
    let (mut solver, mut surface, distances) = snippet::host(
        &instance,
        physical_device,
        &device,
        host.allocator(),
        buffer,
        STOP,
        load_commands,
        commands,
    )
    .unwrap();
    copy_after_fragments(&host, commands, &distances, download.handle);
    for commands in [load_commands, commands] {
        host.end(commands);
        host.submit(commands, vk::Fence::null());
    }
    unsafe { device.queue_wait_idle(host.queue) }.unwrap();

    let source = [80.25, 120.5, 0.5 * 80.25];
    let error = |(index, distance): (usize, &f32)| {
        let square = |(a, b): (f32, f32)| (a - b) * (a - b);
        let exact = position(index).into_iter().zip(source).map(square).sum::<f32>().sqrt();
        (distance - exact).abs()
    };
    let map = &download.floats()[..SIDE * SIDE];
    let largest = map.iter().enumerate().map(error).fold(0.0, f32::max);
    assert!(largest < 1e-3, "{largest}");

    surface.destroy(&device, host.allocator());
    solver.destroy(&device);
    host.free(vertices);
    host.free(download);
    assert_eq!((host.messages(), host.allocations()), (Vec::new(), 0));
}

/// Copies an image that fragment shaders could sample now.
fn copy_after_fragments(
    host: &Host,
    commands: vk::CommandBuffer,
    distances: &geosweep::vulkan::embed::ResultImage,
    to: vk::Buffer,
) {
    let color = vk::ImageAspectFlags::COLOR;
    let range =
        vk::ImageSubresourceRange::default().aspect_mask(color).level_count(1).layer_count(1);
    let barrier = vk::ImageMemoryBarrier::default()
        .image(distances.image)
        .subresource_range(range)
        .src_access_mask(vk::AccessFlags::SHADER_READ)
        .dst_access_mask(vk::AccessFlags::TRANSFER_READ)
        .old_layout(distances.layout)
        .new_layout(vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
    let layers = vk::ImageSubresourceLayers::default().aspect_mask(color).layer_count(1);
    let copy = vk::BufferImageCopy::default()
        .image_subresource(layers)
        .image_extent(distances.extent.into());
    let (from, transfer) =
        (vk::PipelineStageFlags::FRAGMENT_SHADER, vk::PipelineStageFlags::TRANSFER);
    let (none, layout) = (vk::DependencyFlags::empty(), vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
    unsafe {
        let device = &host.device;
        device.cmd_pipeline_barrier(commands, from, transfer, none, &[], &[], &[barrier]);
        device.cmd_copy_image_to_buffer(commands, distances.image, layout, to, &[copy]);
    }
    host.barrier(commands, Access::TRANSFER_WRITE, Access::HOST_READ);
}
