//! geosweep in a program that has a Vulkan device already: distances on a surface that moves every frame,
//! recorded into the program's own command buffer.
//!
//! `cargo run --release --example embed`

use std::error::Error;

use geosweep::Stop;
use geosweep::Wavefront;
use geosweep::ash::{self, vk};
use geosweep::gpu_allocator::{MemoryLocation, vulkan::*};
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{self, Frame, PointSource, Points, Reader, SourceInput};
use geosweep::vulkan::{Method, Schedule, requirements};

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    // ---- A renderer has these: an instance, a device, a queue, an allocator, command buffers ----
    let entry = unsafe { ash::Entry::load()? };
    let application = vk::ApplicationInfo::default().api_version(requirements::API_VERSION);
    let info = vk::InstanceCreateInfo::default().application_info(&application);
    let instance = unsafe { entry.create_instance(&info, None)? };
    let physical_device = unsafe { instance.enumerate_physical_devices()? }
        .into_iter()
        .find(|&device| requirements::unmet(&instance, device).is_empty())
        .ok_or("no Vulkan device meets the requirements")?;
    let family =
        requirements::compute_queue_family(&instance, physical_device).ok_or("no queue")?;
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
    let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
    let device = unsafe { instance.create_device(physical_device, &info, None)? };
    let queue = unsafe { device.get_device_queue(family, 0) };
    let mut allocator = Allocator::new(&AllocatorCreateDesc {
        instance: instance.clone(),
        device: device.clone(),
        physical_device,
        debug_settings: Default::default(),
        buffer_device_address: false,
        allocation_sizes: Default::default(),
    })?;
    let info = vk::CommandPoolCreateInfo::default()
        .queue_family_index(family)
        .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
    let pool = unsafe { device.create_command_pool(&info, None)? };
    let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
    let commands = unsafe { device.allocate_command_buffers(&info)?[0] };
    let submit = |record: &mut dyn FnMut() -> Result<(), Box<dyn Error>>| unsafe {
        device.begin_command_buffer(commands, &vk::CommandBufferBeginInfo::default())?;
        record()?;
        device.end_command_buffer(commands)?;
        let buffers = [commands];
        let info = vk::SubmitInfo::default().command_buffers(&buffers);
        device.queue_submit(queue, &[info], vk::Fence::null())?;
        Ok::<(), Box<dyn Error>>(device.queue_wait_idle(queue)?)
    };

    // ---- and vertices, three floats each here, in a buffer with usage STORAGE_BUFFER ----
    let chart = Chart { rows: 120, cols: 160 };
    let bytes = 12 * chart.points() as u64;
    let (vertices, mut vertex_memory) = buffer(&device, &mut allocator, bytes)?;
    let (picture, picture_memory) = buffer(&device, &mut allocator, 4 * chart.points() as u64)?;

    // ==== Once: pipelines, a surface, a plan of at most six iterations a frame ====
    let passes = [(Schedule::Raster, Wavefront::Curved)];
    let mut solver = embed::Solver::new(&instance, physical_device, &device, &passes)?;
    let points = [Points::positions(vertices, 12)];
    let info = embed::SurfaceInfo::new(chart).with_points(&points);
    println!("the surface will take {} KiB", solver.bytes_for(&device, &info)? / 1024);
    let mut surface = solver.surface(&device, &mut allocator, &info)?;
    let stop = Stop::within(1e-5).or_after(100);
    let method = Method::new(Wavefront::Curved, stop);
    let plan = solver.plan(chart, method, 6)?;
    submit(&mut || {
        solver.record(&device, commands, &surface).prepare();
        Ok(())
    })?;

    for frame in 0..30 {
        // ---- The renderer moves its vertices; in a compute shader, say ----
        let to = vertex_memory.mapped_slice_mut().ok_or("not mapped")?;
        for (index, vertex) in to.chunks_exact_mut(12).take(chart.points()).enumerate() {
            let (x, y) = ((index % chart.cols) as f32, (index / chart.cols) as f32);
            let z = 6.0 * (0.06 * x + 0.2 * frame as f32).sin() * (0.05 * y).cos();
            vertex.copy_from_slice(bytemuck::cast_slice(&[x, y, z]));
        }
        submit(&mut || {
            // ==== Every frame: what to wait for, where the fronts start, who reads the result ====
            // Writes of the program before a submission are visible to the device, so `before` stays at NONE.
            // With several frames in flight, `with_slot` says which of them this is.
            let sources = [PointSource::at(60.0, 80.0 + frame as f32)];
            let map = Frame::new(&plan, SourceInput::Inline(&sources), Reader::COPY).with_points(0);
            let distances = solver.record(&device, commands, &surface).frame(&map)?;
            // ---- The renderer reads `distances.view`, or as here copies `distances.image` ----
            let layers = vk::ImageSubresourceLayers::default()
                .aspect_mask(vk::ImageAspectFlags::COLOR)
                .layer_count(1);
            let copy = vk::BufferImageCopy::default()
                .image_subresource(layers)
                .image_extent(distances.extent.into());
            let (image, layout) = (distances.image, distances.layout);
            unsafe { device.cmd_copy_image_to_buffer(commands, image, layout, picture, &[copy]) };
            Ok(())
        })?;
        let outcome = surface.outcome(0)?;
        let read = picture_memory.mapped_slice().ok_or("not mapped")?;
        let read: &[f32] = bytemuck::cast_slice(&read[..4 * chart.points()]);
        let farthest = read.iter().copied().fold(0.0, f32::max);
        println!("frame {frame}: up to {farthest:.3}, {} iterations", outcome.iterations);
        assert!(outcome.converged && farthest.is_finite());
    }

    // ==== At the end, once no frame is in flight ====
    surface.destroy(&device, &mut allocator);
    solver.destroy(&device);

    unsafe {
        for (buffer, memory) in [(vertices, vertex_memory), (picture, picture_memory)] {
            device.destroy_buffer(buffer, None);
            allocator.free(memory)?;
        }
        device.destroy_command_pool(pool, None);
        drop(allocator);
        device.destroy_device(None);
        instance.destroy_instance(None);
    }
    Ok(())
}

fn buffer(
    device: &ash::Device,
    allocator: &mut Allocator,
    size: u64,
) -> Result<(vk::Buffer, Allocation), Box<dyn Error>> {
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
    let info = vk::BufferCreateInfo::default().size(size).usage(usage);
    let buffer = unsafe { device.create_buffer(&info, None)? };
    let allocation = allocator.allocate(&AllocationCreateDesc {
        name: "the renderer's",
        requirements: unsafe { device.get_buffer_memory_requirements(buffer) },
        location: MemoryLocation::GpuToCpu,
        linear: true,
        allocation_scheme: AllocationScheme::GpuAllocatorManaged,
    })?;
    unsafe { device.bind_buffer_memory(buffer, allocation.memory(), allocation.offset())? };
    Ok((buffer, allocation))
}
