//! Adds a label and queries to a pass while it is being recorded.

use ash::vk;

use super::pass::PassRecord;
use super::presence::Presence;
use super::slots::Profile;
use crate::vulkan::device::labels::Labels;

/// Profile and labels that observe the recording of a command buffer.
#[derive(Clone, Copy)]
pub(crate) struct Watch<'a> {
    pub(crate) device: &'a ash::Device,
    pub(crate) commands: vk::CommandBuffer,
    pub(crate) profile: Option<&'a Profile>,
    pub(crate) labels: Option<&'a Labels>,
}

impl Watch<'_> {
    /// Returns whether there is a profile or labels.
    pub(crate) fn is_on(&self) -> bool {
        self.profile.is_some() || self.labels.is_some()
    }
}

/// Open pass. Dropping it ends the pass.
#[must_use]
pub(crate) struct Scope<'a> {
    watch: Watch<'a>,
    pass: (PassRecord, Presence),
    /// Number of the pass in the profile, if that has room.
    number: Option<usize>,
}

impl<'a> Scope<'a> {
    /// Opens a pass if there is a profile or labels.
    pub(crate) fn open(
        watch: Watch<'a>,
        describe: impl FnOnce() -> (PassRecord, Presence),
    ) -> Option<Self> {
        if !watch.is_on() {
            return None;
        }
        let Watch { device, commands, profile, labels } = watch;
        let mut pass = describe();
        if let Some(profile) = profile {
            pass.0.kind = profile.grain().kind(pass.0.kind);
        }
        if let Some(labels) = labels {
            labels.open(commands, pass.0.kind.label());
        }
        let number = profile.and_then(|profile| profile.open(device, commands, pass.0.kind));
        Some(Self { watch, pass, number })
    }

    /// Opens the next pass of a sequence, unless the open pass absorbs it. The open pass ends before the next
    /// begins.
    pub(crate) fn go_on(
        open: &mut Option<Self>,
        watch: Watch<'a>,
        describe: impl FnOnce() -> (PassRecord, Presence),
    ) {
        if !watch.is_on() {
            return;
        }
        let next = describe();
        if !open.as_mut().is_some_and(|open| open.absorb(&next)) {
            drop(open.take());
            *open = Self::open(watch, || next);
        }
    }

    /// Absorbs the next pass if it belongs to the same scan or iteration and the profile does not request
    /// finer records. Returns whether it did.
    fn absorb(&mut self, (next, presence): &(PassRecord, Presence)) -> bool {
        let Some(grain) = self.watch.profile.map(Profile::grain) else { return false };
        let record = &mut self.pass.0;
        let same = grain.gathers(record.kind)
            && (record.kind, record.iteration) == (grain.kind(next.kind), next.iteration);
        if same {
            record.absorb(next);
            self.pass.1.absorb(*presence);
        }
        same
    }
}

impl Drop for Scope<'_> {
    fn drop(&mut self) {
        let Watch { device, commands, profile, labels } = self.watch;
        if let (Some(profile), Some(number)) = (profile, self.number) {
            profile.close(device, commands, number, self.pass);
        }
        if let Some(labels) = labels {
            labels.close(commands);
        }
    }
}
