//! A surface on the device: its points and normals, its map with the lines on it, and the place of its
//! source.

use geosweep::ash::vk;
use geosweep::gpu_allocator::MemoryLocation;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{Access, Solver};

use crate::Result;
use crate::camera::Camera;
use crate::frames::IN_FLIGHT;
use crate::gpu::Gpu;
use crate::lines::Lines;
use crate::map::{self, Map};
use crate::memory::Buffer;
use crate::pick::{Pick, PickPass};
use crate::shaders::{BINDINGS, Layout};
use crate::surfaces::{Look, Name};

pub struct Stage {
    pub look: Look,
    pub camera: Camera,
    pub map: Map,
    pub pick: Pick,
    pub lines: Lines,
    pub indices: Buffer,
    pub index_count: u32,
    /// Whether normals must be computed.
    unshaded: bool,
    positions: Buffer,
    normals: Buffer,
    corners: Buffer,
    distances: Buffer,
    descriptors: vk::DescriptorPool,
    /// Descriptor sets by frame in flight, and by slot of the map.
    sets: Vec<[vk::DescriptorSet; IN_FLIGHT]>,
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
    pub fn new(gpu: &mut Gpu, name: Name, shared: &Shared) -> Result<Self> {
        let (points, look) = name.load()?;
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let bytes = 16 * look.chart.points() as u64;
        let on_device = MemoryLocation::GpuOnly;
        let positions = if look.deforms {
            Buffer::new(gpu, "positions", bytes, storage, on_device)?
        } else {
            Buffer::filled(gpu, "positions", bytemuck::cast_slice(&points), storage)?
        };
        let normals = Buffer::new(gpu, "normals", bytes, storage, on_device)?;
        let indices = indices(look.chart);
        let index_count = indices.len() as u32;
        let usage = vk::BufferUsageFlags::INDEX_BUFFER;
        let indices = Buffer::filled(gpu, "indices", bytemuck::cast_slice(&indices), usage)?;
        let corners = map::corners(look.chart);
        let corners = Buffer::filled(gpu, "corners", bytemuck::cast_slice(&corners), storage)?;
        let distances = Buffer::new(gpu, "corner distances", 16, storage, on_device)?;
        let pick = Pick::new(gpu, shared.picking)?;
        let lines = Lines::new(gpu, shared.picking)?;
        let memory = map::Memory {
            positions: positions.handle,
            source: pick.source.handle,
            corners: corners.handle,
            distances: distances.handle,
        };
        let map = Map::new(gpu, shared.solver, look.chart, &memory)?;
        let buffers = [positions.handle, normals.handle, shared.palette, distances.handle];
        let (descriptors, sets) = descriptor_sets(gpu, shared, &map, buffers)?;
        let camera = look.camera;
        Ok(Self {
            look,
            camera,
            map,
            pick,
            lines,
            indices,
            index_count,
            unshaded: true,
            positions,
            normals,
            corners,
            distances,
            descriptors,
            sets,
        })
    }

    /// Returns the descriptors for a frame in flight, with the image of distances that is drawn.
    pub fn set(&self, frame: usize) -> vk::DescriptorSet {
        self.sets[frame][self.map.slot()]
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
        let sets = [self.set(frame)];
        let groups = self.look.chart.points().div_ceil(64) as u32;
        let dispatch = |pipeline| {
            let compute = vk::PipelineBindPoint::COMPUTE;
            // SAFETY: the commands are being recorded. All objects are alive.
            unsafe {
                gpu.device.cmd_bind_pipeline(commands, compute, pipeline);
                gpu.device.cmd_bind_descriptor_sets(
                    commands,
                    compute,
                    layout.pipeline,
                    0,
                    &sets,
                    &[],
                );
                gpu.device.cmd_dispatch(commands, groups, 1, 1);
            }
        };
        // The previous frame draws these points, and geosweep no longer uses them.
        barrier(gpu, commands, Access::VERTEX_READ, Access::COMPUTE_WRITE);
        if self.look.deforms {
            dispatch(passes.deform);
            barrier(gpu, commands, Access::COMPUTE_WRITE, Access::COMPUTE_READ);
            self.map.moved_points();
        }
        dispatch(passes.shade);
        barrier(gpu, commands, Access::COMPUTE_WRITE, Access::VERTEX_READ);
    }

