//! Recordings of several surfaces that share their barriers.
//!
//! Each recording is cut at its barriers. They are gone through as often as the longest has parts, and each time
//! one part of each is appended, then one barrier that does what the barriers after these parts do.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};

use ash::vk;

use super::commands::Commands;
use crate::vulkan::barrier::{self, Access, ImageBarrier};

/// Recordings that share barriers, at most: each brings at most one image to a barrier.
pub(crate) const MOST_TOGETHER: usize = 64;

/// Which part of recordings is appended.
#[derive(Debug, Default)]
pub(crate) struct Turn {
    wanted: AtomicU32,
    /// In which part the recording is that is gone through.
    part: AtomicU32,
    merged: Mutex<Merged>,
}

/// What the barriers after a part do, all together.
#[derive(Debug)]
struct Merged {
    is_there: bool,
    /// Stages on both sides, and accesses to all memory.
    before: Access,
    after: Access,
    images: [ImageBarrier; MOST_TOGETHER],
    count: usize,
}

impl Default for Merged {
    fn default() -> Self {
        let none = (vk::PipelineStageFlags::empty(), vk::AccessFlags::empty());
        let images = [ImageBarrier::default(); MOST_TOGETHER];
        Self { is_there: false, before: none, after: none, images, count: 0 }
    }
}

impl Turn {
    /// Whether it is the turn of the part that is gone through.
    pub(super) fn is_now(&self) -> bool {
        self.part.load(Relaxed) == self.wanted.load(Relaxed)
    }

    fn merged(&self) -> MutexGuard<'_, Merged> {
        self.merged.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A part ends with a barrier over all memory.
    pub(super) fn barrier(&self, before: Access, after: Access) {
        self.end_part(|merged| merged.widen(before, after));
    }

    /// A part ends with a barrier of an image.
    pub(super) fn image_barrier(&self, image: ImageBarrier) {
        self.end_part(|merged| {
            let none = vk::AccessFlags::empty();
            merged.widen((image.before.0, none), (image.after.0, none));
            merged.images[merged.count] = image;
            merged.count += 1;
        });
    }

    fn end_part(&self, merge: impl FnOnce(&mut Merged)) {
        if self.is_now() {
            merge(&mut self.merged());
        }
        self.part.fetch_add(1, Relaxed);
    }

    /// Appends recordings, of which `record` goes through the one with a number, part by part. What it does beside
    /// recording is done as often as there are parts.
    pub(crate) fn take(&self, commands: &Commands, count: usize, record: impl Fn(usize)) {
        for wanted in 0.. {
            self.wanted.store(wanted, Relaxed);
            let mut parts = 0;
            for number in 0..count {
                self.part.store(0, Relaxed);
                record(number);
                parts = parts.max(self.part.load(Relaxed));
            }
            self.merged().append(commands);
            if wanted >= parts {
                break;
            }
        }
    }
}

impl Merged {
    fn widen(&mut self, before: Access, after: Access) {
        self.is_there = true;
        self.before = (self.before.0 | before.0, self.before.1 | before.1);
        self.after = (self.after.0 | after.0, self.after.1 | after.1);
    }

    fn append(&mut self, commands: &Commands) {
        if self.is_there {
            let images = &self.images[..self.count];
            let Commands { device, buffer, .. } = *commands;
            barrier::merged(device, buffer, self.before, self.after, images);
        }
        let none = (vk::PipelineStageFlags::empty(), vk::AccessFlags::empty());
        (self.is_there, self.before, self.after, self.count) = (false, none, none, 0);
    }
}
