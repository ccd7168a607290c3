//! Defines where the maps of a batch lie.

use std::fmt;

/// Memory in which a device computes the maps of many sources. Both kinds give the same maps, scan by scan.
///
/// Measured on lavapipe (Mesa 22.3, by the processor's time): on 32 x 32 points maps in shared memory take
/// about half the time of maps in images, and on 64 x 64 points 0.8 to 1.1 times the time of maps in images.
/// The two were not compared on a GPU. On a GPU, maps in shared memory read only the surface's data from
/// memory, which stay in caches, and need barriers only within a workgroup.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PairwiseSchedule {
    /// Each map in the shared memory of a workgroup, for small grids. 16 KiB hold up to 64 x 64 points with
    /// straight or circular fronts, and half as many points with curved ones.
    SharedMemory,
    /// All maps in the layers of images.
    Images,
}

impl PairwiseSchedule {
    /// All schedules.
    pub const ALL: [Self; 2] = [Self::SharedMemory, Self::Images];

    /// Returns the name used in reports.
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
