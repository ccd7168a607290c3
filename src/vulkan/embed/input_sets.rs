//! Manages the descriptor sets of an input that the host may replace with another buffer or image. An input
//! has one set more than the surface has slots. The sets take turns, so that frames in flight keep their
//! sets.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use ash::vk;

use super::flight::Flight;
use super::host_sets::{self, Content, HostSet};
use crate::vulkan::VulkanError;

/// Descriptor sets of one input.
#[derive(Debug)]
pub(super) struct InputSet {
    versions: Box<[Version]>,
    current: usize,
    /// Number of times that the input was replaced.
    pub(super) changes: u32,
}

#[derive(Debug)]
struct Version {
    set: HostSet,
    /// Serial of the last recording that reads the set.
    used: AtomicU32,
}

/// Returns the number of sets of each input on a surface with this many slots.
pub(super) fn versions(slots: usize) -> usize {
    slots.max(1) + 1
}

impl InputSet {
    /// Creates `inputs` inputs. Each takes the next `versions` sets of the iterator.
    pub(super) fn each(
        inputs: usize,
        versions: usize,
        sets: &mut impl Iterator<Item = HostSet>,
    ) -> Vec<Self> {
        let mut next = || {
            let sets = sets.by_ref().take(versions);
            let versions = sets.map(|set| Version { set, used: 0.into() }).collect();
            Self { versions, current: 0, changes: 0 }
        };
        (0..inputs).map(|_| next()).collect()
    }

    /// Returns the set to bind.
    pub(super) fn set(&self) -> HostSet {
        self.versions[self.current].set
    }

    /// Notes that a recording reads the input. The serial of the recording is the next one that is given out.
    pub(super) fn is_read(&self, flight: &Flight) {
        self.versions[self.current].used.store(flight.coming(), Relaxed);
    }

    /// Notes that a recording writes the host's image. With `has_note` the serial of the recording is the
    /// next one that is given out. Otherwise the last serial covers the recording. If the slot's outcome was
    /// recorded before, this is the serial of the outcome.
    pub(super) fn is_written(&self, flight: &Flight, has_note: bool) {
        let serial = if has_note { flight.coming() } else { flight.last() };
        self.versions[self.current].used.store(serial, Relaxed);
    }

    /// Returns whether a tracked recording that reads the input may not have run.
    pub(super) fn is_in_flight(&self, flight: &Flight) -> bool {
        self.versions.iter().any(|version| flight.waits_for(version.used.load(Relaxed)))
    }

    /// Replaces the input. The new content goes into a set that no tracked recording in flight reads.
    pub(super) fn replace(
        &mut self,
        device: &ash::Device,
        flight: &Flight,
        (what, number): (&'static str, usize),
        content: Content,
    ) -> Result<(), VulkanError> {
        let count = self.versions.len();
        let mut others = (1..=count).map(|next| (self.current + next) % count);
        let free = others.find(|&at| !flight.waits_for(self.versions[at].used.load(Relaxed)));
        let Some(free) = free else {
            return Err(VulkanError::InputInFlight { what, number });
        };
        let set: vk::DescriptorSet = self.versions[free].set.set;
        self.versions[free] =
            Version { set: host_sets::fill(device, set, content), used: 0.into() };
        self.current = free;
        self.changes = self.changes.wrapping_add(1);
        Ok(())
    }
}
