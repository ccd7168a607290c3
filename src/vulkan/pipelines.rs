//! The compute pipelines: shared by all surfaces of a device.

use std::io::Cursor;

use ash::vk;

use super::memory::Image;
use super::plan::Scan;
use super::profile::Labels;
use super::{Schedule, Tuning, VulkanError};
use crate::update::Wavefront;

/// The bindings of every shader, and what is bound there.
pub(crate) mod binding {
    pub(crate) const EDGES: u32 = 0;
    pub(crate) const GAUSSIAN: u32 = 1;
    pub(crate) const OLD_FRONTS: u32 = 2;
    pub(crate) const FRONTS_BEHIND: u32 = 3;
    pub(crate) const NEW_FRONTS: u32 = 4;
    /// The image of [`OLD_FRONTS`], for passes that write both.
    pub(crate) const OTHER_FRONTS: u32 = 5;
    pub(crate) const PROGRESS: u32 = 6;
    pub(crate) const UPLOAD: u32 = 7;
    pub(crate) const DOWNLOAD: u32 = 8;
    pub(crate) const TILES: u32 = 9;
    pub(crate) const BLOCKS: u32 = 10;
    /// The bindings from 0 up to here are storage images, the rest storage buffers.
    pub(crate) const IMAGES: u32 = 6;
    pub(crate) const ALL: u32 = 11;
}

/// The bindings of the set that holds the host's own images and buffers, and images of distances.
/// A pass sees one or two of them, and the others are left empty.
pub(crate) mod host {
    pub(crate) const INPUT: u32 = 0;
    pub(crate) const OUTPUT: u32 = 1;
    pub(crate) const TEXTURE: u32 = 2;
    pub(crate) const RESULT: u32 = 3;
    pub(crate) const ALL: u32 = 4;
    pub(crate) const BUFFERS: u32 = 2;
    pub(crate) const IMAGES: u32 = 1;

    pub(crate) fn kind(index: u32) -> ash::vk::DescriptorType {
        match index {
            TEXTURE => ash::vk::DescriptorType::SAMPLED_IMAGE,
            RESULT => ash::vk::DescriptorType::STORAGE_IMAGE,
            _ => ash::vk::DescriptorType::STORAGE_BUFFER,
        }
    }
}

/// Room for the largest block of push constants; every device offers 128 bytes.
pub(crate) const PUSH_CONSTANT_BYTES: u32 = 32;

/// Specialization constants of the shaders.
pub(super) mod constant {
    pub(crate) const AHEAD_X: u32 = 0;
    pub(crate) const AHEAD_Y: u32 = 1;
    pub(crate) const WAVEFRONT: u32 = 2;
    pub(crate) const WIDTH: u32 = 3;
    /// Lines of a block, or iterations inside a tile or a workgroup.
    pub(crate) const REPEATS: u32 = 4;
    pub(crate) const TILE: u32 = 5;
    /// Of a batch, at most.
    pub(crate) const MAPS: u32 = 6;
    pub(crate) const ROWS: u32 = 7;
    pub(crate) const COLS: u32 = 8;
    pub(crate) const PITCH: u32 = 9;
}

/// The layouts common to all pipelines, and those that prepare and read a map.
#[derive(Debug)]
pub(crate) struct Pipelines {
    pub(crate) tuning: Tuning,
    /// Where the host shows labels and names to tools.
    pub(crate) labels: Option<Labels>,
    /// How pipelines are created.
    flags: vk::PipelineCreateFlags,
    pub(crate) set_layout: vk::DescriptorSetLayout,
    pub(crate) layout: vk::PipelineLayout,
    pub(crate) edges_from_positions: vk::Pipeline,
    pub(crate) edges_from_heights: vk::Pipeline,
    pub(crate) edges_from_metric: vk::Pipeline,
    pub(crate) fan_curvature: vk::Pipeline,
    pub(crate) gaussian_curvature: vk::Pipeline,
    pub(crate) seed: vk::Pipeline,
    pub(crate) progress: vk::Pipeline,
    pub(crate) settle: vk::Pipeline,
    pub(crate) unpack: vk::Pipeline,
    /// Passes that see the host's images and buffers have a layout of their own.
    pub(crate) host_set_layout: vk::DescriptorSetLayout,
    pub(crate) host_layout: vk::PipelineLayout,
    pub(crate) points_from_buffer: vk::Pipeline,
    pub(crate) points_from_image: vk::Pipeline,
    pub(crate) sources: vk::Pipeline,
    pub(crate) result: vk::Pipeline,
    pub(crate) lookup: vk::Pipeline,
}

