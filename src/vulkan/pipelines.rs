//! The compute pipelines: shared by all surfaces of a device.

use std::io::Cursor;

use ash::vk;

use super::VulkanError;
use super::plan::Scan;
use crate::update::Wavefront;

/// The bindings of every shader, and what is bound there.
pub(crate) mod binding {
    pub(crate) const EDGES: u32 = 0;
    pub(crate) const OLD_FRONTS: u32 = 1;
    pub(crate) const FRONTS_BEHIND: u32 = 2;
    pub(crate) const NEW_FRONTS: u32 = 3;
    pub(crate) const RESIDUAL: u32 = 4;
    pub(crate) const UPLOAD: u32 = 5;
    pub(crate) const DOWNLOAD: u32 = 6;
    /// The bindings from 0 up to here are storage images, the rest storage buffers.
    pub(crate) const IMAGES: u32 = 4;
    pub(crate) const ALL: u32 = 7;
}

/// Room for the largest block of push constants; every device offers 128 bytes.
const PUSH_CONSTANT_BYTES: u32 = 32;

/// The layout common to all pipelines, and those that prepare and read a map.
#[derive(Debug)]
pub struct Pipelines {
    pub(crate) set_layout: vk::DescriptorSetLayout,
    pub(crate) layout: vk::PipelineLayout,
    pub(crate) edges_from_positions: vk::Pipeline,
    pub(crate) edges_from_heights: vk::Pipeline,
    pub(crate) edges_from_metric: vk::Pipeline,
    pub(crate) fan_curvature: vk::Pipeline,
    pub(crate) gaussian_curvature: vk::Pipeline,
    pub(crate) seed: vk::Pipeline,
    pub(crate) unpack: vk::Pipeline,
}

/// The four rotated scans with one kind of wavefront, in the order of [`Scan::ALL`].
#[derive(Debug)]
pub struct ScanPipelines {
    pub(crate) scans: [vk::Pipeline; 4],
}

macro_rules! spirv {
    ($name:literal) => {
        include_bytes!(concat!(env!("OUT_DIR"), "/", $name, ".spv"))
    };
}

impl Pipelines {
    /// Creates them. [`Pipelines::destroy`] must be called before the device is destroyed.
    pub fn new(device: &ash::Device) -> Result<Self, VulkanError> {
        let mut new = Self {
            set_layout: vk::DescriptorSetLayout::null(),
            layout: vk::PipelineLayout::null(),
            edges_from_positions: vk::Pipeline::null(),
            edges_from_heights: vk::Pipeline::null(),
            edges_from_metric: vk::Pipeline::null(),
            fan_curvature: vk::Pipeline::null(),
            gaussian_curvature: vk::Pipeline::null(),
            seed: vk::Pipeline::null(),
            unpack: vk::Pipeline::null(),
        };
        match new.create(device) {
            Ok(()) => Ok(new),
            Err(error) => {
                new.destroy(device);
                Err(error)
            }
        }
    }

