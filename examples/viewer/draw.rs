//! The pass that draws the background, the shadow, the walls, the surface in its colors, and lines and agents
//! on it.

use std::ffi::CStr;

use geosweep::ash::vk;
use geosweep::vulkan::embed::{CurveBuffer, CurveRecord};

use crate::Result;
use crate::agents::{self, Agents};
use crate::decal::Placement;
use crate::gpu::Gpu;
use crate::shaders::{Draw, Layout};
use crate::stage::Stage;
use crate::swapchain::Target;

/// Number of shades of the palette.
const SHADES: usize = 256;
/// Number of thin lines that make a thick one.
const AROUND: usize = 8;

pub struct Drawing {
    background: vk::Pipeline,
    shadow: vk::Pipeline,
    walls: vk::Pipeline,
    surface: vk::Pipeline,
    /// Surface with a decal, by its placement.
    log_map: vk::Pipeline,
    projected: vk::Pipeline,
    agents: vk::Pipeline,
    thin: vk::Pipeline,
    strong: vk::Pipeline,
    rim: vk::Pipeline,
    path: vk::Pipeline,
}

impl Drawing {
    pub fn new(gpu: &Gpu, layout: &Layout, target: &Target) -> Result<Self> {
        let ground = include_str!("shaders/ground.wgsl");
        let walls = include_str!("shaders/wall.wgsl");
        let surface = include_str!("shaders/surface.wgsl");
        let lines = include_str!("shaders/line.wgsl");
        let decal = concat!(
            include_str!("shaders/point_at.wgsl"),
            include_str!("shaders/surface.wgsl"),
            include_str!("shaders/decal.wgsl")
        );
        let agents =
            concat!(include_str!("shaders/point_at.wgsl"), include_str!("shaders/agent.wgsl"));
        let pipeline = |wgsl, vertex: &CStr, fragment: &CStr, topology, depth, blend| {
            let (samples, pass) = (target.samples, target.pass);
            // All other shaders generate their vertices, or read the points of the grid.
            let curves = wgsl == lines;
            layout.graphics(
                gpu,
                &Draw { wgsl, vertex, fragment, curves, topology, depth, blend, samples, pass },
            )
        };
        let (pieces, path) = (vk::PrimitiveTopology::LINE_LIST, vk::PrimitiveTopology::LINE_STRIP);
        let contour = c"contour_vertex";
        let (list, strip) =
            (vk::PrimitiveTopology::TRIANGLE_LIST, vk::PrimitiveTopology::TRIANGLE_STRIP);
        Ok(Self {
            background: pipeline(ground, c"back_vertex", c"back_fragment", list, false, false)?,
            shadow: pipeline(ground, c"shadow_vertex", c"shadow_fragment", strip, false, true)?,
            walls: pipeline(walls, c"vertex", c"fragment", list, true, false)?,
            surface: pipeline(surface, c"vertex", c"fragment", list, true, false)?,
            log_map: pipeline(decal, c"vertex", c"log_map_fragment", list, true, false)?,
            projected: pipeline(decal, c"vertex", c"projected_fragment", list, true, false)?,
            agents: pipeline(agents, c"vertex", c"fragment", strip, true, true)?,
            thin: pipeline(lines, contour, c"thin_fragment", pieces, true, true)?,
            strong: pipeline(lines, contour, c"strong_fragment", pieces, true, true)?,
            rim: pipeline(lines, c"rim_vertex", c"rim_fragment", path, true, false)?,
            path: pipeline(lines, c"path_vertex", c"path_fragment", path, true, false)?,
        })
    }

