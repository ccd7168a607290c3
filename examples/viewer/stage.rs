//! A surface on the device: its points and normals, its map with the lines on it, and the place of its
//! source.

use geosweep::ash::vk;
use geosweep::gpu_allocator::MemoryLocation;
use geosweep::vulkan::embed::{Access, Solver};

use crate::Result;
use crate::after_map::AfterMap;
use crate::agents::{Agents, WalkPasses};
use crate::camera::Camera;
use crate::decal::Decal;
use crate::frames::Frame;
use crate::gpu::Gpu;
use crate::lines::Lines;
use crate::map::{self, Map};
use crate::memory::Buffer;
use crate::pick::{Pick, PickPass};
use crate::sets::Sets;
use crate::shaders::{self, Layout};
use crate::shown::Shown;
use crate::surfaces::{Look, Model};

pub struct Stage {
    pub look: Look,
    pub camera: Camera,
    pub map: Map,
    pub pick: Pick,
    pub lines: Lines,
    pub decal: Decal,
    /// Agents, created when they are first shown.
    pub agents: Option<Agents>,
    pub indices: Buffer,
    pub index_count: u32,
    /// Whether normals must be computed.
    unshaded: bool,
    positions: Buffer,
    normals: Buffer,
    places: Buffer,
    distances: Buffer,
    sets: Sets,
}

/// Compute passes that write points and normals.
pub struct PointPasses {
    deform: vk::Pipeline,
    shade: vk::Pipeline,
}

/// Resources that all stages share.
pub struct Shared<'a> {
    pub layout: &'a Layout,
    pub solver: &'a Solver,
    pub picking: &'a PickPass,
    pub palette: vk::Buffer,
    /// Views by frame in flight.
    pub views: &'a [Buffer],
}

impl Stage {
    pub fn new(gpu: &mut Gpu, model: &Model, shared: &Shared) -> Result<Self> {
        let look = model.look;
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let bytes = 16 * look.chart.points() as u64;
        let on_device = MemoryLocation::GpuOnly;
        let positions = if look.deforms {
            Buffer::new(gpu, "positions", bytes, storage, on_device)?
        } else {
            Buffer::filled(gpu, "positions", bytemuck::cast_slice(&model.positions), storage)?
        };
        let unshaded = model.normals.is_empty();
        let normals = if unshaded {
            Buffer::new(gpu, "normals", bytes, storage, on_device)?
        } else {
            Buffer::filled(gpu, "normals", bytemuck::cast_slice(&model.normals), storage)?
        };
        let usage = vk::BufferUsageFlags::INDEX_BUFFER;
        let indices =
            Buffer::filled(gpu, "indices", bytemuck::cast_slice(&model.triangles), usage)?;
        let index_count = model.triangles.len() as u32;
        let places = map::places(look.chart);
        let bytes = size_of_val(&places[..]) as u64 / 2;
        let places = Buffer::filled(gpu, "places", bytemuck::cast_slice(&places), storage)?;
        let distances = Buffer::new(gpu, "distances at places", bytes, storage, on_device)?;
        let pick = Pick::new(gpu, shared.picking)?;
        let lines = Lines::new(gpu, shared.picking)?;
        let memory = map::Memory {
            positions: positions.handle,
            source: pick.source.handle,
            places: places.handle,
            distances: distances.handle,
        };
        let map = Map::new(gpu, shared.solver, (look.chart, model.gluing.as_ref()), &memory)?;
        let sets = Sets::new(gpu, shared.layout, shared.views, &map)?;
        for (binding, buffer) in [
            (shaders::POSITIONS, positions.handle),
            (shaders::NORMALS, normals.handle),
            (shaders::PALETTE, shared.palette),
            (shaders::SOME_DISTANCES, distances.handle),
            (shaders::SOURCE, pick.source.handle),
        ] {
            sets.bind_buffer(gpu, binding, buffer);
        }
        let camera = look.camera;
        Ok(Self {
            look,
            camera,
            map,
            pick,
            lines,
            decal: Decal::new(),
            agents: None,
            indices,
            index_count,
            unshaded,
            positions,
            normals,
            places,
            distances,
            sets,
        })
    }

    /// Returns the descriptors for a frame in flight, with the image of distances that is drawn.
    pub fn set(&self, frame: usize) -> vk::DescriptorSet {
        self.sets.get(frame, self.map.slot())
    }

    /// Returns whether sides of the surface's grid are glued.
    pub fn is_closed(&self) -> bool {
        self.map.surface().is_glued()
    }