    fn create(&mut self, device: &ash::Device) -> Result<(), VulkanError> {
        let bindings: Vec<_> = (0..binding::ALL)
            .map(|index| {
                let is_image = index < binding::IMAGES;
                vk::DescriptorSetLayoutBinding::default()
                    .binding(index)
                    .descriptor_type(descriptor_type(is_image))
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: the bindings are within what every Vulkan device offers.
        self.set_layout = unsafe { device.create_descriptor_set_layout(&info, None) }
            .map_err(VulkanError::from_call("vkCreateDescriptorSetLayout"))?;
        let ranges = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
            .size(PUSH_CONSTANT_BYTES)];
        let set_layouts = [self.set_layout];
        let info = vk::PipelineLayoutCreateInfo::default()
            .set_layouts(&set_layouts)
            .push_constant_ranges(&ranges);
        // SAFETY: the set layout was created above.
        self.layout = unsafe { device.create_pipeline_layout(&info, None) }
            .map_err(VulkanError::from_call("vkCreatePipelineLayout"))?;
        let plain = |spirv: &[u8]| compute_pipeline(device, self.layout, spirv, &[]);
        self.edges_from_positions = plain(spirv!("edges_from_positions"))?;
        self.edges_from_heights = plain(spirv!("edges_from_heights"))?;
        self.edges_from_metric = plain(spirv!("edges_from_metric"))?;
        self.fan_curvature = plain(spirv!("fan_curvature"))?;
        self.gaussian_curvature = plain(spirv!("gaussian_curvature"))?;
        self.seed = plain(spirv!("seed"))?;
        self.unpack = plain(spirv!("unpack"))?;
        Ok(())
    }

    /// Destroys them. No submitted work may still use them.
    pub fn destroy(&mut self, device: &ash::Device) {
        // SAFETY: the caller has made sure that nothing uses them; null handles are allowed.
        unsafe {
            for pipeline in [
                self.edges_from_positions,
                self.edges_from_heights,
                self.edges_from_metric,
                self.fan_curvature,
                self.gaussian_curvature,
                self.seed,
                self.unpack,
            ] {
                device.destroy_pipeline(pipeline, None);
            }
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

impl ScanPipelines {
    /// Creates them. [`ScanPipelines::destroy`] must be called before the device is destroyed.
    pub fn new(
        device: &ash::Device,
        pipelines: &Pipelines,
        wavefront: Wavefront,
    ) -> Result<Self, VulkanError> {
        let mut new = Self { scans: [vk::Pipeline::null(); 4] };
        for (slot, scan) in new.scans.iter_mut().zip(Scan::ALL) {
            let (x, y) = scan.ahead();
            let constants = [x, y, wavefront as i32];
            match compute_pipeline(device, pipelines.layout, spirv!("scan"), &constants) {
                Ok(pipeline) => *slot = pipeline,
                Err(error) => {
                    new.destroy(device);
                    return Err(error);
                }
            }
        }
        Ok(new)
    }

    /// Destroys them. No submitted work may still use them.
    pub fn destroy(&mut self, device: &ash::Device) {
        for pipeline in self.scans {
            // SAFETY: the caller has made sure that nothing uses it; null handles are allowed.
            unsafe { device.destroy_pipeline(pipeline, None) };
        }
    }
}

pub(crate) fn descriptor_type(is_image: bool) -> vk::DescriptorType {
    if is_image { vk::DescriptorType::STORAGE_IMAGE } else { vk::DescriptorType::STORAGE_BUFFER }
}

/// A compute pipeline from SPIR-V; constants are specialization constants 0, 1, ...
fn compute_pipeline(
    device: &ash::Device,
    layout: vk::PipelineLayout,
    spirv: &[u8],
    constants: &[i32],
) -> Result<vk::Pipeline, VulkanError> {
    let code = ash::util::read_spv(&mut Cursor::new(spirv)).expect("build.rs embeds SPIR-V");
    let info = vk::ShaderModuleCreateInfo::default().code(&code);
    // SAFETY: the code is valid SPIR-V for Vulkan 1.1.
    let module = unsafe { device.create_shader_module(&info, None) }
        .map_err(VulkanError::from_call("vkCreateShaderModule"))?;
    let entries: Vec<_> = (0..constants.len())
        .map(|index| vk::SpecializationMapEntry {
            constant_id: index as u32,
            offset: (index * size_of::<i32>()) as u32,
            size: size_of::<i32>(),
        })
        .collect();
    let specialization = vk::SpecializationInfo::default()
        .map_entries(&entries)
        .data(bytemuck::cast_slice(constants));
    let stage = vk::PipelineShaderStageCreateInfo::default()
        .stage(vk::ShaderStageFlags::COMPUTE)
        .module(module)
        .name(c"main")
        .specialization_info(&specialization);
    let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout);
    // SAFETY: module and layout are valid, and all that the structures point to is alive.
    let pipelines =
        unsafe { device.create_compute_pipelines(vk::PipelineCache::null(), &[info], None) };
    // SAFETY: a pipeline does not need its module once it is created.
    unsafe { device.destroy_shader_module(module, None) };
    match pipelines {
        Ok(pipelines) => Ok(pipelines[0]),
        Err((_, result)) => Err(VulkanError::Call { call: "vkCreateComputePipelines", result }),
    }
}
