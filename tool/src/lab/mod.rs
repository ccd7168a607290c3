//! Implements the laboratory commands: the accuracy and speed of the engines, the tuning of a device, and the
//! paper's figures and tables.

pub mod accuracy;
pub mod bench;
pub mod figure;
pub mod frames;
mod lists;
mod publication;
mod reference;
pub mod tune;
