//! Inputs of a frame.

use ash::vk;
use bytemuck::{Pod, Zeroable};

use super::arguments::list;
use super::plan::GeosweepPlan;
use super::profile::GeosweepProfile;
use super::status::Failure;
use geosweep::vulkan::embed::{
    Access, MOST_TARGETS, MapLimit, PointSource, Reader, SourceInput, TargetPoint,
};

/// Value of `GeosweepFrame::points` if the points have not changed since the last frame.
pub const GEOSWEEP_POINTS_UNCHANGED: u32 = 0xFFFF_FFFF;

/// Value of `GeosweepSource::curvature` for a source that is one of many grid points on a straight line.
pub const GEOSWEEP_STRAIGHT: f32 = 1e-30;
const _: () = assert!(GEOSWEEP_STRAIGHT == PointSource::STRAIGHT);

/// Stages and accesses by which you use a shared resource: one side of a barrier. All zero means that there
/// is nothing to wait for. An access without a stage is an error.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepAccess {
    /// Pipeline stages.
    pub stages: vk::PipelineStageFlags,
    /// Kinds of access.
    pub access: vk::AccessFlags,
}

/// Reader of an image of distances, for the reads in this frame and the earlier reads of the same image. If
/// the access is all zero, the image is read on another queue, after a semaphore.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepReader {
    /// Stages and accesses of the reader.
    pub access: GeosweepAccess,
    /// Layout in which the recording leaves the image. It is not `VK_IMAGE_LAYOUT_UNDEFINED`.
    pub layout: vk::ImageLayout,
}

/// A source: a place at which the distance, or time, is given. `geosweep_source_at` returns a source with the
/// usual values.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct GeosweepSource {
    /// Row, from 0 to rows - 1. It has a fraction between grid points.
    pub row: f32,
    /// Column, from 0 to cols - 1.
    pub col: f32,
    /// Distance, or time, at the source; usually 0.
    pub time: f32,
    /// Curvature of the front at the source, for the curved wavefront. It is 0 if the source is a point,
    /// which sources between grid points always are. It is `GEOSWEEP_STRAIGHT` if the grid point is one of
    /// many on a straight line. In a buffer, values that are negative, infinite or NaN stand for a point too.
    pub curvature: f32,
}

/// Sources of a recording: an array in the program's memory, which is copied into the command buffer, or, if
/// that is null, a buffer.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepSources {
    /// Array of sources, or null.
    pub sources: *const GeosweepSource,
    /// Number of entries in the array, at most 1024. It is 0 if `sources` is null.
    pub count: u32,
    /// Number of the surface's source buffer, if there is no array.
    pub buffer: u32,
    /// Offset in bytes, added to the offset of the first source in that buffer
    /// (`GeosweepSourceBuffer::offset`); a multiple of 4. With a ring buffer, each frame has another offset.
    pub offset: u64,
}

/// A grid point at which a map may end.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct GeosweepTarget {
    /// Row, from 0 to rows - 1.
    pub row: u32,
    /// Column, from 0 to cols - 1.
    pub col: u32,
}

/// Inputs of a frame.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepFrame {
    /// Access that has written points and sources since the previous frame, or has used the memory of your
    /// own images of distances. The recording always waits for writes by compute shaders and copies. Writes
    /// through mapped memory before the submission need no barrier.
    pub before: GeosweepAccess,
    /// Number of the surface's points that are measured, or `GEOSWEEP_POINTS_UNCHANGED`.
    pub points: u32,
    /// Number of the image of distances that is written.
    pub slot: u32,
    /// Offset in bytes, added to the offset of these points in their buffer (`GeosweepPoints::offset`); a
    /// multiple of 4. With a ring buffer, each frame has another offset.
    pub points_offset: u64,
    /// Sources at which fronts start.
    pub sources: GeosweepSources,
    /// Plan with the passes. The surface's solver must have created it for a grid of the surface's size.
    pub plan: *const GeosweepPlan,
    /// Reader of the image of distances.
    pub reader: GeosweepReader,
    /// Value in the image at points that no front reaches: `INFINITY` or a negative number. Filters turn
    /// infinity to NaN beside such points. It must not be NaN, nor a number that may be a distance.
    pub unreached: f32,
    /// Largest distance of the map, or 0 for no limit. Points that are farther are not reached. The work is
    /// proportional to the area within the radius. Each frame may have another radius.
    pub radius: f32,
    /// Number of nearest targets whose distances are needed, at most `target_count`, or 0 for all targets.
    pub targets_needed: u32,
    /// Targets, or null. The map ends once no front can reach the needed targets earlier, and points farther
    /// than these are not reached. With raster scans, targets do not reduce the work, since an iteration brings
    /// early and late fronts in any order. Only a radius reduces it.
    pub targets: *const GeosweepTarget,
    /// Number of targets, at most 1024. It is 0 if `targets` is null.
    pub target_count: u32,
    /// Profile that records the passes of this frame, or null. A profile records one frame at a time: its
    /// previous frame must have run.
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

