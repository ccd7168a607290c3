//! The tool through its command line: the files that it writes for given arguments, and its messages.

mod canonical;
mod closed;
mod completed;
mod contours;
mod devices;
mod directions;
mod distance;
#[cfg(unix)]
mod documentation;
mod estimate;
mod formats;
mod geodetic;
mod geodetic_files;
mod geodetic_lines;
mod geodetic_places;
mod limits;
mod no_data;
mod notices;
mod offsets;
mod orientation;
mod outside;
mod pairwise;
mod paths;
mod pictures;
mod places;
mod profile;
mod rasters;
mod refusals;
mod regions;
mod ridges;
mod samples;
mod sidecars;
#[path = "../../../tests/common/vincenty.rs"]
mod vincenty;
mod workbench;

/// The program that the tests run.
const TOOL: &str = env!("CARGO_BIN_EXE_geosweep");
