//! Messages of the validation layers.

use std::ffi::{CStr, c_void};
use std::sync::atomic::{AtomicUsize, Ordering};

use geosweep::ash::{self, ext, vk};

use crate::Result;

/// Name of the layer.
pub const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";
/// Checks beyond the default ones.
pub const ENABLED: [vk::ValidationFeatureEnableEXT; 1] =
    [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];

/// Prints messages and counts them.
pub struct Messenger {
    loader: ext::debug_utils::Instance,
    handle: vk::DebugUtilsMessengerEXT,
    count: Box<AtomicUsize>,
}

impl Messenger {
    pub fn new(entry: &ash::Entry, instance: &ash::Instance) -> Result<Self> {
        let count = Box::new(AtomicUsize::new(0));
        let loader = ext::debug_utils::Instance::new(entry, instance);
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
                    | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
            .pfn_user_callback(Some(print))
            .user_data(std::ptr::from_ref::<AtomicUsize>(&count).cast_mut().cast());
        // SAFETY: the count is on the heap and outlives the messenger.
        let handle = unsafe { loader.create_debug_utils_messenger(&info, None)? };
        Ok(Self { loader, handle, count })
    }

    /// Destroys the messenger, after the device. Returns the number of messages.
    pub fn destroy(self) -> usize {
        // SAFETY: nothing uses the messenger any more.
        unsafe { self.loader.destroy_debug_utils_messenger(self.handle, None) };
        self.count.load(Ordering::Relaxed)
    }
}

unsafe extern "system" fn print(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    count: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layers pass a valid message, and the pointer with which the messenger was created.
    let (text, count) =
        unsafe { (CStr::from_ptr((*data).p_message), &*count.cast::<AtomicUsize>()) };
    eprintln!("validation: {}", text.to_string_lossy());
    count.fetch_add(1, Ordering::Relaxed);
    vk::FALSE
}
