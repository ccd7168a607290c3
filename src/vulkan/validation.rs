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

/// Layers since 1.3.290 tell of hazards between accesses of shaders only if they are asked to.
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

/// Whether the layer takes settings from a program. Older ones do not know the structure.
pub(crate) fn takes_settings(entry: &ash::Entry) -> bool {
    // SAFETY: the name is a string.
    let offered = unsafe { entry.enumerate_instance_extension_properties(Some(LAYER)) };
    let is_wanted = |extension: &vk::ExtensionProperties| {
        extension.extension_name_as_c_str() == Ok(ext::layer_settings::NAME)
    };
    offered.unwrap_or_default().iter().any(is_wanted)
}

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

/// Where messages go: also those of an instance's creation and destruction, if it is told of this. Else layers print
/// them, among what a program does. The log, which keeps its address, is to outlive the instance.
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

/// A debug messenger that fills a log.
pub(crate) struct Messenger {
    loader: ext::debug_utils::Instance,
    messenger: vk::DebugUtilsMessengerEXT,
    /// Boxed, since the callback keeps its address.
    log: Box<ValidationLog>,
}

impl Messenger {
    /// With a log that the instance has been told of.
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

    /// Destroys it, before the instance.
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
        // Older layers name it in the text, newer ones beside it.
        let message = match text.contains(&*id) {
            true => text.into_owned(),
            false => format!("[ {id} ] {text}"),
        };
        // Printed as they come too, since a crashing driver takes the log with it.
        // What is left behind by code that fails is no news, and the reason would drown.
        if !std::thread::panicking() {
            eprintln!("validation: {message}");
        }
        log.push(message);
    }
    vk::FALSE
}

/// What the layers say of their own set-up is no finding: which features they turn on for themselves, and which
/// checks they leave out for want of one.
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
