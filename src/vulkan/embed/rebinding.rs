//! Inputs of a surface that are replaced: other buffers or images in place of those that it was made with.

use super::host_sets::{points_content, sources_content};
use super::inputs::{Points, SourceBuffer};
use super::recording::nth;
use super::solver::Solver;
use super::surface::Surface;
use crate::vulkan::VulkanError;

impl Surface {
    /// Replaces the points with a number: recordings from now on read these. Of another kind or in other memory if
    /// the host likes, but with a slowness only if some points of the surface have had one from the start.
    ///
    /// Frames in flight go on with the points that they were recorded for, which stay alive until these have run: an
    /// input has a descriptor set more than there are slots, and takes the next that no followed recording uses.
    /// Followed are recordings with an outcome, and with [`super::Tools::checks`] all; of others the host takes care.
    /// Command buffers that are submitted again and again are to be recorded anew.
    ///
    /// Edges are those of the old points until [`super::Recording::measure`]; contours and paths are lifted to the
    /// new ones after [`super::Contours::rebind`] and [`super::Paths::rebind`].
    ///
    /// # Errors
    /// If there is no such number, the points cannot be used as described, or all descriptor sets are in flight.
    /// Then nothing has changed.
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
        let content = points_content((device, &solver.limits), points, self.grid.chart)?;
        let set = &mut self.sets.points[number];
        set.replace(device, &self.flight, ("points", number), content)?;
        self.points[number] = *points;
        Ok(())
    }

    /// Replaces the source buffer with a number, as [`Surface::set_points`] does points; paths and regions need
    /// [`super::Paths::rebind`] and [`super::Regions::rebind`].
    ///
    /// # Errors
    /// As [`Surface::set_points`].
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
        let set = &mut self.sets.sources[number];
        set.replace(device, &self.flight, ("sources", number), content)?;
        self.sources[number] = *sources;
        Ok(())
    }
}
