//! Creates the Vulkan instance that this crate owns.

use ash::{ext, khr, vk};

use super::requirements::{API_VERSION, have};
use super::validation;
use super::validation::{Messenger, ValidationLog};
use crate::vulkan::VulkanError;

/// Vulkan loader and instance, with the validation layers if requested.
pub(crate) struct Instance {
    // The entry keeps the loader's library in memory.
    _entry: ash::Entry,
    pub(crate) handle: ash::Instance,
    messenger: Option<Messenger>,
    /// Whether `VK_EXT_debug_utils` is enabled for labels and names that tools show.
    pub(crate) debug_utils: bool,
}

impl Instance {
    pub(crate) fn new(validate: bool) -> Result<Self, VulkanError> {
        Self::open(validate, false)
    }

    /// Creates an instance. If `labels` is set, labels and names for tools are enabled where the loader
    /// offers them.
    pub(crate) fn open(validate: bool, labels: bool) -> Result<Self, VulkanError> {
        // SAFETY: the loader's library is the system's own and is kept loaded by the entry.
        let entry = unsafe { ash::Entry::load() }
            .map_err(|error| VulkanError::NoLoader(error.to_string()))?;
        let application = vk::ApplicationInfo::default()
            .application_name(c"geosweep")
            .engine_name(c"geosweep")
            .api_version(API_VERSION);
        // SAFETY: no layer's name is passed, so no pointer needs to stay valid.
        let offered = unsafe { entry.enumerate_instance_extension_properties(None) };
        let offered = offered.unwrap_or_default();
        let offers = |name| have(&offered, name);
        let debug_utils = labels && offers(ext::debug_utils::NAME);
        let mut extensions = Vec::new();
        let mut info = vk::InstanceCreateInfo::default().application_info(&application);
        if validate || debug_utils {
            extensions.push(ext::debug_utils::NAME.as_ptr());
        }
        // Without this flag loaders hide devices that implement only the portable subset of Vulkan, such as
        // the devices of MoltenVK.
        if offers(khr::portability_enumeration::NAME) {
            extensions.push(khr::portability_enumeration::NAME.as_ptr());
            info.flags |= vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR;
        }
        let mut features = vk::ValidationFeaturesEXT::default()
            .enabled_validation_features(validation::features());
        let layers = [validation::LAYER.as_ptr()];
        let settings = validation::settings();
        let mut settings = vk::LayerSettingsCreateInfoEXT::default().settings(&settings);
        let log = Box::<ValidationLog>::default();
        let mut messages = validation::messages_to(&log);
        if validate {
            info = info.push_next(&mut messages);
            extensions.push(ext::validation_features::NAME.as_ptr());
            info = info.enabled_layer_names(&layers).push_next(&mut features);
            if validation::takes_settings(&entry) {
                extensions.push(ext::layer_settings::NAME.as_ptr());
                info = info.push_next(&mut settings);
            }
        }
        info = info.enabled_extension_names(&extensions);
        // SAFETY: all that the structures point to is alive.
        let handle = match unsafe { entry.create_instance(&info, None) } {
            Ok(handle) => handle,
            Err(vk::Result::ERROR_LAYER_NOT_PRESENT) => return Err(VulkanError::NoValidationLayer),
            Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) => return Err(VulkanError::NoDevice),
            Err(result) => return Err(VulkanError::Call { call: "vkCreateInstance", result }),
        };
        let mut new = Self { _entry: entry, handle, messenger: None, debug_utils };
        if validate {
            new.messenger = Some(Messenger::new(&new._entry, &new.handle, log)?);
        }
        Ok(new)
    }

    pub(crate) fn validation_log(&self) -> Option<&ValidationLog> {
        self.messenger.as_ref().map(Messenger::log)
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some(messenger) = &mut self.messenger {
            messenger.destroy();
        }
        // SAFETY: everything made from the instance is gone.
        unsafe { self.handle.destroy_instance(None) };
    }
}
