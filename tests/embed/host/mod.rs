//! A renderer as small as one can be: an instance, a device, an allocator, a queue, and compute
//! passes of its own, written in WGSL.

#![allow(dead_code)] // each test binary uses its part

use std::ffi::{CStr, c_char, c_void};
use std::sync::Mutex;

use geosweep::ash::{self, ext, vk};
use geosweep::gpu_allocator::MemoryLocation;
use geosweep::gpu_allocator::vulkan::{
    Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc,
};
use geosweep::vulkan::requirements;

const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// The renderer.
pub struct Host {
    pub device: ash::Device,
    pub allocator: Option<Allocator>,
    pub physical_device: vk::PhysicalDevice,
    pub queue: vk::Queue,
    pub pool: vk::CommandPool,
    pub instance: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    log: Box<Mutex<Vec<String>>>,
    _entry: ash::Entry,
}

/// A buffer with its memory.
pub struct HostBuffer {
    pub handle: vk::Buffer,
    allocation: Allocation,
}

/// An image with its memory, one texel a grid point.
pub struct HostImage {
    pub image: vk::Image,
    pub view: vk::ImageView,
    allocation: Allocation,
}

/// An image that is rendered into.
pub struct Target {
    pass: vk::RenderPass,
    framebuffer: vk::Framebuffer,
    extent: vk::Extent2D,
}

/// A picture with depths, and the render pass that draws it.
pub struct Canvas {
    target: Target,
    picture: HostImage,
    depths: HostImage,
}

/// A pass of the host's over some storage buffers and, at the last binding, an image.
pub struct HostPass {
    pipeline: vk::Pipeline,
    layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
    descriptors: vk::DescriptorPool,
    set: vk::DescriptorSet,
}

impl Host {
    /// Under the validation layers.
    pub fn new() -> Self {
        Self::open(&[
            vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION,
            vk::ValidationFeatureEnableEXT::GPU_ASSISTED,
        ])
    }

    /// Under the validation layers, but for shaders: that takes long where many pixels are drawn.
    pub fn with_synchronization_validation() -> Self {
        Self::open(&[vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION])
    }

    /// Without them: for timings, and for faults of which they would rightly complain.
    pub fn without_validation() -> Self {
        Self::open(&[])
    }

