//! How large a grid a device takes.

use ash::vk;

use super::{TexelChart, VulkanError, requirements};
use crate::constants::{BORDER, LAYERS};
use crate::surface::Chart;

/// What a device's images and memory hold.
#[derive(Clone, Debug)]
pub(crate) struct Limits {
    /// The device's name.
    device: String,
    pub(crate) kind: vk::PhysicalDeviceType,
    /// Texels on a side of an image.
    side: u32,
    /// Bytes of an image.
    largest_image: u64,
    /// Bytes of the largest heap.
    pub(crate) heap: u64,
    /// Bytes of a buffer that a shader sees.
    pub(crate) storage_range: u64,
}

impl Limits {
    /// Of a device that meets the requirements.
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

    /// The texels of a grid that fits the device.
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
        // Not all drivers refuse what does not fit: on some the system ends the process instead.
        if needed > self.heap || edges > self.largest_image {
            let image = if edges > self.largest_image { self.largest_image } else { self.heap };
            let available = self.heap.min(image) >> 20;
            let needed = needed >> 20;
            return Err(VulkanError::TooMuchMemory { rows, cols, device, needed, available });
        }
        Ok(texels)
    }
}
