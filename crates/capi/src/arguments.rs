//! Checks pointers and numbers from C before they are used.

use super::status::Failure;
use geosweep::surface::Chart;

pub(super) fn usable<T>(pointer: *const T, name: &str) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::argument(name, "is null"));
    }
    if !pointer.is_aligned() {
        let reason = format!("is {pointer:p}, which is not aligned to {} bytes", align_of::<T>());
        return Err(Failure::argument(name, reason));
    }
    Ok(())
}

/// Returns a reference to the value of an argument, or an error if the pointer is null or badly aligned.
///
/// # Safety
/// If `pointer` is neither null nor badly aligned, it points to a `T` that nothing writes during the call.
pub(super) unsafe fn reference<'a, T>(pointer: *const T, name: &str) -> Result<&'a T, Failure> {
    usable(pointer, name)?;
    // SAFETY: checked above, or required.
    Ok(unsafe { &*pointer })
}

/// Returns an array of `count` entries, of which there may be at most `most`. The pointer may be null if
/// `count` is 0.
///
/// # Safety
/// As for [`reference`], for each entry.
pub(super) unsafe fn list<'a, T>(
    pointer: *const T,
    count: u32,
    most: usize,
    name: &str,
) -> Result<&'a [T], Failure> {
    let count = count as usize;
    if count == 0 {
        return Ok(&[]);
    }
    if count > most {
        let reason = format!("has {count} entries; at most {most} are allowed");
        return Err(Failure::argument(name, reason));
    }
    usable(pointer, name).map_err(|_| {
        let how = if pointer.is_null() { "null" } else { "badly aligned" };
        Failure::argument(name, format!("is {how}, and is said to have {count} entries"))
    })?;
    // SAFETY: checked above, or required.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// Returns the value of an argument that may be null, in which case it is `None`.
///
/// # Safety
/// As for [`reference`].
pub(super) unsafe fn optional<'a, T>(
    pointer: *const T,
    name: &str,
) -> Result<Option<&'a T>, Failure> {
    // SAFETY: required.
    if pointer.is_null() { Ok(None) } else { unsafe { reference(pointer, name) }.map(Some) }
}

/// Writes the result of a call.
///
/// # Safety
/// As for [`Output::new`].
pub(super) unsafe fn write<T>(pointer: *mut T, name: &str, value: T) -> Result<(), Failure> {
    // SAFETY: required.
    unsafe { Output::new(pointer, name) }?.write(value);
    Ok(())
}

/// Pointer to which a call writes its result.
pub(super) struct Output<T>(*mut T);

impl<T> Output<T> {
    /// Checks a pointer to which a result will be written.
    ///
    /// # Safety
    /// If `pointer` is neither null nor badly aligned, a `T` may be written there.
    pub(super) unsafe fn new(pointer: *mut T, name: &str) -> Result<Self, Failure> {
        usable(pointer, name)?;
        Ok(Self(pointer))
    }

    /// Writes the entry `index` of an array.
    ///
    /// # Safety
    /// The array has more than `index` entries.
    pub(super) unsafe fn write_at(&self, index: usize, value: T) {
        // SAFETY: required, as for a single value.
        unsafe { self.0.add(index).write(value) };
    }

    pub(super) fn write(self, value: T) {
        // SAFETY: checked or required when this was created. The old value is not read, so it may be
        // uninitialized.
        unsafe { self.0.write(value) };
    }
}

/// Returns the chart of a grid with this size.
pub(super) fn chart(rows: u32, cols: u32) -> Result<Chart, Failure> {
    for (name, size) in [("rows", rows), ("cols", cols)] {
        if size == 0 {
            return Err(Failure::argument(name, "is 0: a grid has at least one point"));
        }
    }
    Ok(Chart { rows: rows as usize, cols: cols as usize })
}
