//! Manages descriptor sets of memory that the host may replace with another buffer or image. The sets have one version
//! more than the surface has slots. The versions are used in turn, so that frames in flight keep their sets.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use super::host_sets::{self, Content, HostSet};
use crate::vulkan::flight::Flight;

/// Descriptor sets in several versions, of one input of a surface or of an output.
#[derive(Debug)]
pub(super) struct Versions {
    versions: Box<[Version]>,
    current: usize,
    /// Number of times that the contents were replaced.
    pub(super) changes: u32,
}

#[derive(Debug)]
struct Version {
    sets: Box<[HostSet]>,
    /// Serial of the last recording that uses the sets; 0 if it is not tracked.
    used: AtomicU32,
}

/// Returns the number of versions on a surface with this many slots.
pub(super) fn versions(slots: usize) -> usize {
    slots.max(1) + 1
}

impl Versions {
    /// Creates the versions from the sets of each of them.
    pub(super) fn new<'a>(versions: impl Iterator<Item = &'a [HostSet]>) -> Self {
        let version = |sets: &[HostSet]| Version { sets: sets.into(), used: 0.into() };
        Self { versions: versions.map(version).collect(), current: 0, changes: 0 }
    }

    /// Creates inputs from their sets, of which each input has `versions`.
    pub(super) fn of_inputs(sets: &[HostSet], versions: usize) -> Vec<Self> {
        sets.chunks(versions).map(|sets| Self::new(sets.chunks(1))).collect()
    }

    /// Returns the sets to bind.
    pub(super) fn sets(&self) -> &[HostSet] {
        &self.versions[self.current].sets
    }

    /// Returns the set of an input to bind.
    pub(super) fn set(&self) -> HostSet {
        self.sets()[0]
    }

    /// Notes that the recording with this serial uses the current sets.
    pub(super) fn are_used_by(&self, serial: u32) {
        self.versions[self.current].used.store(serial, Relaxed);
    }

    /// Notes that a recording reads the input. The next serial belongs to this recording.
    pub(super) fn is_read(&self, flight: &Flight) {
        self.are_used_by(flight.coming());
    }

    /// Notes that a recording writes the host's image. With `has_note` the next serial belongs to the recording.
    /// Otherwise the last serial covers it, which is that of the slot's outcome if the outcome was recorded before.
    pub(super) fn is_written(&self, flight: &Flight, has_note: bool) {
        self.are_used_by(if has_note { flight.coming() } else { flight.last() });
    }

    /// Returns whether a tracked recording that uses a version may still be pending.
    pub(super) fn are_in_flight(&self, flight: &Flight) -> bool {
        self.versions.iter().any(|of| flight.waits_for(of.used.load(Relaxed)))
    }

    /// Replaces the contents, in a version that no tracked recording in flight uses. Returns false if there is none.
    pub(super) fn replace(
        &mut self,
        device: &ash::Device,
        flight: &Flight,
        contents: &[Content],
    ) -> bool {
        let count = self.versions.len();
        let mut others = (1..=count).map(|next| (self.current + next) % count);
        let free = others.find(|&at| !flight.waits_for(self.versions[at].used.load(Relaxed)));
        let Some(free) = free else { return false };
        let of = &mut self.versions[free];
        for (set, content) in of.sets.iter_mut().zip(contents) {
            *set = host_sets::fill(device, set.set, *content);
        }
        of.used = 0.into();
        self.current = free;
        self.changes = self.changes.wrapping_add(1);
        true
    }
}
