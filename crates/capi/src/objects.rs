//! Hands objects to the program, and recognizes objects that were destroyed or that other calls use.

use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicU32, Ordering};

use super::arguments::{Output, usable};
use super::shared::Shared;
use super::status::Failure;
use super::users;

/// An object that the program holds by a pointer, after a mark of its kind.
#[repr(C)]
struct Handed<T: Object> {
    /// [`Object::MARK`], or [`DESTROYED`].
    mark: AtomicU32,
    /// Calls that use the object; see [`users`].
    users: AtomicU32,
    held: MaybeUninit<T::Held>,
}

const DESTROYED: u32 = 0xDEAD_6753;

/// A kind of object, as the header declares it.
pub(super) trait Object {
    /// Value that the program holds by a pointer to this type.
    type Held;
    /// Name of the kind in the header.
    const NAME: &'static str;
    /// Name of arguments of this kind.
    const ARGUMENT: &'static str;
    /// Mark of the kind. No other kind has it, and other memory hardly ever contains it.
    const MARK: u32 = mark_of(Self::NAME);

    /// Returns the shared state of the solver to which the object belongs.
    fn shared(held: &Self::Held) -> &Shared;
}

/// Defines a kind of object: its name in C, that of arguments, and the value that the program holds.
macro_rules! kind_of_object {
    ($kind:ident, $name:ident: $held:ty) => {
        impl $crate::objects::Object for $kind {
            type Held = $held;
            const NAME: &'static str = stringify!($kind);
            const ARGUMENT: &'static str = stringify!($name);

            fn shared(held: &$held) -> &$crate::shared::Shared {
                held.as_ref()
            }
        }

        /// Asserts what the header promises about threads.
        const _: () = {
            const fn for_any_thread<T: Send + Sync>() {}
            for_any_thread::<$held>();
        };
    };
}
pub(super) use kind_of_object;

/// Returns the mark of a kind: the FNV-1a hash of its name.
const fn mark_of(name: &str) -> u32 {
    let (mut hash, mut at) = (0x811C_9DC5_u32, 0);
    while at < name.len() {
        hash = (hash ^ name.as_bytes()[at] as u32).wrapping_mul(0x0100_0193);
        at += 1;
    }
    hash
}

/// Gives an object to the program, until [`take`] takes it back.
pub(super) fn hand_out<T: Object>(to: Output<*mut T>, held: T::Held) {
    let held = MaybeUninit::new(held);
    let handed = Handed::<T> { mark: T::MARK.into(), users: 0.into(), held };
    to.write(Box::into_raw(Box::new(handed)).cast());
}

/// Checks by the mark that the object exists and is of the kind `T`.
///
/// # Safety
/// The pointer is null, badly aligned, or from [`hand_out`], possibly for another kind. The memory that it
/// points to was not freed: solvers with checks keep the memory of destroyed objects.
unsafe fn handed<T: Object>(pointer: *const T, name: &str) -> Result<*mut Handed<T>, Failure> {
    let pointer = pointer.cast::<Handed<T>>();
    usable(pointer, name)?;
    // SAFETY: all kinds begin with a mark.
    match unsafe { (*pointer).mark.load(Ordering::Relaxed) } {
        mark if mark == T::MARK => Ok(pointer.cast_mut()),
        DESTROYED => Err(Failure::argument(name, "was destroyed before")),
        _ => Err(Failure::argument(name, format!("is no {}", T::NAME))),
    }
}

/// Returns an object, which no other call can change or destroy before this call returns.
///
/// # Safety
/// As for [`handed`].
pub(super) unsafe fn object<'a, T: Object + 'a>(pointer: *const T) -> Result<&'a T::Held, Failure> {
    // SAFETY: required.
    unsafe { object_named(pointer, T::ARGUMENT) }
}

/// Returns an object that is not an argument of its own, and has this name.
///
/// # Safety
/// As for [`object`].
pub(super) unsafe fn object_named<'a, T: Object + 'a>(
    pointer: *const T,
    name: &str,
) -> Result<&'a T::Held, Failure> {
    // SAFETY: required. The mark proves that the object exists. It is read again once no call can destroy the object.
    unsafe {
        users::share(&(*handed(pointer, name)?).users, name)?;
        Ok((*handed(pointer, name)?).held.assume_init_ref())
    }
}

/// Returns an object that the call may change. No other call can use it before this call returns.
///
/// # Safety
/// As for [`handed`].
pub(super) unsafe fn exclusive<'a, T: Object + 'a>(
    pointer: *mut T,
) -> Result<&'a mut T::Held, Failure> {
    // SAFETY: as for [`object_named`].
    unsafe {
        users::exclude(&(*handed(pointer, T::ARGUMENT)?).users, T::ARGUMENT)?;
        Ok((*handed(pointer, T::ARGUMENT)?).held.assume_init_mut())
    }
}

/// Takes an object back from the program, to destroy it. Returns `None` for null. It is an error if another call uses
/// the object or `check` refuses. With checks, the object's memory is kept, so that a later use of the pointer is an
/// error and not undefined behaviour.
///
/// # Safety
/// As for [`handed`].
pub(super) unsafe fn take<T: Object>(
    pointer: *mut T,
    check: impl FnOnce(&T::Held) -> Result<(), Failure>,
) -> Result<Option<T::Held>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: required. The object is moved out only once, since the mark then says that it was destroyed.
    unsafe {
        let held = exclusive(pointer)?;
        check(held)?;
        let has_checks = T::shared(held).has_checks();
        let handed = handed(pointer, T::ARGUMENT)?;
        (*handed).mark.store(DESTROYED, Ordering::Relaxed);
        let held = (*handed).held.assume_init_read();
        if !has_checks {
            users::forget(&(*handed).users);
            drop(Box::from_raw(handed));
        }
        Ok(Some(held))
    }
}

/// With checks, returns an error for an object that is destroyed while a recording that uses it has not run.
pub(super) fn check_landed<T: Object>(held: &T::Held, is_in_flight: bool) -> Result<(), Failure> {
    match T::shared(held).has_checks() && is_in_flight {
        true => Err(in_flight(T::ARGUMENT, "is destroyed and a recording of it has not run")),
        false => Ok(()),
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