    pub fn destroy(&mut self, gpu: &mut Gpu) {
        self.lines.destroy(gpu);
        self.map.destroy(gpu);
        self.pick.destroy(gpu);
        // SAFETY: nothing is in flight.
        unsafe { gpu.device.destroy_descriptor_pool(self.descriptors, None) };
        for buffer in [
            &mut self.positions,
            &mut self.normals,
            &mut self.indices,
            &mut self.corners,
            &mut self.distances,
        ] {
            buffer.destroy(gpu);
        }
    }
}

impl PointPasses {
    pub fn new(gpu: &Gpu, layout: &Layout) -> Result<Self> {
        Ok(Self {
            deform: layout.compute(gpu, include_str!("shaders/deform.wgsl"))?,
            shade: layout.compute(gpu, include_str!("shaders/shade.wgsl"))?,
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

/// Returns the indices of two triangles for each cell of the grid.
fn indices(chart: Chart) -> Vec<u32> {
    let cols = chart.cols as u32;
    let cells = (1..chart.rows as u32).flat_map(|row| (1..cols).map(move |col| [row, col]));
    cells
        .flat_map(|[row, col]| {
            let last = row * cols + col;
            let (left, above) = (last - 1, last - cols);
            [above - 1, left, above, above, left, last]
        })
        .collect()
}

type Sets = (vk::DescriptorPool, Vec<[vk::DescriptorSet; IN_FLIGHT]>);

fn descriptor_sets(
    gpu: &Gpu,
    shared: &Shared,
    map: &Map,
    buffers: [vk::Buffer; 4],
) -> Result<Sets> {
    let count = (IN_FLIGHT * shared.views.len()) as u32;
    let sizes =
        BINDINGS.map(|kind| vk::DescriptorPoolSize::default().ty(kind).descriptor_count(count));
    let info = vk::DescriptorPoolCreateInfo::default().max_sets(count).pool_sizes(&sizes);
    let device = &gpu.device;
    // SAFETY: everything that the infos point to is alive, and no set is in use.
    unsafe {
        let pool = device.create_descriptor_pool(&info, None)?;
        let mut sets = Vec::new();
        for view in shared.views {
            let layouts = [shared.layout.set; IN_FLIGHT];
            let info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(pool)
                .set_layouts(&layouts);
            let by_slot: [_; IN_FLIGHT] = device
                .allocate_descriptor_sets(&info)?
                .try_into()
                .map_err(|_| "Vulkan gave another number of descriptor sets")?;
            for (slot, &set) in by_slot.iter().enumerate() {
                for (binding, &buffer) in (0..).zip([view.handle].iter().chain(&buffers)) {
                    let info =
                        [vk::DescriptorBufferInfo::default().buffer(buffer).range(vk::WHOLE_SIZE)];
                    let write = vk::WriteDescriptorSet::default()
                        .dst_set(set)
                        .dst_binding(binding)
                        .descriptor_type(BINDINGS[binding as usize])
                        .buffer_info(&info);
                    device.update_descriptor_sets(&[write], &[]);
                }
                let image = map.image(slot)?;
                let info = [vk::DescriptorImageInfo::default()
                    .image_view(image.view)
                    .image_layout(image.layout)];
                let write = vk::WriteDescriptorSet::default()
                    .dst_set(set)
                    .dst_binding(5)
                    .descriptor_type(BINDINGS[5])
                    .image_info(&info);
                device.update_descriptor_sets(&[write], &[]);
            }
            sets.push(by_slot);
        }
        Ok((pool, sets))
    }
}
