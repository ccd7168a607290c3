//! Errors of the Vulkan engine.

use ash::vk;

use super::Schedule;
use crate::surface::{SourceError, SurfaceError};
use crate::update::Wavefront;

/// Reason why the Vulkan engine cannot run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VulkanError {
    /// The system has no Vulkan loader.
    #[error(
        "no Vulkan loader on this machine ({0}); install one (libvulkan1 on Debian and Ubuntu) \
         or use the CPU engine"
    )]
    NoLoader(String),
    /// The loader finds no driver, or the driver no device.
    #[error(
        "the Vulkan loader finds no device; install a driver (mesa-vulkan-drivers on Debian and \
         Ubuntu brings lavapipe, which needs no GPU) or use the CPU engine"
    )]
    NoDevice,
    /// No device meets the requirements.
    #[error("no Vulkan device is usable: {0}")]
    NoUsableDevice(String),
    /// The requested device does not exist.
    #[error("there is no Vulkan device {wanted}; available: {available}")]
    UnknownDevice {
        /// Requested name or index.
        wanted: String,
        /// Devices that exist.
        available: String,
    },
    /// The requested device does not meet the requirements.
    #[error("Vulkan device \"{device}\" is not usable: {unmet}")]
    Unusable {
        /// Name of the device.
        device: String,
        /// Requirements that the device does not meet.
        unmet: String,
    },
    /// The grid is larger than the device's images can be.
    #[error(
        "a grid of {rows} x {cols} points is too large for \"{device}\": it holds at most \
         {limit} points a side; use the CPU engine"
    )]
    TooLarge {
        /// Number of rows of the grid.
        rows: usize,
        /// Number of columns of the grid.
        cols: usize,
        /// Name of the device.
        device: String,
        /// Largest number of rows or columns.
        limit: usize,
    },
    /// The grid needs more memory than the device has.
    #[error(
        "a grid of {rows} x {cols} points needs {needed} MiB on \"{device}\", which has \
         {available} MiB; use the CPU engine"
    )]
    TooMuchMemory {
        /// Number of rows of the grid.
        rows: usize,
        /// Number of columns of the grid.
        cols: usize,
        /// Name of the device.
        device: String,
        /// Memory needed, in MiB.
        needed: u64,
        /// Size of the device's largest heap, in MiB.
        available: u64,
    },
    /// The device has no room for portions of these sizes.
    #[error("maps cannot be solved in such portions: {0}")]
    Tuning(String),
    /// A map was to be computed in shared memory and does not fit there.
    #[error(
        "a map of {rows} x {cols} points does not fit the {available} bytes of shared memory of \
         \"{device}\"; compute it in images"
    )]
    NotInSharedMemory {
        /// Number of rows of the grid.
        rows: usize,
        /// Number of columns of the grid.
        cols: usize,
        /// Name of the device.
        device: String,
        /// Shared memory of a workgroup, in bytes.
        available: u32,
    },
    /// A memory allocation failed.
    #[error("cannot allocate {what} on the device: {source}")]
    Allocation {
        /// Name of the resource.
        what: &'static str,
        /// Error of the allocator.
        source: gpu_allocator::AllocationError,
    },
    /// A Vulkan call failed.
    #[error("{call} failed: {result}{}", hint(*.result))]
    Call {
        /// Name of the Vulkan function.
        call: &'static str,
        /// Result that the call returned.
        result: vk::Result,
    },
    /// Validation was requested and its layer is missing.
    #[error(
        "the layer VK_LAYER_KHRONOS_validation is missing; install it (vulkan-validationlayers \
         on Debian and Ubuntu) or turn validation off"
    )]
    NoValidationLayer,
    /// The validation layers reported messages.
    #[error("the Vulkan validation layers report {} message(s), the first: {}", .0.len(), .0[0])]
    Validation(Vec<String>),
    /// A plan was requested without the pipelines that it needs.
    #[error(
        "the solver was not made for {schedule} with {wavefront} fronts: name both to HeadlessSolver::new or add_passes"
    )]
    NoPasses {
        /// Requested schedule.
        schedule: Schedule,
        /// Requested wavefront.
        wavefront: Wavefront,
    },
    /// A buffer or image of the host cannot be used as described.
    #[error("your buffer or image of {what} cannot be used: {reason}")]
    HostBuffer {
        /// Contents of the buffer or image.
        what: &'static str,
        /// Reason why it cannot be used.
        reason: String,
    },
    /// The surface has no buffer or image with this number.
    #[error(
        "the surface has {count} {what}, counted from 0, but number {number} was asked for{}",
        if *count == 0 { where_listed(what) } else { "" }
    )]
    NoSuch {
        /// Kind of the buffer or image.
        what: &'static str,
        /// Requested number.
        number: usize,
        /// Number of buffers or images of this kind.
        count: usize,
    },
    /// A profile was requested from a solver that was not made for profiling.
    #[error("the solver was not made for profiling: make it with HeadlessSolver::for_profiling")]
    NotForProfiling,
    /// The plan was made for a grid of another size.
    #[error("the plan was made for a grid of another size than the surface's")]
    OtherGrid,
    /// The plan was made with [`over_seams`](super::embed::Plan::over_seams) and the surface is not glued, or
    /// the surface is glued and the plan was made without it.
    #[error("{}", if *.is_glued {
        "the surface is glued, but the plan has no step over seams: make the plan with Plan::over_seams"
    } else {
        "the plan passes seams, but the surface is not glued: make the plan without Plan::over_seams"
    })]
    OtherGluing {
        /// Whether the surface is glued.
        is_glued: bool,
    },
    /// The surface was used before it was prepared.
    #[error("the surface is not prepared: record Recording::prepare once, before anything else")]
    NotPrepared,
    /// A map was requested before the edges were measured.
    #[error(
        "the surface was never measured for such maps: measure its points in the first frame, and again \
         after it is prepared anew or curved passes are added to the solver"
    )]
    NotMeasured,
    /// A result of a map was requested before there was a map.
    #[error("the surface has no map yet: solve one before this, and again after measuring")]
    NoMap,
    /// A map was to be continued with another method than the one it was started with.
    #[error(
        "the map was started with another wavefront or schedule: go on with its own plan, add sources \
         and find regions with its own wavefront"
    )]
    OtherMap,
    /// An outcome was requested before the recording ran.
    #[error(
        "the last recording for slot {slot} has not run: ask for its outcome after the fence of its \
         submission"
    )]
    NotRun {
        /// Number of the slot.
        slot: usize,
    },
    /// A slot was recorded while its last recording had not run.
    #[error(
        "slot {slot} is recorded again and its last recording has not run: use as many slots as frames \
         in flight, and wait for the fence of a frame before its slot is recorded again"
    )]
    InFlight {
        /// Number of the slot.
        slot: usize,
    },
    /// The preparation of the surface was recorded and never ran on the device.
    #[error(
        "the surface's preparation was recorded and has not run, so that its maps are wrong: submit it before its \
         first frame, or record it again in the same command buffer as that frame"
    )]
    PreparationLost,
    /// The surface owns its images of distances.
    #[error(
        "the surface was made with images of distances of its own: give it the host's when it is made \
         (SurfaceInfo::results)"
    )]
    OwnResults,
    /// Points, sources or another input of the surface were replaced while all of their descriptor sets were
    /// in use.
    #[error(
        "the surface's {what} {number} are replaced again while recordings that read them have not run: wait for \
         the fence of a frame, or use as many slots as frames in flight"
    )]
    InputInFlight {
        /// Kind of the input: points or sources.
        what: &'static str,
        /// Number of the input.
        number: usize,
    },
    /// Contours, paths, regions, directions or a log map were rebound while all of their descriptor sets were in
    /// use.
    #[error(
        "the contours, paths, regions, directions or log map are rebound again while recordings that use them have \
         not run: wait for the fence of a frame, or use as many slots as frames in flight"
    )]
    RebindInFlight,
    /// Contours, paths, regions, directions or a log map were made before an input of their surface was
    /// replaced.
    #[error(
        "the surface's {what} {number} were replaced after its contours, paths, regions, directions or log map \
         were made: call `rebind` on them first"
    )]
    OldInput {
        /// Kind of the input: points or sources.
        what: &'static str,
        /// Number of the input.
        number: usize,
    },
    /// A map cannot end at the given radius or targets.
    #[error("the limit of the map cannot be used: {0}")]
    Limit(String),
    /// One of several frames that are recorded together cannot be recorded.
    #[error("frame {number} (counted from 0) of the frames that are recorded together: {source}")]
    OfFrame {
        /// Number of the frame.
        number: usize,
        /// Error of this frame.
        source: Box<VulkanError>,
    },
    /// Two of the frames that are recorded together belong to one surface.
    #[error(
        "its surface has another frame among them: frames of one surface follow one another, in recordings of \
         their own"
    )]
    TwiceTogether,
    /// Copies of a point of a glued surface lie apart.
    #[error(
        "copies of a point{} of the glued surface lie {gap:.2} of a cell apart: check which sides continue each other, \
         and in which order",
        place.map_or(String::new(), |(row, col)| format!(" (row {row}, column {col})"))
    )]
    SeamGap {
        /// Largest gap between copies, relative to a cell.
        gap: f64,
        /// Row and column of the first copy of that point, if it is known.
        place: Option<(usize, usize)>,
    },
    /// A profile was given to a recording while another recording with it has not run.
    #[error(
        "the profile is used in a recording that has not run: wait for its fence, or use a profile for each frame in \
         flight"
    )]
    ProfileInFlight,
    /// The surface was used after it was destroyed.
    #[error("the surface was destroyed before")]
    Destroyed,
    /// Contours, paths, regions, directions or a log map were made for another surface.
    #[error(
        "the contours, paths, regions, directions or log map were made for another surface than the recording's"
    )]
    OtherSurface,
    /// An output is asked for other sources than those of the map.
    #[error(
        "the sources of the {what} are not those of the map: give all sources of the map, with those that were added to \
         it, in an array or from the place in the buffer from which the map was solved"
    )]
    OtherSources {
        /// Kind of the output.
        what: &'static str,
    },
    /// Contours, paths, regions, directions or a log map cannot be made or recorded as requested.
    #[error("no {what}: {reason}")]
    Curves {
        /// Kind of the result.
        what: &'static str,
        /// Reason for the failure.
        reason: String,
    },
    /// More sources were given than a recording can contain.
    #[error("{given} sources are more than the {most} that a recording can hold: use a buffer")]
    TooManySources {
        /// Number of sources given.
        given: usize,
        /// Largest number of sources in a recording.
        most: usize,
    },
    /// A map with anchors has no room for this number of sources inside cells.
    #[error(
        "more than {most} sources inside cells are too many for a map of anchored fronts: solve for all of \
         them at once, which takes curved ones then, or add them to a map of curved fronts"
    )]
    TooManyAnchors {
        /// Largest number of sources inside cells.
        most: usize,
    },
    /// A source cannot be used.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The surface cannot be used.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
}

impl VulkanError {
    /// Returns a function that turns the result of the Vulkan function `call` into an error.
    pub(crate) fn from_call(call: &'static str) -> impl Fn(vk::Result) -> Self {
        move |result| Self::Call { call, result }
    }
}

/// Returns the advice to list inputs of a kind when a surface is made that has none of them.
fn where_listed(what: &str) -> &'static str {
    match what {
        "point inputs" => "; list them in `points` of the surface's info when it is made",
        "source buffers" => {
            "; list them in `sources` of the surface's info when it is made, or give the sources in an array"
        }
        "lookups" => "; list them in `lookups` of the surface's info when it is made",
        _ => "",
    }
}

fn hint(result: vk::Result) -> &'static str {
    match result {
        vk::Result::ERROR_DEVICE_LOST => {
            "; the driver has given the device up (a reset, a time-out or a fault): try again, \
             or use the CPU engine"
        }
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => {
            "; use a smaller grid or the CPU engine"
        }
        _ => "",
    }
}