    fn open(enabled: &[vk::ValidationFeatureEnableEXT]) -> Self {
        let validate = !enabled.is_empty();
        let entry = unsafe { ash::Entry::load() }.unwrap();
        let application = vk::ApplicationInfo::default().api_version(requirements::API_VERSION);
        let mut features =
            vk::ValidationFeaturesEXT::default().enabled_validation_features(enabled);
        let layers = [LAYER.as_ptr()];
        let extensions = [ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()];
        let mut info = vk::InstanceCreateInfo::default().application_info(&application);
        if validate {
            info = info
                .enabled_layer_names(&layers)
                .enabled_extension_names(&extensions)
                .push_next(&mut features);
        }
        let instance = unsafe { entry.create_instance(&info, None) }
            .expect("the tests need the validation layers; ci/setup installs them");
        let log = Box::new(Mutex::new(Vec::new()));
        let messenger = validate.then(|| listen(&entry, &instance, &log));

        let wanted = std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default().to_lowercase();
        let physical_device = unsafe { instance.enumerate_physical_devices() }
            .unwrap()
            .into_iter()
            .find(|&device| {
                let properties = unsafe { instance.get_physical_device_properties(device) };
                let name = properties.device_name_as_c_str().unwrap().to_string_lossy();
                name.to_lowercase().contains(&wanted)
                    && requirements::unmet(&instance, device).is_empty()
            })
            .expect("the tests need a Vulkan device; ci/setup installs lavapipe");
        let family = family(&instance, physical_device);
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(family)
            .queue_priorities(&[1.0])];
        let features = requirements::features();
        let info =
            vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_features(&features);
        let device = unsafe { instance.create_device(physical_device, &info, None) }.unwrap();
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.clone(),
            device: device.clone(),
            physical_device,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: Default::default(),
        });
        let queue = unsafe { device.get_device_queue(family, 0) };
        let pool = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
            .queue_family_index(family);
        let pool = unsafe { device.create_command_pool(&pool, None) }.unwrap();
        Self {
            device,
            allocator: Some(allocator.unwrap()),
            physical_device,
            queue,
            pool,
            instance,
            messenger,
            log,
            _entry: entry,
        }
    }

    pub fn allocator(&mut self) -> &mut Allocator {
        self.allocator.as_mut().unwrap()
    }

    /// How many allocations there are.
    pub fn allocations(&self) -> usize {
        self.allocator.as_ref().unwrap().generate_report().allocations.len()
    }

    /// What the validation layers have said so far.
    pub fn messages(&self) -> Vec<String> {
        self.log.lock().unwrap().clone()
    }

    /// A command buffer.
    pub fn commands(&self) -> vk::CommandBuffer {
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(self.pool)
            .command_buffer_count(1);
        unsafe { self.device.allocate_command_buffers(&info) }.unwrap()[0]
    }

    pub fn begin(&self, commands: vk::CommandBuffer) {
        let info = vk::CommandBufferBeginInfo::default();
        unsafe { self.device.begin_command_buffer(commands, &info) }.unwrap();
    }

    pub fn end(&self, commands: vk::CommandBuffer) {
        unsafe { self.device.end_command_buffer(commands) }.unwrap();
    }

    pub fn submit(&self, commands: vk::CommandBuffer, fence: vk::Fence) {
        unsafe {
            let commands = [commands];
            let info = vk::SubmitInfo::default().command_buffers(&commands);
            self.device.queue_submit(self.queue, &[info], fence).unwrap();
        }
    }

    /// Records, submits and waits.
    pub fn run<T>(&self, record: impl FnOnce(vk::CommandBuffer) -> T) -> T {
        let commands = self.commands();
        self.begin(commands);
        let result = record(commands);
        self.end(commands);
        self.submit(commands, vk::Fence::null());
        unsafe {
            self.device.queue_wait_idle(self.queue).unwrap();
            self.device.free_command_buffers(self.pool, &[commands]);
        }
        result
    }

    /// A barrier over all memory.
    pub fn barrier(
        &self,
        commands: vk::CommandBuffer,
        before: geosweep::vulkan::embed::Access,
        after: geosweep::vulkan::embed::Access,
    ) {
        let barrier = vk::MemoryBarrier::default()
            .src_access_mask(before.access)
            .dst_access_mask(after.access);
        let none = vk::DependencyFlags::empty();
        unsafe {
            let (from, to) = (before.stages, after.stages);
            self.device.cmd_pipeline_barrier(commands, from, to, none, &[barrier], &[], &[]);
        }
    }

    /// A storage buffer on the device, or, with `mapped`, one that the program reads and writes.
    pub fn buffer(&mut self, bytes: u64, mapped: bool) -> HostBuffer {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        let handle = unsafe { self.device.create_buffer(&info, None) }.unwrap();
        let requirements = unsafe { self.device.get_buffer_memory_requirements(handle) };
        let location = if mapped { MemoryLocation::GpuToCpu } else { MemoryLocation::GpuOnly };
        let allocation = self.allocate(requirements, location, true);
        unsafe {
            let (memory, offset) = (allocation.memory(), allocation.offset());
            self.device.bind_buffer_memory(handle, memory, offset).unwrap();
        }
        HostBuffer { handle, allocation }
    }

    /// A mapped buffer with these contents.
    pub fn buffer_of(&mut self, contents: &[f32]) -> HostBuffer {
        let mut buffer = self.buffer(size_of_val(contents) as u64, true);
        buffer.floats_mut()[..contents.len()].copy_from_slice(contents);
        buffer
    }

    /// A sampled image with these contents, `components` floats a texel.
    pub fn image_of(
        &mut self,
        width: u32,
        height: u32,
        components: usize,
        contents: &[f32],
    ) -> HostImage {
        let format = match components {
            1 => vk::Format::R32_SFLOAT,
            4 => vk::Format::R32G32B32A32_SFLOAT,
            _ => panic!("no such format here"),
        };
        let extent = vk::Extent2D { width, height };
        let usage = vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::TRANSFER_DST
            | vk::ImageUsageFlags::COLOR_ATTACHMENT;
        let new = self.image(extent, format, usage, vk::ImageAspectFlags::COLOR);
        let image = new.image;
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(vk::ImageAspectFlags::COLOR)
            .level_count(1)
            .layer_count(1);
        let staging = self.buffer_of(contents);
        self.run(|commands| unsafe {
            let barrier = vk::ImageMemoryBarrier::default()
                .image(image)
                .subresource_range(range)
                .new_layout(vk::ImageLayout::GENERAL)
                .dst_access_mask(vk::AccessFlags::TRANSFER_WRITE);
            let none = vk::DependencyFlags::empty();
            let (from, to) =
                (vk::PipelineStageFlags::TOP_OF_PIPE, vk::PipelineStageFlags::TRANSFER);
            self.device.cmd_pipeline_barrier(commands, from, to, none, &[], &[], &[barrier]);
            let layers = vk::ImageSubresourceLayers::default()
                .aspect_mask(vk::ImageAspectFlags::COLOR)
                .layer_count(1);
            let copy = vk::BufferImageCopy::default()
                .image_subresource(layers)
                .image_extent(extent.into());
            let layout = vk::ImageLayout::GENERAL;
            self.device.cmd_copy_buffer_to_image(commands, staging.handle, image, layout, &[copy]);
        });
        self.free(staging);
        new
    }

    fn image(
        &mut self,
        extent: vk::Extent2D,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
        aspect: vk::ImageAspectFlags,
    ) -> HostImage {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(extent.into())
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage);
        let image = unsafe { self.device.create_image(&info, None) }.unwrap();
        let requirements = unsafe { self.device.get_image_memory_requirements(image) };
        let allocation = self.allocate(requirements, MemoryLocation::GpuOnly, false);
        unsafe {
            let (memory, offset) = (allocation.memory(), allocation.offset());
            self.device.bind_image_memory(image, memory, offset).unwrap();
        }
        let range =
            vk::ImageSubresourceRange::default().aspect_mask(aspect).level_count(1).layer_count(1);
        let info = vk::ImageViewCreateInfo::default()
            .image(image)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(format)
            .subresource_range(range);
        let view = unsafe { self.device.create_image_view(&info, None) }.unwrap();
        HostImage { image, view, allocation }
    }

    fn allocate(
        &mut self,
        requirements: vk::MemoryRequirements,
        location: MemoryLocation,
        linear: bool,
    ) -> Allocation {
        self.allocator()
            .allocate(&AllocationCreateDesc {
                name: "the host's",
                requirements,
                location,
                linear,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            })
            .unwrap()
    }

    pub fn free(&mut self, buffer: HostBuffer) {
        unsafe { self.device.destroy_buffer(buffer.handle, None) };
        self.allocator().free(buffer.allocation).unwrap();
    }

    pub fn free_image(&mut self, image: HostImage) {
        unsafe {
            self.device.destroy_image_view(image.view, None);
            self.device.destroy_image(image.image, None);
        }
        self.allocator().free(image.allocation).unwrap();
    }

    /// An image as the target of a render pass that leaves it in the layout `GENERAL`.
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

    /// Renders nothing on a clear target.
    pub fn clear(&self, commands: vk::CommandBuffer, target: &Target, value: f32) {
        let clear = [vk::ClearValue { color: vk::ClearColorValue { float32: [value; 4] } }];
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(target.pass)
            .framebuffer(target.framebuffer)
            .render_area(target.extent.into())
            .clear_values(&clear);
        unsafe {
            self.device.cmd_begin_render_pass(commands, &info, vk::SubpassContents::INLINE);
            self.device.cmd_end_render_pass(commands);
        }
    }

    pub fn free_target(&self, target: Target) {
        unsafe {
            self.device.destroy_framebuffer(target.framebuffer, None);
            self.device.destroy_render_pass(target.pass, None);
        }
    }

    /// A pass from WGSL with storage buffers at its first bindings and perhaps a texture after them.
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

    /// A pass that draws triangles, from WGSL with the entry points `vertex` and `fragment`.
    pub fn draw_pass(
        &self,
        wgsl: &str,
        buffers: &[vk::Buffer],
        texture: vk::ImageView,
        canvas: &Canvas,
    ) -> HostPass {
        use vk::ShaderStageFlags as Stage;
        let mut pass =
            self.without_pipeline(Stage::VERTEX | Stage::FRAGMENT, buffers, Some(texture));
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
        let vertices = vk::PipelineVertexInputStateCreateInfo::default();
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
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

    /// The layout and the descriptors of a pass.
    fn without_pipeline(
        &self,
        stages: vk::ShaderStageFlags,
        buffers: &[vk::Buffer],
        texture: Option<vk::ImageView>,
    ) -> HostPass {
        let kinds = buffers
            .iter()
            .map(|_| vk::DescriptorType::STORAGE_BUFFER)
            .chain(texture.map(|_| vk::DescriptorType::SAMPLED_IMAGE));
        let bindings: Vec<_> = (0..)
            .zip(kinds)
            .map(|(binding, kind)| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(binding)
                    .descriptor_type(kind)
                    .descriptor_count(1)
                    .stage_flags(stages)
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
            HostPass { pipeline, layout, set_layout, descriptors, set }
        }
    }

    /// Draws so many vertices on a clear canvas.
    pub fn draw(
        &self,
        commands: vk::CommandBuffer,
        pass: &HostPass,
        canvas: &Canvas,
        vertices: u32,
        background: [f32; 4],
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
            self.device.cmd_draw(commands, vertices, 1, 0, 0);
            self.device.cmd_end_render_pass(commands);
        }
    }

    /// A picture and its depths, to draw on.
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
        // The copy that follows waits.
        let dependencies = [vk::SubpassDependency::default()
            .dst_subpass(vk::SUBPASS_EXTERNAL)
            .src_stage_mask(vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT)
            .src_access_mask(vk::AccessFlags::COLOR_ATTACHMENT_WRITE)
            .dst_stage_mask(vk::PipelineStageFlags::TRANSFER)
            .dst_access_mask(vk::AccessFlags::TRANSFER_READ)];
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
        let layers = vk::ImageSubresourceLayers::default()
            .aspect_mask(vk::ImageAspectFlags::COLOR)
            .layer_count(1);
        let copy = vk::BufferImageCopy::default()
            .image_subresource(layers)
            .image_extent(canvas.target.extent.into());
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

    /// Dispatches so many workgroups of a pass.
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
        }
    }

    /// The device with some functions replaced: those for which `replace` has something else.
    pub fn device_with(
        &self,
        replace: impl Fn(&CStr) -> Option<extern "system" fn() -> vk::Result>,
    ) -> ash::Device {
        let handle = self.device.handle();
        let load = |name: &CStr| match replace(name) {
            // Takes no arguments, which this calling convention allows.
            Some(function) => function as *const c_void,
            None => unsafe {
                std::mem::transmute::<vk::PFN_vkVoidFunction, *const c_void>((self
                    .instance
                    .fp_v1_0()
                    .get_device_proc_addr)(
                    handle,
                    name.as_ptr(),
                ))
            },
        };
        unsafe { ash::Device::load_with(load, handle) }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        unsafe {
            let _ = self.device.device_wait_idle();
            self.device.destroy_command_pool(self.pool, None);
            self.allocator = None;
            self.device.destroy_device(None);
            if let Some((loader, messenger)) = &self.messenger {
                loader.destroy_debug_utils_messenger(*messenger, None);
            }
            self.instance.destroy_instance(None);
        }
        if !std::thread::panicking() {
            // What is said while the device goes is about what was left behind.
            let left: Vec<_> =
                self.messages().into_iter().filter(|m| m.contains("vkDestroyDevice")).collect();
            assert_eq!(left, Vec::<String>::new());
        }
    }
}

