//! Vulkan for a program: an instance, which the validation layers may watch, a device, and an allocator.

use std::error::Error;
use std::ffi::{CStr, c_char, c_void};
use std::sync::Mutex;

use geosweep::ash::{self, ext, vk};
use geosweep::gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use geosweep::vulkan::requirements;

pub type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Name of the validation layers.
pub const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";
/// Validation of calls and of synchronization.
pub const SYNCHRONIZATION: &[vk::ValidationFeatureEnableEXT] =
    &[vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];

type Messenger = (ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT);

/// An instance. [`Instance::close`] destroys it.
pub struct Instance {
    pub entry: ash::Entry,
    pub handle: ash::Instance,
    messenger: Option<Messenger>,
    log: Box<Mutex<Vec<String>>>,
}

impl Instance {
    /// Creates an instance with these extensions, under the validation layers if `checks` names some of their checks.
    pub fn new(
        mut extensions: Vec<*const c_char>,
        checks: &[vk::ValidationFeatureEnableEXT],
    ) -> Result<Self> {
        // SAFETY: the entry is kept as long as the objects that it loads.
        let entry = unsafe { ash::Entry::load() }
            .map_err(|error| format!("no Vulkan loader on this system: {error}"))?;
        let application = vk::ApplicationInfo::default().api_version(requirements::API_VERSION);
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(checks);
        let layers = [LAYER.as_ptr()];
        // Newer layers report hazards of shaders only on request. Older ones do not have the setting.
        // SAFETY: the loader is loaded.
        let of_layer = unsafe { entry.enumerate_instance_extension_properties(Some(LAYER)) };
        let takes_settings = of_layer
            .unwrap_or_default()
            .iter()
            .any(|extension| extension.extension_name_as_c_str() == Ok(ext::layer_settings::NAME));
        let mut setting = vk::LayerSettingEXT::default()
            .layer_name(LAYER)
            .setting_name(c"syncval_shader_accesses_heuristic")
            .ty(vk::LayerSettingTypeEXT::BOOL32);
        (setting.value_count, setting.p_values) = (1, std::ptr::from_ref(&vk::TRUE).cast());
        let settings = [setting];
        let mut settings = vk::LayerSettingsCreateInfoEXT::default().settings(&settings);
        let validate = !checks.is_empty();
        if validate {
            extensions
                .extend([ext::debug_utils::NAME, ext::validation_features::NAME].map(CStr::as_ptr));
        }
        if validate && takes_settings {
            extensions.push(ext::layer_settings::NAME.as_ptr());
        }
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_extension_names(&extensions);
        if validate {
            info = info.enabled_layer_names(&layers).push_next(&mut features);
        }
        if validate && takes_settings {
            info = info.push_next(&mut settings);
        }
        // SAFETY: everything that the info points to is alive.
        let handle =
            unsafe { entry.create_instance(&info, None) }.map_err(|error| match error {
                vk::Result::ERROR_LAYER_NOT_PRESENT => {
                    "the validation layers are not installed; ci/setup installs them".into()
                }
                error => format!("no Vulkan instance: {error}"),
            })?;
        let log = Box::default();
        let messenger = validate.then(|| listen(&entry, &handle, &log)).transpose()?;
        Ok(Self { entry, handle, messenger, log })
    }

    /// Returns all messages of the validation layers so far.
    pub fn messages(&self) -> Vec<String> {
        self.log.lock().unwrap().clone()
    }

    /// Returns the best device whose name contains `wanted` and that meets the requirements, and what `accept` returns
    /// for it: a discrete GPU before an integrated one, and a CPU last.
    pub fn choose<T>(
        &self,
        wanted: &str,
        accept: impl Fn(vk::PhysicalDevice) -> std::result::Result<T, String>,
    ) -> Result<(vk::PhysicalDevice, T)> {
        let wanted = wanted.to_lowercase();
        let (mut lacking, mut usable) = (Vec::new(), Vec::new());
        // SAFETY: the physical devices are from this instance.
        for device in unsafe { self.handle.enumerate_physical_devices()? } {
            let properties = unsafe { self.handle.get_physical_device_properties(device) };
            let name = name(&properties);
            let unmet = requirements::unmet(&self.handle, device);
            if !name.to_lowercase().contains(&wanted) {
                lacking.push(format!("{name} is not the device asked for"));
            } else if !unmet.is_empty() {
                lacking.push(format!("{name}: {}", unmet.join("; ")));
            } else {
                let rank = match properties.device_type {
                    vk::PhysicalDeviceType::DISCRETE_GPU => 0,
                    vk::PhysicalDeviceType::INTEGRATED_GPU => 1,
                    vk::PhysicalDeviceType::CPU => 3,
                    _ => 2,
                };
                match accept(device) {
                    Ok(found) => usable.push((rank, device, found)),
                    Err(reason) => lacking.push(format!("{name} {reason}")),
                }
            }
        }
        let best = usable.into_iter().min_by_key(|(rank, ..)| *rank);
        let (_, device, found) =
            best.ok_or_else(|| format!("no Vulkan device can be used: {}", lacking.join(", ")))?;
        Ok((device, found))
    }

