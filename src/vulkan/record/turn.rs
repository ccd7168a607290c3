//! Merges recordings of several surfaces so that they share their barriers.
//!
//! Each recording is cut into parts at its barriers. Run `n` calls all recordings, and appends only part `n` of each. A
//! single barrier follows, which replaces the barriers after these parts. The longest recording determines the number
//! of runs.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};

use ash::vk;

use crate::vulkan::device::barrier;
use crate::vulkan::device::barrier::{Access, ImageBarrier, MOST_TOGETHER};

/// State of a run: the number of the parts that it appends, and the barriers after them.
#[derive(Debug, Default)]
pub(crate) struct Turn {
    /// Number of the part that is appended.
    wanted: AtomicU32,
    /// Number of the part that the current recording has reached.
    part: AtomicU32,
    merged: Mutex<MergedBarrier>,
}

/// Union of the barriers that several recordings need at the same point.
#[derive(Debug)]
struct MergedBarrier {
    needed: bool,
    /// Stages and memory accesses before the barrier.
    before: Access,
    /// Stages and memory accesses after the barrier.
    after: Access,
    images: [ImageBarrier; MOST_TOGETHER],
    count: usize,
}

impl Default for MergedBarrier {
    fn default() -> Self {
        let none = (vk::PipelineStageFlags::empty(), vk::AccessFlags::empty());
        let images = [ImageBarrier::default(); MOST_TOGETHER];
        Self { needed: false, before: none, after: none, images, count: 0 }
    }
}

impl Turn {
    /// Returns whether the current part is the one that is appended.
    pub(super) fn is_now(&self) -> bool {
        self.part.load(Relaxed) == self.wanted.load(Relaxed)
    }

    fn merged(&self) -> MutexGuard<'_, MergedBarrier> {
        self.merged.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends a part with a barrier over all memory.
    pub(super) fn barrier(&self, before: Access, after: Access) {
        self.end_part(|merged| merged.widen(before, after));
    }

    /// Ends a part with a barrier of an image.
    pub(super) fn image_barrier(&self, image: ImageBarrier) {
        self.end_part(|merged| {
            let none = vk::AccessFlags::empty();
            merged.widen((image.before.0, none), (image.after.0, none));
            merged.images[merged.count] = image;
            merged.count += 1;
        });
    }

    fn end_part(&self, merge: impl FnOnce(&mut MergedBarrier)) {
        if self.is_now() {
            merge(&mut self.merged());
        }
        self.part.fetch_add(1, Relaxed);
    }

    /// Appends `count` recordings to a command buffer part by part. `record` runs the recording with a given number. It
    /// runs once for each part, so its side effects are repeated.
    pub(crate) fn take(
        &self,
        (device, buffer): (&ash::Device, vk::CommandBuffer),
        count: usize,
        record: impl Fn(usize),
    ) {
        for wanted in 0.. {
            self.wanted.store(wanted, Relaxed);
            let mut parts = 0;
            for number in 0..count {
                self.part.store(0, Relaxed);
                record(number);
                parts = parts.max(self.part.load(Relaxed));
            }
            self.merged().append(device, buffer);
            if wanted >= parts {
                break;
            }
        }
    }
}

impl MergedBarrier {
    fn widen(&mut self, before: Access, after: Access) {
        self.needed = true;
        self.before = (self.before.0 | before.0, self.before.1 | before.1);
        self.after = (self.after.0 | after.0, self.after.1 | after.1);
    }

    fn append(&mut self, device: &ash::Device, buffer: vk::CommandBuffer) {
        if self.needed {
            let images = &self.images[..self.count];
            barrier::merged(device, buffer, self.before, self.after, images);
        }
        let none = (vk::PipelineStageFlags::empty(), vk::AccessFlags::empty());
        (self.needed, self.before, self.after, self.count) = (false, none, none, 0);
    }
}
