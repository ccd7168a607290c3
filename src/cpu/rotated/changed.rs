//! Marks by which updates of lines tell the active set what has changed.

/// How updates have changed some points. The largest of several counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::cpu) enum Changed {
    #[default]
    No,
    /// Only fronts have changed that are later than the limit.
    Beyond,
    /// Fronts have changed that may reach other points before the limit.
    Within,
}
