//! Creates the compute pipelines of a device. Each pipeline is made once, when it is first requested, and all
//! surfaces share it.

use std::fmt::Display;
use std::io::Cursor;
use std::marker::PhantomData;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;

use ash::vk;
use bytemuck::Pod;

use super::descriptors::{KINDS, SETS};
use super::labels::Labels;
use super::memory::Image;
use super::passes::{
    CommonPass, MapSize, PUSH_CONSTANT_BYTES, Pass, Row, Specialization, TABLE, Variant,
};
use super::shaders::Shader;
use crate::update::Wavefront;
use crate::vulkan::{Tuning, VulkanError};

/// Pipeline whose push constants are of type `P`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pipeline<P> {
    pub(crate) handle: vk::Pipeline,
    pub(crate) layout: vk::PipelineLayout,
    constants: PhantomData<fn(P)>,
}

/// Pipelines of the passes in the table, and their common layouts.
#[derive(Debug)]
pub(crate) struct Pipelines {
    pub(crate) tuning: Tuning,
    /// Whether a barrier separates scans that go in a pair. The barrier is not needed, but the validation
    /// layers report it as missing: they track images and buffers as a whole, not the texels that a scan
    /// accesses.
    pub(crate) separates_pairs: bool,
    /// Whether the device computes on a processor's cores.
    on_processor: bool,
    /// Order in which workgroups take their numbers, in pipelines made from now on. 0 is the device's own
    /// order. Tests set other orders, see `glsl/shared/groups.glsl`.
    pub(crate) group_order: i32,
    /// Labels and names for tools, if the host enables them.
    pub(crate) labels: Option<Labels>,
    /// Flags with which pipelines are created.
    flags: vk::PipelineCreateFlags,
    /// Pipeline cache, locked while pipelines are created.
    cache: Mutex<Cache>,
    /// Layouts of the sets, by the index at which they are bound ([`KINDS`]): a surface and the fronts that are read,
    /// the host's images and buffers, and the resources in which a map is solved. The last one is empty, in the place
    /// of the host's sets for passes that use none.
    pub(crate) set_layouts: [vk::DescriptorSetLayout; SETS as usize + 1],
    /// Pipeline layouts of passes without and with a set of the host, by the number of words pushed. A layout
    /// has room for no more words than its passes push, so that each dispatch sets all of them.
    layouts: [[vk::PipelineLayout; SIZES_PUSHED]; 2],
    /// Pipelines made, by pass and variant ([`Row::place_of`]).
    made: Vec<[OnceLock<vk::Pipeline>; Variant::COUNT]>,
    /// Pipelines of passes that also depend on the size of maps. The pipeline used last is at the end.
    sized: Mutex<Vec<Sized>>,
    /// Number of pipelines that were created, destroyed ones included.
    created: AtomicUsize,
}

/// Pipeline cache with which pipelines are created.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cache {
    handle: vk::PipelineCache,
    /// Whether several threads may create pipelines with the cache at once.
    is_shared: bool,
}

impl Cache {
    /// Wraps the host's cache, or none if `handle` is null. The host may have promised the driver that only
    /// one thread at a time uses the cache.
    pub(crate) fn of_host(handle: vk::PipelineCache) -> Self {
        Self { handle, is_shared: handle == vk::PipelineCache::null() }
    }

    /// Wraps a cache that the driver synchronizes.
    pub(crate) fn shared(handle: vk::PipelineCache) -> Self {
        Self { handle, is_shared: true }
    }
}

/// Pipeline for maps of one size.
#[derive(Debug)]
struct Sized {
    number: usize,
    wavefront: Wavefront,
    map: MapSize,
    handle: vk::Pipeline,
    users: InUse,
}

/// Number of possible counts of pushed words.
const SIZES_PUSHED: usize = 1 + PUSH_CONSTANT_BYTES as usize / size_of::<u32>();

/// Guard that is held as long as a pipeline for maps of one size is used.
pub(crate) type InUse = Arc<()>;

