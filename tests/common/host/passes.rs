//! Passes of the renderer: compute passes in WGSL, and render passes.

use super::*;

impl Host {
    /// Returns an image as the target of a render pass that leaves it in the layout `GENERAL`.
    pub fn target(&self, image: &HostImage, width: u32, height: u32) -> Target {
        let attachment = [vk::AttachmentDescription::default()
            .format(vk::Format::R32_SFLOAT)
            .samples(vk::SampleCountFlags::TYPE_1)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE)
            .final_layout(vk::ImageLayout::GENERAL)];
        let reference = [vk::AttachmentReference::default().layout(vk::ImageLayout::GENERAL)];
        let subpass = [vk::SubpassDescription::default().color_attachments(&reference)];
        let info = vk::RenderPassCreateInfo::default().attachments(&attachment).subpasses(&subpass);
        let pass = unsafe { self.device.create_render_pass(&info, None) }.unwrap();
        let extent = vk::Extent2D { width, height };
        Target { pass, framebuffer: self.framebuffer(pass, &[image.view], extent), extent }
    }

    fn framebuffer(
        &self,
        pass: vk::RenderPass,
        views: &[vk::ImageView],
        extent: vk::Extent2D,
    ) -> vk::Framebuffer {
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(pass)
            .attachments(views)
            .width(extent.width)
            .height(extent.height)
            .layers(1);
        unsafe { self.device.create_framebuffer(&info, None) }.unwrap()
    }

    /// Records a render pass that only clears the target.
    pub fn clear(&self, commands: vk::CommandBuffer, target: &Target, value: f32) {
        self.in_pass(commands, target, value, || ());
    }

    /// Runs `record` inside a render pass that has cleared the target.
    pub fn in_pass<T>(
        &self,
        commands: vk::CommandBuffer,
        target: &Target,
        value: f32,
        inside: impl FnOnce() -> T,
    ) -> T {
        let clear = [vk::ClearValue { color: vk::ClearColorValue { float32: [value; 4] } }];
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(target.pass)
            .framebuffer(target.framebuffer)
            .render_area(target.extent.into())
            .clear_values(&clear);
        unsafe {
            self.device.cmd_begin_render_pass(commands, &info, vk::SubpassContents::INLINE);
        }
        let result = inside();
        unsafe { self.device.cmd_end_render_pass(commands) };
        result
    }

    pub fn free_target(&self, target: Target) {
        unsafe {
            self.device.destroy_framebuffer(target.framebuffer, None);
            self.device.destroy_render_pass(target.pass, None);
        }
    }

    /// Creates a compute pass from WGSL, with storage buffers at the first bindings and optionally a texture
    /// and a linear sampler after them.
    pub fn pass(
        &self,
        wgsl: &str,
        buffers: &[vk::Buffer],
        texture: Option<vk::ImageView>,
    ) -> HostPass {
        let mut pass = self.without_pipeline(vk::ShaderStageFlags::COMPUTE, buffers, texture);
        let device = &self.device;
        let module = self.module(wgsl, naga::ShaderStage::Compute, "main");
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(c"main");
        let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(pass.layout);
        let cache = vk::PipelineCache::null();
        unsafe {
            pass.pipeline = device.create_compute_pipelines(cache, &[info], None).unwrap()[0];
            device.destroy_shader_module(module, None);
        }
        pass
    }

    /// Creates a pass that draws triangles, from WGSL with the entry points `vertex` and `fragment`.
    pub fn draw_pass(
        &self,
        wgsl: &str,
        buffers: &[vk::Buffer],
        texture: vk::ImageView,
        canvas: &Canvas,
    ) -> HostPass {
        let vertices = vk::PipelineVertexInputStateCreateInfo::default();
        let topology = vk::PrimitiveTopology::TRIANGLE_LIST;
        self.graphics_pass(wgsl, buffers, Some(texture), canvas, (vertices, topology))
    }

    /// Creates a pass that draws this library's curves, from WGSL with the entry points `vertex` and
    /// `fragment`.
    pub fn curve_pass(
        &self,
        wgsl: &str,
        buffers: &[vk::Buffer],
        canvas: &Canvas,
        topology: vk::PrimitiveTopology,
    ) -> HostPass {
        use geosweep::vulkan::embed::CurveVertex;
        let bindings = [vk::VertexInputBindingDescription::default().stride(CurveVertex::BYTES)];
        let attributes = CurveVertex::attributes(0, 0);
        let vertices = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(&bindings)
            .vertex_attribute_descriptions(&attributes);
        self.graphics_pass(wgsl, buffers, None, canvas, (vertices, topology))
    }

    fn graphics_pass(
        &self,
        wgsl: &str,
        buffers: &[vk::Buffer],
        texture: Option<vk::ImageView>,
        canvas: &Canvas,
        (vertices, topology): (vk::PipelineVertexInputStateCreateInfo, vk::PrimitiveTopology),
    ) -> HostPass {
        use vk::ShaderStageFlags as Stage;
        let mut pass = self.without_pipeline(Stage::VERTEX | Stage::FRAGMENT, buffers, texture);
        let modules = [
            self.module(wgsl, naga::ShaderStage::Vertex, "vertex"),
            self.module(wgsl, naga::ShaderStage::Fragment, "fragment"),
        ];
        let stage = |module, stage, name| {
            vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module).name(name)
        };
        let stages = [
            stage(modules[0], Stage::VERTEX, c"vertex"),
            stage(modules[1], Stage::FRAGMENT, c"fragment"),
        ];
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(topology);
        let scissors = [vk::Rect2D::from(canvas.target.extent)];
        let viewports = [vk::Viewport {
            width: canvas.target.extent.width as f32,
            height: canvas.target.extent.height as f32,
            max_depth: 1.0,
            ..Default::default()
        }];
        let viewport = vk::PipelineViewportStateCreateInfo::default()
            .viewports(&viewports)
            .scissors(&scissors);
        let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
        let samples = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(true)
            .depth_write_enable(true)
            .depth_compare_op(vk::CompareOp::LESS);
        let all = [vk::PipelineColorBlendAttachmentState::default()
            .color_write_mask(vk::ColorComponentFlags::RGBA)];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&all);
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&vertices)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .layout(pass.layout)
            .render_pass(canvas.target.pass);
        let cache = vk::PipelineCache::null();
        unsafe {
            let pipelines = self.device.create_graphics_pipelines(cache, &[info], None);
            pass.pipeline = pipelines.unwrap()[0];
            modules.into_iter().for_each(|module| self.device.destroy_shader_module(module, None));
        }
        pass
    }

    fn module(&self, wgsl: &str, stage: naga::ShaderStage, entry: &str) -> vk::ShaderModule {
        let code = spirv(wgsl, stage, entry);
        let info = vk::ShaderModuleCreateInfo::default().code(&code);
        unsafe { self.device.create_shader_module(&info, None) }.unwrap()
    }

    fn linear_sampler(&self) -> vk::Sampler {
        let edge = vk::SamplerAddressMode::CLAMP_TO_EDGE;
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(vk::Filter::LINEAR)
            .min_filter(vk::Filter::LINEAR)
            .address_mode_u(edge)
            .address_mode_v(edge);
        unsafe { self.device.create_sampler(&info, None) }.unwrap()
    }

    /// Creates the layout and the descriptors of a pass.
    fn without_pipeline(
        &self,
        stages: vk::ShaderStageFlags,
        buffers: &[vk::Buffer],
        texture: Option<vk::ImageView>,
    ) -> HostPass {
        let kinds = buffers.iter().map(|_| vk::DescriptorType::STORAGE_BUFFER).chain(
            texture
                .iter()
                .flat_map(|_| [vk::DescriptorType::SAMPLED_IMAGE, vk::DescriptorType::SAMPLER]),
        );
        let sampler = texture.map(|_| self.linear_sampler());
        let samplers = [sampler.unwrap_or_default()];
        let bindings: Vec<_> = (0..)
            .zip(kinds)
            .map(|(binding, kind)| {
                let layout = vk::DescriptorSetLayoutBinding::default()
                    .binding(binding)
                    .descriptor_type(kind)
                    .descriptor_count(1)
                    .stage_flags(stages);
                match kind {
                    vk::DescriptorType::SAMPLER => layout.immutable_samplers(&samplers),
                    _ => layout,
                }
            })
            .collect();
        let sizes: Vec<_> = bindings
            .iter()
            .map(|binding| {
                vk::DescriptorPoolSize::default().ty(binding.descriptor_type).descriptor_count(1)
            })
            .collect();
        let device = &self.device;
        unsafe {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            let set_layout = device.create_descriptor_set_layout(&info, None).unwrap();
            let set_layouts = [set_layout];
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts);
            let layout = device.create_pipeline_layout(&info, None).unwrap();
            let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
            let descriptors = device.create_descriptor_pool(&info, None).unwrap();
            let info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(descriptors)
                .set_layouts(&set_layouts);
            let set = device.allocate_descriptor_sets(&info).unwrap()[0];
            for (binding, &buffer) in (0..).zip(buffers) {
                let info =
                    [vk::DescriptorBufferInfo::default().buffer(buffer).range(vk::WHOLE_SIZE)];
                let write = vk::WriteDescriptorSet::default()
                    .dst_set(set)
                    .dst_binding(binding)
                    .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                    .buffer_info(&info);
                device.update_descriptor_sets(&[write], &[]);
            }
            if let Some(view) = texture {
                let info = [vk::DescriptorImageInfo::default()
                    .image_view(view)
                    .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)];
                let write = vk::WriteDescriptorSet::default()
                    .dst_set(set)
                    .dst_binding(buffers.len() as u32)
                    .descriptor_type(vk::DescriptorType::SAMPLED_IMAGE)
                    .image_info(&info);
                device.update_descriptor_sets(&[write], &[]);
            }
            let pipeline = vk::Pipeline::null();
            HostPass { pipeline, layout, set_layout, descriptors, set, sampler }
        }
    }

    /// Draws `vertices` vertices on a cleared canvas.
    pub fn draw(
        &self,
        commands: vk::CommandBuffer,
        pass: &HostPass,
        canvas: &Canvas,
        vertices: u32,
        background: [f32; 4],
    ) {
        self.on_canvas(commands, pass, canvas, background, || unsafe {
            self.device.cmd_draw(commands, vertices, 1, 0, 0);
        });
    }

    /// Draws this library's curves on a cleared canvas.
    pub fn draw_curves(
        &self,
        commands: vk::CommandBuffer,
        pass: &HostPass,
        canvas: &Canvas,
        curves: geosweep::vulkan::embed::CurveBuffer,
    ) {
        let stride = geosweep::vulkan::embed::CurveRecord::BYTES;
        self.on_canvas(commands, pass, canvas, [0.0, 0.0, 0.0, 1.0], || unsafe {
            let (buffers, offsets) = ([curves.buffer], [curves.vertices_offset]);
            self.device.cmd_bind_vertex_buffers(commands, 0, &buffers, &offsets);
            // Several draws per command would need a feature of the device.
            for curve in 0..curves.curves {
                let record = u64::from(curve * stride);
                self.device.cmd_draw_indirect(commands, curves.buffer, record, 1, stride);
            }
        });
    }

    fn on_canvas(
        &self,
        commands: vk::CommandBuffer,
        pass: &HostPass,
        canvas: &Canvas,
        background: [f32; 4],
        draw: impl FnOnce(),
    ) {
        let clear = [
            vk::ClearValue { color: vk::ClearColorValue { float32: background } },
            vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth: 1.0, stencil: 0 } },
        ];
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(canvas.target.pass)
            .framebuffer(canvas.target.framebuffer)
            .render_area(canvas.target.extent.into())
            .clear_values(&clear);
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        unsafe {
            self.device.cmd_begin_render_pass(commands, &info, vk::SubpassContents::INLINE);
            self.device.cmd_bind_pipeline(commands, graphics, pass.pipeline);
            let sets = [pass.set];
            self.device.cmd_bind_descriptor_sets(commands, graphics, pass.layout, 0, &sets, &[]);
            draw();
            self.device.cmd_end_render_pass(commands);
        }
    }

    /// Creates a picture and its depth image.
    pub fn canvas(&mut self, size: vk::Extent2D, format: vk::Format, depth: vk::Format) -> Canvas {
        use vk::ImageUsageFlags as Usage;
        let usage = Usage::COLOR_ATTACHMENT | Usage::TRANSFER_SRC;
        let picture = self.image(size, format, usage, vk::ImageAspectFlags::COLOR);
        let usage = Usage::DEPTH_STENCIL_ATTACHMENT;
        let depths = self.image(size, depth, usage, vk::ImageAspectFlags::DEPTH);
        let attachment = |format, store, layout| {
            vk::AttachmentDescription::default()
                .format(format)
                .samples(vk::SampleCountFlags::TYPE_1)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(store)
                .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
                .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
                .final_layout(layout)
        };
        let depth_layout = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        let (store, forget) = (vk::AttachmentStoreOp::STORE, vk::AttachmentStoreOp::DONT_CARE);
        let attachments = [
            attachment(format, store, vk::ImageLayout::TRANSFER_SRC_OPTIMAL),
            attachment(depth, forget, depth_layout),
        ];
        let colors =
            [vk::AttachmentReference::default().layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)];
        let reference = vk::AttachmentReference::default().attachment(1).layout(depth_layout);
        let subpasses = [vk::SubpassDescription::default()
            .color_attachments(&colors)
            .depth_stencil_attachment(&reference)];
        let attached = vk::PipelineStageFlags::EARLY_FRAGMENT_TESTS
            | vk::PipelineStageFlags::LATE_FRAGMENT_TESTS
            | vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT;
        let written = vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE
            | vk::AccessFlags::COLOR_ATTACHMENT_WRITE;
        let dependencies = [
            // The next render pass draws on the same picture.
            vk::SubpassDependency::default()
                .src_subpass(vk::SUBPASS_EXTERNAL)
                .src_stage_mask(attached)
                .src_access_mask(written)
                .dst_stage_mask(attached)
                .dst_access_mask(written),
            // The copy that follows waits for the render pass.
            vk::SubpassDependency::default()
                .dst_subpass(vk::SUBPASS_EXTERNAL)
                .src_stage_mask(vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT)
                .src_access_mask(vk::AccessFlags::COLOR_ATTACHMENT_WRITE)
                .dst_stage_mask(vk::PipelineStageFlags::TRANSFER)
                .dst_access_mask(vk::AccessFlags::TRANSFER_READ),
        ];
        let info = vk::RenderPassCreateInfo::default()
            .attachments(&attachments)
            .subpasses(&subpasses)
            .dependencies(&dependencies);
        let pass = unsafe { self.device.create_render_pass(&info, None) }.unwrap();
        let views = [picture.view, depths.view];
        let target =
            Target { pass, framebuffer: self.framebuffer(pass, &views, size), extent: size };
        Canvas { target, picture, depths }
    }

    pub fn copy_canvas(&self, commands: vk::CommandBuffer, canvas: &Canvas, to: &HostBuffer) {
        let copy = whole_copy(canvas.target.extent);
        let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        let image = canvas.picture.image;
        unsafe {
            self.device.cmd_copy_image_to_buffer(commands, image, layout, to.handle, &[copy]);
        }
        use geosweep::vulkan::embed::Access;
        self.barrier(commands, Access::TRANSFER_WRITE, Access::HOST_READ);
    }

    pub fn free_canvas(&mut self, canvas: Canvas) {
        self.free_target(canvas.target);
        self.free_image(canvas.picture);
        self.free_image(canvas.depths);
    }

    /// Dispatches `groups` workgroups of a pass.
    pub fn dispatch(&self, commands: vk::CommandBuffer, pass: &HostPass, groups: u32) {
        let compute = vk::PipelineBindPoint::COMPUTE;
        unsafe {
            self.device.cmd_bind_pipeline(commands, compute, pass.pipeline);
            let sets = [pass.set];
            self.device.cmd_bind_descriptor_sets(commands, compute, pass.layout, 0, &sets, &[]);
            self.device.cmd_dispatch(commands, groups, 1, 1);
        }
    }

    pub fn destroy_pass(&self, pass: HostPass) {
        unsafe {
            self.device.destroy_pipeline(pass.pipeline, None);
            self.device.destroy_pipeline_layout(pass.layout, None);
            self.device.destroy_descriptor_pool(pass.descriptors, None);
            self.device.destroy_descriptor_set_layout(pass.set_layout, None);
            if let Some(sampler) = pass.sampler {
                self.device.destroy_sampler(sampler, None);
            }
        }
    }
}

/// Compiles WGSL to SPIR-V with one entry point.
fn spirv(wgsl: &str, shader_stage: naga::ShaderStage, entry: &str) -> Vec<u32> {
    use naga::back::spv;
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    let module = naga::front::wgsl::parse_str(wgsl)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(wgsl)));
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
    let entry = spv::PipelineOptions { shader_stage, entry_point: entry.into() };
    spv::write_vec(&module, &info.unwrap(), &spv::Options::default(), Some(&entry)).unwrap()
}
