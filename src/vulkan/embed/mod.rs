//! Records distance maps into the command buffers of a renderer. The result stays on the device.
//!
//! The host is the program that embeds geosweep. It owns the instance, the device, the queues, the frames in
//! flight and all synchronization. A [`Solver`] holds the pipelines of a device, and a [`FrameSurface`] holds
//! the images of one grid. The host creates both before the first frame. A [`Recording`] appends passes and
//! barriers to a command buffer of the host and does nothing else. The device decides by itself when a map
//! has converged. `docs/embedding.md` describes the barriers, frames in flight, deforming surfaces and costs.
//!
//! [`crate::Wavefront::Anchored`] is for surfaces that are known to be floor plans. This is not known of
//! surfaces whose points are on the device, so maps with this wavefront are solved as
//! [`crate::Wavefront::Curved`] here.
//!
//! ```no_run
//! # use geosweep::ash::{self, vk};
//! # use geosweep::gpu_allocator::vulkan::Allocator;
//! # fn host(instance: &ash::Instance, physical_device: vk::PhysicalDevice, device: &ash::Device,
//! #     allocator: &mut Allocator, vertices: vk::Buffer, load_commands: vk::CommandBuffer,
//! #     commands: vk::CommandBuffer, frame_in_flight: usize,
//! # ) -> Result<(), geosweep::vulkan::VulkanError> {
//! use geosweep::Stop;
//! use geosweep::surface::Chart;
//! use geosweep::vulkan::embed::{self, Access, Frame, PointSource, Points, Reader, SourceInput};
//! use geosweep::vulkan::{Method, Schedule};
//! use geosweep::Wavefront;
//!
//! // Once: pipelines, a surface of 256 x 256 points in the host's vertex buffer, a plan.
//! let passes = [(Schedule::Raster, Wavefront::Curved)];
//! let solver = embed::Solver::new(instance, physical_device, device, &passes)?;
//! let chart = Chart { rows: 256, cols: 256 };
//! let points = [Points::positions(vertices, 32)];
//! let info = embed::SurfaceInfo::new(chart).with_slots(2).with_points(&points);
//! let mut surface = solver.surface(device, allocator, &info)?;
//! let stop = Stop::within(1e-4).or_after(100);
//! let method = Method::new(Wavefront::Curved, stop);
//! let plan = solver.plan(chart, method, 8)?;
//! solver.record(device, load_commands, &surface).prepare();
//!
//! // Every frame, between the pass that moves the vertices and the one that draws:
//! let sources = [PointSource::at(120.5, 80.25)];
//! let frame = Frame::new(&plan, SourceInput::Inline(&sources), Reader::FRAGMENT)
//!     .with_before(Access::COMPUTE_WRITE)
//!     .with_points(0)
//!     .with_slot(frame_in_flight)
//!     .with_unreached(-1.0);
//! let distances = solver.record(device, commands, &surface).frame(&frame)?;
//! // `distances.view` is in `distances.layout`, for fragment shaders to sample.
//!
//! // At the end, once no frame is in flight:
//! surface.destroy(device, allocator);
//! # let mut solver = solver;
//! solver.destroy(device);
//! # Ok(()) }
//! ```

mod access;
mod bound_sets;
mod contours;
mod creation;
mod curves;
mod directions;
mod frame;
mod host_sets;
mod input_sets;
mod inputs;
mod log_map;
mod map_sources;
mod names;
mod numbered;
mod outcome;
mod outputs;
mod paths;
mod plan;
mod readings;
mod rebinding;
mod recording;
mod regions;
mod solver;
mod starts;
mod state;
mod surface;
mod surface_info;
mod surface_sets;
mod together;
mod way_image;

pub use super::device::barrier::MOST_TOGETHER;
pub use super::device::device_memory::{DeviceMemory, MemoryBlock, MemoryRequest};
pub use super::device::memory::{Buffer, BufferInfo};
pub use super::map_limit::{MOST_TARGETS, MapLimit, TargetPoint};
pub use super::point_kind::PointKind;
pub use access::{Access, Reader};
pub use contours::{ContourFrame, Contours, LevelInput};
pub use curves::{CurveBuffer, CurveRecord, CurveStatus, CurveVertex};
pub use directions::{DirectionFrame, Directions};
pub use frame::Frame;
pub use inputs::{Lookup, PointMemory, PointSource, Points, SourceBuffer, SourceInput};
pub use log_map::{LogMapFrame, LogMapImage};
pub use outcome::Outcome;
pub use outputs::{BufferKind, HostImage, ImageKind, Output, SourceFrame};
pub use paths::{PathFrame, Paths, PathsInfo, StartInput};
pub use plan::Plan;
pub use recording::Recording;
pub use regions::{RegionBuffer, RegionFrame, Regions};
pub use solver::{Solver, Tools};
pub use surface::{FrameSurface, PackedTimes, ResultImage};
pub use surface_info::SurfaceInfo;
pub use together::SurfaceFrame;
