//! The map of a surface with vertices in a buffer of wgpu.

use std::sync::Arc;

use geosweep::ash::vk;
use geosweep::vulkan::embed::{
    CurveVertex, Frame, FrameSurface, Outcome, Plan, Points, Reader, SourceInput, SurfaceInfo,
};
use geosweep::vulkan::{Method, VulkanError};
use wgpu::TextureFormat;

use crate::hal::{raw_buffer, texture, with_commands};
use crate::outputs::{Outputs, READER, bring_into_layout};
use crate::{Error, MapDevice, MapFrame, MapInfo};

/// The map of a surface, with its distances and other outputs as textures and buffers of wgpu. A point at row r and
/// column c is the texel x = c, y = r.
pub struct DistanceMap {
    texture: wgpu::Texture,
    directions: Option<wgpu::Texture>,
    log_map: Option<wgpu::Texture>,
    plan: Plan,
    memory: Arc<Memory>,
}

/// Resources that are freed when neither the map nor wgpu, which may draw a last frame, uses them any more.
struct Memory {
    surface: FrameSurface,
    outputs: Outputs,
    on: Arc<MapDevice>,
    /// Vertices that geosweep's passes read, of which wgpu knows nothing.
    _vertices: wgpu::Buffer,
}

impl Drop for Memory {
    fn drop(&mut self) {
        self.outputs.destroy(&self.on);
        self.surface.destroy(&self.on.raw, &mut *self.on.allocator());
    }
}

