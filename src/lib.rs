//! Geodesic distance maps on parametric surfaces, computed where the pixels already are.
//!
//! A [`Surface`] is an M x N grid of points (a geometry image, a height field, a range scan) or a metric per
//! grid point. The crate computes the distance from [`Sources`] to every point. It solves the eikonal
//! equation by parallel raster scans, after Weber, Devir, Bronstein, Bronstein and Kimmel, "Parallel
//! algorithms for approximation of distance maps on parametric surfaces" (ACM Transactions on Graphics 27(4),
//! 2008). This documentation calls that article "the paper".
//!
//! # A map in one call
//!
//! [`distance_map`] takes a surface and its sources and returns the distances. It runs on the CPU, or on a
//! GPU for large grids.
//!
//! ```
//! use geosweep::{Engine, Options, Sources, Spacing, Surface, distance_map};
//!
//! // A ramp of 65 x 65 points, 10 m apart.
//! let heights = (0..65 * 65).map(|i| 3.0 * (i % 65) as f64).collect();
//! let surface = Surface::from_heights(65, 65, heights, Spacing::square(10.0))?;
//! let options = Options::default().with_engine(Engine::Cpu);
//! let map = distance_map(&surface, &Sources::point(0.0, 0.0), &options)?;
//! let exact = f32::hypot(64.0 * 10.0, 64.0 * f32::hypot(10.0, 3.0));
//! assert!((map.distance(64, 64) - exact).abs() < 1e-5 * exact);
//! # Ok::<(), geosweep::Error>(())
//! ```
//!
//! [`geometry`] makes contours, shortest paths, Voronoi regions and offset curves of a map, [`pairwise`] computes the
//! distances between all pairs of points, and [`estimate_error`] an error for each distance. A program that computes
//! many maps of one surface reuses a [`cpu::RotatedScan`] or a [`vulkan::HeadlessSolver`].
//!
//! # A map in a renderer's frame
//!
//! [`vulkan::embed`] records a map into the command buffer of a renderer, on the renderer's device. Points
//! come from the renderer's vertex buffer and may move every frame. The distances are an image that shaders
//! sample in the same frame. Nothing is read back, and recording allocates nothing.
//!
//! # Features
//!
//! All features but `vulkan` are off by default.
//!
//! | feature | adds |
//! |---|---|
//! | `vulkan` | the Vulkan engine; without it the CPU computes all maps |
//! | `formats` | the module `io`: grids, images, curves, and matrices larger than memory as files |
//! | `canonical` | canonical forms: multidimensional scaling of geodesic distances |
//! | `tracing` | passes that were profiled on a device as spans of the crate `tracing` |
//! | `shaderc` | compiles the shaders while building, in place of the SPIR-V in the package |
//! | `twins` | the shaders' twins in Rust, for tests and studies; without promises of stability |
//!
//! Modules depend on each other in one direction only: [`surface`] (lengths and sources), [`update`] (one
//! triangle), the engines [`cpu`] and [`vulkan`], then [`distance_map`] and [`pairwise`], then
//! [`estimate_error`], [`accuracy`] and [`geometry`], file formats and the tool.

pub mod accuracy;
#[cfg(feature = "vulkan")]
mod auto;
mod engine;
mod error;
mod estimate;
mod map_solver;
#[cfg(feature = "vulkan")]
mod method;
mod options;
pub mod pairwise;
#[cfg(feature = "vulkan")]
mod share;
mod solve;
#[cfg(feature = "vulkan")]
mod solve_on_device;
#[cfg(feature = "vulkan")]
pub mod vulkan;

#[cfg(feature = "vulkan")]
pub use ash;
pub use engine::Engine;
pub use error::Error;
pub use estimate::{ErrorEstimate, estimate_error, estimate_error_f64};
pub use geosweep_cpu as cpu;
pub use geosweep_geometry as geometry;
#[cfg(feature = "formats")]
pub use geosweep_io as io;
pub use geosweep_surface as surface;
#[cfg(feature = "vulkan")]
pub(crate) use geosweep_surface::constants;
pub(crate) use geosweep_surface::name;
#[doc(hidden)]
pub use geosweep_surface::shown;
pub use geosweep_surface::{
    Cancelled, Convergence, DEFAULT_TOLERANCE, DEFAULT_TOLERANCE_F64, DistanceMap, EdgeRule,
    MetricTensor, Monitor, Report, Source, Sources, Spacing, Stop, Surface, Targets, UnknownName,
    UsedEngine, Wavefront, update,
};
pub use glam;
#[cfg(feature = "vulkan")]
pub use gpu_allocator;
pub use map_solver::MapSolver;
pub use options::Options;
pub use solve::{distance_map, distance_map_f64};
#[cfg(feature = "vulkan")]
pub use vulkan::DeviceChoice;

/// Compiles and runs the examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// Compiles and runs the examples of the page on profiling.
#[cfg(doctest)]
#[doc = include_str!("../docs/profiling.md")]
struct Profiling;

/// Compiles and runs the examples of the page on maps.
#[cfg(doctest)]
#[doc = include_str!("../docs/maps.md")]
struct Maps;

/// Compiles and runs the examples of the page on all pairs.
#[cfg(doctest)]
#[doc = include_str!("../docs/pairwise.md")]
struct AllPairs;
