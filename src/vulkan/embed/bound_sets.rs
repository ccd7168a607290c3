//! Manages the descriptor sets of the outputs of a surface, which read inputs of the surface.

use std::sync::Arc;

use ash::vk;

use super::host_sets::{self, Content, HostSet};
use super::input_sets::{Versions, versions};
use super::inputs::SourceInput;
use super::surface::FrameSurface;
use crate::vulkan::VulkanError;
use crate::vulkan::device::pipelines::Pipelines;
use crate::vulkan::flight::Flight;

/// Descriptor sets in the same number of versions as a replaceable input of the surface. Each rebinding uses the next
/// free version.
#[derive(Debug)]
pub(super) struct BoundSets {
    pool: vk::DescriptorPool,
    versions: Versions,
    /// Number of replacements of each of the surface's points at the last binding. `sources` counts those of the source
    /// buffers.
    points: Vec<u32>,
    sources: Vec<u32>,
    flight: Arc<Flight>,
    /// Pool of the surface's own sets. It identifies the surface.
    surface: vk::DescriptorPool,
}

impl BoundSets {
    pub(super) fn new(
        device: &ash::Device,
        pipelines: &Pipelines,
        surface: &FrameSurface,
        contents: &[Content],
    ) -> Result<Self, VulkanError> {
        let count = versions(surface.slots());
        let (all, owner) = (contents.repeat(count), &surface.grid.owner);
        let (pool, sets) = host_sets::describe(device, pipelines, &all, owner)?;
        Ok(Self {
            pool,
            versions: Versions::new(sets.chunks(contents.len())),
            points: changes(&surface.sets.points),
            sources: changes(&surface.sets.sources),
            flight: Arc::clone(&surface.flight),
            surface: surface.sets.pool,
        })
    }

    /// Returns the current sets, in the order of the contents.
    pub(super) fn sets(&self) -> &[HostSet] {
        self.versions.sets()
    }

    /// Binds the next free version of the sets to the current inputs of the surface.
    pub(super) fn rebind(
        &mut self,
        device: &ash::Device,
        surface: &FrameSurface,
        contents: &[Content],
    ) -> Result<(), VulkanError> {
        self.check_surface(surface)?;
        if !self.versions.replace(device, &self.flight, contents) {
            return Err(VulkanError::RebindInFlight);
        }
        self.points = changes(&surface.sets.points);
        self.sources = changes(&surface.sets.sources);
        Ok(())
    }

    /// Returns an error unless `surface` is the one that the sets were made for.
    pub(super) fn check_surface(&self, surface: &FrameSurface) -> Result<(), VulkanError> {
        match surface.sets.pool == self.surface {
            true => Ok(()),
            false => Err(VulkanError::OtherSurface),
        }
    }

    /// Returns an error if the points with this number were replaced after the last binding. The surface must
    /// have such points.
    pub(super) fn check_points(
        &self,
        surface: &FrameSurface,
        number: usize,
    ) -> Result<(), VulkanError> {
        match self.points[number] == surface.sets.points[number].changes {
            true => Ok(()),
            false => Err(VulkanError::OldInput { what: "points", number }),
        }
    }

    /// Returns an error if the source buffer was replaced after the last binding.
    pub(super) fn check_sources(
        &self,
        surface: &FrameSurface,
        sources: SourceInput,
    ) -> Result<(), VulkanError> {
        match sources.buffer() {
            Some((number, _)) if self.sources[number] != surface.sets.sources[number].changes => {
                Err(VulkanError::OldInput { what: "sources", number })
            }
            _ => Ok(()),
        }
    }

    /// Notes that a recording uses the current sets. `serial` is the number that the device writes after the
    /// recording, if it is tracked.
    pub(super) fn are_used(&self, serial: Option<u32>) {
        self.versions.are_used_by(serial.unwrap_or(0));
    }

    /// Returns whether a tracked recording that uses the sets may still be pending.
    pub(super) fn are_in_flight(&self) -> bool {
        self.versions.are_in_flight(&self.flight)
    }

    pub(super) fn destroy(&mut self, device: &ash::Device) {
        // SAFETY: the caller has made sure that no submitted work uses the sets. Null handles are allowed.
        unsafe { device.destroy_descriptor_pool(self.pool, None) };
        self.pool = vk::DescriptorPool::null();
    }
}

fn changes(sets: &[Versions]) -> Vec<u32> {
    sets.iter().map(|set| set.changes).collect()
}
