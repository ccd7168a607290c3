//! Hands objects to the program, and recognizes objects that were destroyed.

use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicU32, Ordering};

use super::arguments::{Output, usable};
use super::shared::Shared;
use super::status::Failure;

/// An object that the program holds by a pointer, after a mark of its kind.
#[repr(C)]
struct Handed<T> {
    /// [`Object::MARK`], or [`DESTROYED`].
    mark: AtomicU32,
    object: MaybeUninit<T>,
}

const DESTROYED: u32 = 0xDEAD_6753;

/// A kind of object.
pub(super) trait Object {
    /// Name of the kind in the header.
    const NAME: &'static str;
    /// Mark of the kind. No other kind has it, and other memory hardly ever contains it.
    const MARK: u32;

    /// Returns the shared state of the solver to which the object belongs.
    fn shared(&self) -> &Shared;
}

/// Gives an object to the program, until [`take`] takes it back.
pub(super) fn hand_out<T: Object>(to: Output<*mut T>, object: T) {
    let handed = Handed { mark: T::MARK.into(), object: MaybeUninit::new(object) };
    to.write(Box::into_raw(Box::new(handed)).cast());
}

/// Checks by the mark that the object exists and is of the kind `T`.
///
/// # Safety
/// The pointer is null, badly aligned, or from [`hand_out`], possibly for another kind. The memory that it
/// points to was not freed: solvers with checks keep the memory of destroyed objects.
unsafe fn handed<T: Object>(pointer: *const T, name: &str) -> Result<*const Handed<T>, Failure> {
    let pointer = pointer.cast::<Handed<T>>();
    usable(pointer, name)?;
    // SAFETY: all kinds begin with a mark.
    match unsafe { (*pointer).mark.load(Ordering::Relaxed) } {
        mark if mark == T::MARK => Ok(pointer),
        DESTROYED => Err(Failure::argument(name, "was destroyed before")),
        _ => Err(Failure::argument(name, format!("is no {}", T::NAME))),
    }
}

/// Returns an object.
///
/// # Safety
/// As for [`handed`]. Nothing changes the object during the call.
pub(super) unsafe fn object<'a, T: Object>(
    pointer: *const T,
    name: &str,
) -> Result<&'a T, Failure> {
    // SAFETY: required. The mark proves that the object exists.
    Ok(unsafe { (*handed(pointer, name)?).object.assume_init_ref() })
}

/// Returns an object that the call may change.
///
/// # Safety
/// As for [`object`]. Nothing else reads the object either.
pub(super) unsafe fn exclusive<'a, T: Object>(
    pointer: *mut T,
    name: &str,
) -> Result<&'a mut T, Failure> {
    // SAFETY: required. The mark proves that the object exists.
    unsafe {
        let handed = handed(pointer, name)?.cast_mut();
        Ok((*handed).object.assume_init_mut())
    }
}

/// Returns an object that is about to be destroyed, or `None` for null. With checks, this is an error while a
/// recording that uses the object has not run.
///
/// # Safety
/// As for [`object`].
pub(super) unsafe fn land<'a, T: Object>(
    pointer: *const T,
    name: &str,
    is_in_flight: impl FnOnce(&T) -> bool,
) -> Result<Option<&'a T>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: required.
    let of: &T = unsafe { object(pointer, name) }?;
    match of.shared().has_checks() && is_in_flight(of) {
        true => Err(in_flight(name, "is destroyed and a recording of it has not run")),
        false => Ok(Some(of)),
    }
}

/// Returns the error for a call that must wait until a recording has run.
pub(super) fn in_flight(name: &str, what: &str) -> Failure {
    Failure::argument(
        name,
        format!(
            "{what}: wait for the fence of its submission, or say by geosweep_surface_discard or \
             geosweep_surface_discard_commands that there will be none"
        ),
    )
}

/// Takes an object back from the program. Returns `None` for null. With checks, its memory is kept, so that a
/// later use of the pointer is an error and not undefined behaviour.
///
/// # Safety
/// As for [`exclusive`].
pub(super) unsafe fn take<T: Object>(pointer: *mut T, name: &str) -> Result<Option<T>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: required. The object is moved out only once, since the mark then says that it was destroyed.
    unsafe {
        let handed = handed(pointer, name)?.cast_mut();
        (*handed).mark.store(DESTROYED, Ordering::Relaxed);
        let object = (*handed).object.assume_init_read();
        if !object.shared().has_checks() {
            drop(Box::from_raw(handed));
        }
        Ok(Some(object))
    }
}
