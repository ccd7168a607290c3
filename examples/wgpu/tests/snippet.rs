use geosweep::{surface::Chart, vulkan::embed::PointSource};
use wgpu_example::distance_map::{DistanceMap, MapDevice, unmet};

/// Once, for vertices 16 bytes apart in a buffer with usage STORAGE.
pub fn load(adapter: &wgpu::Adapter, device: &wgpu::Device, queue: &wgpu::Queue, vertices: &wgpu::Buffer)
    -> Result<(DistanceMap, wgpu::TextureView), Box<dyn std::error::Error>> {
    assert!(unmet(adapter).is_empty()); // when the adapter is chosen
    let map_device = MapDevice::new(device)?;
    let chart = Chart { rows: 60, cols: 72 };
    let map = DistanceMap::new(&map_device, queue, vertices, 16, chart)?;
    let view = map.texture().create_view(&Default::default()); // for bind groups
    Ok((map, view))
}

/// Every frame, between the commands that move the vertices and those that draw.
pub fn frame(device: &wgpu::Device, queue: &wgpu::Queue, map: &DistanceMap,
    moving: wgpu::CommandEncoder, drawing: wgpu::CommandEncoder)
    -> Result<(), Box<dyn std::error::Error>> {
    let mut mapping = device.create_command_encoder(&Default::default());
    map.record(&mut mapping, &[PointSource::at(12.25, 20.5)])?;
    queue.submit([moving.finish(), mapping.finish(), drawing.finish()]);
    Ok(())
}