impl HostBuffer {
    pub fn floats(&self) -> &[f32] {
        let bytes = self.allocation.mapped_slice().expect("the buffer was made to be mapped");
        bytemuck::cast_slice(&bytes[..bytes.len() / 4 * 4])
    }

    pub fn floats_mut(&mut self) -> &mut [f32] {
        let bytes = self.allocation.mapped_slice_mut().expect("the buffer was made to be mapped");
        let words = bytes.len() / 4 * 4;
        bytemuck::cast_slice_mut(&mut bytes[..words])
    }

    pub fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(self.floats())
    }
}

/// A queue family for compute and graphics.
pub fn family(instance: &ash::Instance, physical_device: vk::PhysicalDevice) -> u32 {
    let both = vk::QueueFlags::COMPUTE | vk::QueueFlags::GRAPHICS;
    let families = unsafe { instance.get_physical_device_queue_family_properties(physical_device) };
    families.iter().position(|family| family.queue_flags.contains(both)).unwrap() as u32
}

/// SPIR-V from WGSL, with one entry point.
fn spirv(wgsl: &str, shader_stage: naga::ShaderStage, entry: &str) -> Vec<u32> {
    use naga::back::spv;
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    let module = naga::front::wgsl::parse_str(wgsl)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(wgsl)));
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
    let entry = spv::PipelineOptions { shader_stage, entry_point: entry.into() };
    spv::write_vec(&module, &info.unwrap(), &spv::Options::default(), Some(&entry)).unwrap()
}

type Messenger = (ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT);

fn listen(entry: &ash::Entry, instance: &ash::Instance, log: &Mutex<Vec<String>>) -> Messenger {
    let loader = ext::debug_utils::Instance::new(entry, instance);
    let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(
            vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
                | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
        )
        .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
        .pfn_user_callback(Some(collect))
        .user_data(std::ptr::from_ref(log).cast_mut().cast());
    let messenger = unsafe { loader.create_debug_utils_messenger(&info, None) }.unwrap();
    (loader, messenger)
}

unsafe extern "system" fn collect(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    log: *mut c_void,
) -> vk::Bool32 {
    let text: *const c_char = unsafe { (*data).p_message };
    let text = unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned();
    // What the layers say of their own set-up is no finding.
    if !(text.contains("GPU-Assisted Validation") && text.contains("not enabled")) {
        eprintln!("validation: {text}");
        unsafe { &*log.cast::<Mutex<Vec<String>>>() }.lock().unwrap().push(text);
    }
    vk::FALSE
}
