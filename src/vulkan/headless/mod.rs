//! The solver without a renderer. It brings its own device, command buffers and allocator.

pub(in crate::vulkan) mod ceilings;
pub(in crate::vulkan) mod context;
#[cfg(test)]
mod group_orders;
mod kept;
pub(in crate::vulkan) mod solver;
mod solving;
pub(in crate::vulkan) mod surface_on_device;
#[cfg(test)]
pub(in crate::vulkan) mod testing;
mod upload_surface;

pub use ceilings::DeviceCeilings;
pub use kept::keep_devices;
pub(crate) use kept::with_device;
pub use solver::HeadlessSolver;
pub use solving::HeadlessSolution;
pub use surface_on_device::SurfaceOnDevice;
