//! State that a solver shares with its surfaces, plans and other objects.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::vk;

use super::memory::Memory;
use geosweep::vulkan::embed;

/// Implements conversions between structs of the library and of the header that have the same fields.
macro_rules! same_fields {
    ($($from:ty => $to:ty { $($field:ident),* };)*) => {$(
        impl From<$from> for $to {
            fn from(of: $from) -> Self {
                Self { $($field: of.$field),* }
            }
        }
    )*};
}
pub(super) use same_fields;

/// State that a solver shares with all objects that it creates.
pub(super) struct Shared {
    pub(super) instance: ash::Instance,
    pub(super) physical_device: vk::PhysicalDevice,
    pub(super) device: ash::Device,
    pub(super) solver: embed::Solver,
    pub(super) allocator: Mutex<Memory>,
    pub(super) checks: bool,
}

/// Object of a solver.
pub(super) struct Made<T> {
    pub(super) shared: Arc<Shared>,
    pub(super) of: T,
}

impl<T> AsRef<Shared> for Made<T> {
    fn as_ref(&self) -> &Shared {
        &self.shared
    }
}

impl Shared {
    /// Returns whether the program has set `GEOSWEEP_SOLVER_CHECKS`.
    pub(super) fn has_checks(&self) -> bool {
        self.checks
    }

    pub(super) fn allocator(&self) -> MutexGuard<'_, Memory> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
