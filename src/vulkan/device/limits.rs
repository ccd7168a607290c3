//! Checks whether a grid fits the images and the memory of a device.

use ash::vk;

use super::requirements;
use crate::constants::{BORDER, LAYERS, MOST_GROUPS};
use crate::surface::Chart;
use crate::vulkan::{TexelChart, VulkanError};

/// Returns the number of workgroups in a column if `count` workgroups are arranged in columns. There are at
/// most `MOST_GROUPS` columns, which every device accepts.
pub(crate) fn column_of(count: u32) -> u32 {
    count.div_ceil(MOST_GROUPS).max(1)
}

/// Limits of a device's images and memory.
#[derive(Clone, Debug)]
pub(crate) struct Limits {
    /// Name of the device.
    device: String,
    pub(crate) kind: vk::PhysicalDeviceType,
    /// Largest side of an image, in texels.
    side: u32,
    /// Largest size of an image, in bytes.
    largest_image: u64,
    /// Size of the largest heap, in bytes.
    pub(crate) heap: u64,
    /// Largest range of a buffer that a shader can access, in bytes.
    pub(crate) storage_range: u64,
}

impl Limits {
    /// Reads the limits of a device that meets the requirements.
    pub(crate) fn of(instance: &ash::Instance, physical_device: vk::PhysicalDevice) -> Self {
        // SAFETY: the physical device is from this instance.
        let (properties, memory) = unsafe {
            (
                instance.get_physical_device_properties(physical_device),
                instance.get_physical_device_memory_properties(physical_device),
            )
        };
        let (side, largest_image) =
            requirements::largest_side(instance, physical_device).unwrap_or_default();
        let name = properties.device_name_as_c_str().unwrap_or(c"unnamed");
        Self {
            device: name.to_string_lossy().into_owned(),
            kind: properties.device_type,
            side,
            largest_image,
            heap: memory.memory_heaps_as_slice().iter().map(|heap| heap.size).max().unwrap_or(0),
            storage_range: properties.limits.max_storage_buffer_range.into(),
        }
    }

    /// Returns the texels of a grid, or an error if the grid does not fit the device.
    pub(crate) fn texels(&self, chart: Chart) -> Result<TexelChart, VulkanError> {
        let (rows, cols, device) = (chart.rows, chart.cols, self.device.clone());
        let texels = TexelChart::new(chart).filter(|texels| {
            let extent = texels.edges_extent();
            extent.width <= self.side && extent.height <= self.side
        });
        let Some(texels) = texels else {
            let limit = self.side.saturating_sub(4 * BORDER) as usize;
            return Err(VulkanError::TooLarge { rows, cols, device, limit });
        };
        let bytes = |extent: vk::Extent3D| u64::from(extent.width) * u64::from(extent.height) * 16;
        let edges = bytes(texels.edges_extent());
        let fronts = u64::from(LAYERS) * bytes(texels.fronts_extent());
        let gaussian = bytes(texels.fronts_extent());
        let needed = edges + gaussian + 2 * fronts;
        // Some drivers do not refuse allocations that do not fit. The system then ends the process.
        if needed > self.heap || edges > self.largest_image {
            let image = if edges > self.largest_image { self.largest_image } else { self.heap };
            let available = self.heap.min(image) >> 20;
            let needed = needed >> 20;
            return Err(VulkanError::TooMuchMemory { rows, cols, device, needed, available });
        }
        Ok(texels)
    }
}
