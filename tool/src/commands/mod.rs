//! Implements the commands for users. They read surfaces from files, write maps, matrices, curves and regions
//! to files, and report on devices and profiles.
//!
//! Each command has a file. Further files have the parts that several commands share: level curves, curves over a map,
//! labels of regions, and samples; `directions` holds the outputs of `distance` beside the map.

pub mod builtin;
pub mod canonical;
pub mod compare;
pub mod contours;
pub mod devices;
mod directions;
pub mod distance;
mod labels;
mod level_curves;
mod limits;
pub mod notices;
pub mod offset;
mod over_map;
pub mod pairwise;
pub mod path;
pub mod profile;
pub mod ridges;
pub mod sample;
mod samples;
pub mod value;
pub mod voronoi;
