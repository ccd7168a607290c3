//! State that a solver shares with its surfaces, plans and other objects.

use std::sync::{Mutex, MutexGuard, PoisonError};

use ash::vk;

use super::memory::Memory;
use crate::vulkan::embed;

/// State that a solver shares with all objects that it creates.
pub(super) struct Shared {
    pub(super) instance: ash::Instance,
    pub(super) physical_device: vk::PhysicalDevice,
    pub(super) device: ash::Device,
    pub(super) solver: embed::Solver,
    pub(super) allocator: Mutex<Memory>,
    pub(super) checks: bool,
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
