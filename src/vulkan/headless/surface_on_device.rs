//! Holds a surface on a device, with the resources of its maps other than the solver's pipelines.

use std::sync::Arc;

use super::context::{CommandBuffer, Context};
use crate::constants::SOURCES_INSIDE;
use crate::surface::{Chart, Origins, Seed, Surface};
use crate::update::{Setting, Wavefront};
use crate::vulkan::copies::CopyList;
use crate::vulkan::device::passes::{Splits, Variant};
use crate::vulkan::device::pipelines::Pipelines;
use crate::vulkan::grid_images::{GridImages, Purpose};
use crate::vulkan::schedules::plan::Step;
use crate::vulkan::upload::{Anchors, curvatures};
use crate::vulkan::{TexelChart, VulkanError};

/// Edge lengths of a surface on a device, ready for any number of maps.
///
/// Dropping it frees its memory. It keeps its device open.
pub struct SurfaceOnDevice {
    pub(in crate::vulkan) images: GridImages,
    /// Anchors, if the surface is a floor plan.
    pub(in crate::vulkan) anchors: Option<Anchors>,
    /// The splits of the surface's obtuse triangles, according to its edges.
    pub(in crate::vulkan) splits: Splits,
    /// Whether the slowness of the surface is not the same everywhere.
    pub(in crate::vulkan) slowed: bool,
    /// Whether the fronts of the last map have anchors.
    is_anchored: bool,
    /// Origins of the last map's fronts.
    pub(in crate::vulkan) origins: Origins,
    /// Command buffer that starts a map.
    pub(in crate::vulkan) first: CommandBuffer,
    /// Command buffers that continue a map, one for each part of the steps in `goes_on`. `goes_on` also holds
    /// their variant, and whether they are for maps with targets.
    pub(in crate::vulkan) further: Vec<CommandBuffer>,
    pub(in crate::vulkan) goes_on: Option<((Variant, bool), Vec<Step>)>,
    pub(in crate::vulkan) context: Arc<Context>,
}

/// State of the map before the seeds.
#[derive(Clone, Copy, PartialEq)]
pub(in crate::vulkan) enum Start {
    /// All points are unreached.
    Fresh,
    /// Points have the fronts of the last map.
    FromLast,
}

impl SurfaceOnDevice {
    /// Allocates the resources of a surface with these texels.
    pub(in crate::vulkan) fn new(
        context: &Arc<Context>,
        pipelines: &Pipelines,
        surface: &Surface,
        texels: TexelChart,
    ) -> Result<Self, VulkanError> {
        let first = CommandBuffer::new(context)?;
        let slowed = surface.is_slowed_unevenly();
        // These loops run before the allocator is locked. A thread that waits for others in a loop may take up other
        // work, which may need the allocator too.
        let anchors = Anchors::of(surface, texels);
        let copies = surface.copies().map(|groups| CopyList::of_groups(surface.chart(), groups));
        let sizes = (surface.chart(), texels);
        let images = allocated(context, pipelines, sizes, Purpose::headless(slowed), copies)?;
        Ok(Self {
            images,
            anchors,
            splits: Splits::None,
            slowed,
            is_anchored: false,
            origins: Origins::none(slowed),
            first,
            further: Vec::new(),
            goes_on: None,
            context: Arc::clone(context),
        })
    }

    /// Returns the wavefront itself, or the curved one where the surface does not allow it.
    pub(in crate::vulkan) fn suited(&self, wavefront: Wavefront, has_anchors: bool) -> Wavefront {
        match wavefront.or_curved(Setting::of_device(has_anchors)) {
            // Circles have no centre where rays bend.
            Wavefront::Circular if self.slowed => Wavefront::Curved,
            wavefront => wavefront,
        }
    }

    /// Returns the wavefront of a map, and what the fronts at its seeds carry in addition to their times.
    pub(in crate::vulkan) fn begin(
        &mut self,
        wavefront: Wavefront,
        seeds: &[Seed],
        start: Start,
    ) -> Result<(Wavefront, Vec<f32>), VulkanError> {
        let goes_on = start == Start::FromLast;
        if !goes_on {
            self.origins.forget();
        }
        seeds.iter().for_each(|seed| self.origins.add(seed));
        // A map is continued with the fronts with which it was started.
        let has_anchors = self.anchors.is_some() && (!goes_on || self.is_anchored);
        let wavefront = self.suited(wavefront, has_anchors);
        let is_anchored = wavefront == Wavefront::Anchored;
        if let Some(anchors) = self.anchors.as_mut().filter(|_| is_anchored) {
            if !goes_on {
                anchors.forget();
            }
            if let Some(numbers) = anchors.numbers(seeds) {
                anchors.write(self.images.anchors());
                self.is_anchored = true;
                return Ok((wavefront, numbers));
            }
            if goes_on {
                return Err(VulkanError::TooManyAnchors { most: SOURCES_INSIDE as usize });
            }
        }
        self.is_anchored = false;
        // A wavefront that is still anchored here has no room for the numbers of its sources.
        let wavefront = wavefront.or_curved(Setting::of_device(false));
        Ok((wavefront, curvatures(seeds)))
    }

    /// Returns the bytes of device and staging memory held.
    pub fn bytes(&self) -> u64 {
        self.images.bytes()
    }
}

/// Allocates the images of a surface, and the list of its copies if it is glued. The allocator is locked meanwhile.
fn allocated(
    context: &Context,
    pipelines: &Pipelines,
    sizes: (Chart, TexelChart),
    purpose: Purpose,
    copies: Option<CopyList>,
) -> Result<GridImages, VulkanError> {
    let (device, allocator) = (&context.device, &mut *context.allocator());
    let mut images = GridImages::new(device, allocator, pipelines, sizes, purpose)?;
    if let Some(copies) = copies
        && let Err(error) = images.glue(device, allocator, pipelines, copies)
    {
        images.destroy(device, allocator);
        return Err(error);
    }
    Ok(images)
}

impl Drop for SurfaceOnDevice {
    fn drop(&mut self) {
        self.images.destroy(&self.context.device, &mut self.context.allocator());
    }
}
