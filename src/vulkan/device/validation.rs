//! Enables the Khronos validation layers and collects their messages over a device's life.

use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, PoisonError};

use ash::{ext, vk};

use super::requirements::have;
use crate::vulkan::VulkanError;

pub(crate) const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Checks that are enabled in addition to the layer's defaults.
const FEATURES: [vk::ValidationFeatureEnableEXT; 2] = [
    vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION,
    vk::ValidationFeatureEnableEXT::GPU_ASSISTED,
];

/// Returns the checks that are enabled in addition to the layer's defaults. GPU-assisted validation adds code to
/// shaders. It is left out if the layer's own environment variable turns the checks of shaders off.
pub(crate) fn features() -> &'static [vk::ValidationFeatureEnableEXT] {
    let disabled = std::env::var_os("VK_LAYER_DISABLES").unwrap_or_default();
    match disabled.to_string_lossy().contains("VK_VALIDATION_FEATURE_DISABLE_SHADERS_EXT") {
        true => &FEATURES[..1],
        false => &FEATURES,
    }
}

/// Returns settings of the layer. Since version 1.3.290 the layer reports hazards between accesses of shaders
/// only if this is requested.
pub(crate) fn settings() -> [vk::LayerSettingEXT<'static>; 1] {
    let setting = vk::LayerSettingEXT::default()
        .layer_name(LAYER)
        .setting_name(c"syncval_shader_accesses_heuristic")
        .ty(vk::LayerSettingTypeEXT::BOOL32);
    [vk::LayerSettingEXT {
        value_count: 1,
        p_values: std::ptr::from_ref(&vk::TRUE).cast(),
        ..setting
    }]
}

/// Returns whether the layer takes settings from a program. Older layers do not know the structure.
pub(crate) fn takes_settings(entry: &ash::Entry) -> bool {
    // SAFETY: the name is a string.
    let offered = unsafe { entry.enumerate_instance_extension_properties(Some(LAYER)) };
    have(&offered.unwrap_or_default(), ext::layer_settings::NAME)
}

/// Warnings and errors of the validation layers, in the order in which they came. Clones share one log. The
/// log outlives the device, so that it also contains what the layers report while the device is destroyed.
#[derive(Clone, Debug, Default)]
pub struct ValidationLog(Arc<Mutex<Vec<String>>>);

impl ValidationLog {
    /// Returns the messages so far.
    pub fn messages(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn push(&self, message: String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(message);
    }
}

/// Returns the description of a messenger that writes to `log`. If an instance is created with it, the log
/// also receives the messages of the instance's creation and destruction. Otherwise the layers print these
/// messages among the program's output. The log must not move, and must outlive the instance.
pub(crate) fn messages_to(log: &ValidationLog) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(
            vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
                | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
        )
        .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
        .pfn_user_callback(Some(collect))
        .user_data(std::ptr::from_ref(log).cast_mut().cast())
}

/// Debug messenger that fills a log.
pub(crate) struct Messenger {
    loader: ext::debug_utils::Instance,
    messenger: vk::DebugUtilsMessengerEXT,
    /// Log of the messages. It is boxed because the callback holds its address.
    log: Box<ValidationLog>,
}

impl Messenger {
    /// Creates a messenger for a log with which the instance was created.
    pub(crate) fn new(
        entry: &ash::Entry,
        instance: &ash::Instance,
        log: Box<ValidationLog>,
    ) -> Result<Self, VulkanError> {
        let loader = ext::debug_utils::Instance::new(entry, instance);
        // SAFETY: the log is boxed and lives until the messenger is destroyed.
        let messenger = unsafe { loader.create_debug_utils_messenger(&messages_to(&log), None) }
            .map_err(VulkanError::from_call("vkCreateDebugUtilsMessengerEXT"))?;
        Ok(Self { loader, messenger, log })
    }

    pub(crate) fn log(&self) -> &ValidationLog {
        &self.log
    }

    /// Destroys the messenger. This must happen before the instance is destroyed.
    pub(crate) fn destroy(&mut self) {
        // SAFETY: the instance is alive, and no call that could report is under way.
        unsafe { self.loader.destroy_debug_utils_messenger(self.messenger, None) };
    }
}

unsafe extern "system" fn collect(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    log: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data, and the log that was given to it.
    let (id, text, log) = unsafe {
        let id = (*data).message_id_name_as_c_str().unwrap_or(c"").to_string_lossy();
        let text = (*data).message_as_c_str().unwrap_or(c"").to_string_lossy();
        (id, text, &*log.cast::<ValidationLog>())
    };
    if !is_about_the_layer_itself(severity, &id) {
        // In older layers the text contains the message's identifier. In newer ones the identifier is only a
        // separate field.
        let message = match text.contains(&*id) {
            true => text.into_owned(),
            false => format!("[ {id} ] {text}"),
        };
        // Messages are also printed as they come, since a crashing driver takes the log with it. They are not
        // printed while the thread panics: failing code leaves objects behind, and messages about these would
        // hide the reason.
        if !std::thread::panicking() {
            eprintln!("validation: {message}");
        }
        log.push(message);
    }
    vk::FALSE
}

/// Returns whether a message is about the layers' own set-up, which is no finding. Such messages say which
/// features the layers enable for themselves, and which checks they omit because a feature is missing.
fn is_about_the_layer_itself(severity: vk::DebugUtilsMessageSeverityFlagsEXT, id: &str) -> bool {
    let of_layers = ["WARNING-GPU-Assisted", "UNASSIGNED-GPU-Assisted", "VALIDATION-SETTINGS"];
    severity == vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
        && of_layers.iter().any(|start| id.starts_with(start))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn set_up_is_no_finding_whatever_its_words_and_errors_always_are() {
        type Severity = vk::DebugUtilsMessageSeverityFlagsEXT;
        for id in ["WARNING-GPU-Assisted-Validation", "UNASSIGNED-GPU-Assisted Validation. "] {
            assert!(is_about_the_layer_itself(Severity::WARNING, id));
            assert!(!is_about_the_layer_itself(Severity::ERROR, id));
        }
        for id in ["SYNC-HAZARD-READ-AFTER-WRITE", "VUID-vkCmdDispatch-groupCountX-00386", ""] {
            assert!(!is_about_the_layer_itself(Severity::WARNING, id));
        }
    }
}
