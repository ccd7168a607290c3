//! The solver without a renderer. It brings its own device, command buffers and allocator.

pub(in crate::vulkan) mod ceilings;
pub(in crate::vulkan) mod context;
#[cfg(test)]
mod group_orders;
pub(in crate::vulkan) mod solver;
mod solving;
pub(in crate::vulkan) mod surface_on_device;
mod upload_surface;

use crate::surface::{GluingError, Surface, SurfaceError};

/// Returns an error on glued surfaces: no pass exchanges fronts between the copies of a point yet. Such a pass
/// would read [`Surface::copies`] and follow each scan, or each round of tiles.
pub(crate) fn check_open(surface: &Surface) -> Result<(), super::VulkanError> {
    let instead = "let the CPU compute the map";
    let checked: Result<(), GluingError> = surface.check_open("the Vulkan engine", instead);
    Ok(checked.map_err(SurfaceError::from)?)
}

pub use ceilings::DeviceCeilings;
pub use solver::HeadlessSolver;
pub use solving::HeadlessSolution;
pub use surface_on_device::SurfaceOnDevice;
