//! Records frames of several surfaces together, so that they share barriers.

use std::array;

use ash::vk;

use super::frame::Frame;
use super::map_sources::Given;
use super::recording::Recording;
use super::solver::Solver;
use super::surface::FrameSurface;
use crate::vulkan::VulkanError;
use crate::vulkan::device::barrier::MOST_TOGETHER;
use crate::vulkan::record::{Commands, Recorder, Turn};
use crate::vulkan::setters::setters;

/// Frame of one of several surfaces that [`Solver::record_frames`] records together.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct SurfaceFrame<'a> {
    /// Surface of the frame.
    pub surface: &'a FrameSurface,
    /// Frame to record.
    pub frame: Frame<'a>,
    /// Offset in bytes, added to the surface's own offset of the points, as in [`Recording::points_at`].
    pub points_at: u64,
}

impl<'a> SurfaceFrame<'a> {
    /// Returns a frame of `surface`, with the surface's own offset of the points.
    pub fn new(surface: &'a FrameSurface, frame: Frame<'a>) -> Self {
        Self { surface, frame, points_at: 0 }
    }

    setters! {
        with_surface(surface: &'a FrameSurface);
        with_frame(frame: Frame<'a>);
        with_points_at(points_at: u64);
    }
}

impl Solver {
    /// Records frames of several surfaces so that they run side by side. Each frame is recorded as by
    /// [`Recording::frame`], and the passes of all frames share the same barriers.
    ///
    /// A Vulkan memory barrier makes all later passes wait for all earlier ones, whatever memory they use.
    /// Maps that are recorded one after another therefore run one after another, and small maps leave most of
    /// the device idle. Recorded together, `n` surfaces of the same size and plan need the barriers of one
    /// surface and `n` times its dispatches. If sizes or plans differ, the longest recording determines the
    /// number of barriers. Up to 64 frames share their barriers. Larger numbers of frames are recorded in
    /// groups of 64.
    ///
    /// The command buffer must be in the state that [`Solver::record`] requires. Profiles do not record these
    /// frames. All frames together have one debug label. [`FrameSurface::result`] returns the image of
    /// distances of each surface. Surfaces, sources and slots are checked as for single frames.
    ///
    /// # Errors
    /// [`VulkanError::OfFrame`] with the number of the frame and the error of [`Recording::frame`], or with
    /// [`VulkanError::TwiceTogether`] if an earlier frame of the list has the same surface. Nothing is
    /// recorded then.
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

    /// Records frames that were checked, at most [`MOST_TOGETHER`] of them.
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
        turn.take((all.device, all.buffer), count, |number| {
            let (recording, frame) = recording(number);
            recording.begin(frame.before);
            if let Some((points, read)) = frame.points.zip(recording.points_of(frame)) {
                recording.record_measure(points, read);
            }
            recording.recorder.forget();
            recording.limited(frame.limit).start(frame.sources, frame.plan, false);
        });
        for SurfaceFrame { surface, frame, .. } in frames {
            if frame.points.is_some() {
                surface.measures(self);
            }
            let sources = Given::new(frame.sources, surface);
            surface.state.solve(frame.plan, frame.limit, sources);
        }
        let steps: [_; MOST_TOGETHER] = array::from_fn(|number| {
            let of = frames.get(number)?;
            let recording = self.recording_of(device, commands, of);
            let variant = recording.variant(of.frame.plan);
            let has_targets = !of.frame.limit.targets.is_empty();
            Some((recording.recorder, variant, of.frame.plan.steps(), has_targets))
        });
        Recorder::steps_together(&steps);
        // Serials are taken here, once for each frame, since the closure below is called once for each part
        // of a recording.
        let serials: [_; MOST_TOGETHER] = array::from_fn(|number| {
            let of = frames.get(number)?;
            let recording = self.recording_of(device, commands, of);
            Some((recording.next_outcome(of.frame.slot), recording.next_note()))
        });
        turn.take((all.device, all.buffer), count, |number| {
            let ((recording, frame), Some((outcome, note))) = (recording(number), serials[number])
            else {
                return;
            };
            recording.trim();
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
    /// Returns this recording, restricted to the part that `turn` selects.
    fn in_turn(mut self, turn: &'a Turn) -> Self {
        self.recorder.commands.turn = Some(turn);
        self
    }

    /// Returns the points that a frame measures, if any. The frame was checked before.
    fn points_of(&self, frame: &Frame) -> Option<(super::host_sets::HostSet, super::Points)> {
        frame.points.and_then(|number| self.points(number).ok())
    }
}
