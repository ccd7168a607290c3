//! The laboratory: how accurate and how fast the engines are, what suits a device, and the paper's
//! figures and tables.

pub mod accuracy;
pub mod bench;
pub mod figure;
pub mod frames;
mod lists;
mod publication;
mod reference;
pub mod tune;
