//! Records the usual frame of a surface: new points, a map, and the image of its distances.

use super::access::{Access, Reader};
use super::inputs::SourceInput;
use super::names::Labelled;
use super::plan::Plan;
use super::recording::Recording;
use super::solver::Solver;
use super::surface::{FrameSurface, ResultImage};
use crate::vulkan::profile::Grain;
use crate::vulkan::setters::setters;
use crate::vulkan::{MapLimit, VulkanError};

/// Parameters of [`Recording::frame`].
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Frame<'a> {
    /// Access by which the host has written points and sources since the previous frame.
    pub before: Access,
    /// Number of the surface's points to measure; `None` if they have not changed since the previous frame.
    pub points: Option<usize>,
    /// Sources at which the fronts start.
    pub sources: SourceInput<'a>,
    /// Passes of the map.
    pub plan: &'a Plan,
    /// Slot whose image of distances is written. Each frame in flight has its own slot.
    pub slot: usize,
    /// Reader of the image.
    pub reader: Reader,
    /// Limit of the map. The radius and the targets may change from frame to frame.
    pub limit: MapLimit<'a>,
    /// Value of the image at points that are not reached. It may be +infinity, but bilinear filters turn that
    /// into NaN beside such points. A negative number is easy to test for.
    pub unreached: f32,
}

impl<'a> Frame<'a> {
    /// Returns the parameters of a frame without new points. It writes slot 0, has +infinity at points that
    /// are not reached, and does not wait for writes of the host.
    pub fn new(plan: &'a Plan, sources: SourceInput<'a>, reader: Reader) -> Self {
        let (before, points, slot) = (Access::NONE, None, 0);
        let (limit, unreached) = (MapLimit::NONE, f32::INFINITY);
        Self { before, points, sources, plan, slot, reader, limit, unreached }
    }

    /// Sets [`Frame::points`].
    pub fn with_points(self, points: impl Into<Option<usize>>) -> Self {
        Self { points: points.into(), ..self }
    }

    setters! {
        with_before(before: Access);
        with_sources(sources: SourceInput<'a>);
        with_slot(slot: usize);
        with_reader(reader: Reader);
        with_limit(limit: MapLimit<'a>);
        with_unreached(unreached: f32);
    }
}

impl Recording<'_> {
    /// Records a usual frame: [`Recording::begin`], [`Recording::measure`] if there are new points,
    /// [`Recording::solve`], [`Recording::outcome`] and [`Recording::result`]. The frame includes all
    /// barriers between these, and before the reads of `frame.reader`. Returns the image that receives the
    /// distances.
    ///
    /// # Errors
    /// As for these methods. Nothing is recorded then.
    pub fn frame(&self, frame: &Frame) -> Result<ResultImage, VulkanError> {
        let result = self.check_frame(frame)?;
        let _group = self.group(Labelled::Frame);
        self.begin(frame.before);
        if let Some(points) = frame.points {
            self.record_measure(points, self.points(points)?);
            self.surface.measures(self.solver);
        }
        self.limited(frame.limit).record_solve(frame.sources, frame.plan);
        self.record_outcome(frame.slot, self.next_outcome(frame.slot));
        self.record_result(result, frame.slot, frame.reader, frame.unreached);
        self.note();
        Ok(result)
    }

    /// Checks whether a frame can be recorded, and records nothing. Returns the image that the frame will
    /// write.
    ///
    /// # Errors
    /// As for [`Recording::frame`].
    pub fn check_frame(&self, frame: &Frame) -> Result<ResultImage, VulkanError> {
        if let Some(points) = frame.points {
            self.points(points)?;
        }
        self.check(frame.plan)?;
        self.check_sources(frame.sources)?;
        frame.limit.check(self.surface.grid.chart)?;
        let result = self.surface.result(frame.slot, frame.reader.layout)?;
        match frame.points {
            Some(_) => self.surface.state.check_prepared()?,
            None => {
                self.surface.state.check_measured(frame.plan)?;
                self.surface.check_seams()?;
            }
        }
        self.check_slot(frame.slot, true)?;
        Ok(result)
    }
}

impl Solver {
    /// Returns the largest number of profile records that [`Recording::frame`] makes for a surface, or
    /// [`Recording::resume`] with the same plan. A [`crate::vulkan::profile::Profile`] needs room for all of them.
    /// Other calls add further records: [`super::Output::passes`], and one record for each lookup.
    pub fn passes_of_frame(&self, surface: &FrameSurface, plan: &Plan, grain: Grain) -> u32 {
        surface.passes_around() + plan.records(grain)
    }
}
