//! Finds what the host selects by number: a slot, points, a source buffer or a lookup.

use crate::vulkan::VulkanError;

/// Returns the entry with this number, or an error that says how many there are.
pub(super) fn nth<'a, T>(
    all: &'a [T],
    what: &'static str,
    number: usize,
) -> Result<&'a T, VulkanError> {
    all.get(number).ok_or(VulkanError::NoSuch { what, number, count: all.len() })
}
