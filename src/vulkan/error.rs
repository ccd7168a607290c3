//! Why the Vulkan engine cannot run.

use ash::vk;

use super::Schedule;
use crate::surface::{SourceError, SurfaceError};
use crate::update::Wavefront;

/// Why the Vulkan engine cannot run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VulkanError {
    /// There is no Vulkan loader.
    #[error(
        "no Vulkan loader on this machine ({0}); install one (libvulkan1 on Debian and Ubuntu) \
         or use the CPU engine"
    )]
    NoLoader(String),
    /// The loader has no driver, or the driver no device.
    #[error(
        "the Vulkan loader finds no device; install a driver (mesa-vulkan-drivers on Debian and \
         Ubuntu brings lavapipe, which needs no GPU) or use the CPU engine"
    )]
    NoDevice,
    /// No device meets the requirements.
    #[error("no Vulkan device is usable: {0}")]
    NoUsableDevice(String),
    /// The device asked for does not exist.
    #[error("there is no Vulkan device {wanted}; available: {available}")]
    UnknownDevice {
        /// The name or index asked for.
        wanted: String,
        /// The devices there are.
        available: String,
    },
    /// The device asked for does not meet the requirements.
    #[error("Vulkan device \"{device}\" is not usable: {unmet}")]
    Unusable {
        /// Its name.
        device: String,
        /// What it lacks.
        unmet: String,
    },
    /// The grid is larger than the device's images.
    #[error(
        "a grid of {rows} x {cols} points is too large for \"{device}\": it holds at most \
         {limit} points a side; use the CPU engine"
    )]
    TooLarge {
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        cols: usize,
        /// The device's name.
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
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        cols: usize,
        /// The device's name.
        device: String,
        /// MiB needed.
        needed: u64,
        /// MiB in the device's largest heap.
        available: u64,
    },
    /// Portions of such sizes do not fit the device.
    #[error("maps cannot be solved in such portions: {0}")]
    Tuning(String),
    /// A map was to be computed in shared memory and does not fit it.
    #[error(
        "a map of {rows} x {cols} points does not fit the {available} bytes of shared memory of \
         \"{device}\"; compute it in images"
    )]
    NotInSharedMemory {
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        cols: usize,
        /// The device's name.
        device: String,
        /// Bytes of shared memory of a workgroup.
        available: u32,
    },
    /// An allocation failed.
    #[error("cannot allocate {what} on the device: {source}")]
    Allocation {
        /// Which resource.
        what: &'static str,
        /// The allocator's word.
        source: gpu_allocator::AllocationError,
    },
    /// A Vulkan call failed.
    #[error("{call} failed: {result}{}", hint(*.result))]
    Call {
        /// The call.
        call: &'static str,
        /// What it returned.
        result: vk::Result,
    },
    /// Validation was asked for and its layer is missing.
    #[error(
        "the layer VK_LAYER_KHRONOS_validation is missing; install it (vulkan-validationlayers \
         on Debian and Ubuntu) or turn validation off"
    )]
    NoValidationLayer,
    /// The validation layers found something.
    #[error("the Vulkan validation layers report {} message(s), the first: {}", .0.len(), .0[0])]
    Validation(Vec<String>),
    /// A plan was asked for without the pipelines that it needs.
    #[error(
        "the solver was not made for {schedule} with {wavefront} fronts: name both to Solver::new or add_passes"
    )]
    NoPasses {
        /// The schedule asked for.
        schedule: Schedule,
        /// The wavefront asked for.
        wavefront: Wavefront,
    },
    /// A buffer or image of the host's cannot be used as described.
    #[error("your buffer or image of {what} cannot be used: {reason}")]
    HostBuffer {
        /// What it holds.
        what: &'static str,
        /// What is wrong with it.
        reason: String,
    },
    /// A surface has no buffer or image with this number.
    #[error(
        "the surface has {count} {what}, counted from 0, and number {number} was asked for{}",
        if *count == 0 { "; it is made with them, unless an array is given in their place" } else { "" }
    )]
    NoSuch {
        /// Of which kind.
        what: &'static str,
        /// The number asked for.
        number: usize,
        /// How many there are.
        count: usize,
    },
    /// A profile was asked for of a solver that was made without.
    #[error("the solver was not made for profiling: make it with Solver::for_profiling")]
    NotForProfiling,
    /// A plan was made for a grid of another size.
    #[error("the plan was made for a grid of another size than the surface's")]
    OtherGrid,
    /// A surface was used before it was prepared.
    #[error("the surface is not prepared: record that once, before anything else")]
    NotPrepared,
    /// A map was asked for before there were edges.
    #[error(
        "the surface was never measured for such maps: measure its points in the first frame, and again \
         after it is prepared anew or curved passes are added to the solver"
    )]
    NotMeasured,
    /// Something of a map was asked for before there was one.
    #[error("the surface has no map yet: solve one before this, and again after measuring")]
    NoMap,
    /// A map is to go on with another method than it was started with.
    #[error(
        "the map was started with another wavefront or schedule: go on with its own plan, add sources \
         and find regions with its own wavefront"
    )]
    OtherMap,
    /// An outcome was asked for before the recording has run.
    #[error(
        "the last recording for slot {slot} has not run: ask for its outcome after the fence of its \
         submission"
    )]
    NotRun {
        /// The slot.
        slot: usize,
    },
    /// A slot is recorded while its last recording has not run.
    #[error(
        "slot {slot} is recorded again and its last recording has not run: use as many slots as frames \
         in flight, and wait for the fence of a frame before its slot is recorded again"
    )]
    InFlight {
        /// The slot.
        slot: usize,
    },
    /// The device has never seen the surface's preparation.
    #[error(
        "the surface's preparation was recorded and has not run, so that its maps are wrong: submit it before its \
         first frame, or record it again in the same command buffer as that"
    )]
    PreparationLost,
    /// The surface has images of distances of its own.
    #[error(
        "the surface was made with images of distances of its own: give it the host's when it is made \
         (SurfaceInfo::results)"
    )]
    OwnResults,
    /// Points or sources are replaced while all of their descriptors are in use.
    #[error(
        "the surface's {what} {number} are replaced again while recordings that read them have not run: wait for \
         the fence of a frame, or use as many slots as frames in flight"
    )]
    InputInFlight {
        /// Points or sources.
        what: &'static str,
        /// Their number.
        number: usize,
    },
    /// Contours, paths or regions were made before an input of their surface was replaced.
    #[error(
        "the surface's {what} {number} were replaced after its contours, paths or regions were made: call their \
         rebind first"
    )]
    OldInput {
        /// Points or sources.
        what: &'static str,
        /// Their number.
        number: usize,
    },
    /// One of several frames that are recorded together cannot be.
    #[error("frame {number} of those recorded together, counted from 0: {source}")]
    OfFrame {
        /// Its number.
        number: usize,
        /// What is wrong with it.
        source: Box<VulkanError>,
    },
    /// Two of the frames that are recorded together are of one surface.
    #[error(
        "its surface has another frame among them: frames of one surface follow one another, in recordings of \
         their own"
    )]
    TwiceTogether,
    /// A surface was used after it was destroyed.
    #[error("the surface was destroyed before")]
    Destroyed,
    /// Contours or paths were made for another surface.
    #[error("the contours or paths were made for another surface than the recording's")]
    OtherSurface,
    /// Contours, paths or regions cannot be made or recorded as asked.
    #[error("no {what}: {reason}")]
    Curves {
        /// Which of them.
        what: &'static str,
        /// What is wrong.
        reason: String,
    },
    /// More sources than a recording can bring with it.
    #[error("{given} sources are more than the {most} that a recording can hold: use a buffer")]
    TooManySources {
        /// How many were given.
        given: usize,
        /// How many are taken.
        most: usize,
    },
    /// More sources inside cells than a map with anchors has room for.
    #[error(
        "more than {most} sources inside cells are too many for a map of anchored fronts: solve for all of \
         them at once, which takes curved ones then, or add them to a map of curved fronts"
    )]
    TooManyAnchors {
        /// How many there is room for.
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
    #[cfg(feature = "capi")]
    /// What is wrong, for a program that has no other engine.
    pub(crate) fn without_other_engines(&self) -> String {
        const ADVICE: [&str; 3] =
            ["; use the CPU engine", ", or use the CPU engine", " or the CPU engine"];
        ADVICE.iter().fold(self.to_string(), |text, advice| text.replace(advice, ""))
    }

    /// Names the call that a result comes from.
    pub(crate) fn from_call(call: &'static str) -> impl Fn(vk::Result) -> Self {
        move |result| Self::Call { call, result }
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
