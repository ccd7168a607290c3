//! The compute pipelines of a device: each is made once, when it is first asked for, and shared by
//! all surfaces.

use std::io::Cursor;
use std::marker::PhantomData;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;

use ash::vk;
use bytemuck::Pod;

use super::memory::Image;
use super::passes::{
    CommonPass, MapSize, PUSH_CONSTANT_BYTES, Pass, Row, Specialization, TABLE, Variant,
};
use super::profile::Labels;
use super::shaders::{Shader, set_0, set_1, set_2};
use super::{Tuning, VulkanError};
use crate::update::Wavefront;

/// A pipeline to which these constants are pushed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pipeline<P> {
    pub(crate) handle: vk::Pipeline,
    pub(crate) layout: vk::PipelineLayout,
    constants: PhantomData<fn(P)>,
}

/// The pipelines of the table's passes, and the layouts that are common to them.
#[derive(Debug)]
pub(crate) struct Pipelines {
    pub(crate) tuning: Tuning,
    /// Whether the device computes on a processor's cores.
    on_processor: bool,
    /// Where the host shows labels and names to tools.
    pub(crate) labels: Option<Labels>,
    /// How pipelines are created.
    flags: vk::PipelineCreateFlags,
    /// Locked while pipelines are created.
    cache: Mutex<Cache>,
    /// Of the sets that every pass sees: a surface, and the fronts that are read.
    pub(crate) surface_set_layout: vk::DescriptorSetLayout,
    /// Of the sets with the host's images and buffers.
    pub(crate) host_set_layout: vk::DescriptorSetLayout,
    /// Of the sets with what a map is solved in.
    pub(crate) map_set_layout: vk::DescriptorSetLayout,
    /// In the place of the host's sets where a pass sees none.
    no_set_layout: vk::DescriptorSetLayout,
    /// Of passes that see no set of the host's, and of those that see one.
    /// Of passes that see nothing of the host's and of those that do, by the words that are pushed: a layout has room
    /// for no more, so that each dispatch sets all of it.
    layouts: [[vk::PipelineLayout; SIZES_PUSHED]; 2],
    /// By pass and variant ([`Row::place_of`]).
    made: [[OnceLock<vk::Pipeline>; Variant::COUNT]; TABLE.len()],
    /// Of passes that depend on the size of maps too, the one used last at the end.
    sized: Mutex<Vec<Sized>>,
}

/// What pipelines are created with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cache {
    handle: vk::PipelineCache,
    /// Whether several threads may create pipelines with it at once.
    is_shared: bool,
}

impl Cache {
    /// The host's, or none if it is null. The host may have promised the driver that one thread at a time uses it.
    pub(crate) fn of_host(handle: vk::PipelineCache) -> Self {
        Self { handle, is_shared: handle == vk::PipelineCache::null() }
    }

    /// One that the driver synchronizes.
    pub(crate) fn shared(handle: vk::PipelineCache) -> Self {
        Self { handle, is_shared: true }
    }
}

/// A pipeline for maps of a size.
#[derive(Debug)]
struct Sized {
    number: usize,
    wavefront: Wavefront,
    map: MapSize,
    handle: vk::Pipeline,
    users: InUse,
}

/// Numbers of words that may be pushed.
const SIZES_PUSHED: usize = 1 + PUSH_CONSTANT_BYTES as usize / size_of::<u32>();

/// To be kept as long as a pipeline for maps of a size is used.
pub(crate) type InUse = Arc<()>;

/// So many pipelines for maps of sizes that nothing uses are kept, so that a host may compute maps of ever
/// new sizes.
const SIZES_KEPT: usize = 16;

impl Pipelines {
    /// The layouts, and no pipeline. [`Pipelines::destroy`] must be called before the device is
    /// destroyed.
    ///
    /// With `capture`, for which the device must have `pipelineExecutableInfo`, drivers keep what
    /// they can tell of pipelines.
    pub(crate) fn new(
        device: &ash::Device,
        (tuning, on_processor): (Tuning, bool),
        labels: Option<Labels>,
        capture: bool,
    ) -> Result<Self, VulkanError> {
        let flags = match capture {
            true => vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR,
            false => vk::PipelineCreateFlags::empty(),
        };
        let mut new = Self {
            tuning,
            on_processor,
            labels,
            flags,
            cache: Mutex::new(Cache::of_host(vk::PipelineCache::null())),
            surface_set_layout: vk::DescriptorSetLayout::null(),
            host_set_layout: vk::DescriptorSetLayout::null(),
            map_set_layout: vk::DescriptorSetLayout::null(),
            no_set_layout: vk::DescriptorSetLayout::null(),
            layouts: [[vk::PipelineLayout::null(); SIZES_PUSHED]; 2],
            made: [const { [const { OnceLock::new() }; Variant::COUNT] }; TABLE.len()],
            sized: Mutex::default(),
        };
        match new.create_layouts(device) {
            Ok(()) => Ok(new),
            Err(error) => {
                new.destroy(device);
                Err(error)
            }
        }
    }

