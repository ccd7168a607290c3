//! Obtuse triangles, which are split into parts. `unfold.rs` finds the splits.

pub(super) mod cells;
pub(super) mod lists;
mod part_search;
pub(super) mod parts;
mod search;

pub(crate) use parts::Part;
pub(crate) use search::is_obtuse;
