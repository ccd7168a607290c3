//! Profiles each pass of a map: its work and its time.
//!
//! Nothing is recorded for profiling unless it is requested. A host gives a [`Profile`] a range of its own
//! query pools ([`Slots`]), records with [`Recording::profiled`], and requests the records with
//! [`Profile::resolve`] frames later. No call waits. [`planned`] counts the work of a plan without a device.
//! [`HeadlessSolver::for_profiling`] does all of this by itself.
//!
//! A [`PassRecord`] is plain values, which a program can forward to any viewer. With the feature `tracing`,
//! `emit` turns records into spans. [`Capabilities`] states what a device does not offer. `docs/profiling.md`
//! has an example and explains how to read the results.
//!
//! Recorders do not depend on profiles. A [`Profile`] observes what they record, and computes its records from that,
//! from the steps of plans and from the device's decisions.
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
mod recorded;
mod resolved;
mod session;
mod slots;
#[cfg(feature = "tracing")]
mod spans;
pub(in crate::vulkan) mod steps;
mod work;

pub use super::record::PassKind;
pub use capabilities::{Capabilities, Capability, Unavailable};
pub use clock::Clock;
pub(crate) use executables::executables;
pub use executables::{Executable, Statistic};
pub use pass::{Area, Grain, PassRecord};
pub use recorded::Profile;
pub use resolved::Resolved;
pub(crate) use session::Session;
pub use session::{Detail, SolveProfile, SubmissionRecord};
pub use slots::{Decided, QueryRange, Slots};
#[cfg(feature = "tracing")]
pub use spans::emit;
pub use work::Work;