    fn create_layouts(&mut self, device: &ash::Device) -> Result<(), VulkanError> {
        self.surface_set_layout = set_layout(device, &set_0::KINDS)?;
        self.host_set_layout = set_layout(device, &set_1::KINDS)?;
        self.map_set_layout = set_layout(device, &set_2::KINDS)?;
        self.no_set_layout = set_layout(device, &[])?;
        let of_map = [self.surface_set_layout, self.no_set_layout, self.map_set_layout];
        let of_host = [self.surface_set_layout, self.host_set_layout];
        for shader in TABLE.iter().map(|row| row.shader) {
            let bytes = shader.push_constant_bytes;
            let (sets, name): (&[_], _) = match shader.sees_host {
                true => (&of_host, "passes that see the host's"),
                false => (&of_map, "passes over a surface"),
            };
            let layout = &mut self.layouts[usize::from(shader.sees_host)][words(bytes)];
            if *layout == vk::PipelineLayout::null() {
                *layout = pipeline_layout(device, sets, bytes)?;
                let layout = *layout;
                self.name(name, layout);
            }
        }
        self.name("a surface's own", self.surface_set_layout);
        self.name("what the host gives", self.host_set_layout);
        self.name("a map's own", self.map_set_layout);
        self.name("nothing", self.no_set_layout);
        Ok(())
    }

    /// Pipelines are created with this cache from now on.
    pub(crate) fn set_cache(&self, cache: Cache) {
        *lock(&self.cache) = cache;
    }

    fn place(&self, number: usize, variant: Variant) -> &OnceLock<vk::Pipeline> {
        &self.made[number][TABLE[number].place_of(variant)]
    }

    /// Makes the pipelines of passes, by their numbers in the table, unless they are there;
    /// `variant` is that of passes which depend on it.
    pub(crate) fn make_all(
        &self,
        device: &ash::Device,
        numbers: &[usize],
        variant: impl Into<Variant>,
    ) -> Result<(), VulkanError> {
        let variant = variant.into();
        let wanted: Vec<_> = numbers.iter().map(|&number| (number, variant)).collect();
        self.make_each(device, &wanted)
    }

    /// The same for passes of several variants, on several threads where the cache allows it: drivers take up to
    /// seconds to compile a shader.
    pub(crate) fn make_each(
        &self,
        device: &ash::Device,
        wanted: &[(usize, Variant)],
    ) -> Result<(), VulkanError> {
        let cache = lock(&self.cache);
        let place =
            |&(number, variant): &(usize, Variant)| (number, TABLE[number].place_of(variant));
        let mut missing: Vec<_> =
            wanted.iter().filter(|of| self.place(of.0, of.1).get().is_none()).collect();
        missing.sort_by_key(|of| place(of));
        missing.dedup_by_key(|of| place(of));
        let next = AtomicUsize::new(0);
        let make = || {
            while let Some(&&(number, variant)) = missing.get(next.fetch_add(1, Ordering::Relaxed))
            {
                let new = self.create_one(device, number, variant, *cache)?;
                // No other thread creates it: this one has the cache, and its helpers have other passes.
                self.place(number, variant).get_or_init(|| new);
            }
            Ok(())
        };
        let threads = match cache.is_shared {
            true => thread::available_parallelism().map_or(1, usize::from).min(missing.len()),
            false => 1,
        };
        thread::scope(|scope| {
            let helpers: Vec<_> = (1..threads).map(|_| scope.spawn(make)).collect();
            let own = make();
            let helped =
                helpers.into_iter().map(|helper| helper.join().expect("creation does not panic"));
            helped.fold(own, Result::and)
        })
    }

    /// The pipeline of a pass, which is made unless it is there.
    pub(crate) fn make<P: Pod>(
        &self,
        device: &ash::Device,
        pass: Pass<P>,
        variant: impl Into<Variant>,
    ) -> Result<Pipeline<P>, VulkanError> {
        Ok(self.with_handle(pass, self.make_one(device, pass.number(), variant.into())?))
    }

