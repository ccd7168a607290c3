//! Devices and surfaces that several tests use.

use super::HeadlessSolver;
use super::context::Context;
use crate::surface::{Spacing, Surface};
use crate::vulkan::DeviceChoice;
use crate::vulkan::device::barrier::{Access, PASS};

/// Returns the device that tests use.
pub(in crate::vulkan) fn device() -> DeviceChoice {
    DeviceChoice::Name(std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default())
}

/// Returns a solver under the validation layers.
pub(in crate::vulkan) fn validated() -> HeadlessSolver {
    HeadlessSolver::with_validation(&device()).unwrap()
}

/// Returns a solver for profiling under the validation layers, which gives names to pipelines and images.
pub(in crate::vulkan) fn profiling() -> HeadlessSolver {
    HeadlessSolver::with(Context::open(&device(), true, Some(&[])).unwrap()).unwrap()
}

/// Returns a rough surface of `rows` x `cols` points. Point `i` has the height of the point `of(i)`.
pub(in crate::vulkan) fn hill(rows: u32, cols: u32, of: fn(u32) -> u32) -> Surface {
    let heights = (0..rows * cols).map(of).map(|i| f64::from(i % 7 + i / 90).sin()).collect();
    Surface::from_heights(rows as usize, cols as usize, heights, Spacing::square(1.0)).unwrap()
}

/// Returns whether a barrier separates two passes.
pub(in crate::vulkan) fn is_between_passes(before: Access, after: Access) -> bool {
    (before, after) == (PASS, PASS)
}