    /// Destroys the instance, after everything that was created from it. Messages are kept.
    pub fn close(&mut self) {
        // SAFETY: nothing is left that was created from the instance.
        unsafe {
            if let Some((loader, messenger)) = self.messenger.take() {
                loader.destroy_debug_utils_messenger(messenger, None);
            }
            self.handle.destroy_instance(None);
        }
    }
}

/// Returns the name of a device.
pub fn name(properties: &vk::PhysicalDeviceProperties) -> String {
    properties.device_name_as_c_str().unwrap_or(c"unnamed").to_string_lossy().into_owned()
}

fn listen(
    entry: &ash::Entry,
    instance: &ash::Instance,
    log: &Mutex<Vec<String>>,
) -> Result<Messenger> {
    use vk::DebugUtilsMessageSeverityFlagsEXT as Severity;
    let loader = ext::debug_utils::Instance::new(entry, instance);
    let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
        .pfn_user_callback(Some(collect))
        .user_data(std::ptr::from_ref(log).cast_mut().cast());
    // SAFETY: the log is on the heap and outlives the messenger.
    let messenger = unsafe { loader.create_debug_utils_messenger(&info, None)? };
    Ok((loader, messenger))
}

unsafe extern "system" fn collect(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    log: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layers pass a valid message.
    let id = unsafe { (*data).message_id_name_as_c_str() }.unwrap_or(c"").to_string_lossy();
    let text = unsafe { (*data).message_as_c_str() }.unwrap_or(c"").to_string_lossy();
    // Messages of the layers about their own set-up are not findings.
    let is_warning = severity == vk::DebugUtilsMessageSeverityFlagsEXT::WARNING;
    if !(is_warning && id.contains("GPU-Assisted")) {
        let text = format!("[ {id} ] {text}");
        // Objects that a failing test leaves behind are expected, and reporting them would hide its cause.
        if !std::thread::panicking() {
            eprintln!("validation: {text}");
        }
        // SAFETY: this is the log with which the messenger was created.
        unsafe { &*log.cast::<Mutex<Vec<String>>>() }.lock().unwrap().push(text);
    }
    vk::FALSE
}

/// A device with its instance and an allocator. [`Context::close_device`] destroys the device.
pub struct Context {
    pub device: ash::Device,
    /// Allocator; `None` only after the device was destroyed.
    pub allocator: Option<Allocator>,
    pub physical_device: vk::PhysicalDevice,
    pub instance: ash::Instance,
    /// Owner of the instance.
    pub root: Instance,
}

impl Context {
    /// Creates a device with these queues and extensions.
    pub fn new(
        root: Instance,
        physical_device: vk::PhysicalDevice,
        queues: &[vk::DeviceQueueCreateInfo],
        extensions: &[*const c_char],
    ) -> Result<Self> {
        let features = requirements::features();
        let info = vk::DeviceCreateInfo::default()
            .queue_create_infos(queues)
            .enabled_extension_names(extensions)
            .enabled_features(&features);
        // SAFETY: the physical device is from this instance, and has the queues and the extensions.
        let device = unsafe { root.handle.create_device(physical_device, &info, None)? };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: root.handle.clone(),
            device: device.clone(),
            physical_device,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: Default::default(),
        })?;
        let (allocator, instance) = (Some(allocator), root.handle.clone());
        Ok(Self { device, allocator, physical_device, instance, root })
    }

    pub fn allocator(&mut self) -> &mut Allocator {
        self.allocator.as_mut().expect("the allocator lives as long as the device")
    }

    /// Returns all messages of the validation layers so far.
    pub fn messages(&self) -> Vec<String> {
        self.root.messages()
    }

    pub fn properties(&self) -> vk::PhysicalDeviceProperties {
        // SAFETY: the physical device is from this instance.
        unsafe { self.instance.get_physical_device_properties(self.physical_device) }
    }

    /// Waits until the device is idle.
    pub fn wait(&self) {
        // SAFETY: the device is alive. If it is lost, there is nothing to wait for.
        let _ = unsafe { self.device.device_wait_idle() };
    }

    /// Destroys the device, after everything that was created from it. Returns the names of allocations that were left
    /// behind.
    pub fn close_device(&mut self) -> Vec<String> {
        let left = self.allocator().generate_report().allocations;
        self.wait();
        self.allocator = None;
        // SAFETY: nothing is in flight, and nothing is left that was created from the device.
        unsafe { self.device.destroy_device(None) };
        left.into_iter().map(|allocation| allocation.name).collect()
    }
}