    /// Records what is needed once: the passes that prepare the map, and the first source.
    pub fn prepare(&self, gpu: &Gpu, solver: &Solver, commands: vk::CommandBuffer) {
        self.map.prepare(gpu, solver, commands);
        self.pick.set(gpu, commands, map::source(self.look.source));
        self.lines.start.set(gpu, commands, [f32::NAN; 4]);
    }

    /// Changes what is shown from the next frame on.
    pub fn show(&mut self, gpu: &mut Gpu, solver: &Solver, shown: &Shown) -> Result<()> {
        let shown = shown.on(self.is_closed());
        let surface = self.map.surface();
        self.lines.show_contours(gpu, solver, surface, shown.contours)?;
        self.decal.show(gpu, solver, (surface, &self.sets), shown.decal)?;
        let steps = shown.steps();
        if steps.is_some() && self.agents.is_none() {
            self.agents = Some(Agents::new(gpu, solver, surface, &self.sets)?);
        }
        if let Some(agents) = &mut self.agents {
            agents.show(steps);
        }
        Ok(())
    }

    /// Records the passes that move the points, if they move, and compute normals.
    pub fn record_points(
        &mut self,
        gpu: &Gpu,
        passes: &PointPasses,
        layout: &Layout,
        commands: vk::CommandBuffer,
        frame: usize,
    ) {
        if !self.look.deforms && !self.unshaded {
            return;
        }
        self.unshaded = false;
        let (set, points) = (self.set(frame), self.look.chart.points() as u32);
        let dispatch = |pipeline| layout.dispatch(gpu, commands, (pipeline, set), points);
        // The previous frame draws these points, and geosweep no longer uses them.
        let drawing = Access::VERTEX_READ.and(Access::FRAGMENT_READ);
        barrier(gpu, commands, drawing, Access::COMPUTE_WRITE);
        if self.look.deforms {
            dispatch(passes.deform);
            barrier(gpu, commands, Access::COMPUTE_WRITE, Access::COMPUTE_READ);
            self.map.moved_points();
        }
        dispatch(passes.shade);
        barrier(gpu, commands, Access::COMPUTE_WRITE, drawing);
    }

    /// Records the passes that find lines and the log map. `changed` tells whether the map is new.
    pub fn record_outputs(
        &mut self,
        gpu: &Gpu,
        solver: &Solver,
        commands: vk::CommandBuffer,
        changed: bool,
    ) -> Result<()> {
        let surface = self.map.surface();
        let map = AfterMap { gpu, solver, commands, surface, changed };
        self.lines.record(&map, self.look.spacing)?;
        self.decal.record(&map, self.look.spacing)
    }

    /// Records the passes that find the agents' ways and move them.
    pub fn record_agents(
        &mut self,
        gpu: &Gpu,
        solver: &Solver,
        passes: (&WalkPasses, &Layout),
        frame: Frame,
        changed: bool,
    ) -> Result<()> {
        let set = self.set(frame.index);
        let Some(agents) = &mut self.agents else { return Ok(()) };
        let (commands, surface) = (frame.commands, self.map.surface());
        agents.record(&AfterMap { gpu, solver, commands, surface, changed }, passes, set)
    }

    pub fn destroy(&mut self, gpu: &mut Gpu) {
        self.lines.destroy(gpu);
        self.map.destroy(gpu);
        self.pick.destroy(gpu);
        self.decal.destroy(gpu);
        if let Some(agents) = &mut self.agents {
            agents.destroy(gpu);
        }
        self.sets.destroy(gpu);
        for buffer in [
            &mut self.positions,
            &mut self.normals,
            &mut self.indices,
            &mut self.places,
            &mut self.distances,
        ] {
            buffer.destroy(gpu);
        }
    }
}

impl PointPasses {
    pub fn new(gpu: &Gpu, layout: &Layout) -> Result<Self> {
        Ok(Self {
            deform: layout.compute(gpu, include_str!("shaders/deform.wgsl"), c"main")?,
            shade: layout.compute(gpu, include_str!("shaders/shade.wgsl"), c"main")?,
        })
    }

    pub fn destroy(&self, gpu: &Gpu) {
        // SAFETY: nothing is in flight.
        unsafe {
            gpu.device.destroy_pipeline(self.deform, None);
            gpu.device.destroy_pipeline(self.shade, None);
        }
    }
}

/// Records a barrier for all memory.
pub fn barrier(gpu: &Gpu, commands: vk::CommandBuffer, before: Access, after: Access) {
    let barrier =
        vk::MemoryBarrier::default().src_access_mask(before.access).dst_access_mask(after.access);
    let (from, to, none) = (before.stages, after.stages, vk::DependencyFlags::empty());
    // SAFETY: the commands are being recorded, outside a render pass.
    unsafe { gpu.device.cmd_pipeline_barrier(commands, from, to, none, &[barrier], &[], &[]) };
}
