//! Creates the descriptor sets of a surface: for its images of distances, and for the host's images and
//! buffers.

use ash::vk;

use super::host_sets::{
    Content, HostSet, Part, WORD, check_count, describe, inline_sources_content, measured_content,
    sources_content,
};
use super::input_sets::{InputSet, versions};
use super::inputs::{Lookup, Points, SourceBuffer};
use super::outputs::HostImage;
use crate::vulkan::VulkanError;
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::pipelines::Pipelines;
use crate::vulkan::grid_images::GridImages;

/// Descriptor sets of a surface.
#[derive(Debug)]
pub(super) struct HostSets {
    pub(super) pool: vk::DescriptorPool,
    pub(super) results: Vec<InputSet>,
    pub(super) inline_sources: HostSet,
    pub(super) points: Vec<InputSet>,
    pub(super) sources: Vec<InputSet>,
    pub(super) lookups: Vec<HostSet>,
}

/// Resources of the host for a surface: images of distances, points, sources and lookups.
pub(super) type Hosts<'a> = (&'a [HostImage], &'a [Points], &'a [SourceBuffer], &'a [Lookup]);

impl HostSets {
    pub(super) fn new(
        device: &ash::Device,
        pipelines: &Pipelines,
        limits: &Limits,
        grid: &GridImages,
        (results, points, sources, lookups): Hosts,
    ) -> Result<Self, VulkanError> {
        let versions = versions(grid.slots);
        // Images of the surface's own are never replaced.
        let of_results = if results.is_empty() { 1 } else { versions };
        let views = grid.results.iter().map(|image| image.view);
        let views = views.chain(results.iter().map(|image| image.view));
        let mut contents: Vec<_> =
            views.flat_map(|view| std::iter::repeat_n(Content::Result(view), of_results)).collect();
        let on = (device, limits);
        contents.push(inline_sources_content(on, grid)?);
        for points in points {
            let content = measured_content(on, points, grid)?;
            contents.extend(std::iter::repeat_n(content, versions));
        }
        for sources in sources {
            let content = sources_content(on, sources)?;
            contents.extend(std::iter::repeat_n(content, versions));
        }
        for lookup in lookups {
            check_count("places", lookup.count)?;
            let count = u64::from(lookup.count);
            let Lookup { places, places_offset, distances, distances_offset, .. } = *lookup;
            contents.push(Content::InputAndOutput(
                Part::new(on, "places", places, places_offset, 2 * WORD * count)?,
                Part::new(on, "distances", distances, distances_offset, WORD * count)?,
            ));
        }
        let (pool, sets) = describe(device, pipelines, &contents)?;
        let mut sets = sets.into_iter();
        Ok(Self {
            pool,
            results: InputSet::each(grid.slots, of_results, &mut sets),
            inline_sources: sets.next().expect("every surface has this set"),
            points: InputSet::each(points.len(), versions, &mut sets),
            sources: InputSet::each(sources.len(), versions, &mut sets),
            lookups: sets.collect(),
        })
    }

    pub(super) fn destroy(&mut self, device: &ash::Device) {
        // SAFETY: the caller has made sure that nothing uses the sets. Null handles are allowed.
        unsafe { device.destroy_descriptor_pool(self.pool, None) };
        self.pool = vk::DescriptorPool::null();
    }
}
