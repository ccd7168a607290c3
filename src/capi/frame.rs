//! What a frame takes.

use ash::vk;
use bytemuck::{Pod, Zeroable};

use super::arguments::list;
use super::objects::object;
use super::plan::GeosweepPlan;
use super::profile::GeosweepProfile;
use super::status::Failure;
use super::surface::GeosweepSurface;
use crate::vulkan::embed::{self, Access, PointSource, Reader, SourceInput};
use crate::vulkan::grid_images::INLINE_SOURCES;

/// For `GeosweepFrame::points`: the points have not changed since the last frame.
pub const GEOSWEEP_POINTS_UNCHANGED: u32 = 0xFFFF_FFFF;

/// For `GeosweepSource::curvature`: the source is one of many grid points on a straight line.
pub const GEOSWEEP_STRAIGHT: f32 = 1e-30;
const _: () = assert!(GEOSWEEP_STRAIGHT == PointSource::STRAIGHT);

/// How you use what you share with us, as one side of a barrier. All zero: nothing to wait for. An access without a
/// stage is an error.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepAccess {
    /// In which stages.
    pub stages: vk::PipelineStageFlags,
    /// Of which kinds.
    pub access: vk::AccessFlags,
}

/// How you read an image of distances, this frame and whenever you read that image before. With an
/// access of all zero you read it on another queue, after a semaphore.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepReader {
    /// In which stages, and how.
    pub access: GeosweepAccess,
    /// The layout in which the image is left.
    pub layout: vk::ImageLayout,
}

/// A source: a place where the distance, or time, is known. `geosweep_source_at` makes the usual one.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct GeosweepSource {
    /// From 0 to rows - 1, fractional between grid points.
    pub row: f32,
    /// From 0 to cols - 1.
    pub col: f32,
    /// The distance, or time, at the source; usually 0.
    pub time: f32,
    /// Of the front there, for the curved wavefront: 0 where the source is a point, as sources between grid
    /// points are in any case; `GEOSWEEP_STRAIGHT` where the grid point is one of many on a straight line. In a
    /// buffer, what is negative, infinite or no number stands for a point as well.
    pub curvature: f32,
}

/// The sources of a recording: an array of the program's, which is copied into the command buffer,
/// or, if that is null, a buffer.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepSources {
    /// The array, or null.
    pub sources: *const GeosweepSource,
    /// Its length, at most 1024; 0 with null.
    pub count: u32,
    /// The number of the surface's source buffer, if there is no array.
    pub buffer: u32,
    /// Bytes beyond the first source that the surface has in that buffer, as in a ring of which each frame has
    /// another part; a multiple of 4.
    pub offset: u64,
}

/// What a frame takes.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepFrame {
    /// How you have written points and sources since the frame before: compute shaders and copies
    /// are waited for in any case, and what you write through mapped memory before you submit needs
    /// nothing.
    pub before: GeosweepAccess,
    /// Which of the surface's points are measured, or `GEOSWEEP_POINTS_UNCHANGED`.
    pub points: u32,
    /// Which image of distances is written.
    pub slot: u32,
    /// Bytes beyond where the surface has these points in their buffer, as in a ring of which each frame has another
    /// part; a multiple of 4.
    pub points_offset: u64,
    /// Where the fronts start.
    pub sources: GeosweepSources,
    /// The passes, made by the surface's solver for a grid of the surface's size.
    pub plan: *const GeosweepPlan,
    /// Who reads the image of distances.
    pub reader: GeosweepReader,
    /// What stands in it where nothing was reached: `INFINITY`, which filters turn to NaN beside
    /// such points, or a negative number. Neither 0, which is the distance of sources, nor NaN.
    pub unreached: f32,
    /// Where the passes of this frame are taken down, or null. One frame at a time: that of the same profile before
    /// has run.
    pub profile: *const GeosweepProfile,
}

pub(super) fn access(given: GeosweepAccess, name: &str) -> Result<Access, Failure> {
    let GeosweepAccess { stages, access } = given;
    if !stages.is_empty() {
        return Ok(Access::new(stages, access));
    }
    if !access.is_empty() {
        let reason = format!(
            "is 0, and the access beside it is {:#x}: stages of VkPipelineStageFlags2 above the 32nd bit are no \
             VkPipelineStageFlags, in which a copy is VK_PIPELINE_STAGE_TRANSFER_BIT",
            access.as_raw()
        );
        return Err(Failure::argument(&format!("{name}.stages"), reason));
    }
    // Vulkan has no barrier without a stage.
    Ok(Access::NONE)
}

pub(super) fn reader(given: GeosweepReader, name: &str) -> Result<Reader, Failure> {
    let GeosweepReader { access, layout } = given;
    if [vk::ImageLayout::UNDEFINED, vk::ImageLayout::PREINITIALIZED].contains(&layout) {
        let reason = format!("is {}, in which no image can be read", layout.as_raw());
        return Err(Failure::argument(&format!("{name}layout"), reason));
    }
    let access = self::access(access, "access");
    let access = access.map_err(|failure| failure.inside(name))?;
    Ok(Reader { access, layout })
}

pub(super) fn unreached(given: f32, name: &str) -> Result<f32, Failure> {
    if given.is_nan() || given == 0.0 {
        let reason = format!("is {given}: give infinity or a number that no distance is");
        return Err(Failure::argument(name, reason));
    }
    Ok(given)
}

/// # Safety
/// The array is as long as is said.
pub(super) unsafe fn sources<'a>(
    given: &GeosweepSources,
    name: &str,
) -> Result<SourceInput<'a>, Failure> {
    if given.sources.is_null() && given.count == 0 {
        return Ok(SourceInput::BufferAt { number: given.buffer as usize, offset: given.offset });
    }
    if given.offset != 0 {
        let reason = format!("is {}, and the sources are an array", given.offset);
        return Err(Failure::argument(&name.replace(".sources", ".offset"), reason));
    }
    // SAFETY: the caller's promise.
    let sources = unsafe { list(given.sources, given.count, INLINE_SOURCES, name) }?;
    // Both are four floats of the same meaning.
    Ok(SourceInput::Inline(bytemuck::cast_slice::<GeosweepSource, PointSource>(sources)))
}

/// # Safety
/// The pointer is null or a plan's.
pub(super) unsafe fn plan<'a>(
    plan: *const GeosweepPlan,
    surface: &GeosweepSurface,
    name: &str,
) -> Result<&'a embed::Plan, Failure> {
    // SAFETY: the caller's promise.
    let plan = unsafe { object(plan, name) }?;
    if !std::sync::Arc::ptr_eq(&plan.shared, &surface.shared) {
        return Err(Failure::argument(name, "was made by another solver than the surface"));
    }
    Ok(&plan.plan)
}

/// A source at a place, with distance 0.
#[unsafe(no_mangle)]
pub extern "C" fn geosweep_source_at(row: f32, col: f32) -> GeosweepSource {
    let PointSource { row, col, time, curvature } = PointSource::at(row, col);
    GeosweepSource { row, col, time, curvature }
}
