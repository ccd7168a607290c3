//! Compiles WGSL to pipelines. All of them share one layout of descriptors.

use std::ffi::CStr;

use geosweep::ash::vk;
use geosweep::vulkan::embed::{CurveVertex, PointSource};
use naga::back::spv;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::Result;
use crate::gpu::Gpu;

/// Layout of the descriptors that all shaders share. The files in shaders/ declare the same bindings.
pub struct Layout {
    pub set: vk::DescriptorSetLayout,
    pub pipeline: vk::PipelineLayout,
}

/// Size of the workgroups of all compute shaders.
const GROUP: u32 = 64;

/// Bindings of these descriptors.
pub const VIEW: u32 = 0;
pub const POSITIONS: u32 = 1;
pub const NORMALS: u32 = 2;
pub const PALETTE: u32 = 3;
pub const SOME_DISTANCES: u32 = 4;
pub const DISTANCES: u32 = 5;
pub const SOURCE: u32 = 6;
pub const AGENTS: u32 = 7;
pub const DIRECTIONS: u32 = 8;
pub const LOG_MAP: u32 = 9;

/// Type of each binding, and the stages that use it. No stage uses more than four storage buffers, the number that
/// every device supports.
pub const BINDINGS: [(vk::DescriptorType, vk::ShaderStageFlags); 10] = {
    const BUFFER: vk::DescriptorType = vk::DescriptorType::STORAGE_BUFFER;
    const IMAGE: vk::DescriptorType = vk::DescriptorType::SAMPLED_IMAGE;
    const COMPUTE: vk::ShaderStageFlags = vk::ShaderStageFlags::COMPUTE;
    const FRAGMENT: vk::ShaderStageFlags = vk::ShaderStageFlags::FRAGMENT;
    const ALL: vk::ShaderStageFlags = vk::ShaderStageFlags::from_raw(
        vk::ShaderStageFlags::VERTEX.as_raw() | COMPUTE.as_raw() | FRAGMENT.as_raw(),
    );
    const POINTS: vk::ShaderStageFlags =
        vk::ShaderStageFlags::from_raw(vk::ShaderStageFlags::VERTEX.as_raw() | COMPUTE.as_raw());
    const MAPS: vk::ShaderStageFlags =
        vk::ShaderStageFlags::from_raw(COMPUTE.as_raw() | FRAGMENT.as_raw());
    [
        (vk::DescriptorType::UNIFORM_BUFFER, ALL),
        (BUFFER, ALL),
        (BUFFER, POINTS),
        (BUFFER, FRAGMENT),
        (BUFFER, FRAGMENT),
        (IMAGE, MAPS),
        (BUFFER, MAPS),
        (BUFFER, POINTS),
        (IMAGE, COMPUTE),
        (IMAGE, FRAGMENT),
    ]
};

