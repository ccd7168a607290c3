//! Statuses that calls return, and error messages.

use std::cell::UnsafeCell;
use std::ffi::c_char;
use std::panic::{AssertUnwindSafe, catch_unwind};

use ash::vk;
use gpu_allocator::AllocationError;

use super::users::Call;
use geosweep::surface::SurfaceError;
use geosweep::vulkan::VulkanError;

/// Result of a call. `geosweep_last_error` describes an error in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum GeosweepStatus {
    /// The call succeeded.
    Success = 0,
    /// An argument cannot be used. The message says which one, and why. Nothing was created or recorded.
    InvalidArgument = 1,
    /// The device lacks something that is needed. The message lists everything that is missing.
    Unsupported = 2,
    /// The grid is too large for the device's images or its memory.
    TooLarge = 3,
    /// Out of memory, on the device or in the program, or memory could not be mapped.
    OutOfMemory = 4,
    /// The device is lost.
    DeviceLost = 5,
    /// Another Vulkan call failed. The message names the call and its result.
    VulkanError = 6,
    /// A defect in geosweep, which was kept from crossing into your program. The object of the call is in an
    /// unknown state: destroy it.
    InternalError = 7,
    /// The result is not available yet. Call again after the fence of the submission.
    NotReady = 8,
}

/// Status and message of a call that failed.
#[derive(Debug)]
pub(super) struct Failure {
    status: GeosweepStatus,
    message: String,
}

impl Failure {
    /// Returns the error of an argument, from its name in the header and the reason.
    pub(super) fn argument(name: &str, reason: impl std::fmt::Display) -> Self {
        let message = format!("{name} {reason}");
        Self { status: GeosweepStatus::InvalidArgument, message }
    }

    pub(super) fn not_ready(message: &str) -> Self {
        Self { status: GeosweepStatus::NotReady, message: message.into() }
    }

    /// Puts `name` before the message: the struct to which the argument belongs, with a dot at its end.
    pub(super) fn inside(self, name: &str) -> Self {
        Self { message: format!("{name}{}", self.message), ..self }
    }

    /// Adds the number of the frame to which the argument belongs.
    pub(super) fn of_frame(self, number: usize) -> Self {
        Self { message: format!("frames[{number}]: {}", self.message), ..self }
    }

    pub(super) fn unsupported(message: String) -> Self {
        Self { status: GeosweepStatus::Unsupported, message }
    }
}

impl From<VulkanError> for Failure {
    fn from(error: VulkanError) -> Self {
        use GeosweepStatus as S;
        use VulkanError as E;
        if let E::OfFrame { number, source } = error {
            return Self::from(*source).of_frame(number);
        }
        let status = match &error {
            E::NotRun { .. } => S::NotReady,
            E::Unusable { .. } => S::Unsupported,
            E::TooLarge { .. } | E::TooMuchMemory { .. } => S::TooLarge,
            E::Allocation { source, .. } => status_of(result_of(source)),
            E::Call { result, .. } => status_of(*result),
            // All other errors are caused by the arguments.
            _ => S::InvalidArgument,
        };
        Self { status, message: message(&error) }
    }
}

/// Returns the status of a Vulkan call that failed.
fn status_of(result: vk::Result) -> GeosweepStatus {
    match result {
        vk::Result::ERROR_OUT_OF_HOST_MEMORY
        | vk::Result::ERROR_OUT_OF_DEVICE_MEMORY
        | vk::Result::ERROR_MEMORY_MAP_FAILED => GeosweepStatus::OutOfMemory,
        vk::Result::ERROR_DEVICE_LOST => GeosweepStatus::DeviceLost,
        _ => GeosweepStatus::VulkanError,
    }
}

/// Returns the result of the Vulkan call that made an allocation fail. Allocators report most results in words, as the
/// name or the description of the result.
fn result_of(error: &AllocationError) -> vk::Result {
    const KNOWN: [vk::Result; 3] = [
        vk::Result::ERROR_OUT_OF_HOST_MEMORY,
        vk::Result::ERROR_MEMORY_MAP_FAILED,
        vk::Result::ERROR_DEVICE_LOST,
    ];
    let text = match error {
        AllocationError::OutOfMemory => return vk::Result::ERROR_OUT_OF_DEVICE_MEMORY,
        AllocationError::FailedToMap(text) | AllocationError::Internal(text) => text,
        _ => return vk::Result::ERROR_UNKNOWN,
    };
    let is_named = |result: &vk::Result| {
        text.contains(&format!("{result:?}")) || text.contains(&result.to_string())
    };
    KNOWN.into_iter().find(is_named).unwrap_or(vk::Result::ERROR_UNKNOWN)
}