    fn make_one(
        &self,
        device: &ash::Device,
        number: usize,
        variant: Variant,
    ) -> Result<vk::Pipeline, VulkanError> {
        let place = self.place(number, variant);
        if let Some(&made) = place.get() {
            return Ok(made);
        }
        let cache = lock(&self.cache);
        // Another thread may have made it before it released the cache.
        if let Some(&made) = place.get() {
            return Ok(made);
        }
        let new = self.create_one(device, number, variant, *cache)?;
        Ok(*place.get_or_init(|| new))
    }

    fn create_one(
        &self,
        device: &ash::Device,
        number: usize,
        variant: Variant,
        cache: Cache,
    ) -> Result<vk::Pipeline, VulkanError> {
        let map = MapSize::default();
        let (tuning, on_processor) = (self.tuning, self.on_processor);
        let of = Specialization { tuning, on_processor, variant, map };
        self.create(device, &TABLE[number], &of, cache)
    }

    /// The pipeline of a pass for maps of this size, which is made unless it is there. It may go once nothing
    /// holds what comes with it; no submitted work may use it then.
    pub(crate) fn make_sized<P: Pod>(
        &self,
        device: &ash::Device,
        pass: Pass<P>,
        wavefront: Wavefront,
        map: MapSize,
    ) -> Result<(Pipeline<P>, InUse), VulkanError> {
        let mut sized = lock(&self.sized);
        let wanted = (pass.number(), wavefront, map);
        let place = sized.iter().position(|of| (of.number, of.wavefront, of.map) == wanted);
        let found = match place {
            Some(place) => sized.remove(place),
            None => {
                let (tuning, on_processor) = (self.tuning, self.on_processor);
                let of = Specialization { tuning, on_processor, variant: wavefront.into(), map };
                let handle = self.create(device, pass.row(), &of, *lock(&self.cache))?;
                let (number, users) = (pass.number(), InUse::default());
                Sized { number, wavefront, map, handle, users }
            }
        };
        let made = (self.with_handle(pass, found.handle), Arc::clone(&found.users));
        sized.push(found);
        while sized.len() > SIZES_KEPT {
            let idle = sized.iter().position(|of| Arc::strong_count(&of.users) == 1);
            let Some(place) = idle else { break };
            // SAFETY: no one holds it, so that no submitted work uses it.
            unsafe { device.destroy_pipeline(sized.remove(place).handle, None) };
        }
        Ok(made)
    }

    fn with_handle<P: Pod>(&self, pass: Pass<P>, handle: vk::Pipeline) -> Pipeline<P> {
        Pipeline { handle, layout: self.layout(pass.row().shader), constants: PhantomData }
    }

    /// Whether the pipelines of passes were made for a variant.
    pub(crate) fn have(&self, numbers: &[usize], variant: Variant) -> bool {
        numbers.iter().all(|&number| self.place(number, variant).get().is_some())
    }

    /// The pipeline of a pass for a variant, if it was made.
    pub(crate) fn made<P: Pod>(
        &self,
        pass: Pass<P>,
        variant: impl Into<Variant>,
    ) -> Option<Pipeline<P>> {
        let handle = *self.place(pass.number(), variant.into()).get()?;
        Some(self.with_handle(pass, handle))
    }

    /// The pipeline of a pass with this number, if it was made, and its layout with how many bytes are pushed.
    pub(crate) fn numbered(
        &self,
        number: usize,
        variant: Variant,
    ) -> Option<(vk::Pipeline, (vk::PipelineLayout, u32))> {
        let shader = TABLE[number].shader;
        let handle = *self.place(number, variant).get()?;
        Some((handle, (self.layout(shader), shader.push_constant_bytes)))
    }

    /// The pipeline of a pass of every surface.
    pub(crate) fn of<P: Pod>(&self, pass: CommonPass<P>) -> Pipeline<P> {
        let made = self.made(pass.pass(), Wavefront::Planar);
        made.expect("a solver begins with the common passes")
    }

    /// All that were made, with their names.
    pub(crate) fn named(&self) -> impl Iterator<Item = (String, vk::Pipeline)> {
        let made = TABLE.iter().zip(&self.made).flat_map(|(row, made)| {
            Variant::all().zip(made).filter_map(|(variant, made)| {
                let made = *made.get()?;
                Some((row.name(variant), made))
            })
        });
        let sized = lock(&self.sized);
        let sized = sized.iter().map(|of| (TABLE[of.number].name(of.wavefront.into()), of.handle));
        made.chain(sized.collect::<Vec<_>>())
    }

