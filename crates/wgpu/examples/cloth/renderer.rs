//! A renderer of wgpu with a cloth and its map, for the program beside this file and for tests.

use std::error::Error;

use geosweep_wgpu::{DistanceMap, MapDevice, MapFrame, MapInfo, PointSource, unmet};

use super::cloth::{self, Cloth, PICTURE, PICTURE_FORMAT};

/// Opens a Vulkan device whose name contains `name`, in upper or lower case, and on which maps run.
///
/// # Errors
/// If there is no such device.
pub fn open(
    flags: wgpu::InstanceFlags,
    name: &str,
) -> Result<(wgpu::Device, wgpu::Queue), Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::VULKAN,
        flags,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN));
    let wanted = |adapter: &wgpu::Adapter| {
        adapter.get_info().name.to_lowercase().contains(&name.to_lowercase())
            && unmet(adapter).is_empty()
    };
    let adapter = adapters.into_iter().find(wanted).ok_or("there is no such device")?;
    Ok(pollster::block_on(adapter.request_device(&Default::default()))?)
}

/// Returns the source of the front in a frame.
pub fn source(frame: u32) -> PointSource {
    PointSource::at(12.25 + 4.5 * frame as f32, 20.5 + 3.0 * frame as f32)
}

/// A renderer: a cloth, its map and a picture.
pub struct Renderer {
    /// Device of wgpu.
    pub device: wgpu::Device,
    /// Queue of wgpu.
    pub queue: wgpu::Queue,
    /// Cloth that is drawn.
    pub cloth: Cloth,
    /// Distances on the cloth.
    pub map: DistanceMap,
    /// Last frame.
    pub picture: wgpu::Texture,
    colours: wgpu::BindGroup,
}

impl Renderer {
    /// Creates everything.
    ///
    /// # Errors
    /// If the device does not meet the requirements.
    pub fn new(device: wgpu::Device, queue: wgpu::Queue) -> Result<Self, Box<dyn Error>> {
        let cloth = Cloth::new(&device);
        let info = MapInfo::new(&cloth.vertices, cloth::STRIDE, cloth::CHART);
        let map = DistanceMap::new(&MapDevice::new(&device)?, &queue, &info)?;
        let colours = cloth.colours(&device, map.texture());
        let picture = cloth::target(&device, PICTURE_FORMAT, PICTURE);
        Ok(Self { device, queue, cloth, map, picture, colours })
    }

    /// Records and submits a frame: moves the cloth, computes the map and draws. Does not wait for earlier
    /// frames.
    ///
    /// # Errors
    /// If the map cannot be recorded.
    pub fn frame(&self, number: u32) -> Result<(), Box<dyn Error>> {
        let sources = [source(number)];
        self.frame_with(number, |commands| {
            Ok(self.map.record(commands, &MapFrame::new(&sources))?)
        })
    }

    /// Records and submits a frame with a given recording of the map.
    ///
    /// # Errors
    /// If the map cannot be recorded.
    pub fn frame_with(
        &self,
        number: u32,
        record: impl FnOnce(&mut wgpu::CommandEncoder) -> Result<(), Box<dyn Error>>,
    ) -> Result<(), Box<dyn Error>> {
        let encoder = || self.device.create_command_encoder(&Default::default());
        let [mut moving, mut mapping, mut drawing] = [encoder(), encoder(), encoder()];
        self.cloth.move_to(&self.queue, &mut moving, 0.4 * number as f32);
        record(&mut mapping)?;
        let view = self.picture.create_view(&Default::default());
        self.cloth.draw(&mut drawing, &self.colours, &view);
        self.queue.submit([moving.finish(), mapping.finish(), drawing.finish()]);
        Ok(())
    }
}
