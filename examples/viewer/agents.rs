//! Agents that walk over a surface to its source. geosweep finds the directions of their ways after the map,
//! and a compute pass moves them in the same frame. The program never reads them.

use geosweep::ash::vk;
use geosweep::gpu_allocator::MemoryLocation;
use geosweep::vulkan::embed::{
    Access, DirectionFrame, Directions, FrameSurface, Reader, Solver, SourceInput,
};

use crate::Result;
use crate::after_map::AfterMap;
use crate::gpu::Gpu;
use crate::memory::Buffer;
use crate::sets::Sets;
use crate::shaders::{self, Layout};
use crate::stage::barrier;

pub const COUNT: u32 = 10_000;
/// Speed of the agents, in spacings of lines a second.
pub const PACE: f32 = 4.0;
/// Size of the buffer of agents: four floats each, the last of which is not used.
const BYTES: u64 = 16 * COUNT as u64;

/// Rule by which agents choose their steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Steps {
    /// Steps along the image of directions.
    Directions,
    /// Steps to one of eight neighbours, as agents on grids usually do. This reads the image of distances only.
    Neighbours,
}

/// Compute passes that move agents.
pub struct WalkPasses {
    by_directions: vk::Pipeline,
    to_neighbours: vk::Pipeline,
}

/// Agents of a surface.
pub struct Agents {
    /// Steps; `None` while the agents are hidden and do not move.
    steps: Option<Steps>,
    places: Buffer,
    /// Whether no agent has started yet.
    fresh: bool,
    directions: Directions,
    /// Whether the map has changed since the directions were found.
    outdated: bool,
}

impl WalkPasses {
    pub fn new(gpu: &Gpu, layout: &Layout) -> Result<Self> {
        let walk = concat!(
            include_str!("shaders/point_at.wgsl"),
            include_str!("shaders/ways.wgsl"),
            include_str!("shaders/walk.wgsl")
        );
        Ok(Self {
            by_directions: layout.compute(gpu, walk, c"by_directions")?,
            to_neighbours: layout.compute(gpu, walk, c"to_neighbours")?,
        })
    }

    pub fn destroy(&self, gpu: &Gpu) {
        for pipeline in [self.by_directions, self.to_neighbours] {
            // SAFETY: nothing is in flight.
            unsafe { gpu.device.destroy_pipeline(pipeline, None) };
        }
    }
}

impl Agents {
    /// Creates agents and binds them. Waits for the device, since it may be using the sets.
    pub fn new(
        gpu: &mut Gpu,
        solver: &Solver,
        surface: &FrameSurface,
        sets: &Sets,
    ) -> Result<Self> {
        let device = gpu.device.clone();
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let places = Buffer::new(gpu, "agents", BYTES, usage, MemoryLocation::GpuOnly)?;
        let directions = solver.directions(&device, gpu.allocator(), surface)?;
        gpu.wait();
        sets.bind_buffer(gpu, shaders::AGENTS, places.handle);
        sets.bind_image(gpu, shaders::DIRECTIONS, directions.image(Reader::COMPUTE.layout));
        Ok(Self { steps: None, places, fresh: true, directions, outdated: true })
    }

    /// Shows agents that choose their steps by the given rule, or hides the agents.
    pub fn show(&mut self, steps: Option<Steps>) {
        self.steps = steps;
    }

    pub fn are_shown(&self) -> bool {
        self.steps.is_some()
    }

    /// Records the passes that find the directions, if the map has changed, and the pass that moves the
    /// agents.
    pub fn record(
        &mut self,
        map: &AfterMap,
        (passes, layout): (&WalkPasses, &Layout),
        set: vk::DescriptorSet,
    ) -> Result<()> {
        let AfterMap { gpu, commands, .. } = *map;
        self.outdated |= map.changed;
        let Some(steps) = self.steps else { return Ok(()) };
        if steps == Steps::Directions && std::mem::replace(&mut self.outdated, false) {
            let frame = DirectionFrame::new(SourceInput::Buffer(0), Reader::COMPUTE)
                .with_before(Access::TRANSFER_WRITE);
            map.recording().directions(&self.directions, &frame)?;
        }
        self.start(gpu, commands);
        let pipeline = match steps {
            Steps::Directions => passes.by_directions,
            Steps::Neighbours => passes.to_neighbours,
        };
        // The previous frame draws the agents from these places.
        let moves = Access::COMPUTE_READ.and(Access::COMPUTE_WRITE);
        barrier(gpu, commands, Access::VERTEX_READ.and(Access::COMPUTE_WRITE), moves);
        layout.dispatch(gpu, commands, (pipeline, set), COUNT);
        barrier(gpu, commands, Access::COMPUTE_WRITE, Access::VERTEX_READ);
        Ok(())
    }

    /// Records a fill of the buffer with zeros, before the first frame with agents. Zeros mark an agent as not started.
    fn start(&mut self, gpu: &Gpu, commands: vk::CommandBuffer) {
        if !std::mem::replace(&mut self.fresh, false) {
            return;
        }
        let moves = Access::COMPUTE_READ.and(Access::COMPUTE_WRITE);
        // SAFETY: the commands are being recorded, outside a render pass. Nothing in flight uses the buffer.
        unsafe { gpu.device.cmd_fill_buffer(commands, self.places.handle, 0, vk::WHOLE_SIZE, 0) };
        barrier(gpu, commands, Access::TRANSFER_WRITE, moves);
    }

    pub fn destroy(&mut self, gpu: &mut Gpu) {
        let device = gpu.device.clone();
        self.directions.destroy(&device, gpu.allocator());
        self.places.destroy(gpu);
    }
}