    /// Names an object for tools, if they look on.
    pub(crate) fn name(&self, name: &str, object: impl vk::Handle) {
        if let Some(labels) = &self.labels {
            // In captures they stand among the host's.
            labels.name(object, &format!("geosweep: {name}"));
        }
    }

    /// The same of an image and its view, of which layers and tools tell as often.
    pub(crate) fn name_image(&self, name: &str, image: &Image) {
        self.name(name, image.image);
        self.name(name, image.view);
    }

    /// The layout of a shader's pipelines.
    pub(crate) fn layout(&self, shader: &Shader) -> vk::PipelineLayout {
        self.layouts[usize::from(shader.sees_host)][words(shader.push_constant_bytes)]
    }

    fn create(
        &self,
        device: &ash::Device,
        row: &Row,
        of: &Specialization,
        cache: Cache,
    ) -> Result<vk::Pipeline, VulkanError> {
        let layout = self.layout(row.shader);
        let constants = row.constants(of);
        let how = (layout, self.flags, cache.handle);
        let made = compute_pipeline(device, row.shader, how, &constants)?;
        self.name(&row.name(of.variant), made);
        Ok(made)
    }

    /// From now on pipelines are made for these sizes, and those that were made are destroyed. No submitted work
    /// may still use them.
    pub(crate) fn set_tuning(&mut self, device: &ash::Device, tuning: Tuning) {
        self.destroy_made(device);
        self.tuning = tuning;
    }

    fn destroy_made(&mut self, device: &ash::Device) {
        // SAFETY: the caller has made sure that nothing uses them.
        unsafe {
            let sized = self.sized.get_mut().unwrap_or_else(PoisonError::into_inner);
            let sized = sized.drain(..).map(|of| of.handle);
            let made = self.made.iter_mut().flatten().filter_map(OnceLock::take);
            for pipeline in made.chain(sized) {
                device.destroy_pipeline(pipeline, None);
            }
        }
    }

    /// Destroys everything. No submitted work may still use it.
    pub(crate) fn destroy(&mut self, device: &ash::Device) {
        self.destroy_made(device);
        // SAFETY: the caller has made sure that nothing uses them; null handles are allowed.
        unsafe {
            for layout in self.layouts.as_flattened_mut() {
                device.destroy_pipeline_layout(std::mem::take(layout), None);
            }
            for layout in [
                &mut self.surface_set_layout,
                &mut self.host_set_layout,
                &mut self.map_set_layout,
                &mut self.no_set_layout,
            ] {
                device.destroy_descriptor_set_layout(std::mem::take(layout), None);
            }
        }
    }
}

/// The place of a layout with room for so many bytes of push constants.
fn words(bytes: u32) -> usize {
    bytes as usize / size_of::<u32>()
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The layout of a set with one descriptor of each of these kinds.
fn set_layout(
    device: &ash::Device,
    kinds: &[vk::DescriptorType],
) -> Result<vk::DescriptorSetLayout, VulkanError> {
    let binding = |(index, &kind)| {
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
    pushed: u32,
) -> Result<vk::PipelineLayout, VulkanError> {
    let ranges =
        [vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::COMPUTE).size(pushed)];
    let ranges = if pushed > 0 { &ranges[..] } else { &[] };
    let info = vk::PipelineLayoutCreateInfo::default()
        .set_layouts(set_layouts)
        .push_constant_ranges(ranges);
    // SAFETY: the set layouts are alive.
    unsafe { device.create_pipeline_layout(&info, None) }
        .map_err(VulkanError::from_call("vkCreatePipelineLayout"))
}

/// A compute pipeline of a shader, with specialization constants by their numbers.
fn compute_pipeline(
    device: &ash::Device,
    shader: &Shader,
    (layout, flags, cache): (vk::PipelineLayout, vk::PipelineCreateFlags, vk::PipelineCache),
    constants: &[(u32, i32)],
) -> Result<vk::Pipeline, VulkanError> {
    let code =
        ash::util::read_spv(&mut Cursor::new(shader.spirv)).expect("the build embeds SPIR-V");
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
    // SAFETY: module, layout and cache are valid, no other thread uses the cache by us unless the driver
    // synchronizes it, and all that the structures point to is alive.
    let pipelines = unsafe { device.create_compute_pipelines(cache, &[info], None) };
    // SAFETY: a pipeline does not need its module once it is created.
    unsafe { device.destroy_shader_module(module, None) };
    match pipelines {
        Ok(pipelines) => Ok(pipelines[0]),
        Err((_, result)) => Err(VulkanError::Call { call: "vkCreateComputePipelines", result }),
    }
}
