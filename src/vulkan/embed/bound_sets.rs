//! Descriptor sets of contours, paths and regions, which read inputs of their surface.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use ash::vk;

use super::flight::Flight;
use super::host_sets::{self, Content, HostSet};
use super::input_sets::{InputSet, versions};
use super::inputs::SourceInput;
use super::surface::Surface;
use crate::vulkan::VulkanError;
use crate::vulkan::pipelines::Pipelines;

/// As many times as there are sets of a surface's input, taken in turn when they are bound to others.
#[derive(Debug)]
pub(super) struct BoundSets {
    pool: vk::DescriptorPool,
    versions: Vec<Version>,
    current: usize,
    /// How often the surface's points and sources had been replaced.
    points: Vec<u32>,
    sources: Vec<u32>,
    flight: Arc<Flight>,
    /// Of the surface's own sets, which tells surfaces apart.
    surface: vk::DescriptorPool,
}

#[derive(Debug)]
struct Version {
    sets: Vec<HostSet>,
    /// Serial of the last recording that uses them, if recordings are followed.
    used: AtomicU32,
}

impl BoundSets {
    pub(super) fn new(
        device: &ash::Device,
        pipelines: &Pipelines,
        surface: &Surface,
        contents: &[Content],
    ) -> Result<Self, VulkanError> {
        let count = versions(surface.slots());
        let (pool, sets) = host_sets::describe(device, pipelines, &contents.repeat(count))?;
        let of = |sets: &[HostSet]| Version { sets: sets.to_vec(), used: 0.into() };
        Ok(Self {
            pool,
            versions: sets.chunks(contents.len().max(1)).map(of).collect(),
            current: 0,
            points: changes(&surface.sets.points),
            sources: changes(&surface.sets.sources),
            flight: Arc::clone(&surface.flight),
            surface: surface.sets.pool,
        })
    }

    /// The sets of the contents, in their order.
    pub(super) fn sets(&self) -> &[HostSet] {
        &self.versions[self.current].sets
    }

    /// Binds the next sets to what is now the surface's.
    pub(super) fn rebind(
        &mut self,
        device: &ash::Device,
        surface: &Surface,
        contents: &[Content],
    ) -> Result<(), VulkanError> {
        self.check_surface(surface)?;
        let count = self.versions.len();
        let mut others = (1..=count).map(|next| (self.current + next) % count);
        let waits = |at: &usize| self.flight.waits_for(self.versions[*at].used.load(Relaxed));
        let free = others.find(|at| !waits(at));
        let what = "inputs of contours, paths or regions";
        let free = free.ok_or(VulkanError::InputInFlight { what, number: 0 })?;
        let of = &mut self.versions[free];
        for (set, content) in of.sets.iter_mut().zip(contents) {
            *set = host_sets::fill(device, set.set, *content);
        }
        of.used = 0.into();
        self.current = free;
        self.points = changes(&surface.sets.points);
        self.sources = changes(&surface.sets.sources);
        Ok(())
    }

    /// Refuses another surface than that which they were made for.
    pub(super) fn check_surface(&self, surface: &Surface) -> Result<(), VulkanError> {
        match surface.sets.pool == self.surface {
            true => Ok(()),
            false => Err(VulkanError::OtherSurface),
        }
    }

    /// Refuses points, which the surface has, if they were replaced meanwhile.
    pub(super) fn check_points(&self, surface: &Surface, number: usize) -> Result<(), VulkanError> {
        match self.points[number] == surface.sets.points[number].changes {
            true => Ok(()),
            false => Err(VulkanError::OldInput { what: "points", number }),
        }
    }

    /// The same of sources.
    pub(super) fn check_sources(
        &self,
        surface: &Surface,
        sources: SourceInput,
    ) -> Result<(), VulkanError> {
        match sources.buffer() {
            Some((number, _)) if self.sources[number] != surface.sets.sources[number].changes => {
                Err(VulkanError::OldInput { what: "sources", number })
            }
            _ => Ok(()),
        }
    }

    /// A recording uses them, behind which the device writes this serial, if any.
    pub(super) fn are_used(&self, serial: Option<u32>) {
        self.versions[self.current].used.store(serial.unwrap_or(0), Relaxed);
    }

    /// Whether a followed recording that uses them may not have run.
    pub(super) fn are_in_flight(&self) -> bool {
        self.versions.iter().any(|of| self.flight.waits_for(of.used.load(Relaxed)))
    }

    pub(super) fn destroy(&mut self, device: &ash::Device) {
        // SAFETY: the caller has made sure that nothing uses them; null handles are allowed.
        unsafe { device.destroy_descriptor_pool(self.pool, None) };
        self.pool = vk::DescriptorPool::null();
    }
}

fn changes(sets: &[InputSet]) -> Vec<u32> {
    sets.iter().map(|set| set.changes).collect()
}
