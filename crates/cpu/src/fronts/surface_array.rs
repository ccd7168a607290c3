//! Stores the data that a kind of front needs at each point of a surface.

use std::ops::Deref;
use std::sync::Arc;

/// Data of each point of a surface, as a bordered array.
#[derive(Clone, Debug)]
pub(crate) enum SurfaceArray<G> {
    /// An array that is stored with the edge lengths.
    OfEdges(Arc<Vec<G>>),
    Own(Vec<G>),
}

impl<G> SurfaceArray<G> {
    /// Returns the memory in bytes, without the data stored with the edge lengths.
    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::OfEdges(_) => 0,
            Self::Own(data) => size_of_val(data.as_slice()),
        }
    }
}

impl<G> Deref for SurfaceArray<G> {
    type Target = [G];

    fn deref(&self) -> &[G] {
        match self {
            Self::OfEdges(data) => data,
            Self::Own(data) => data,
        }
    }
}
