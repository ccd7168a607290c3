use geosweep_wgpu::{DistanceMap, MapDevice, MapFrame, MapInfo, PointSource, geosweep::surface::Chart};

/// Once, for vertices 16 bytes apart in a buffer with usage STORAGE.
pub fn load(adapter: &wgpu::Adapter, device: &wgpu::Device, queue: &wgpu::Queue, vertices: &wgpu::Buffer)
    -> Result<(DistanceMap, wgpu::TextureView), Box<dyn std::error::Error>> {
    assert!(geosweep_wgpu::unmet(adapter).is_empty()); // when the adapter is chosen
    let chart = Chart { rows: 60, cols: 72 };
    let info = MapInfo::new(vertices, 16, chart);
    let map = DistanceMap::new(&MapDevice::new(device)?, queue, &info)?;
    let view = map.texture().create_view(&Default::default()); // for bind groups
    Ok((map, view))
}

/// Every frame, between the commands that move the vertices and those that draw.
pub fn frame(device: &wgpu::Device, queue: &wgpu::Queue, map: &DistanceMap,
    moving: wgpu::CommandEncoder, drawing: wgpu::CommandEncoder)
    -> Result<(), Box<dyn std::error::Error>> {
    let mut mapping = device.create_command_encoder(&Default::default());
    map.record(&mut mapping, &MapFrame::new(&[PointSource::at(12.25, 20.5)]))?;
    queue.submit([moving.finish(), mapping.finish(), drawing.finish()]);
    Ok(())
}
