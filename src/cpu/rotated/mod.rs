//! Solves by rotated raster scans in SIMD lanes. Large grids are solved by patches.

pub(in crate::cpu) mod changed;
pub(in crate::cpu) mod due;
mod exchange;
pub(in crate::cpu) mod line_update;
pub(in crate::cpu) mod merge;
pub(in crate::cpu) mod order;
pub(in crate::cpu) mod panel;
mod patches;
pub(in crate::cpu) mod prepared;
pub(in crate::cpu) mod rotated_scan;
mod scan_copy;
pub(in crate::cpu) mod scanner;
pub(in crate::cpu) mod scans;
pub(in crate::cpu) mod stream;
pub(in crate::cpu) mod tiles;
pub(in crate::cpu) mod transpose;
mod transposed;
pub(in crate::cpu) mod typical_edge;

pub use order::Order;
pub use rotated_scan::{RotatedScan, rotated_scan};
pub use scans::PatchCounts;