/// The passes of one schedule with one kind of wavefront.
#[derive(Debug)]
pub(crate) struct SchedulePipelines {
    /// For the raster schedule the four rotated scans in the order of [`Scan::ALL`].
    pub(crate) passes: Vec<vk::Pipeline>,
    /// Whether fronts carry anything beside their arrival time.
    pub(crate) has_two_layers: bool,
}

macro_rules! spirv {
    ($name:literal) => {
        include_bytes!(concat!(env!("OUT_DIR"), "/", $name, ".spv"))
    };
}
pub(super) use spirv;

impl Pipelines {
    /// Creates them. [`Pipelines::destroy`] must be called before the device is destroyed.
    ///
    /// With `capture`, for which the device must have `pipelineExecutableInfo`, drivers keep what
    /// they can tell of them.
    pub(crate) fn new(
        device: &ash::Device,
        tuning: Tuning,
        labels: Option<Labels>,
        capture: bool,
    ) -> Result<Self, VulkanError> {
        let flags = match capture {
            true => vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR,
            false => vk::PipelineCreateFlags::empty(),
        };
        let mut new = Self {
            tuning,
            labels,
            flags,
            set_layout: vk::DescriptorSetLayout::null(),
            layout: vk::PipelineLayout::null(),
            edges_from_positions: vk::Pipeline::null(),
            edges_from_heights: vk::Pipeline::null(),
            edges_from_metric: vk::Pipeline::null(),
            fan_curvature: vk::Pipeline::null(),
            gaussian_curvature: vk::Pipeline::null(),
            seed: vk::Pipeline::null(),
            progress: vk::Pipeline::null(),
            settle: vk::Pipeline::null(),
            unpack: vk::Pipeline::null(),
            host_set_layout: vk::DescriptorSetLayout::null(),
            host_layout: vk::PipelineLayout::null(),
            points_from_buffer: vk::Pipeline::null(),
            points_from_image: vk::Pipeline::null(),
            sources: vk::Pipeline::null(),
            result: vk::Pipeline::null(),
            lookup: vk::Pipeline::null(),
        };
        match new.create(device) {
            Ok(()) => {
                new.named().into_iter().for_each(|(name, pipeline)| new.name(name, pipeline));
                Ok(new)
            }
            Err(error) => {
                new.destroy(device);
                Err(error)
            }
        }
    }

