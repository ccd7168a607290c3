//! Records commands. Each function appends commands to a command buffer that the caller has begun. It ends with a
//! barrier, after which any other of these functions may be recorded. No function submits or waits.

mod commands;
mod exchange;
mod map;
mod observer;
mod pass_kind;
mod recorder;
mod surface;
mod turn;

pub(crate) use commands::{Commands, Groups};
pub(crate) use observer::{Moved, Observer, OpenPass, PlannedSteps, StepsOf};
pub(crate) use pass_kind::MapPart;
pub use pass_kind::PassKind;
pub(crate) use recorder::Recorder;
pub(crate) use turn::Turn;
