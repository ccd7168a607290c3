//! Obtuse triangles, which are split into parts. `unfold.rs` finds the splits.

mod around;
pub(super) mod cells;
pub(super) mod lists;
mod part_search;
pub(super) mod parts;
pub(super) mod reach;
mod search;

#[doc(hidden)]
pub use around::PartsAround;
#[doc(hidden)]
pub use parts::SplitPart;
#[doc(hidden)]
pub use search::is_obtuse;