/// Returns the value of points without a distance, which must be no distance.
pub(super) fn unreached(given: f32, name: &str) -> Result<f32, Failure> {
    if given.is_nan() || (given >= 0.0 && given.is_finite()) {
        let reason = format!(
            "is {given}, which {}; give infinity or a negative number",
            match given {
                0.0 => "is the distance of a source",
                _ if given.is_nan() => "filters spread to other points",
                _ => "may be a distance",
            }
        );
        return Err(Failure::argument(name, reason));
    }
    Ok(given)
}

/// Smallest magnitude of [`no_place`] where no radius bounds the coordinates.
const FAR_AWAY: f32 = 1e6;

/// Returns the coordinates of points without a place in a log map, which must be no place within the radius.
pub(super) fn no_place(given: f32, radius: f32, name: &str) -> Result<f32, Failure> {
    let beyond = if radius > 0.0 { radius } else { FAR_AWAY };
    // NaN and the limit itself differ from every coordinate that is shown.
    if given.abs() < beyond {
        let reason = format!(
            "is {given}, which may be a coordinate{}; give infinity, or a number beyond {beyond}",
            if given == 0.0 { ", as that of a source" } else { "" }
        );
        return Err(Failure::argument(name, reason));
    }
    Ok(given)
}

/// Checks that there are as many targets as are needed.
pub(super) fn check_needed(needed: u32, targets: u32, name: &str) -> Result<(), Failure> {
    match needed > targets {
        true => {
            let reason = format!("is {needed}, and there are {targets} targets");
            Err(Failure::argument(name, reason))
        }
        false => Ok(()),
    }
}

/// Returns the limit of a frame's map.
///
/// # Safety
/// The array of targets has as many entries as the frame says.
pub(super) unsafe fn limit<'a>(given: &GeosweepFrame) -> Result<MapLimit<'a>, Failure> {
    let &GeosweepFrame { radius, targets, target_count, targets_needed, .. } = given;
    // SAFETY: the caller's promise.
    let targets = unsafe { list(targets, target_count, MOST_TARGETS as usize, "frame->targets") }?;
    check_needed(targets_needed, target_count, "frame->targets_needed")?;
    // Both types are two numbers with the same meaning.
    let targets = bytemuck::cast_slice::<GeosweepTarget, TargetPoint>(targets);
    Ok(MapLimit::to(targets)
        .with_radius(if radius == 0.0 { f32::INFINITY } else { radius })
        .with_needed(if targets_needed == 0 { u32::MAX } else { targets_needed }))
}

/// Returns the sources of a recording.
///
/// # Safety
/// The array has `given.count` entries.
pub(super) unsafe fn sources<'a>(
    given: &GeosweepSources,
    name: &str,
) -> Result<SourceInput<'a>, Failure> {
    if given.sources.is_null() && given.count == 0 {
        return Ok(SourceInput::BufferAt { number: given.buffer as usize, offset: given.offset });
    }
    for (member, number) in [("offset", given.offset), ("buffer", given.buffer.into())] {
        if number != 0 {
            let reason = format!("is {number}, and the sources are an array");
            let member = format!("{}{member}", name.trim_end_matches("sources"));
            return Err(Failure::argument(&member, reason));
        }
    }
    if given.count == 0 {
        let name = format!("{}count", name.trim_end_matches("sources"));
        return Err(Failure::argument(&name, "is 0, and sources is not null"));
    }
    // SAFETY: the caller's promise.
    let sources = unsafe { list(given.sources, given.count, SourceInput::MOST_INLINE, name) }?;
    // Both types are four floats with the same meaning.
    Ok(SourceInput::Inline(bytemuck::cast_slice::<GeosweepSource, PointSource>(sources)))
}

/// Returns a source at a place, with distance 0.
#[unsafe(no_mangle)]
pub extern "C" fn geosweep_source_at(row: f32, col: f32) -> GeosweepSource {
    let PointSource { row, col, time, curvature } = PointSource::at(row, col);
    GeosweepSource { row, col, time, curvature }
}
