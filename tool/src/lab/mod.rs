//! The laboratory: how accurate and how fast the engines are, and the paper's figures and tables.

pub mod accuracy;
pub mod bench;
pub mod figure;
mod lists;
mod publication;
mod reference;
