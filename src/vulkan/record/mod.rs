//! Records commands. Each function appends commands to a command buffer that the caller has begun, and ends
//! with a barrier after which the next function may be recorded. None submits or waits.

mod commands;
mod exchange;
mod map;
mod recorder;
mod surface;
mod turn;

pub(crate) use commands::{Commands, Groups};
pub(crate) use recorder::{Recorder, dispatched};
pub(crate) use turn::Turn;

#[cfg(feature = "capi")]
pub(crate) use super::device::barrier::MOST_TOGETHER;
