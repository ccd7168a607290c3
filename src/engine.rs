//! Names the engines that compute maps.

use crate::name::{UnknownName, by_name};
#[cfg(feature = "vulkan")]
use crate::vulkan::DeviceChoice;
use crate::{Report, UsedEngine};

/// The engine that computes a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Engine {
    /// The CPU, or a GPU if there is one and the whole call should be faster on it, including set-up, upload and
    /// read-back. On the GPU that was measured, this holds from 17 million points on with curved fronts. The report
    /// names the engine and the reason. A Vulkan device that is a CPU is used only on request. A
    /// [`crate::Options::schedule`] requires Vulkan. A program that reuses a [`crate::vulkan::HeadlessSolver`] sets the
    /// device up only once, and gains on smaller grids too.
    #[default]
    Auto,
    /// A Vulkan device. It is an error if none can be used.
    #[cfg(feature = "vulkan")]
    Vulkan(DeviceChoice),
    /// The CPU, by rotated raster scans or in the order of time, whichever is faster ([`crate::cpu::Order`]).
    Cpu,
    /// Fast marching on the CPU: points one after another, in the order in which fronts reach them
    /// ([`crate::cpu::Order::Times`]), also where scans are faster. Its map is that of [`Self::Cpu`], up to rounding. On
    /// steep random hills some circular and curved maps differ by up to 2e-3, since the order decides there which of two
    /// fronts a point keeps. Anchored fronts are scanned. By default its fronts are planar.
    FastMarching,
}

impl Engine {
    /// Resolves [`Engine::Auto`] to the engine that computed the map of `report`. Other engines are returned
    /// unchanged.
    pub(crate) fn as_for(&self, report: &Report) -> Self {
        match (self, report.engine) {
            (Self::Auto, UsedEngine::Cpu) => Self::Cpu,
            #[cfg(feature = "vulkan")]
            (Self::Auto, _) => Self::Vulkan(DeviceChoice::Any),
            _ => self.clone(),
        }
    }

    /// Returns the name that the tool uses. It does not depend on the device.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Auto => "auto",
            #[cfg(feature = "vulkan")]
            Self::Vulkan(_) => "vulkan",
            Self::Cpu => "cpu",
            Self::FastMarching => "fast-marching",
        }
    }
}

impl std::fmt::Display for Engine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Parses the [`name`](Engine::name) of an engine. The name `vulkan` stands for any device.
impl std::str::FromStr for Engine {
    type Err = UnknownName;

    fn from_str(text: &str) -> Result<Self, UnknownName> {
        let all = [
            Self::Auto,
            #[cfg(feature = "vulkan")]
            Self::Vulkan(DeviceChoice::Any),
            Self::Cpu,
            Self::FastMarching,
        ];
        by_name("engine", text, &all.each_ref(), |engine| engine.name()).cloned()
    }
}
