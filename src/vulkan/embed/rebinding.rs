//! Replaces the host's memory of a surface: other buffers or images take the place of those with which the
//! surface was made.

use super::host_sets::{Content, measured_content, sources_content};
use super::input_sets::Versions;
use super::inputs::{Points, SourceBuffer};
use super::numbered::nth;
use super::outputs::HostImage;
use super::solver::Solver;
use super::surface::FrameSurface;
use super::surface_info::check_kind;
use super::surface_sets::HostSets;
use crate::vulkan::VulkanError;

impl FrameSurface {
    /// Replaces the surface's points with this `number` in all later recordings. The new points may be of
    /// another kind and in another type of memory. They may have a slowness only if some points of the
    /// surface had one when it was made.
    ///
    /// Frames in flight still read the old points. The host keeps these alive until the frames have run. Each
    /// input has one descriptor set more than the surface has slots, and the new points take the next set
    /// that no tracked recording uses. Recordings with an outcome are tracked. With [`super::Tools::checks`]
    /// all recordings are. The host must make sure itself that other recordings have run. A command buffer
    /// that is submitted repeatedly must be recorded again.
    ///
    /// Edge lengths are those of the old points until [`super::Recording::measure`]. Contours and paths are
    /// lifted to the new points after [`super::Output::rebind`].
    ///
    /// # Errors
    /// If there is no such number, the points cannot be used as described, the surface was destroyed, or all
    /// descriptor sets of the input are in flight. The surface is unchanged then.
    pub fn set_points(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        number: usize,
        points: &Points,
    ) -> Result<(), VulkanError> {
        nth(&self.points, "point inputs", number)?;
        self.state.check_there()?;
        if points.slowness.is_some() && !self.grid.is_slowed() {
            let reason = "they have a slowness, and the surface was made for none".into();
            return Err(VulkanError::HostBuffer { what: "points", reason });
        }
        if let Some(gluing) = &self.gluing {
            check_kind(gluing, points.kind)?;
        }
        let content = measured_content((device, &solver.limits), points, &self.grid)?;
        self.replace(device, |sets| &mut sets.points, ("points", number), content)?;
        self.points[number] = *points;
        Ok(())
    }

    /// Replaces the surface's source buffer with this `number`, under the same rules as
    /// [`FrameSurface::set_points`]. Outputs other than contours read the new buffer after [`super::Output::rebind`].
    ///
    /// # Errors
    /// As for [`FrameSurface::set_points`].
    pub fn set_sources(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        number: usize,
        sources: &SourceBuffer,
    ) -> Result<(), VulkanError> {
        nth(&self.sources, "source buffers", number)?;
        self.state.check_there()?;
        let content = sources_content((device, &solver.limits), sources)?;
        self.replace(device, |sets| &mut sets.sources, ("sources", number), content)?;
        self.sources[number] = *sources;
        Ok(())
    }

    /// Replaces the host's image for the distances of a slot in all later recordings. Render graphs need this
    /// if their transient images change from frame to frame.
    ///
    /// Frames in flight still write the image that they were recorded for. The host keeps it alive until they
    /// have run.
    ///
    /// # Errors
    /// If there is no such slot, the surface uses images of its own, a handle is null, or all descriptor sets
    /// of the slot are in flight because the image was replaced too often. The surface is unchanged then.
    pub fn set_result(
        &mut self,
        device: &ash::Device,
        slot: usize,
        image: HostImage,
    ) -> Result<(), VulkanError> {
        nth(&self.sets.results, "slots", slot)?;
        self.state.check_there()?;
        if self.results.is_empty() {
            return Err(VulkanError::OwnResults);
        }
        image.check("distances")?;
        let content = Content::result(image.view);
        self.replace(device, |sets| &mut sets.results, ("distances", slot), content)?;
        self.results[slot] = image;
        Ok(())
    }
    /// Replaces the content of an input of the surface. Returns an error if all of its descriptor sets are in flight.
    fn replace(
        &mut self,
        device: &ash::Device,
        inputs: impl FnOnce(&mut HostSets) -> &mut Vec<Versions>,
        (what, number): (&'static str, usize),
        content: Content,
    ) -> Result<(), VulkanError> {
        match inputs(&mut self.sets)[number].replace(device, &self.flight, &[content]) {
            true => Ok(()),
            false => Err(VulkanError::InputInFlight { what, number }),
        }
    }
}
