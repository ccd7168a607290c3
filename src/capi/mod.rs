//! The interface for C and C++ (feature `capi`): [`crate::vulkan::embed`] through `extern "C"`
//! functions, declared in `src/capi/geosweep.h`.
//!
//! The library is built with
//!
//! ```sh
//! cargo rustc --release --lib --features capi --crate-type cdylib,staticlib
//! ```
//!
//! and `docs/embedding.md` tells how to use it. The items here are documented for C; from Rust, use
//! [`crate::vulkan::embed`].
//!
//! # Errors
//!
//! Calls return a [`GeosweepStatus`]. [`geosweep_last_error`] says in words what was wrong, from
//! storage of the thread's own: there is nothing to free, no buffer to size, no lock, and no
//! pointer that goes bad while the thread lives. Null, numbers that are no enumerator, and counts
//! that make no sense are errors that name the argument. No panic crosses into C.
//!
//! # Safety
//!
//! What cannot be checked is the caller's promise, the same for all functions:
//!
//! - A pointer that is not null points to what its type says, and an array is as long as its count.
//!   Nothing else writes to it during the call.
//! - Objects are used between the calls that create and destroy them. Calls that take a pointer to
//!   `const` may run at once on one object; others have it for themselves.
//! - Vulkan handles that are not null are alive and belong together. What Vulkan demands of a
//!   program, such as one thread at a time for a command pool, is the program's to see to.

#![allow(clippy::missing_safety_doc)] // said once, above

mod arguments;
mod choices;
mod contours;
mod curves;
mod frame;
mod loader;
mod memory;
mod objects;
mod paths;
mod plan;
mod points;
mod profile;
mod record;
mod regions;
mod requirements;
mod solver;
mod status;
mod surface;
mod surface_info;

pub use choices::{GeosweepEdgeRule, GeosweepSchedule, GeosweepWavefront};
pub use contours::*;
pub use curves::*;
pub use frame::{
    GEOSWEEP_POINTS_UNCHANGED, GEOSWEEP_STRAIGHT, GeosweepAccess, GeosweepFrame, GeosweepReader,
    GeosweepSource, GeosweepSources, geosweep_source_at,
};
pub use memory::{GeosweepAllocator, GeosweepMemory, GeosweepMemoryRequest};
pub use paths::*;
pub use plan::*;
pub use points::{GeosweepPointKind, GeosweepPoints};
pub use profile::*;
pub use record::*;
pub use regions::*;
pub use requirements::*;
pub use solver::*;
pub use status::{GeosweepStatus, geosweep_last_error};
pub use surface::*;
pub use surface_info::*;

/// What the header says of threads.
const _: () = {
    const fn for_any_thread<T: Send + Sync>() {}
    for_any_thread::<GeosweepSolver>();
    for_any_thread::<GeosweepSurface>();
    for_any_thread::<GeosweepPlan>();
    for_any_thread::<GeosweepContours>();
    for_any_thread::<GeosweepPaths>();
    for_any_thread::<GeosweepRegions>();
    for_any_thread::<GeosweepProfile>();
};