    /// Draws into the whole viewport.
    pub fn record(
        &self,
        gpu: &Gpu,
        layout: &Layout,
        stage: &Stage,
        (commands, frame): (vk::CommandBuffer, usize),
        viewport: vk::Viewport,
    ) {
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        let sets = [stage.set(frame)];
        let device = &gpu.device;
        let bind = |pipeline| unsafe { device.cmd_bind_pipeline(commands, graphics, pipeline) };
        // SAFETY: the commands are being recorded, in the render pass. All objects are alive.
        unsafe {
            device.cmd_set_viewport(commands, 0, &[viewport]);
            device.cmd_bind_descriptor_sets(commands, graphics, layout.pipeline, 0, &sets, &[]);
            bind(self.background);
            device.cmd_draw(commands, 3, 1, 0, 0);
            if stage.look.ground.is_some() {
                bind(self.shadow);
                device.cmd_draw(commands, 4, 1, 0, 0);
            }
            if stage.look.ground.is_some_and(|ground| ground.walls) {
                let chart = stage.look.chart;
                let border = 2 * (chart.rows + chart.cols - 2) as u32;
                bind(self.walls);
                device.cmd_draw(commands, 6 * border, 1, 0, 0);
            }
            bind(match stage.decal.look.placement {
                None => self.surface,
                Some(Placement::LogMap) => self.log_map,
                Some(Placement::Projected) => self.projected,
            });
            let indices = stage.indices.handle;
            device.cmd_bind_index_buffer(commands, indices, 0, vk::IndexType::UINT32);
            device.cmd_draw_indexed(commands, stage.index_count, 1, 0, 0, 0);
        }
        if let Some(contours) = stage.lines.contours() {
            bind(self.thin);
            draw_thick(gpu, commands, contours, viewport, 0.0);
            bind(self.strong);
            draw_thick(gpu, commands, contours, viewport, 1.9);
        }
        if let Some(path) = stage.lines.path() {
            bind(self.rim);
            draw_thick(gpu, commands, path, viewport, 5.5);
            bind(self.path);
            draw_thick(gpu, commands, path, viewport, 2.5);
        }
        if stage.agents.as_ref().is_some_and(Agents::are_shown) {
            bind(self.agents);
            // SAFETY: as above.
            unsafe {
                device.cmd_set_viewport(commands, 0, &[viewport]);
                device.cmd_draw(commands, 4, agents::COUNT, 0, 0);
            }
        }
    }

    pub fn destroy(&self, gpu: &Gpu) {
        let lines = [self.thin, self.strong, self.rim, self.path];
        let areas = [self.background, self.shadow, self.walls];
        let surfaces = [self.surface, self.log_map, self.projected, self.agents];
        for pipeline in areas.into_iter().chain(surfaces).chain(lines) {
            // SAFETY: nothing is in flight.
            unsafe { gpu.device.destroy_pipeline(pipeline, None) };
        }
    }
}

/// Draws curves with a width in pixels. Only lines of one pixel are available on every device, so a thick
/// line consists of several of these, each shifted a little.
fn draw_thick(
    gpu: &Gpu,
    commands: vk::CommandBuffer,
    curves: CurveBuffer,
    viewport: vk::Viewport,
    width: f32,
) {
    let radius = 0.5 * (width - 1.0).max(0.0);
    let times = if radius > 0.0 { AROUND } else { 1 };
    for step in 0..times {
        let turn = std::f32::consts::TAU * step as f32 / AROUND as f32;
        let (x, y) = (viewport.x + radius * turn.cos(), viewport.y + radius * turn.sin());
        let moved = [vk::Viewport { x, y, ..viewport }];
        // SAFETY: the commands are being recorded, in the render pass. The buffer is alive.
        unsafe {
            let (device, buffer, stride) = (&gpu.device, curves.buffer, CurveRecord::BYTES);
            device.cmd_set_viewport(commands, 0, &moved);
            device.cmd_bind_vertex_buffers(commands, 0, &[buffer], &[curves.vertices_offset]);
            device.cmd_draw_indirect(commands, buffer, 0, 1, stride);
        }
    }
}

/// Returns linear colors from bright at the source to dark far away. The darkest shades are left out, since dark lines
/// would be invisible on them.
pub fn palette() -> Vec<[f32; 4]> {
    let linear = |channel: u8| {
        let channel = f32::from(channel) / 255.0;
        if channel <= 0.04045 { channel / 12.92 } else { ((channel + 0.055) / 1.055).powf(2.4) }
    };
    (0..SHADES)
        .map(|index| {
            let place = 1.0 - 0.90 * index as f64 / (SHADES - 1) as f64;
            let color = colorous::VIRIDIS.eval_continuous(place);
            [linear(color.r), linear(color.g), linear(color.b), 1.0]
        })
        .collect()
}
