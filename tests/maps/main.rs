//! Results of the library, compared with the truth and between engines: maps, matrices, results on maps, and
//! files.

mod accuracy;
mod any_cells;
mod bounds;
#[cfg(feature = "canonical")]
mod canonical;
mod closed;
mod closed_directions;
mod closed_estimate;
mod closed_offset;
mod closed_regions;
mod closed_ridges;
mod closed_signed;
mod closed_sources;
mod closed_steep;
mod coarsening;
#[path = "../common/mod.rs"]
mod common;
mod completed;
mod contours;
mod directions;
mod double_precision;
mod engines;
mod estimate;
mod fibres;
mod floor_plan_twins;
#[cfg(feature = "formats")]
mod formats;
mod gdal;
mod geodetic;
mod level_set;
mod log_map_on_bumps;
mod monitor;
mod offset;
mod origins;
mod pairwise;
mod pairwise_matrix;
mod patches;
mod paths;
mod paths_around_holes;
mod paths_over_slowness;
mod properties;
mod radius;
mod rays;
mod ridges;
mod rims;
mod rotated_scan;
mod sampling;
mod shared_edges;
mod skewed_cells;
mod slowness;
mod straight_lines;
mod tile_order;
mod times;
mod uneven_steps;
mod voronoi;