/// Returns the message for an error, with the names of the header.
fn message(error: &VulkanError) -> String {
    match error {
        VulkanError::NoPasses { schedule, wavefront } => format!(
            "the solver has no pipelines for the schedule {schedule} with {wavefront} fronts: name both in \
             GeosweepSolverInfo::passes"
        ),
        VulkanError::OtherGluing { is_glued } => format!(
            "{}: set GeosweepMethod::over_seams to {} for the plan",
            match is_glued {
                true => "the surface is glued, but the plan has no step over seams",
                false => "the plan passes seams, but the surface is not glued",
            },
            u32::from(*is_glued),
        ),
        VulkanError::NotPrepared => {
            "the surface is not prepared: geosweep_record_prepare comes once, before \
             anything else"
                .into()
        }
        VulkanError::NotMeasured => {
            "the surface was never measured: GeosweepFrame::points is a number of its points \
             in the first frame"
                .into()
        }
        VulkanError::NoMap => {
            "the surface has no map yet: geosweep_record_frame or geosweep_record_solve comes \
             before this, and geosweep_record_measure takes the map away"
                .into()
        }
        VulkanError::OwnResults => {
            "the surface was made with images of distances of its own: give it yours as \
             GeosweepSurfaceInfo::results"
                .into()
        }
        VulkanError::OldInput { what, number } => format!(
            "the surface's {what} {number} were replaced after its contours, paths, regions, directions or log map \
             were made: call geosweep_contours_rebind or its counterpart for them first"
        ),
        error => without_other_engines(error),
    }
}

/// Returns the error's text for a program whose solvers have no other engine.
fn without_other_engines(error: &VulkanError) -> String {
    const ADVICE: [&str; 3] =
        ["; use the CPU engine", ", or use the CPU engine", " or the CPU engine"];
    ADVICE.iter().fold(error.to_string(), |text, advice| text.replace(advice, ""))
}

impl From<SurfaceError> for Failure {
    fn from(error: SurfaceError) -> Self {
        VulkanError::Surface(error).into()
    }
}

/// Runs a call. Errors and panics become a status and a message for `geosweep_last_error`.
pub(super) fn guard(call: impl FnOnce() -> Result<(), Failure>) -> GeosweepStatus {
    let _call = Call::begin();
    // The caller only destroys the object of a call that has panicked, as the status demands.
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(Ok(())) => GeosweepStatus::Success,
        Ok(Err(failure)) => {
            note(&failure.message);
            failure.status
        }
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            note(&format!(
                "a defect of geosweep's, please report it: {}",
                text.unwrap_or("unknown")
            ));
            // Dropping the panic's payload might panic too.
            std::mem::forget(panic);
            GeosweepStatus::InternalError
        }
    }
}

/// Defines functions of the header, which return a [`GeosweepStatus`]. In the bodies the caller's promises hold, which
/// the documentation of this crate lists.
macro_rules! calls {
    ($($(#[$doc:meta])* fn $name:ident($($argument:ident: $kind:ty),* $(,)?) $body:block)*) => {$(
        $(#[$doc])*
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name($($argument: $kind),*) -> $crate::GeosweepStatus {
            $crate::status::guard(|| {
                // SAFETY: the caller's promise.
                unsafe { $body }
                Ok(())
            })
        }
    )*};
}
pub(super) use calls;

/// Largest size in bytes of a message with its terminating zero.
const MESSAGE_BYTES: usize = 2048;

thread_local! {
    // A thread-local array without a destructor exists until the thread ends. Writing it needs no allocation,
    // so it works even when memory has run out.
    static MESSAGE: UnsafeCell<[u8; MESSAGE_BYTES]> = const { UnsafeCell::new([0; MESSAGE_BYTES]) };
}

/// Stores a message, cut off where the room ends.
fn note(message: &str) {
    let mut length = message.len().min(MESSAGE_BYTES - 1);
    while !message.is_char_boundary(length) {
        length -= 1;
    }
    MESSAGE.with(|kept| {
        // SAFETY: only this thread accesses the array, and no other reference into it exists.
        let kept = unsafe { &mut *kept.get() };
        for (to, &from) in kept.iter_mut().zip(&message.as_bytes()[..length]) {
            *to = if from == 0 { b'?' } else { from };
        }
        kept[length] = 0;
    });
}

/// Returns why the last failed call on this thread failed: a sentence in UTF-8 of at most 2047 bytes. It is
/// empty if no call has failed. The pointer is valid as long as the thread lives, and the text until the
/// thread's next call that fails.
#[unsafe(no_mangle)]
pub extern "C" fn geosweep_last_error() -> *const c_char {
    MESSAGE.with(UnsafeCell::get).cast()
}

#[cfg(test)]
mod tests {
    use std::ffi::CStr;

    use super::*;

    fn last() -> String {
        // SAFETY: the message ends with a zero.
        unsafe { CStr::from_ptr(geosweep_last_error()) }.to_str().unwrap().to_owned()
    }

    #[test]
    fn panics_become_a_status_and_a_message() {
        for panic in [|| panic!("at once"), || panic!("at {}", "once")] {
            assert_eq!(guard(panic), GeosweepStatus::InternalError);
            assert!(last().ends_with(": at once"), "{}", last());
        }
    }

    #[test]
    fn a_message_is_the_threads_own_and_ends_within_its_room() {
        assert_eq!(last(), "");
        let fail = |message: String| guard(|| Err(Failure::unsupported(message)));
        assert_eq!(fail("x".into()), GeosweepStatus::Unsupported);
        std::thread::spawn(|| assert_eq!(last(), "")).join().unwrap();
        // A success keeps the message.
        assert_eq!(guard(|| Ok(())), GeosweepStatus::Success);
        assert_eq!(last(), "x");
        fail("nul\0".into());
        assert_eq!(last(), "nul?");
        // With two bytes per character, byte 2047 lies inside a character.
        fail("ä".repeat(2000));
        assert_eq!(last(), "ä".repeat(1023));
    }
}
