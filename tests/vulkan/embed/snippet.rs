use geosweep::{Stop, Wavefront, ash::{self, vk}, surface::Chart};
use geosweep::vulkan::{Method, Schedule, VulkanError, embed::*};
pub fn host(instance: &ash::Instance, physical_device: vk::PhysicalDevice, device: &ash::Device,
    allocator: &mut geosweep::gpu_allocator::vulkan::Allocator, vertices: vk::Buffer, stop: Stop,
    load_commands: vk::CommandBuffer, commands: vk::CommandBuffer)
    -> Result<(Solver, Surface, ResultImage), VulkanError> {
let passes = [(Schedule::Raster, Wavefront::Curved)];
let solver = Solver::new(instance, physical_device, device, &passes)?;
let (chart, points) = (Chart { rows: 256, cols: 256 }, [Points::positions(vertices, 32)]);
let info = SurfaceInfo { points: &points, ..SurfaceInfo::new(chart) };
let surface = solver.surface(device, allocator, &info)?;
let method = Method { wavefront: Wavefront::Curved, schedule: None, stop };
let plan = solver.plan(chart, method, 8)?;
solver.record(device, load_commands, &surface).prepare();
let distances = solver.record(device, commands, &surface).frame(&Frame { // every frame
    before: Access::COMPUTE_WRITE, points: Some(0), plan: &plan, slot: 0, unreached: -1.0,
    sources: SourceInput::Inline(&[PointSource::at(120.5, 80.25)]), reader: Reader::FRAGMENT,
})?; // its view is for fragment shaders to sample
Ok((solver, surface, distances)) }
