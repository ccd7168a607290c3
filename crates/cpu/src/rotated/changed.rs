//! Defines the marks by which updates of lines report changes to the active set.

/// Mark of the changes of some points, in ascending order. The mark of several changes is the largest of their marks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Changed {
    #[default]
    No,
    /// The fronts that have changed are all later than the limit.
    Beyond,
    /// Fronts have changed that may reach other points before the limit.
    Within,
}
