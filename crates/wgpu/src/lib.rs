//! Geodesic distance maps on a device of wgpu. Maps are recorded into wgpu's command encoders, and wgpu's pipelines
//! sample their images without a copy. `docs/wgpu.md` in the repository has a whole host, and a plugin of Bevy.
//!
//! wgpu must drive the device by **Vulkan**: on Metal, DX12, OpenGL and WebGPU there are no maps. The first number of
//! this crate's version is that of wgpu.
//!
//! ```no_run
//! use geosweep_wgpu::{DistanceMap, MapDevice, MapFrame, MapInfo, geosweep::surface::Chart};
//! # fn host(device: &wgpu::Device, queue: &wgpu::Queue, vertices: &wgpu::Buffer)
//! #     -> Result<(), geosweep_wgpu::Error> {
//! // Once: positions 16 bytes apart in a buffer with usage STORAGE.
//! let info = MapInfo::new(vertices, 16, Chart { rows: 60, cols: 72 });
//! let map = DistanceMap::new(&MapDevice::new(device)?, queue, &info)?;
//! let view = map.texture().create_view(&Default::default());
//! // Every frame, in an encoder of its own:
//! let mut encoder = device.create_command_encoder(&Default::default());
//! map.record(&mut encoder, &MapFrame::new(&[geosweep_wgpu::PointSource::at(12.0, 20.5)]))?;
//! queue.submit([encoder.finish()]);
//! # Ok(()) }
//! ```

mod device;
mod hal;
mod info;
mod map;
mod outputs;

pub use geosweep;
pub use geosweep::vulkan::embed::{LevelInput, Outcome, PointSource};

pub use device::MapDevice;
pub use hal::unmet;
pub use info::{MapFrame, MapInfo};
pub use map::DistanceMap;

/// Error of a map on wgpu.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// wgpu drives the device by another interface than Vulkan.
    #[error("wgpu does not use Vulkan here, and maps need it: ask wgpu for Backends::VULKAN")]
    NotVulkan,
    /// A buffer was destroyed.
    #[error("the buffer of {0} is destroyed")]
    DestroyedBuffer(&'static str),
    /// Memory ran out.
    #[error(transparent)]
    Memory(#[from] geosweep::gpu_allocator::AllocationError),
    /// geosweep or Vulkan refuses the call.
    #[error(transparent)]
    Vulkan(#[from] geosweep::vulkan::VulkanError),
}