/// Number of pipelines for maps of one size above which unused ones are destroyed. It limits their number if a host
/// keeps computing maps of new sizes.
const SIZES_KEPT: usize = 16;

impl Pipelines {
    /// Creates the layouts, and no pipeline. [`Pipelines::destroy`] must be called before the device is
    /// destroyed.
    ///
    /// With `capture`, drivers keep their statistics of pipelines. The device must then have the feature
    /// `pipelineExecutableInfo`.
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
            separates_pairs: false,
            on_processor,
            group_order: 0,
            labels,
            flags,
            cache: Mutex::new(Cache::of_host(vk::PipelineCache::null())),
            set_layouts: Default::default(),
            layouts: [[vk::PipelineLayout::null(); SIZES_PUSHED]; 2],
            made: TABLE.iter().map(|_| [const { OnceLock::new() }; Variant::COUNT]).collect(),
            sized: Mutex::default(),
            created: AtomicUsize::new(0),
        };
        let created = new.create_layouts(device);
        created.inspect_err(|_| new.destroy(device))?;
        Ok(new)
    }

    fn create_layouts(&mut self, device: &ash::Device) -> Result<(), VulkanError> {
        let names = ["a surface's own", "what the host gives", "a map's own", "nothing"];
        for (index, kinds) in KINDS.into_iter().chain([&[][..]]).enumerate() {
            self.set_layouts[index] = set_layout(device, kinds)?;
            self.name(names[index], self.set_layouts[index]);
        }
        let [surface, host, map, none] = self.set_layouts;
        let (of_map, of_host) = ([surface, none, map], [surface, host]);
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
        Ok(())
    }

    /// Sets the cache with which pipelines are created from now on.
    pub(crate) fn set_cache(&self, cache: Cache) {
        *lock(&self.cache) = cache;
    }

    fn place(&self, number: usize, variant: Variant) -> &OnceLock<vk::Pipeline> {
        &self.made[number][TABLE[number].place_of(variant)]
    }

    /// Makes the pipelines of passes, given by their numbers in the table and their variants, unless they exist. If the
    /// cache allows it, several threads do this: drivers take up to seconds to compile a shader.
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
                let of = self.specialization(variant, MapSize::default());
                let new = self.create(device, &TABLE[number], &of, *cache)?;
                // No other thread creates this pipeline: this thread has locked the cache, and its helpers
                // create other pipelines.
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

    /// Returns the pipeline of a pass, and makes it unless it exists.
    pub(crate) fn make<P: Pod>(
        &self,
        device: &ash::Device,
        pass: Pass<P>,
        variant: impl Into<Variant>,
    ) -> Result<Pipeline<P>, VulkanError> {
        let variant = variant.into();
        if self.made(pass, variant).is_none() {
            self.make_each(device, &[(pass.number(), variant)])?;
        }
        Ok(self.made(pass, variant).expect("it was made"))
    }

    /// Returns the pipeline of a pass for maps of the size `map`, and makes it unless it exists. The pipeline
    /// may be destroyed once nothing holds the returned guard. No submitted work may use the pipeline then.
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
                let of = self.specialization(wavefront.into(), map);
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
            // SAFETY: nothing holds the pipeline's guard, so no submitted work uses the pipeline.
            unsafe { device.destroy_pipeline(sized.remove(place).handle, None) };
        }
        Ok(made)
    }

    fn specialization(&self, variant: Variant, map: MapSize) -> Specialization {
        let Self { tuning, on_processor, group_order, .. } = *self;
        Specialization { tuning, on_processor, variant, map, group_order }
    }

    fn with_handle<P: Pod>(&self, pass: Pass<P>, handle: vk::Pipeline) -> Pipeline<P> {
        Pipeline { handle, layout: self.layout(pass.row().shader), constants: PhantomData }
    }

    /// Returns whether the pipelines of passes were made for a variant.
    pub(crate) fn have(&self, numbers: &[usize], variant: Variant) -> bool {
        numbers.iter().all(|&number| self.place(number, variant).get().is_some())
    }

    /// Returns the pipeline of a pass for a variant, if it was made.
    pub(crate) fn made<P: Pod>(
        &self,
        pass: Pass<P>,
        variant: impl Into<Variant>,
    ) -> Option<Pipeline<P>> {
        let handle = *self.place(pass.number(), variant.into()).get()?;
        Some(self.with_handle(pass, handle))
    }

    /// Returns the pipeline of the pass with this number, if it was made, with its layout and the number of
    /// bytes pushed.
    pub(crate) fn numbered(
        &self,
        number: usize,
        variant: Variant,
    ) -> Option<(vk::Pipeline, (vk::PipelineLayout, u32))> {
        let shader = TABLE[number].shader;
        let handle = *self.place(number, variant).get()?;
        Some((handle, (self.layout(shader), shader.push_constant_bytes)))
    }

    /// Returns the pipeline of a common pass, which serves every surface.
    pub(crate) fn of<P: Pod>(&self, pass: CommonPass<P>) -> Pipeline<P> {
        let made = self.made(pass.pass(), Wavefront::Planar);
        made.expect("a solver begins with the common passes")
    }

    /// Returns the number of pipelines that were created so far, destroyed ones included.
    pub(crate) fn created(&self) -> usize {
        self.created.load(Ordering::Relaxed)
    }

    /// Returns all pipelines that were made, with their names.
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

    /// Names an object for tools, if names are enabled.
    pub(crate) fn name(&self, name: impl Display, object: impl vk::Handle) {
        if let Some(labels) = &self.labels {
            // The prefix distinguishes these names from the host's names in captures.
            labels.name(object, &format!("geosweep: {name}"));
        }
    }

    /// Names an image and its view. Layers and tools refer to both.
    pub(crate) fn name_image(&self, name: impl Display, image: &Image) {
        self.name(&name, image.image);
        self.name(&name, image.view);
    }

    /// Returns the layout of a shader's pipelines.
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
        let spirv = row.shader_of(&of.tuning).spirv(of.variant.wavefront);
        let made = compute_pipeline(device, spirv, how, &constants)?;
        self.created.fetch_add(1, Ordering::Relaxed);
        self.name(row.name(of.variant), made);
        Ok(made)
    }

    /// Sets the sizes for which pipelines are made, and destroys those that were made. No submitted work may
    /// still use them.
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
            for layout in &mut self.set_layouts {
                device.destroy_descriptor_set_layout(std::mem::take(layout), None);
            }
        }
    }
}

/// Returns the index of the layout for `bytes` bytes of push constants.
fn words(bytes: u32) -> usize {
    bytes as usize / size_of::<u32>()
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Creates the layout of a set with one descriptor of each of these kinds.
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

/// Creates a compute pipeline from a SPIR-V module, with specialization constants by their numbers.
fn compute_pipeline(
    device: &ash::Device,
    spirv: &[u8],
    (layout, flags, cache): (vk::PipelineLayout, vk::PipelineCreateFlags, vk::PipelineCache),
    constants: &[(u32, i32)],
) -> Result<vk::Pipeline, VulkanError> {
    let code = ash::util::read_spv(&mut Cursor::new(spirv)).expect("the build embeds SPIR-V");
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
    // SAFETY: module, layout and cache are valid, and all that the structures point to is alive. This crate
    // does not use the cache on another thread unless the driver synchronizes it.
    let pipelines = unsafe { device.create_compute_pipelines(cache, &[info], None) };
    // SAFETY: a pipeline does not need its module once it is created.
    unsafe { device.destroy_shader_module(module, None) };
    match pipelines {
        Ok(pipelines) => Ok(pipelines[0]),
        Err((_, result)) => Err(VulkanError::Call { call: "vkCreateComputePipelines", result }),
    }
}
