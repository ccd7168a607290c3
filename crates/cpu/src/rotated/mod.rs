//! Solves by rotated raster scans in SIMD lanes. Large grids are solved by patches, rough ones in the order of time.

mod buckets;
pub(crate) mod changed;
pub(crate) mod due;
mod exchange;
pub(crate) mod line_update;
pub(crate) mod merge;
pub(crate) mod order;
pub(crate) mod panel;
mod patches;
pub(crate) mod prepared;
pub(crate) mod rotated_scan;
mod scan_copy;
pub(crate) mod scanner;
pub(crate) mod scans;
pub(crate) mod stream;
pub(crate) mod tiles;
pub(crate) mod transpose;
mod transposed;
pub(crate) mod typical_edge;

pub use order::Order;
pub use rotated_scan::{RotatedScan, rotated_scan};
pub use scans::PatchCounts;
