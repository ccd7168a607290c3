//! The pass that draws: background, shadow, walls and the surface in its colors.

use std::ffi::CStr;

use geosweep::ash::vk;

use crate::Result;
use crate::gpu::Gpu;
use crate::shaders::{Draw, Layout};
use crate::stage::Stage;
use crate::swapchain::Target;

/// Shades of the palette.
const SHADES: usize = 256;

pub struct Drawing {
    background: vk::Pipeline,
    shadow: vk::Pipeline,
    walls: vk::Pipeline,
    surface: vk::Pipeline,
}

impl Drawing {
    pub fn new(gpu: &Gpu, layout: &Layout, target: &Target) -> Result<Self> {
        let ground = include_str!("shaders/ground.wgsl");
        let walls = include_str!("shaders/wall.wgsl");
        let surface = include_str!("shaders/surface.wgsl");
        let pipeline = |wgsl, vertex: &CStr, fragment: &CStr, topology, depth, blend| {
            let (samples, pass) = (target.samples, target.pass);
            layout.graphics(
                gpu,
                &Draw { wgsl, vertex, fragment, topology, depth, blend, samples, pass },
            )
        };
        let (list, strip) =
            (vk::PrimitiveTopology::TRIANGLE_LIST, vk::PrimitiveTopology::TRIANGLE_STRIP);
        Ok(Self {
            background: pipeline(ground, c"back_vertex", c"back_fragment", list, false, false)?,
            shadow: pipeline(ground, c"shadow_vertex", c"shadow_fragment", strip, false, true)?,
            walls: pipeline(walls, c"vertex", c"fragment", list, true, false)?,
            surface: pipeline(surface, c"vertex", c"fragment", list, true, false)?,
        })
    }

    pub fn record(
        &self,
        gpu: &Gpu,
        layout: &Layout,
        stage: &Stage,
        commands: vk::CommandBuffer,
        frame: usize,
    ) {
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        let sets = [stage.set(frame)];
        let device = &gpu.device;
        let bind = |pipeline| unsafe { device.cmd_bind_pipeline(commands, graphics, pipeline) };
        // SAFETY: the commands are being recorded, in the render pass; all objects are alive.
        unsafe {
            device.cmd_bind_descriptor_sets(commands, graphics, layout.pipeline, 0, &sets, &[]);
            bind(self.background);
            device.cmd_draw(commands, 3, 1, 0, 0);
            bind(self.shadow);
            device.cmd_draw(commands, 4, 1, 0, 0);
            if stage.look.walls {
                let chart = stage.look.chart;
                let border = 2 * (chart.rows + chart.cols - 2) as u32;
                bind(self.walls);
                device.cmd_draw(commands, 6 * border, 1, 0, 0);
            }
            bind(self.surface);
            let indices = stage.indices.handle;
            device.cmd_bind_index_buffer(commands, indices, 0, vk::IndexType::UINT32);
            device.cmd_draw_indexed(commands, stage.index_count, 1, 0, 0, 0);
        }
    }

    pub fn destroy(&self, gpu: &Gpu) {
        for pipeline in [self.background, self.shadow, self.walls, self.surface] {
            // SAFETY: nothing is in flight.
            unsafe { gpu.device.destroy_pipeline(pipeline, None) };
        }
    }
}

/// From bright at the source to dark far away, without the darkest shades, on which dark lines
/// would be lost. Linear.
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
