//! The Vulkan engine: the method of the paper's section 5.3, in compute shaders.
//!
//! This module stores arrival times in two RGBA32F images with 2 x 2 grid points a texel. A third image holds
//! the edge lengths, one point a texel. A pass reads one image of times and writes the other. A [`Schedule`]
//! decides which points a pass visits. The raster schedule scans the grid in blocks of lines, with a barrier
//! between blocks. From the positions of the sources it computes which points no front can have reached yet,
//! and skips them. The tiles schedule visits the tiles beside which something has changed. A recording runs
//! without decisions of the host: the device detects that a map has converged, and passes recorded beyond
//! that visit nothing.
//!
//! A [`plan`] is a list of plain values. [`embed`] records it into a renderer's own command buffer, on the
//! renderer's device and with its allocator. [`HeadlessSolver`] brings its own device, command buffers and
//! allocator. [`requirements`] lists what a device must offer: Vulkan 1.1, and no extension or feature.

pub(crate) mod copies;
pub(crate) mod device;
pub mod embed;
mod error;
mod flight;
pub(crate) mod grid_images;
mod headless;
mod map_limit;
mod pairwise;
mod point_kind;
pub mod profile;
pub(crate) mod record;
mod schedules;
mod setters;
mod texel_chart;
pub(crate) mod upload;

pub use device::devices::{DeviceChoice, DeviceInfo, devices};
pub(crate) use device::pipeline_store::are_pipelines_kept;
pub use device::pipeline_store::{PipelineStore, keep_pipelines_in};
pub use device::requirements;
pub use device::tile_lanes::TileLanes;
pub use device::validation::ValidationLog;
pub use error::VulkanError;
pub(crate) use headless::with_device;
pub use headless::{
    DeviceCeilings, HeadlessSolution, HeadlessSolver, SurfaceOnDevice, keep_devices,
};
pub use map_limit::{MOST_TARGETS, MapLimit, TargetPoint};
pub use pairwise::{PairwiseOnDevice, PairwiseSchedule};
pub use profile::steps::planned;
pub use schedules::method::Method;
pub use schedules::plan;
pub use schedules::schedule::Schedule;
pub use schedules::tuning::Tuning;
pub use texel_chart::TexelChart;
