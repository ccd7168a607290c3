//! What can go wrong, said so that the message tells what to do.

use crate::surface::{SourceError, SurfaceError};
use crate::vulkan::VulkanError;

/// Any failure of the crate's one-call interface, [`crate::distance_map`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The surface cannot be used.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A source does not lie on the surface.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The Vulkan engine was asked for and cannot run.
    #[error(transparent)]
    Vulkan(#[from] VulkanError),
    /// An option is out of its range.
    #[error("{0}")]
    Options(String),
}