    /// The pipelines with the names of their shaders.
    pub(crate) fn named(&self) -> [(&'static str, vk::Pipeline); 14] {
        [
            ("edges_from_positions", self.edges_from_positions),
            ("edges_from_heights", self.edges_from_heights),
            ("edges_from_metric", self.edges_from_metric),
            ("fan_curvature", self.fan_curvature),
            ("gaussian_curvature", self.gaussian_curvature),
            ("seed", self.seed),
            ("progress", self.progress),
            ("settle", self.settle),
            ("unpack", self.unpack),
            ("points_from_buffer", self.points_from_buffer),
            ("points_from_image", self.points_from_image),
            ("sources", self.sources),
            ("result", self.result),
            ("lookup", self.lookup),
        ]
    }

    /// Names an object for tools, if they look on.
    pub(crate) fn name(&self, name: &str, object: impl vk::Handle) {
        if let Some(labels) = &self.labels {
            labels.name(object, name);
        }
    }

    /// The same of an image and its view, of which layers and tools tell as often.
    pub(crate) fn name_image(&self, name: &str, image: &Image) {
        self.name(name, image.image);
        self.name(name, image.view);
    }

    fn create(&mut self, device: &ash::Device) -> Result<(), VulkanError> {
        let kind = |index| descriptor_type(index < binding::IMAGES);
        self.set_layout = set_layout(device, (0..binding::ALL).map(kind))?;
        self.host_set_layout = set_layout(device, (0..host::ALL).map(host::kind))?;
        self.layout = pipeline_layout(device, &[self.set_layout])?;
        self.host_layout = pipeline_layout(device, &[self.set_layout, self.host_set_layout])?;
        let of = |layout, spirv: &[u8], constants: &[(u32, i32)]| {
            compute_pipeline_with(device, self.flags, layout, spirv, constants)
        };
        let plain = |spirv: &[u8]| of(self.layout, spirv, &[]);
        self.edges_from_positions = plain(spirv!("edges_from_positions"))?;
        self.edges_from_heights = plain(spirv!("edges_from_heights"))?;
        self.edges_from_metric = plain(spirv!("edges_from_metric"))?;
        self.fan_curvature = plain(spirv!("fan_curvature"))?;
        self.gaussian_curvature = plain(spirv!("gaussian_curvature"))?;
        let tile = (constant::TILE, self.tuning.tile as i32);
        let lines = (constant::REPEATS, self.tuning.scan_lines as i32);
        self.seed = of(self.layout, spirv!("seed"), &[tile, lines])?;
        self.progress = plain(spirv!("progress"))?;
        self.settle = of(self.layout, spirv!("settle"), &[tile])?;
        self.unpack = plain(spirv!("unpack"))?;
        let hosted = |spirv: &[u8]| of(self.host_layout, spirv, &[]);
        self.points_from_buffer = hosted(spirv!("points_from_buffer"))?;
        self.points_from_image = hosted(spirv!("points_from_image"))?;
        self.sources = hosted(spirv!("sources"))?;
        self.result = hosted(spirv!("result"))?;
        self.lookup = hosted(spirv!("lookup"))?;
        Ok(())
    }

    /// The pass that solves the surroundings of a host's source, for one wavefront; whoever asks for it
    /// destroys it.
    pub(crate) fn surroundings(
        &self,
        device: &ash::Device,
        wavefront: Wavefront,
    ) -> Result<vk::Pipeline, VulkanError> {
        let constants = [(constant::WAVEFRONT, wavefront as i32)];
        let spirv = spirv!("surroundings");
        compute_pipeline_with(device, self.flags, self.host_layout, spirv, &constants)
    }

    /// Destroys them. No submitted work may still use them.
    pub(crate) fn destroy(&mut self, device: &ash::Device) {
        // SAFETY: the caller has made sure that nothing uses them; null handles are allowed.
        unsafe {
            for (_, pipeline) in self.named() {
                device.destroy_pipeline(pipeline, None);
            }
            for layout in [self.layout, self.host_layout] {
                device.destroy_pipeline_layout(layout, None);
            }
            for layout in [self.set_layout, self.host_set_layout] {
                device.destroy_descriptor_set_layout(layout, None);
            }
        }
    }
}

/// SPIR-V with the specialization constants of a pass.
pub(super) type Pass<'a> = (&'a [u8], Vec<(u32, i32)>);

impl SchedulePipelines {
    /// Creates them. [`SchedulePipelines::destroy`] must be called before the device is destroyed.
    pub(crate) fn new(
        device: &ash::Device,
        pipelines: &Pipelines,
        schedule: Schedule,
        wavefront: Wavefront,
    ) -> Result<Self, VulkanError> {
        use constant::*;
        let Tuning { scan_width, scan_lines, tile, inner } = pipelines.tuning;
        let has_two_layers = wavefront.has_two_layers();
        let wavefront = (WAVEFRONT, wavefront as i32);
        let passes: Vec<Pass> = match schedule {
            Schedule::Raster => {
                let size = [(WIDTH, scan_width as i32), (REPEATS, scan_lines as i32), wavefront];
                Scan::ALL.map(|scan| scan_pass(spirv!("scan"), scan, &size)).to_vec()
            }
            Schedule::AllPoints => vec![(spirv!("all_points").as_slice(), vec![wavefront])],
            Schedule::Tiles => {
                let size = [(WIDTH, tile as i32 / 2), (REPEATS, inner as i32), (TILE, tile as i32)];
                vec![(spirv!("tiles").as_slice(), [vec![wavefront], size.to_vec()].concat())]
            }
        };
        Ok(Self { has_two_layers, ..Self::of(device, pipelines, &passes)? })
    }

    /// Creates the pipelines of passes.
    pub(super) fn of(
        device: &ash::Device,
        pipelines: &Pipelines,
        passes: &[Pass],
    ) -> Result<Self, VulkanError> {
        let mut new = Self { passes: Vec::new(), has_two_layers: false };
        for (spirv, constants) in passes {
            let (flags, layout) = (pipelines.flags, pipelines.layout);
            match compute_pipeline_with(device, flags, layout, spirv, constants) {
                Ok(pipeline) => new.passes.push(pipeline),
                Err(error) => {
                    new.destroy(device);
                    return Err(error);
                }
            }
        }
        Ok(new)
    }

    /// The pipelines with names that tell them from those of other schedules and wavefronts.
    pub(crate) fn named(
        &self,
        schedule: Schedule,
        wavefront: Wavefront,
    ) -> impl Iterator<Item = (String, vk::Pipeline)> {
        self.passes.iter().enumerate().map(move |(number, &pipeline)| {
            let scan = Scan::ALL.get(number).filter(|_| schedule == Schedule::Raster);
            let scan = scan.map_or(String::new(), |scan| format!(" {}", scan.name()));
            (format!("{schedule}, {wavefront}{scan}"), pipeline)
        })
    }

