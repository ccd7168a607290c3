//! Updates points one by one: the paper's directed scans, and the fronts that fast marching and twins update.

mod point_fronts;
mod raster_scan;

pub(super) use point_fronts::PointFronts;
pub use raster_scan::raster_scan;
