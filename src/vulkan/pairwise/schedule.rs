//! Where the maps of many sources lie.

use std::fmt;

/// Where the maps of many sources lie while a device computes them. Both ways lead to the same
/// maps, scan by scan.
///
/// Measured on lavapipe (Mesa 22.3, by the processor's time): on 32 x 32 points maps in shared memory
/// take about half the time of maps in images, on 64 x 64 points 0.8 to 1.1 times. No GPU has been at
/// hand; there the first way needs no traffic with memory but for the lengths, which caches hold, and
/// no barrier beyond a workgroup.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PairwiseSchedule {
    /// A map in the shared memory of a workgroup: for small grids, with 16 KiB up to 64 x 64 points
    /// where fronts are straight or circular and half as many where they are curved or anchored.
    SharedMemory,
    /// All maps in the layers of images.
    Images,
}

impl PairwiseSchedule {
    /// Both.
    pub const ALL: [Self; 2] = [Self::SharedMemory, Self::Images];

    /// The name used in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::SharedMemory => "shared memory",
            Self::Images => "images",
        }
    }
}

impl fmt::Display for PairwiseSchedule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
