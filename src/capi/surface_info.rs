//! What a surface is made for.

use ash::vk;

use super::arguments::list;
use super::choices::{EdgeRuleNumber, edge_rule};
use super::plan::chart;
use super::points::{Form, GeosweepPoints};
use super::solver::Shared;
use super::status::Failure;
use crate::surface::{Chart, EdgeRule};
use crate::vulkan::embed;

/// Entries of an array that describes a surface, at most.
const MOST: usize = 1024;
/// Slots, at most.
const MOST_SLOTS: u32 = 64;

/// A buffer of sources, each a `GeosweepSource`, that your shaders write. An entry that is not on
/// the grid, in a hole, or has a time that is NaN or not below 1e30 is passed over: write NaN where
/// there is none.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepSourceBuffer {
    /// With usage `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`.
    pub buffer: vk::Buffer,
    /// Bytes before the first; a multiple of 4.
    pub offset: u64,
    /// How many.
    pub count: u32,
}

/// Buffers for looking distances up: places in, distances out. Both with usage
/// `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepLookup {
    /// Two floats a place, row and column, fractional between grid points.
    pub places: vk::Buffer,
    /// Bytes before the first; a multiple of 4.
    pub places_offset: u64,
    /// One float a place.
    pub distances: vk::Buffer,
    /// Bytes before the first; a multiple of 4.
    pub distances_offset: u64,
    /// How many.
    pub count: u32,
}

/// An image of yours for the distances of a slot, in place of one that the surface makes, so that a render graph may give
/// its memory to others meanwhile. `VK_FORMAT_R32_SFLOAT`, 2D, of cols x rows texels or more, with usage
/// `VK_IMAGE_USAGE_STORAGE_BIT` and that of its readers. What is there is thrown away, whatever its layout is; who has
/// used the memory before is waited for by `GeosweepFrame::before`, or by a barrier of yours.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepHostImage {
    /// The image.
    pub image: vk::Image,
    /// A view of it.
    pub view: vk::ImageView,
}

/// What a surface is made for. Images and buffers stay yours: they must be alive whenever
/// a recording that reads them runs. The arrays are not needed after the call, and may be null
/// where their count is 0.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepSurfaceInfo {
    /// Rows of grid points.
    pub rows: u32,
    /// Columns of grid points.
    pub cols: u32,
    /// How edges are measured.
    pub edge_rule: EdgeRuleNumber,
    /// How many images of distances there are, to be written in turn: as many as frames in flight,
    /// from 1 to 64.
    pub slots: u32,
    /// The queue families that use the images of distances and the packed distances: ours and the
    /// readers'. If they differ, no ownership needs to be transferred. None: one family at a time
    /// uses them.
    pub queue_families: *const u32,
    /// How many.
    pub queue_family_count: u32,
    /// Images of yours for the distances, one a slot; null for images that the surface makes.
    pub results: *const GeosweepHostImage,
    /// How many: 0 or as many as slots.
    pub result_count: u32,
    /// Where points may come from, by number: one for each frame in flight, say.
    pub points: *const GeosweepPoints,
    /// How many.
    pub point_count: u32,
    /// Buffers that sources may come from, by number.
    pub sources: *const GeosweepSourceBuffer,
    /// How many.
    pub source_count: u32,
    /// Buffers for lookups, by number.
    pub lookups: *const GeosweepLookup,
    /// How many.
    pub lookup_count: u32,
}

impl From<GeosweepHostImage> for embed::HostImage {
    fn from(image: GeosweepHostImage) -> Self {
        let GeosweepHostImage { image, view } = image;
        Self { image, view }
    }
}

/// What is asked for, checked.
pub(super) struct Wanted<'a> {
    pub(super) chart: Chart,
    pub(super) edge_rule: EdgeRule,
    slots: usize,
    families: &'a [u32],
    results: Vec<embed::HostImage>,
    pub(super) points: Vec<Form>,
    sources: Vec<embed::SourceBuffer>,
    lookups: Vec<embed::Lookup>,
}

impl<'a> Wanted<'a> {
    /// # Safety
    /// The arrays are as long as is said.
    pub(super) unsafe fn new(info: &'a GeosweepSurfaceInfo) -> Result<Self, Failure> {
        let GeosweepSurfaceInfo { rows, cols, slots, .. } = *info;
        if !(1..=MOST_SLOTS).contains(&slots) {
            let reason = format!("is {slots}: as many as frames in flight, from 1 to {MOST_SLOTS}");
            return Err(Failure::argument("info->slots", reason));
        }
        // SAFETY: the caller's promise.
        let (families, results, points, sources, lookups) = unsafe {
            let families = info.queue_families;
            (
                list(families, info.queue_family_count, MOST, "info->queue_families")?,
                list(info.results, info.result_count, MOST, "info->results")?,
                list(info.points, info.point_count, MOST, "info->points")?,
                list(info.sources, info.source_count, MOST, "info->sources")?,
                list(info.lookups, info.lookup_count, MOST, "info->lookups")?,
            )
        };
        let form = |(index, points)| Form::of(points, &name(index));
        let sources = sources.iter().map(|sources| {
            let GeosweepSourceBuffer { buffer, offset, count } = *sources;
            embed::SourceBuffer { buffer, offset, count }
        });
        let lookups = lookups.iter().map(|lookup| {
            let GeosweepLookup { places, places_offset, distances, distances_offset, count } =
                *lookup;
            embed::Lookup { places, places_offset, distances, distances_offset, count }
        });
        Ok(Self {
            chart: chart(rows, cols)?,
            edge_rule: edge_rule(info.edge_rule, "info->edge_rule")?,
            slots: slots as usize,
            families,
            results: results.iter().map(|&image| image.into()).collect(),
            points: points.iter().enumerate().map(form).collect::<Result<_, _>>()?,
            sources: sources.collect(),
            lookups: lookups.collect(),
        })
    }

    pub(super) fn info(&'a self, points: &'a [embed::Points]) -> embed::SurfaceInfo<'a> {
        embed::SurfaceInfo {
            chart: self.chart,
            edge_rule: self.edge_rule,
            slots: self.slots,
            queue_families: self.families,
            results: &self.results,
            points,
            sources: &self.sources,
            lookups: &self.lookups,
        }
    }

    pub(super) fn bytes(&self, shared: &Shared) -> Result<u64, Failure> {
        let mut bytes = shared.solver.bytes_for(&shared.device, &self.info(&[]))?;
        for form in &self.points {
            if let Form::InProgram(layout, _) = form {
                bytes += layout.buffer(self.chart).bytes(&shared.device)?;
            }
        }
        Ok(bytes)
    }
}

/// The name of points in messages.
pub(super) fn name(index: usize) -> String {
    format!("info->points[{index}]")
}
