//! Keeps calls on other threads from changing or destroying an object while a call uses it.
//!
//! Each object counts the calls that use it. A call notes its objects, and [`Call`] releases them when it returns.

use std::cell::UnsafeCell;
use std::ptr::null;
use std::sync::atomic::{AtomicU32, Ordering};

use super::status::Failure;

/// Bit of a count that is set while a call has the object to itself.
const EXCLUSIVE: u32 = 1 << 31;

/// Largest number of objects of a call: surfaces and plans that are recorded together, and a few others.
const MOST: usize = 2 * geosweep::vulkan::embed::MOST_TOGETHER + 8;

/// Objects that the current call of this thread uses.
struct Used {
    count: usize,
    users: [(*const AtomicU32, u32); MOST],
}

thread_local! {
    // As for messages, an array without a destructor needs no allocation and exists until the thread ends.
    static USED: UnsafeCell<Used> =
        const { UnsafeCell::new(Used { count: 0, users: [(null(), 0); MOST] }) };
}

fn with_used<R>(access: impl FnOnce(&mut Used) -> R) -> R {
    // SAFETY: only this thread accesses the list, and no closure of this module calls this function.
    USED.with(|used| access(unsafe { &mut *used.get() }))
}

/// A call that is under way. When it is dropped, the objects that the call has noted are released.
pub(super) struct Call {
    /// Number of objects that an outer call uses. A program's allocator may call the library again.
    before: usize,
}

impl Call {
    pub(super) fn begin() -> Self {
        Self { before: with_used(|used| used.count) }
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        with_used(|used| {
            for (users, amount) in &used.users[self.before..used.count] {
                // SAFETY: an object that a call uses exists until the call releases it, or has been forgotten.
                if let Some(users) = unsafe { users.as_ref() } {
                    users.fetch_sub(*amount, Ordering::Release);
                }
            }
            used.count = self.before;
        });
    }
}

fn note(users: &AtomicU32, amount: u32) {
    with_used(|used| {
        used.users[used.count] = (users, amount);
        used.count += 1;
    });
}

fn check_room(name: &str) -> Result<(), Failure> {
    match with_used(|used| used.count < MOST) {
        true => Ok(()),
        false => Err(Failure::argument(name, "is one of too many objects of a call")),
    }
}

/// Notes that the current call uses an object, together with other calls that do not change it.
pub(super) fn share(users: &AtomicU32, name: &str) -> Result<(), Failure> {
    check_room(name)?;
    if users.fetch_add(1, Ordering::Acquire) & EXCLUSIVE != 0 {
        users.fetch_sub(1, Ordering::Release);
        let reason =
            "is being changed or destroyed by a call on another thread, which has not returned";
        return Err(Failure::argument(name, reason));
    }
    note(users, 1);
    Ok(())
}

/// Notes that the current call has an object to itself.
pub(super) fn exclude(users: &AtomicU32, name: &str) -> Result<(), Failure> {
    check_room(name)?;
    if users.compare_exchange(0, EXCLUSIVE, Ordering::Acquire, Ordering::Relaxed).is_err() {
        let reason = "is used by a call on another thread, which has not returned";
        return Err(Failure::argument(name, reason));
    }
    note(users, EXCLUSIVE);
    Ok(())
}

/// Forgets an object of the current call whose memory is about to be freed.
pub(super) fn forget(users: &AtomicU32) {
    with_used(|used| {
        let count = used.count;
        let of_object = used.users[..count].iter_mut().filter(|(of, _)| std::ptr::eq(*of, users));
        of_object.for_each(|entry| *entry = (null(), 0));
    });
}
