//! Tells an observer what is recorded: where passes and steps begin and end, and their commands. Profiles are built on
//! top of this, and no pass depends on them.

use super::commands::Commands;
use super::pass_kind::PassKind;
use crate::vulkan::device::labels::Group;
use crate::vulkan::grid_images::GridImages;
use crate::vulkan::schedules::plan::Step;
use crate::vulkan::{TexelChart, Tuning};

/// Bytes that a pass reads and writes. `None` stands for a number that only the device knows.
pub(crate) type Moved = [Option<u64>; 2];

/// Steps of a plan that are about to be recorded, with what determines their work.
#[derive(Clone, Copy)]
pub(crate) struct PlannedSteps<'a> {
    pub(crate) steps: &'a [Step],
    pub(crate) texels: TexelChart,
    pub(crate) tuning: Tuning,
    /// Whether fronts carry a value in addition to their time.
    pub(crate) carries: bool,
    /// Bytes that an exchange between copies of points reads and writes, if the surface is glued.
    pub(crate) exchanged: Option<[u64; 2]>,
    /// Surface with the map, or the number of maps in a batch.
    pub(crate) of: StepsOf<'a>,
}

/// Maps on which steps work.
#[derive(Clone, Copy)]
pub(crate) enum StepsOf<'a> {
    Map(&'a GridImages),
    Batch(u32),
}

/// Observer of a recording.
pub(crate) trait Observer: Sync {
    /// Called when a pass begins. It moves the bytes `moved`, or else those of its copies, fills and updates.
    fn begin(&self, commands: &Commands, kind: PassKind, moved: Option<Moved>);

    /// Called when the pass that began last ends.
    fn end(&self, commands: &Commands);

    /// Called when workgroups are dispatched in the current pass.
    fn dispatched(&self, groups: [u32; 3]);

    /// Called when a copy, a fill or an update in the current pass reads and writes bytes.
    fn transferred(&self, read: u64, written: u64);

    /// Called before the steps of a plan. The observer may copy the device's decisions. Returns the number of blocks of
    /// scans whose visits the device shall note.
    fn begin_steps(&self, commands: &Commands, steps: PlannedSteps) -> u32;

    /// Called when the next of these steps begins. It ends where the next step or pass begins, or with the steps.
    fn step(&self, commands: &Commands, step: &Step);

    /// Called after the steps.
    fn end_steps(&self, commands: &Commands);

    /// Called after the steps of a map and the commands that belong to them.
    fn end_portion(&self, commands: &Commands);
}

/// Pass that is being recorded. Dropping the value ends the pass.
#[must_use]
pub(crate) struct OpenPass<'a> {
    commands: Commands<'a>,
    /// Whether it is a step of a plan, which ends where the next one begins.
    is_step: bool,
    _label: Option<Group<'a>>,
}

impl<'a> Commands<'a> {
    /// Begins a pass that ends when the returned value is dropped. It moves the bytes of its copies, fills and updates.
    pub(crate) fn pass(&self, kind: PassKind) -> Option<OpenPass<'a>> {
        self.begin(kind, None)
    }

    /// Begins a pass that moves these bytes, and ends when the returned value is dropped.
    pub(crate) fn pass_moving(&self, kind: PassKind, moved: Moved) -> Option<OpenPass<'a>> {
        self.begin(kind, Some(moved))
    }

    fn begin(&self, kind: PassKind, moved: Option<Moved>) -> Option<OpenPass<'a>> {
        if self.turn.is_some() {
            return None;
        }
        let _label = self.group(kind.label());
        if let Some(observer) = self.observer {
            observer.begin(self, kind, moved);
        }
        Some(OpenPass { commands: *self, is_step: false, _label })
    }

    /// Begins a step of a plan, whose label ends when the returned value is dropped.
    pub(crate) fn step(&self, step: &Step) -> OpenPass<'a> {
        let _label = self.group(PassKind::of(step).label());
        if let Some(observer) = self.observer {
            observer.step(self, step);
        }
        OpenPass { commands: *self, is_step: true, _label }
    }
}

impl Drop for OpenPass<'_> {
    fn drop(&mut self) {
        if let Some(observer) = self.commands.observer.filter(|_| !self.is_step) {
            observer.end(&self.commands);
        }
    }
}
