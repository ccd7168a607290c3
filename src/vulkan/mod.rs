//! The Vulkan engine: the paper's section 5.3 on compute shaders.
//!
//! This module stores arrival times in two RGBA32F images with 2 x 2 grid points a texel. A third image holds
//! the edge lengths, one point a texel. A pass reads one image of times and writes the other. A [`Schedule`]
//! decides which points a pass visits. The raster schedule scans the grid in blocks of lines, with a barrier
//! between blocks. From the positions of the sources it computes which points no front can have reached yet,
//! and skips them. The tiles schedule visits the tiles beside which something has changed. The host reads
//! nothing back to steer: the device detects that a map has converged, and passes recorded beyond that visit
//! nothing.
//!
//! A [`plan`] is a list of plain values. [`embed`] records it into a renderer's own command buffer, on the
//! renderer's device and with its allocator. [`HeadlessSolver`] brings its own device, command buffers and allocator.
//! [`requirements`] lists what a device must offer: Vulkan 1.1, and no extension or feature.

mod anchors;
mod barrier;
mod ceilings;
mod descriptors;
mod device_memory;
mod devices;
mod driver;
pub mod embed;
mod error;
pub(crate) mod grid_images;
mod headless;
mod instance;
mod limits;
pub(crate) mod memory;
mod origins;
mod pairwise;
mod passes;
mod pipeline_store;
mod pipelines;
pub mod plan;
mod point_kind;
pub mod profile;
mod progress;
pub(crate) mod record;
pub mod requirements;
mod schedule;
mod schedules;
mod shaders;
mod solver;
mod solving;
mod surface_on_device;
mod texel_chart;
mod tile_lanes;
pub(crate) mod upload;
mod upload_surface;
mod validation;

pub use ceilings::DeviceCeilings;
pub use devices::{DeviceChoice, DeviceInfo, devices};
pub use error::VulkanError;
pub use pairwise::{PairwiseOnDevice, PairwiseSchedule};
pub use pipeline_store::{PipelineStore, keep_pipelines_in};
pub use schedule::{Schedule, Tuning};
pub use schedules::planned;
pub use solver::HeadlessSolver;
pub use solving::{HeadlessSolution, Method};
pub use surface_on_device::SurfaceOnDevice;
pub use texel_chart::TexelChart;
pub use tile_lanes::TileLanes;
pub use validation::ValidationLog;
