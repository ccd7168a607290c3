//! The Vulkan engine: the paper's section 5.3 on compute shaders.
//!
//! Arrival times are kept in two RGBA32F images with 2 x 2 grid points a texel, edge lengths in
//! a third with one point a texel. A scan reads the times of one image and writes the other,
//! line by line, with a barrier between lines; lines that cannot have been reached yet are
//! skipped, and bounds within a line likewise, by arithmetic on where the sources are
//! ([`plan`]). Nothing is read back to steer a scan; after each iteration of four scans the
//! host reads one number, the residual.
//!
//! [`plan`] is a list of plain values. [`Pipelines`], [`GridImages`] and [`record`] work on a
//! device, an allocator and a command buffer of the caller's. [`Solver`] brings its own of each.
//!
//! Needs Vulkan 1.1 and no extension or feature.

mod barrier;
mod devices;
mod error;
mod grid_images;
mod headless;
mod memory;
mod pipelines;
pub mod plan;
pub mod record;
mod requirements;
mod solver;
mod texel_chart;
mod upload;
mod validation;

pub use devices::{DeviceInfo, devices};
pub use error::VulkanError;
pub use grid_images::GridImages;
pub use pipelines::{Pipelines, ScanPipelines};
pub use requirements::{API_VERSION, unmet_requirements};
pub use solver::{Solution, Solver, SurfaceOnDevice};
pub use texel_chart::TexelChart;
pub use validation::ValidationLog;
