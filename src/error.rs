//! The errors of the one-call interface. Messages say how to correct the input, where the caller can.

use crate::Cancelled;
use crate::surface::{SourceError, SurfaceError, Unresolved};
use crate::update::Unsuited;
#[cfg(feature = "vulkan")]
use crate::vulkan::VulkanError;

/// Any failure of [`crate::distance_map`] and of the other functions that compute maps, such as those of
/// [`crate::pairwise`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The surface cannot be used.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The sources cannot be used: there is none, one does not lie on the surface, or one has an unusable value.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The Vulkan engine was requested and cannot run.
    #[cfg(feature = "vulkan")]
    #[error(transparent)]
    Vulkan(#[from] VulkanError),
    /// The distances do not fit into memory.
    #[error(
        "{rows} rows of {points} distances need {} MiB of memory, more than is available; compute \
         fewer rows at a time",
        .rows.saturating_mul(*.points).saturating_mul(size_of::<f32>()) >> 20
    )]
    Memory {
        /// Number of rows.
        rows: usize,
        /// Number of distances in a row.
        points: usize,
    },
    /// The map does not fit into memory.
    #[error(
        "the map of a grid of {points} points needs {} MiB of memory in addition to the surface, more than \
         is available; take a coarser grid or a part of the surface",
        .bytes >> 20
    )]
    MapMemory {
        /// Number of points of the grid.
        points: usize,
        /// Largest number of bytes that the map needs.
        bytes: usize,
    },
    /// The computation was cancelled by its [`crate::Monitor`].
    #[error("{Cancelled}")]
    Cancelled,
    /// The error of the map cannot be estimated: all grids would be late alike.
    #[error(
        "the error cannot be estimated: {0}. Choose rows or columns along the direction in which lengths are short"
    )]
    Unresolved(Unresolved),
    /// An option is out of its range, or does not suit the surface, the sources, the engine or the precision.
    #[error("{0}")]
    Options(String),
}

impl From<Cancelled> for Error {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<Unsuited> for Error {
    fn from(unsuited: Unsuited) -> Self {
        Self::Options(unsuited.to_string())
    }
}
