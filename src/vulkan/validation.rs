//! The Khronos validation layers: collected messages of a device's life.

use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, PoisonError};

use ash::{ext, vk};

use super::VulkanError;

pub(crate) const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// The checks turned on beside the layer's usual ones.
pub(crate) const FEATURES: [vk::ValidationFeatureEnableEXT; 2] = [
    vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION,
    vk::ValidationFeatureEnableEXT::GPU_ASSISTED,
];

/// Warnings and errors of the validation layers, in the order in which they came. Clones share
/// one log, which outlives the device: what the layers say while it is destroyed is in it too.
#[derive(Clone, Debug, Default)]
pub struct ValidationLog(Arc<Mutex<Vec<String>>>);

impl ValidationLog {
    /// The messages so far.
    pub fn messages(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn push(&self, message: String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(message);
    }
}

/// A debug messenger that fills a log.
pub(crate) struct Messenger {
    loader: ext::debug_utils::Instance,
    messenger: vk::DebugUtilsMessengerEXT,
    /// Boxed, since the callback keeps its address.
    log: Box<ValidationLog>,
}

impl Messenger {
    pub(crate) fn new(entry: &ash::Entry, instance: &ash::Instance) -> Result<Self, VulkanError> {
        let log = Box::new(ValidationLog::default());
        let loader = ext::debug_utils::Instance::new(entry, instance);
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
                    | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
            .pfn_user_callback(Some(collect))
            .user_data(std::ptr::from_ref::<ValidationLog>(&log).cast_mut().cast());
        // SAFETY: the log is boxed and lives until the messenger is destroyed.
        let messenger = unsafe { loader.create_debug_utils_messenger(&info, None) }
            .map_err(VulkanError::from_call("vkCreateDebugUtilsMessengerEXT"))?;
        Ok(Self { loader, messenger, log })
    }

    pub(crate) fn log(&self) -> &ValidationLog {
        &self.log
    }

    /// Destroys it, before the instance.
    pub(crate) fn destroy(&mut self) {
        // SAFETY: the instance is alive, and no call that could report is under way.
        unsafe { self.loader.destroy_debug_utils_messenger(self.messenger, None) };
    }
}

unsafe extern "system" fn collect(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    log: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data, and the log that was given to it.
    let (message, log) = unsafe {
        let text = (*data).message_as_c_str().unwrap_or(c"").to_string_lossy();
        (text.into_owned(), &*log.cast::<ValidationLog>())
    };
    if !is_about_the_layer_itself(&message) {
        // Printed as they come too, since a crashing driver takes the log with it.
        eprintln!("validation: {message}");
        log.push(message);
    }
    vk::FALSE
}

/// What the layers say of their own set-up is no finding.
fn is_about_the_layer_itself(message: &str) -> bool {
    message.contains("GPU-Assisted Validation") && message.contains("not enabled")
}