impl DistanceMap {
    /// Layout of the vertices of contours: position (location 0), distance (1), row and column (2).
    pub const CONTOUR_LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
        array_stride: CurveVertex::BYTES as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Float32x2],
    };

    /// Creates a map. Submits its preparation to the queue.
    ///
    /// # Errors
    /// If the vertices are too few or the device's limits too low for the grid, or memory runs out.
    pub fn new(
        on: &Arc<MapDevice>,
        queue: &wgpu::Queue,
        info: &MapInfo<'_>,
    ) -> Result<Self, Error> {
        let MapDevice { solver, raw, device, .. } = &**on;
        let chart = info.chart;
        let plan = solver.plan(chart, Method::new(info.wavefront, info.stop), info.iterations)?;
        let plan = if info.gluing.is_some() { plan.over_seams() } else { plan };
        let points = [Points::positions(raw_buffer(info.vertices, "vertices")?, info.stride)];
        // wgpu submits to one queue, on which frames wait for one another, so that one image is enough.
        let surface_info = SurfaceInfo::new(chart).with_points(&points).with_gluing(info.gluing);
        let surface = solver.surface(raw, &mut *on.allocator(), &surface_info)?;
        let (outputs, vertices) = (Outputs::default(), info.vertices.clone());
        let mut memory = Memory { surface, outputs, on: Arc::clone(on), _vertices: vertices };
        memory.outputs.create(on, &memory.surface, info)?;

        let memory = Arc::new(memory);
        let Memory { surface, outputs, .. } = &*memory;
        let distances = surface.result(0, READER.layout)?.image;
        let directions = outputs.directions.as_ref().map(|it| it.image(READER.layout).image);
        let log_map = outputs.log_map.as_ref().map(|it| it.image(READER.layout).image);
        let mut encoder = device.create_command_encoder(&Default::default());
        with_commands(&mut encoder, |commands| {
            solver.record(raw, commands, surface).prepare();
            let images: Vec<_> =
                [Some(distances), directions, log_map].into_iter().flatten().collect();
            bring_into_layout(raw, commands, &images);
        })?;
        let mut clearing = device.create_command_encoder(&Default::default());
        outputs.buffers().for_each(|buffer| clearing.clear_buffer(buffer, 0, None));
        queue.submit([encoder.finish(), clearing.finish()]);

        let size = [chart.cols as u32, chart.rows as u32];
        let wrap = |image: vk::Image, label, format| {
            // SAFETY: `memory` keeps the image, which recordings leave in the layout of `READER`.
            unsafe { texture(device, (image, label), size, format, Arc::clone(&memory)) }
        };
        let optional = |image: Option<vk::Image>, label, format| {
            image.map(|image| wrap(image, label, format)).transpose()
        };
        Ok(Self {
            texture: wrap(distances, "distances", TextureFormat::R32Float)?,
            directions: optional(directions, "directions", TextureFormat::Rg16Float)?,
            log_map: optional(log_map, "log map", TextureFormat::Rg32Float)?,
            plan,
            memory,
        })
    }

    /// Records a new map, and all its outputs, from the vertices as they are when the commands run. The encoder is for
    /// maps alone: an encoder records either wgpu's own commands or those of others. Submit its commands after the
    /// commands that write the vertices, and before those that read the outputs.
    ///
    /// # Errors
    /// If a source is off the grid, the limit or a level is no number, or levels do not ascend. If only levels are
    /// refused, the map itself has been recorded.
    ///
    /// # Panics
    /// If the encoder has recorded commands of wgpu.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &MapFrame<'_>,
    ) -> Result<(), Error> {
        self.record_for(READER, encoder, frame)
    }

    /// Records a new map as [`DistanceMap::record`] does, for another reader of the distances.
    ///
    /// # Errors
    /// As for [`DistanceMap::record`].
    ///
    /// # Panics
    /// As for [`DistanceMap::record`].
    #[doc(hidden)]
    pub fn record_for(
        &self,
        reader: Reader,
        encoder: &mut wgpu::CommandEncoder,
        frame: &MapFrame<'_>,
    ) -> Result<(), Error> {
        let Memory { surface, on, .. } = &*self.memory;
        with_commands(encoder, |commands| -> Result<(), VulkanError> {
            let of_map = self.frame(frame).with_reader(reader);
            on.solver.record(&on.raw, commands, surface).frame(&of_map)?;
            self.record_outputs(commands, frame)
        })??;
        Ok(())
    }

    /// Returns the texture of distances, `R32Float`: one texel for each vertex, x is the column and y the row. Devices
    /// need not filter this format.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }

    /// Returns the texture of the directions of ways back, `Rg16Float`, if the map has it: unit vectors of columns and
    /// rows, 0 at sources and where no source reaches.
    pub fn directions(&self) -> Option<&wgpu::Texture> {
        self.directions.as_ref()
    }

    /// Returns the texture of the log map, `Rg32Float`, if the map has it: the direction in which a point's shortest
    /// path leaves its source, times the distance.
    pub fn log_map(&self) -> Option<&wgpu::Texture> {
        self.log_map.as_ref()
    }

    /// Returns the buffer of labels, if the map has it: a `u32` for each vertex, the index of its nearest source, or
    /// [`geosweep::geometry::NO_REGION`]. The buffer is longer than the labels. Its usages are `STORAGE`, `VERTEX` and
    /// `COPY_SRC`.
    pub fn regions(&self) -> Option<&wgpu::Buffer> {
        self.memory.outputs.regions.as_ref().map(|(_, buffer)| buffer)
    }

    /// Returns the buffer of contours, if the map has it, and the offset of its first vertex in bytes. Its usages are
    /// `VERTEX`, `INDIRECT`, `STORAGE` and `COPY_SRC`. Draw a list of lines:
    ///
    /// ```no_run
    /// # fn draw(map: &geosweep_wgpu::DistanceMap, pass: &mut wgpu::RenderPass<'_>) {
    /// let (contours, vertices) = map.contours().unwrap();
    /// pass.set_vertex_buffer(0, contours.slice(vertices..)); // DistanceMap::CONTOUR_LAYOUT
    /// pass.draw_indirect(contours, 0);
    /// # }
    /// ```
    pub fn contours(&self) -> Option<(&wgpu::Buffer, u64)> {
        let (contours, buffer) = self.memory.outputs.contours.as_ref()?;
        Some((buffer, contours.curves().vertices_offset))
    }

    /// Returns the outcome of the last map, once it has run.
    ///
    /// # Errors
    /// If no map has run.
    pub fn outcome(&self) -> Result<Outcome, Error> {
        Ok(self.memory.surface.outcome(0)?)
    }

    pub(crate) fn surface(&self) -> &FrameSurface {
        &self.memory.surface
    }

    /// Returns the parameters of a frame for the library.
    pub(crate) fn frame<'a>(&'a self, frame: &MapFrame<'a>) -> Frame<'a> {
        // The map waits for writes of wgpu's compute passes and copies in any case, so `before` stays at NONE.
        Frame::new(&self.plan, SourceInput::Inline(frame.sources), READER)
            .with_points(0)
            .with_limit(frame.limit)
            .with_unreached(frame.unreached)
    }

    /// Records the outputs of the map that was recorded before.
    pub(crate) fn record_outputs(
        &self,
        commands: vk::CommandBuffer,
        frame: &MapFrame<'_>,
    ) -> Result<(), VulkanError> {
        let Memory { surface, outputs, on, .. } = &*self.memory;
        outputs.record(&on.solver.record(&on.raw, commands, surface), frame)
    }
}

impl Drop for DistanceMap {
    /// Waits for submitted work, since wgpu does not know which images geosweep's passes use. A lost device
    /// runs nothing any more.
    fn drop(&mut self) {
        let _ = self.memory.on.device.poll(wgpu::PollType::wait_indefinitely());
    }
}
