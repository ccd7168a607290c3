use geosweep::{Stop, Wavefront, ash::{self, vk}, surface::Chart};
use geosweep::vulkan::{Method, Schedule, VulkanError, embed::*};
pub fn host(instance: &ash::Instance, physical_device: vk::PhysicalDevice, device: &ash::Device,
    allocator: &mut geosweep::gpu_allocator::vulkan::Allocator, vertices: vk::Buffer, stop: Stop,
    load_commands: vk::CommandBuffer, commands: vk::CommandBuffer)
    -> Result<(Solver, FrameSurface, ResultImage), VulkanError> {
let passes = [(Schedule::Raster, Wavefront::Curved)];
let solver = Solver::new(instance, physical_device, device, &passes)?;
let (chart, points) = (Chart { rows: 256, cols: 256 }, [Points::positions(vertices, 32)]);
let info = SurfaceInfo::new(chart).with_points(&points);
let surface = solver.surface(device, allocator, &info)?;
let method = Method::new(Wavefront::Curved, stop);
let plan = solver.plan(chart, method, 8)?;
solver.record(device, load_commands, &surface).prepare();
let sources = [PointSource::at(120.5, 80.25)]; // every frame
let frame = Frame::new(&plan, SourceInput::Inline(&sources), Reader::FRAGMENT)
    .with_before(Access::COMPUTE_WRITE).with_points(0).with_unreached(-1.0);
let distances = solver.record(device, commands, &surface).frame(&frame)?; // fragment shaders sample its view
Ok((solver, surface, distances)) }
