//! Labels passes and names objects, for debuggers and profilers that show them.

use std::ffi::CStr;
use std::fmt::{self, Display, Formatter};

use ash::{ext, vk};

/// Functions of `VK_EXT_debug_utils`. A value exists only if the instance has enabled that extension.
#[derive(Clone)]
pub(crate) struct Labels(ext::debug_utils::Device);

impl fmt::Debug for Labels {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("Labels")
    }
}

impl Labels {
    /// Loads the functions. The instance must have `VK_EXT_debug_utils` enabled.
    pub(crate) fn new(instance: &ash::Instance, device: &ash::Device) -> Self {
        Self(ext::debug_utils::Device::new(instance, device))
    }

    /// Begins a label, under which tools show the commands until the returned value is dropped.
    pub(crate) fn group<'a>(&'a self, commands: vk::CommandBuffer, label: &CStr) -> Group<'a> {
        let label = vk::DebugUtilsLabelEXT::default().label_name(label);
        // SAFETY: the command buffer is being recorded on this device.
        unsafe { self.0.cmd_begin_debug_utils_label(commands, &label) };
        Group { labels: self, commands }
    }

    /// Names an object. Names are only for people who debug, so failures are ignored.
    pub(crate) fn name(&self, object: impl vk::Handle, name: &str) {
        let text: Vec<u8> = name.bytes().chain([0]).collect();
        let Ok(text) = CStr::from_bytes_with_nul(&text) else { return };
        let info =
            vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(text);
        // SAFETY: the object belongs to this device.
        let _ = unsafe { self.0.set_debug_utils_object_name(&info) };
    }
}

/// Name of an object, and of the surface to which it belongs. The latter is empty if a device has a single surface.
pub(crate) struct NameOf<'a>(pub(crate) &'a str, pub(crate) &'a str);

impl Display for NameOf<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self(name, owner) = *self;
        match owner {
            "" => f.write_str(name),
            _ => write!(f, "{name} of {owner}"),
        }
    }
}

/// A label that is open until this value is dropped.
#[must_use]
pub(crate) struct Group<'a> {
    labels: &'a Labels,
    commands: vk::CommandBuffer,
}

impl Drop for Group<'_> {
    fn drop(&mut self) {
        // SAFETY: the label was begun in the same command buffer.
        unsafe { self.labels.0.cmd_end_debug_utils_label(self.commands) };
    }
}
