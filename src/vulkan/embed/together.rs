//! Frames of several surfaces, recorded together.

use std::array;

use ash::vk;

use super::recording::{Frame, Recording};
use super::solver::Solver;
use super::surface::Surface;
use crate::vulkan::VulkanError;
use crate::vulkan::record::{Commands, MOST_TOGETHER, Recorder, Turn};

/// A frame of one of several surfaces: [`Solver::record_frames`].
#[derive(Clone, Copy, Debug)]
pub struct SurfaceFrame<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// Its frame.
    pub frame: Frame<'a>,
    /// Where its points are read, as [`Recording::points_at`] has it: bytes beyond those of the surface.
    pub points_at: u64,
}

impl Solver {
    /// Records frames of several surfaces so that they run beside one another: each as [`Recording::frame`] does,
    /// with the passes of all between the same barriers.
    ///
    /// A barrier of Vulkan's has all passes after it wait for all before it, whatever memory it names. So maps that are
    /// recorded one after another run one after another, and small ones leave a device idle. Recorded together, `n`
    /// surfaces of one size and plan have the barriers of one and `n` times its dispatches; of others the longest
    /// counts. 64 share their barriers, more go by 64. Frames have no place in profiles, and one label.
    ///
    /// The images of distances are those of [`Surface::result`]. Surfaces, sources and slots are looked at as for
    /// single frames.
    ///
    /// # Errors
    /// [`VulkanError::OfFrame`], with what [`Recording::frame`] says of that frame, or
    /// [`VulkanError::TwiceTogether`] if its surface has another. Then nothing is recorded.
    pub fn record_frames(
        &self,
        device: &ash::Device,
        commands: vk::CommandBuffer,
        frames: &[SurfaceFrame],
    ) -> Result<(), VulkanError> {
        for (number, of) in frames.iter().enumerate() {
            let is_same = |other: &SurfaceFrame| std::ptr::eq(other.surface, of.surface);
            let checked = match frames[..number].iter().any(is_same) {
                true => Err(VulkanError::TwiceTogether),
                false => self.recording_of(device, commands, of).check_frame(&of.frame),
            };
            checked.map_err(|source| VulkanError::OfFrame { number, source: Box::new(source) })?;
        }
        let _group = Commands::new(device, commands, &self.pipelines).group(c"geosweep: frames");
        for frames in frames.chunks(MOST_TOGETHER) {
            self.record_together(device, commands, frames);
        }
        Ok(())
    }

    fn recording_of<'a>(
        &'a self,
        device: &'a ash::Device,
        commands: vk::CommandBuffer,
        of: &SurfaceFrame<'a>,
    ) -> Recording<'a> {
        self.record(device, commands, of.surface).points_at(of.points_at)
    }

    /// Of frames that were checked, no more than share barriers.
    fn record_together(
        &self,
        device: &ash::Device,
        commands: vk::CommandBuffer,
        frames: &[SurfaceFrame],
    ) {
        let turn = Turn::default();
        let all = Commands::new(device, commands, &self.pipelines);
        let count = frames.len();
        let recording = |number: usize| {
            let recording = self.recording_of(device, commands, &frames[number]);
            (recording.in_turn(&turn), &frames[number].frame)
        };
        turn.take(&all, count, |number| {
            let (recording, frame) = recording(number);
            recording.begin(frame.before);
            if let Some((points, read)) = frame.points.zip(recording.points_of(frame)) {
                recording.record_measure(points, read);
            }
            recording.recorder.forget();
            recording.start(frame.sources, frame.plan, false);
        });
        for SurfaceFrame { surface, frame, .. } in frames {
            if frame.points.is_some() {
                surface.state.measure(self.is_curved());
            }
            surface.state.solve(frame.plan);
        }
        let steps: [_; MOST_TOGETHER] = array::from_fn(|number| {
            let of = frames.get(number)?;
            let recording = self.recording_of(device, commands, of);
            let variant = recording.variant(of.frame.plan);
            Some((recording.recorder, variant, of.frame.plan.steps()))
        });
        Recorder::steps_together(&steps);
        // Given out once, since parts are gone through again and again.
        let serials: [_; MOST_TOGETHER] = array::from_fn(|number| {
            let of = frames.get(number)?;
            let recording = self.recording_of(device, commands, of);
            Some((recording.next_outcome(of.frame.slot), recording.next_note()))
        });
        turn.take(&all, count, |number| {
            let ((recording, frame), Some((outcome, note))) = (recording(number), serials[number])
            else {
                return;
            };
            recording.record_outcome(frame.slot, outcome);
            if let Ok(image) = recording.surface.result(frame.slot, frame.reader.layout) {
                recording.record_result(image, frame.slot, frame.reader, frame.unreached);
            }
            if let Some(note) = note {
                recording.record_note(note);
            }
        });
    }
}

impl<'a> Recording<'a> {
    /// The same, of which the part is recorded whose turn it is.
    fn in_turn(mut self, turn: &'a Turn) -> Self {
        self.recorder.commands.turn = Some(turn);
        self
    }

    /// The points that a frame measures, if it does, once it was checked.
    fn points_of(&self, frame: &Frame) -> Option<(super::host_sets::HostSet, super::Points)> {
        frame.points.and_then(|number| self.points(number).ok())
    }
}
