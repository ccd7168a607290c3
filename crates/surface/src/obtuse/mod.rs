//! Obtuse triangles, which are split into parts. `unfold.rs` finds the splits.

pub(super) mod cells;
pub(super) mod lists;
mod part_search;
pub(super) mod parts;
mod search;

#[doc(hidden)]
pub use parts::SplitPart;
#[doc(hidden)]
pub use search::is_obtuse;
