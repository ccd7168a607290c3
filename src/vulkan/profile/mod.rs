//! Profiles each pass of a map: what it had to do, and how long it took.
//!
//! Nothing is recorded for profiling unless it is requested. A host gives a [`Profile`] a range of its own
//! query pools ([`Slots`]), records with [`Recording::profiled`], and requests the records with
//! [`Profile::resolve`] frames later. No call waits. [`planned`] counts the work of a plan without a device.
//! [`HeadlessSolver::for_profiling`] does all of this by itself.
//!
//! A [`PassRecord`] is plain values, which a program can forward to any viewer. With the feature `tracing`,
//! `emit` turns records into spans. [`Capabilities`] states what a device does not offer. `docs/profiling.md`
//! explains how to read the results.
//!
//! ```no_run
//! # use geosweep::ash::{self, vk};
//! # use geosweep::vulkan::{VulkanError, embed};
//! # fn host(device: &ash::Device, commands: vk::CommandBuffer, timestamps: vk::QueryPool,
//! #     solver: &embed::Solver, surface: &embed::FrameSurface, plan: &embed::Plan,
//! #     frame: &embed::Frame, clock: geosweep::vulkan::profile::Clock,
//! # ) -> Result<(), VulkanError> {
//! use geosweep::vulkan::profile::{Grain, Profile, QueryRange, Slots};
//!
//! // Once for each frame in flight: a range of a pool of `TIMESTAMP` queries.
//! let passes = solver.passes_of_frame(surface, plan, Grain::Scans);
//! let range = QueryRange { pool: timestamps, first: 0, count: passes + 1 };
//! let slots = Slots::default().with_timestamps(range);
//! let profile = Profile::new(passes, Grain::Scans, slots);
//!
//! // Every frame:
//! solver.record(device, commands, surface).profiled(&profile).frame(frame)?;
//!
//! // When the frame comes round again, or at any time:
//! if let Some(resolved) = profile.resolve(device, Some(clock), None)? {
//!     for pass in &resolved.passes {
//!         println!("{} {:?} ns", pass.kind.name(), pass.nanoseconds);
//!     }
//! }
//! # Ok(()) }
//! ```
//!
//! [`Recording::profiled`]: super::embed::Recording::profiled
//! [`planned`]: super::planned
//! [`HeadlessSolver::for_profiling`]: super::HeadlessSolver::for_profiling

mod blocks;
mod calibration;
mod capabilities;
mod clock;
mod decisions;
mod executables;
mod pass;
mod presence;
mod scope;
mod session;
mod slots;
#[cfg(feature = "tracing")]
mod spans;
mod work;

pub(crate) use blocks::Blocks;
pub use capabilities::{Capabilities, Capability, Unavailable};
pub use clock::Clock;
pub(crate) use decisions::BEFORE as BEFORE_BYTES;
pub(crate) use executables::executables;
pub use executables::{Executable, Statistic};
pub use pass::{Area, Grain, PassKind, PassRecord};
#[cfg(test)]
pub(crate) use presence::{Decisions, decided};
pub(crate) use presence::{Presence, StepCounter};
pub(crate) use scope::{Scope, Watch};
pub(crate) use session::Session;
pub use session::{Detail, SolveProfile, SubmissionRecord};
pub use slots::{Decided, Profile, QueryRange, Resolved, Slots};
#[cfg(feature = "tracing")]
pub use spans::emit;
pub use work::Work;
