//! Records passes that use the map of a surface into the commands of a frame: lines, the decal, and ways.

use geosweep::ash::vk;
use geosweep::vulkan::embed::{Access, FrameSurface, Recording, Solver};

use crate::gpu::Gpu;

/// Objects with which passes that use the map of a surface are recorded.
#[derive(Clone, Copy)]
pub struct AfterMap<'a> {
    pub gpu: &'a Gpu,
    pub solver: &'a Solver,
    pub commands: vk::CommandBuffer,
    pub surface: &'a FrameSurface,
    /// Whether the map is new in this frame.
    pub changed: bool,
}

impl<'a> AfterMap<'a> {
    /// Begins the recording of passes that use the map. An earlier frame may have computed the map.
    pub fn recording(&self) -> Recording<'a> {
        let recording = self.solver.record(&self.gpu.device, self.commands, self.surface);
        if !self.changed {
            recording.begin(Access::NONE);
        }
        recording
    }
}
