//! What calls return, and what they say of it.

use std::cell::UnsafeCell;
use std::ffi::c_char;
use std::panic::{AssertUnwindSafe, catch_unwind};

use ash::vk;
use gpu_allocator::AllocationError;

use crate::surface::SurfaceError;
use crate::vulkan::VulkanError;

/// What a call has come to. `geosweep_last_error` says the rest in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum GeosweepStatus {
    /// Done.
    Success = 0,
    /// An argument cannot be used: the message says which one, and why. Nothing was made or
    /// recorded.
    InvalidArgument = 1,
    /// The device lacks something that is needed: the message names all of it.
    Unsupported = 2,
    /// The grid is too large for the device's images or its memory.
    TooLarge = 3,
    /// Memory has run out, on the device or in the program.
    OutOfMemory = 4,
    /// The driver has given the device up.
    DeviceLost = 5,
    /// Another Vulkan call failed: the message names it and what it returned.
    VulkanError = 6,
    /// A defect of geosweep's, which was kept from crossing into your program. What the call was
    /// about is in an unknown state: destroy it.
    InternalError = 7,
    /// What was asked for is not there yet: ask again after the fence of its submission.
    NotReady = 8,
}

/// Why a call fails.
#[derive(Debug)]
pub(super) struct Failure {
    status: GeosweepStatus,
    message: String,
}

impl Failure {
    /// An argument, by its name in the header, and what is wrong with it.
    pub(super) fn argument(name: &str, reason: impl std::fmt::Display) -> Self {
        let message = format!("{name} {reason}");
        Self { status: GeosweepStatus::InvalidArgument, message }
    }

    pub(super) fn not_ready(message: &str) -> Self {
        Self { status: GeosweepStatus::NotReady, message: message.into() }
    }

    /// Of a member, whose struct has this name with a dot behind it.
    pub(super) fn inside(self, name: &str) -> Self {
        Self { message: format!("{name}{}", self.message), ..self }
    }

    /// Of one of several frames.
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
            E::Allocation { source: AllocationError::OutOfMemory, .. } => S::OutOfMemory,
            E::Allocation { .. } => S::VulkanError,
            E::Call { result, .. } => match *result {
                vk::Result::ERROR_OUT_OF_HOST_MEMORY | vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => {
                    S::OutOfMemory
                }
                vk::Result::ERROR_DEVICE_LOST => S::DeviceLost,
                _ => S::VulkanError,
            },
            // The others are about what was asked for.
            _ => S::InvalidArgument,
        };
        Self { status, message: message(&error) }
    }
}

/// What is wrong, in the words of the header.
fn message(error: &VulkanError) -> String {
    match error {
        VulkanError::NoPasses { schedule, wavefront } => format!(
            "the solver has no pipelines for the schedule {schedule} with {wavefront} fronts: name both in \
             GeosweepSolverInfo::passes"
        ),
        VulkanError::NotPrepared => {
            "the surface is not prepared: geosweep_record_prepare comes once, before \
                                     anything else"
                .into()
        }
        VulkanError::NotMeasured => "the surface was never measured: GeosweepFrame::points is a \
                                     number of its points in the first frame"
            .into(),
        VulkanError::NoMap => {
            "the surface has no map yet: geosweep_record_frame or geosweep_record_solve \
                               comes before this, and geosweep_record_measure takes the map away"
                .into()
        }
        VulkanError::OwnResults => {
            "the surface was made with images of distances of its own: give it yours as \
                                    GeosweepSurfaceInfo::results"
                .into()
        }
        VulkanError::OldInput { what, number } => format!(
            "the surface's {what} {number} were replaced after its contours, paths or regions were made: call \
             geosweep_contours_rebind, geosweep_paths_rebind or geosweep_regions_rebind first"
        ),
        error => error.without_other_engines(),
    }
}

impl From<SurfaceError> for Failure {
    fn from(error: SurfaceError) -> Self {
        VulkanError::Surface(error).into()
    }
}

/// Runs a call: errors and panics become a status, and a message for `geosweep_last_error`.
pub(super) fn guard(call: impl FnOnce() -> Result<(), Failure>) -> GeosweepStatus {
    // What a panic leaves behind is only destroyed, says the status.
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
            // Dropping what was thrown might panic in turn.
            std::mem::forget(panic);
            GeosweepStatus::InternalError
        }
    }
}

/// Bytes of a message with its end.
const MESSAGE_BYTES: usize = 2048;

thread_local! {
    // An array that needs no drop is there until the thread ends, and needs no allocation to be
    // written when memory has run out.
    static MESSAGE: UnsafeCell<[u8; MESSAGE_BYTES]> = const { UnsafeCell::new([0; MESSAGE_BYTES]) };
}

/// Keeps a message, or as much of it as there is room for.
fn note(message: &str) {
    let mut length = message.len().min(MESSAGE_BYTES - 1);
    while !message.is_char_boundary(length) {
        length -= 1;
    }
    MESSAGE.with(|kept| {
        // SAFETY: only this thread sees the array, and no reference into it is held elsewhere.
        let kept = unsafe { &mut *kept.get() };
        for (to, &from) in kept.iter_mut().zip(&message.as_bytes()[..length]) {
            *to = if from == 0 { b'?' } else { from };
        }
        kept[length] = 0;
    });
}

/// Why the last call on this thread that failed did so: a sentence in UTF-8 of at most 2047 bytes,
/// or an empty one if none has. The pointer stays good as long as the thread, and the text until
/// the thread's next call that fails.
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
        // A success leaves it.
        assert_eq!(guard(|| Ok(())), GeosweepStatus::Success);
        assert_eq!(last(), "x");
        fail("nul\0".into());
        assert_eq!(last(), "nul?");
        // Two bytes a character: 2047 is inside of one.
        fail("ä".repeat(2000));
        assert_eq!(last(), "ä".repeat(1023));
    }
}
