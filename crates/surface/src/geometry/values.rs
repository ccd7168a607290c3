//! Arrays of one value per grid point, in memory of their own or in memory of the calling program.

use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

/// Array of one value per grid point, row-major. Clones share the memory.
#[derive(Clone)]
pub struct Values<T> {
    /// The values' memory.
    slice: *const [T],
    /// The owner of the memory, which keeps the memory alive.
    #[expect(dead_code, reason = "owns what `slice` points to")]
    owner: Arc<dyn AsRef<[T]> + Send + Sync>,
}

// SAFETY: `Values` gives shared access to a slice of `T`, as `&[T]` does, and its owner is `Send + Sync`.
unsafe impl<T: Sync> Send for Values<T> {}
// SAFETY: see above.
unsafe impl<T: Sync> Sync for Values<T> {}

impl<T> Values<T> {
    /// Takes values from memory that belongs to the program, without a copy.
    #[inline]
    pub(crate) fn shared(owner: Arc<dyn AsRef<[T]> + Send + Sync>) -> Self {
        // The slice is taken from the owner once, rather than for each element that is read.
        let slice: *const [T] = (*owner).as_ref();
        Self { slice, owner }
    }
}

impl<T: Send + Sync + 'static> From<Vec<T>> for Values<T> {
    fn from(values: Vec<T>) -> Self {
        Self::shared(Arc::new(values))
    }
}

impl<T> Deref for Values<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        // SAFETY: the slice was borrowed from the owner. While `self` has an `Arc` to the owner, the owner is
        // neither moved nor mutably borrowed. So the borrow may last as long as `self`.
        unsafe { &*self.slice }
    }
}

impl<T: fmt::Debug> fmt::Debug for Values<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_lie_where_their_owner_has_them() {
        let owner = Arc::new(vec![1.0, 2.0, 3.0]);
        let (at, weak) = (owner.as_ptr(), Arc::downgrade(&owner));
        let values = Values::shared(owner);
        let clone = values.clone();
        drop(values);
        assert_eq!((clone.as_ptr(), &*clone), (at, &[1.0, 2.0, 3.0][..]));
        assert!(weak.upgrade().is_some());
        drop(clone);
        assert!(weak.upgrade().is_none());
    }
}
