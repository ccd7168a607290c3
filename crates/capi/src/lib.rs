//! Interface for C and C++ (feature `capi`): [`geosweep::vulkan::embed`] through `extern "C"` functions, which
//! `src/capi/geosweep.h` declares.
//!
//! This command builds the library:
//!
//! ```sh
//! cargo rustc --release --lib --features capi --crate-type cdylib,staticlib
//! ```
//!
//! `docs/c.md` explains how to use the library. The items here are documented for C; from Rust, use
//! [`geosweep::vulkan::embed`].
//!
//! # Errors
//!
//! Calls return a [`GeosweepStatus`]. [`geosweep_last_error`] describes the error in words. Each thread has
//! its own storage for this text, which is valid while the thread lives: there is nothing to free, no buffer
//! to size and no lock. Null, numbers without an enumerator, and impossible counts are errors that name the
//! argument. No panic crosses into C.
//!
//! # Safety
//!
//! The caller promises what cannot be checked. The promises are the same for all functions:
//!
//! - A pointer that is not null points to a value of its type, and an array has as many entries as its count
//!   says. Nothing else writes to them during the call.
//! - Objects are used between the calls that create and destroy them. Calls that take a pointer to `const`
//!   may use one object at the same time. Other calls need the object to themselves.
//! - Vulkan handles that are not null are alive and belong together. The program keeps Vulkan's own rules,
//!   such as one thread at a time for a command pool.

#![allow(clippy::missing_safety_doc)] // said once, above

mod arguments;
mod choices;
mod contours;
mod cpu_map;
mod curves;
mod directions;
mod frame;
mod loader;
mod log_map;
mod memory;
mod objects;
mod outputs;
mod paths;
mod plan;
mod points;
mod profile;
mod record;
mod regions;
mod requirements;
mod shared;
mod solver;
mod status;
mod surface;
mod surface_info;
mod users;

pub use choices::{GeosweepEdgeRule, GeosweepGluing, GeosweepSchedule, GeosweepWavefront};
pub use contours::*;
pub use cpu_map::*;
pub use curves::*;
pub use directions::*;
pub use frame::{
    GEOSWEEP_POINTS_UNCHANGED, GEOSWEEP_STRAIGHT, GeosweepAccess, GeosweepFrame, GeosweepReader,
    GeosweepSource, GeosweepSources, GeosweepTarget, geosweep_source_at,
};
pub use log_map::*;
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