    /// Destroys them. No submitted work may still use them.
    pub(crate) fn destroy(&mut self, device: &ash::Device) {
        for pipeline in self.passes.drain(..) {
            // SAFETY: the caller has made sure that nothing uses it; null handles are allowed.
            unsafe { device.destroy_pipeline(pipeline, None) };
        }
    }
}

/// The pass of one of the four scans, with constants beside its direction.
pub(super) fn scan_pass<'a>(spirv: &'a [u8], scan: Scan, constants: &[(u32, i32)]) -> Pass<'a> {
    let (x, y) = scan.ahead();
    (spirv, [&[(constant::AHEAD_X, x), (constant::AHEAD_Y, y)], constants].concat())
}

pub(crate) fn descriptor_type(is_image: bool) -> vk::DescriptorType {
    if is_image { vk::DescriptorType::STORAGE_IMAGE } else { vk::DescriptorType::STORAGE_BUFFER }
}

/// The layout of a set with one descriptor of each of these kinds.
fn set_layout(
    device: &ash::Device,
    kinds: impl Iterator<Item = vk::DescriptorType>,
) -> Result<vk::DescriptorSetLayout, VulkanError> {
    let binding = |(index, kind)| {
        vk::DescriptorSetLayoutBinding::default()
            .binding(index)
            .descriptor_type(kind)
            .descriptor_count(1)
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
    };
    let bindings: Vec<_> = (0..).zip(kinds).map(binding).collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    // SAFETY: the bindings are within what every usable device offers.
    unsafe { device.create_descriptor_set_layout(&info, None) }
        .map_err(VulkanError::from_call("vkCreateDescriptorSetLayout"))
}

fn pipeline_layout(
    device: &ash::Device,
    set_layouts: &[vk::DescriptorSetLayout],
) -> Result<vk::PipelineLayout, VulkanError> {
    let ranges = [vk::PushConstantRange::default()
        .stage_flags(vk::ShaderStageFlags::COMPUTE)
        .size(PUSH_CONSTANT_BYTES)];
    let info = vk::PipelineLayoutCreateInfo::default()
        .set_layouts(set_layouts)
        .push_constant_ranges(&ranges);
    // SAFETY: the set layouts are alive.
    unsafe { device.create_pipeline_layout(&info, None) }
        .map_err(VulkanError::from_call("vkCreatePipelineLayout"))
}

/// A compute pipeline from SPIR-V, with specialization constants by their numbers.
pub(super) fn compute_pipeline(
    device: &ash::Device,
    layout: vk::PipelineLayout,
    spirv: &[u8],
    constants: &[(u32, i32)],
) -> Result<vk::Pipeline, VulkanError> {
    let flags = vk::PipelineCreateFlags::empty();
    compute_pipeline_with(device, flags, layout, spirv, constants)
}

fn compute_pipeline_with(
    device: &ash::Device,
    flags: vk::PipelineCreateFlags,
    layout: vk::PipelineLayout,
    spirv: &[u8],
    constants: &[(u32, i32)],
) -> Result<vk::Pipeline, VulkanError> {
    let code = ash::util::read_spv(&mut Cursor::new(spirv)).expect("build.rs embeds SPIR-V");
    let info = vk::ShaderModuleCreateInfo::default().code(&code);
    // SAFETY: the code is valid SPIR-V for Vulkan 1.1.
    let module = unsafe { device.create_shader_module(&info, None) }
        .map_err(VulkanError::from_call("vkCreateShaderModule"))?;
    let (ids, values): (Vec<u32>, Vec<i32>) = constants.iter().copied().unzip();
    let entry = |(index, &constant_id): (usize, &u32)| vk::SpecializationMapEntry {
        constant_id,
        offset: (index * size_of::<i32>()) as u32,
        size: size_of::<i32>(),
    };
    let entries: Vec<_> = ids.iter().enumerate().map(entry).collect();
    let specialization =
        vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::cast_slice(&values));
    let stage = vk::PipelineShaderStageCreateInfo::default()
        .stage(vk::ShaderStageFlags::COMPUTE)
        .module(module)
        .name(c"main")
        .specialization_info(&specialization);
    let info = vk::ComputePipelineCreateInfo::default().flags(flags).stage(stage).layout(layout);
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
