//! The Vulkan engine (being written).
use crate::surface::{Seed, Surface, SurfaceError};
use crate::{DeviceChoice, Wavefront, cpu::Stop};

/// Why the Vulkan engine cannot run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VulkanError {
    /// The surface cannot be used.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// being written
    #[error("not yet")]
    Missing,
}

/// x
pub struct Solver;
/// x
pub struct Solution {
    /// x
    pub distances: Vec<f32>,
    /// x
    pub iterations: u32,
    /// x
    pub residual: f64,
    /// x
    pub time: std::time::Duration,
}
impl Solver {
    /// x
    pub fn new(_: &DeviceChoice) -> Result<Self, VulkanError> {
        Err(VulkanError::Missing)
    }
    /// x
    pub fn solve(
        &mut self,
        _: &Surface,
        _: &[Seed],
        _: Wavefront,
        _: Stop,
    ) -> Result<Solution, VulkanError> {
        Err(VulkanError::Missing)
    }
    /// x
    pub fn device_name(&self) -> &str {
        ""
    }
}
/// x
pub fn devices() {}
