//! What can go wrong, said so that the message tells what to do.

use crate::surface::{SourceError, SurfaceError};
use crate::update::Unsuited;
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
    /// Distances do not fit memory.
    #[error(
        "{rows} rows of {points} distances need {} MiB of memory, which cannot be had; compute \
         fewer rows at a time",
        .rows.saturating_mul(*.points).saturating_mul(size_of::<f32>()) >> 20
    )]
    Memory {
        /// Number of rows.
        rows: usize,
        /// Distances of a row.
        points: usize,
    },
    /// A map does not fit memory.
    #[error(
        "the map of a grid of {points} points needs {} MiB of memory beside the surface, which \
         cannot be had; take a coarser grid or a part of the surface",
        .bytes >> 20
    )]
    MapMemory {
        /// Number of points of the grid.
        points: usize,
        /// Bytes that are needed at most.
        bytes: usize,
    },
    /// An option is out of its range.
    #[error("{0}")]
    Options(String),
}

impl From<Unsuited> for Error {
    fn from(unsuited: Unsuited) -> Self {
        Self::Options(unsuited.to_string())
    }
}
