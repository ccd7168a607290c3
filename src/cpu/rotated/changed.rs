//! Marks by which updates of lines tell the active set what has changed.

/// The change of some points by updates, from least to most. Of several changes the largest counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::cpu) enum Changed {
    #[default]
    No,
    /// The fronts that have changed are all later than the limit.
    Beyond,
    /// Fronts have changed that may reach other points before the limit.
    Within,
}
