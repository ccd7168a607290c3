//! Creates the descriptor sets of a surface: for its images of distances, and for the host's images and
//! buffers.

use ash::vk;

use super::host_sets::{
    BufferRange, Content, HostSet, WORD, check_count, describe, inline_sources_content,
    measured_content, sources_content,
};
use super::input_sets::{Versions, versions};
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
    pub(super) results: Vec<Versions>,
    pub(super) inline_sources: HostSet,
    pub(super) points: Vec<Versions>,
    pub(super) sources: Vec<Versions>,
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
        let result_versions = if results.is_empty() { 1 } else { versions };
        let views = grid.results.iter().map(|image| image.view);
        let views = views.chain(results.iter().map(|image| image.view));
        let mut contents: Vec<_> = views
            .flat_map(|view| std::iter::repeat_n(Content::result(view), result_versions))
            .collect();
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
            let input = BufferRange::new(on, "places", places, places_offset, 2 * WORD * count)?;
            let output =
                BufferRange::new(on, "distances", distances, distances_offset, WORD * count)?;
            contents.push(Content::input(input).and_output(output));
        }
        let (pool, sets) = describe(device, pipelines, &contents, &grid.owner)?;
        let (of_results, rest) = sets.split_at(grid.slots * result_versions);
        let (inline_sources, rest) = rest.split_first().expect("every surface has this set");
        let (of_points, rest) = rest.split_at(points.len() * versions);
        let (of_sources, of_lookups) = rest.split_at(sources.len() * versions);
        Ok(Self {
            pool,
            results: Versions::of_inputs(of_results, result_versions),
            inline_sources: *inline_sources,
            points: Versions::of_inputs(of_points, versions),
            sources: Versions::of_inputs(of_sources, versions),
            lookups: of_lookups.to_vec(),
        })
    }

    pub(super) fn destroy(&mut self, device: &ash::Device) {
        // SAFETY: the caller has made sure that nothing uses the sets. Null handles are allowed.
        unsafe { device.destroy_descriptor_pool(self.pool, None) };
        self.pool = vk::DescriptorPool::null();
    }
}
