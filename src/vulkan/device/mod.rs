//! Access to a device that all solvers share: its choice and limits, memory, barriers, descriptors, and the
//! table of passes with their shaders and pipelines.

pub(in crate::vulkan) mod bands;
pub(in crate::vulkan) mod barrier;
pub(in crate::vulkan) mod descriptors;
pub(in crate::vulkan) mod device_memory;
pub(in crate::vulkan) mod devices;
pub(in crate::vulkan) mod driver;
pub(in crate::vulkan) mod instance;
pub(in crate::vulkan) mod labels;
pub(in crate::vulkan) mod limits;
pub(crate) mod memory;
pub(in crate::vulkan) mod memory_types;
pub(in crate::vulkan) mod passes;
pub(in crate::vulkan) mod pipeline_store;
pub(in crate::vulkan) mod pipelines;
pub mod requirements;
pub(in crate::vulkan) mod shaders;
pub(in crate::vulkan) mod staging;
pub(in crate::vulkan) mod tile_lanes;
pub(in crate::vulkan) mod validation;
