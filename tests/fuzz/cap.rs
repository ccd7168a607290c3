//! An allocator that refuses allocations beyond a cap for the process.

use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::current;

/// Largest number of bytes that the process may hold at a time.
pub const CAP: usize = 1 << 30;

struct Capped;

static HELD: AtomicUsize = AtomicUsize::new(0);

/// Counts `bytes` bytes as held, and returns whether they fit below [`CAP`]. If they do not fit, counts nothing and
/// reports the current case, since the process may end without the allocation.
fn take(bytes: usize) -> bool {
    let held = HELD.fetch_add(bytes, Ordering::Relaxed);
    let fits = held.checked_add(bytes).is_some_and(|held| held <= CAP);
    if !fits {
        give(bytes);
        current::tell_of_refusal(bytes);
    }
    fits
}

fn give(bytes: usize) {
    HELD.fetch_sub(bytes, Ordering::Relaxed);
}

// SAFETY: all calls go to the system's allocator, or return null.
unsafe impl GlobalAlloc for Capped {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if take(layout.size()) { unsafe { System.alloc(layout) } } else { ptr::null_mut() }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if take(layout.size()) { unsafe { System.alloc_zeroed(layout) } } else { ptr::null_mut() }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if !take(size) {
            return ptr::null_mut();
        }
        let moved = unsafe { System.realloc(pointer, layout, size) };
        give(if moved.is_null() { size } else { layout.size() });
        moved
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        give(layout.size());
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static CAPPED: Capped = Capped;