impl Layout {
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let bindings: Vec<_> = (0..)
            .zip(BINDINGS)
            .map(|(binding, (kind, stages))| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(binding)
                    .descriptor_type(kind)
                    .descriptor_count(1)
                    .stage_flags(stages)
            })
            .collect();
        // SAFETY: everything that the infos point to is alive.
        unsafe {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            let set = gpu.device.create_descriptor_set_layout(&info, None)?;
            let sets = [set];
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
            let pipeline = gpu.device.create_pipeline_layout(&info, None)?;
            Ok(Self { set, pipeline })
        }
    }

    /// Creates a compute pipeline with an entry point.
    pub fn compute(&self, gpu: &Gpu, wgsl: &str, entry: &CStr) -> Result<vk::Pipeline> {
        let module = module(gpu, wgsl)?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(entry);
        let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(self.pipeline);
        // SAFETY: module and layout are alive.
        unsafe {
            let made = gpu.device.create_compute_pipelines(Default::default(), &[info], None);
            gpu.device.destroy_shader_module(module, None);
            Ok(made.map_err(|(_, error)| error)?[0])
        }
    }

    /// Records a compute pass with one thread for each of `items` items.
    pub fn dispatch(
        &self,
        gpu: &Gpu,
        commands: vk::CommandBuffer,
        (pipeline, set): (vk::Pipeline, vk::DescriptorSet),
        items: u32,
    ) {
        let (compute, sets) = (vk::PipelineBindPoint::COMPUTE, [set]);
        let device = &gpu.device;
        // SAFETY: the commands are being recorded, outside a render pass. All objects are alive.
        unsafe {
            device.cmd_bind_pipeline(commands, compute, pipeline);
            device.cmd_bind_descriptor_sets(commands, compute, self.pipeline, 0, &sets, &[]);
            device.cmd_dispatch(commands, items.div_ceil(GROUP), 1, 1);
        }
    }

    /// Creates a pipeline that draws into a render pass with colors and optionally depths.
    pub fn graphics(&self, gpu: &Gpu, draw: &Draw) -> Result<vk::Pipeline> {
        let module = module(gpu, draw.wgsl)?;
        let stage = |stage, name| {
            vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module).name(name)
        };
        let stages = [
            stage(vk::ShaderStageFlags::VERTEX, draw.vertex),
            stage(vk::ShaderStageFlags::FRAGMENT, draw.fragment),
        ];
        let bindings = [vk::VertexInputBindingDescription::default().stride(CurveVertex::BYTES)];
        // The row and the column are not used.
        let [position, time, _] = CurveVertex::attributes(0, 0);
        let attributes = [position, time];
        let mut vertices = vk::PipelineVertexInputStateCreateInfo::default();
        if draw.curves {
            vertices = vertices
                .vertex_binding_descriptions(&bindings)
                .vertex_attribute_descriptions(&attributes);
        }
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(draw.topology);
        let viewport =
            vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&states);
        // Triangles are counter-clockwise in the world. Pictures have y downwards.
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
            .line_width(1.0);
        let samples =
            vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(draw.samples);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(draw.depth)
            .depth_write_enable(draw.depth)
            .depth_compare_op(vk::CompareOp::LESS);
        let blend = [vk::PipelineColorBlendAttachmentState::default()
            .blend_enable(draw.blend)
            .src_color_blend_factor(vk::BlendFactor::SRC_ALPHA)
            .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .src_alpha_blend_factor(vk::BlendFactor::ZERO)
            .dst_alpha_blend_factor(vk::BlendFactor::ONE)
            .color_write_mask(vk::ColorComponentFlags::RGBA)];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blend);
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&vertices)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .dynamic_state(&dynamic)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .layout(self.pipeline)
            .render_pass(draw.pass);
        // SAFETY: module, layout and render pass are alive.
        unsafe {
            let made = gpu.device.create_graphics_pipelines(Default::default(), &[info], None);
            gpu.device.destroy_shader_module(module, None);
            Ok(made.map_err(|(_, error)| error)?[0])
        }
    }

    pub fn destroy(&self, gpu: &Gpu) {
        // SAFETY: nothing is in flight.
        unsafe {
            gpu.device.destroy_pipeline_layout(self.pipeline, None);
            gpu.device.destroy_descriptor_set_layout(self.set, None);
        }
    }
}

/// Parameters of a pipeline that draws.
pub struct Draw<'a> {
    pub wgsl: &'a str,
    pub vertex: &'a CStr,
    pub fragment: &'a CStr,
    /// Whether the vertices are those of contours or paths.
    pub curves: bool,
    pub topology: vk::PrimitiveTopology,
    pub depth: bool,
    pub blend: bool,
    pub samples: vk::SampleCountFlags,
    pub pass: vk::RenderPass,
}

fn module(gpu: &Gpu, wgsl: &str) -> Result<vk::ShaderModule> {
    let code = spirv(wgsl)?;
    let info = vk::ShaderModuleCreateInfo::default().code(&code);
    // SAFETY: the code is valid SPIR-V.
    Ok(unsafe { gpu.device.create_shader_module(&info, None)? })
}

fn spirv(wgsl: &str) -> Result<Vec<u32>> {
    // geosweep defines the curvature of a front at a source.
    let at_source = PointSource::at(0.0, 0.0).curvature;
    let view = include_str!("shaders/view.wgsl");
    let bilinear = include_str!("shaders/bilinear.wgsl");
    let wgsl = format!("{view}\nconst AT_SOURCE = f32({at_source:?});\n{bilinear}\n{wgsl}");
    let module = naga::front::wgsl::parse_str(&wgsl).map_err(|e| e.emit_to_string(&wgsl))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|error| error.emit_to_string(&wgsl))?;
    Ok(spv::write_vec(&module, &info, &spv::Options::default(), None)?)
}
