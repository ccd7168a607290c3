//! Around a pass while it is being recorded: its label, and its queries.

use super::pass::{Grain, PassKind, PassRecord};
use super::slots::Profile;
use super::work::Presence;
use crate::vulkan::record::Recorder;

/// Ends the pass when it is dropped.
#[must_use]
pub(crate) struct Scope<'a> {
    recorder: Recorder<'a>,
    pass: (PassRecord, Presence),
    /// In the profile, if it has room.
    number: Option<usize>,
}

impl<'a> Scope<'a> {
    /// Opens a pass, if anyone looks on.
    pub(crate) fn open(
        recorder: &Recorder<'a>,
        describe: impl FnOnce() -> (PassRecord, Presence),
    ) -> Option<Self> {
        let Recorder { device, commands, profile, pipelines, .. } = *recorder;
        if !recorder.is_watched() {
            return None;
        }
        let pass = describe();
        if let Some(labels) = &pipelines.labels {
            labels.open(commands, pass.0.kind.label());
        }
        let number = profile.and_then(|profile| profile.open(device, commands));
        Some(Self { recorder: *recorder, pass, number })
    }
}

impl Scope<'_> {
    /// Takes the next step of the same scan in, if the profile wants scans; says whether it does.
    pub(crate) fn absorb(&mut self, (next, presence): (PassRecord, Presence)) -> bool {
        let wants_scans = |profile: &Profile| profile.grain() == Grain::Scans;
        let (record, own_presence) = &mut self.pass;
        let same = matches!(next.kind, PassKind::Scan(_))
            && (record.kind, record.iteration, *own_presence)
                == (next.kind, next.iteration, presence)
            && self.recorder.profile.is_some_and(wants_scans);
        if same {
            record.absorb(&next);
        }
        same
    }
}

impl Drop for Scope<'_> {
    fn drop(&mut self) {
        let Recorder { device, commands, profile, pipelines, .. } = self.recorder;
        if let (Some(profile), Some(number)) = (profile, self.number) {
            profile.close(device, commands, number, self.pass);
        }
        if let Some(labels) = &pipelines.labels {
            labels.close(commands);
        }
    }
}
