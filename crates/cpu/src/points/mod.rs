//! Updates points one by one: the paper's directed scans, and the fronts that twins update.

mod point_fronts;
mod raster_scan;

#[cfg(any(test, feature = "twins"))]
pub(super) use point_fronts::PointFronts;
pub use raster_scan::raster_scan;
