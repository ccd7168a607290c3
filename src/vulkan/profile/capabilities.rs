//! Finds out what a device offers for profiling.

use std::ffi::CStr;
use std::fmt;

use ash::{ext, khr, vk};

use super::clock::Clock;
use crate::vulkan::device::requirements::have;

/// Capability that a device may offer for profiling. Computing a map needs none of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Capability {
    /// Timestamp queries on the queue: the GPU time of each pass.
    Timestamps,
    /// Pipeline-statistics queries: the invocations of each pass.
    Statistics,
    /// `VK_KHR_pipeline_executable_properties`: registers, spills and subgroup size of pipelines.
    Executables,
    /// Calibrated timestamps, which relate the device's clock to the host's.
    Calibration,
    /// `VK_EXT_debug_utils`: labels and names in tools.
    Labels,
}

impl Capability {
    /// All capabilities.
    pub const ALL: [Self; 5] =
        [Self::Timestamps, Self::Statistics, Self::Executables, Self::Calibration, Self::Labels];

    /// Returns the name used on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Timestamps => "timestamps",
            Self::Statistics => "statistics",
            Self::Executables => "executables",
            Self::Calibration => "calibration",
            Self::Labels => "labels",
        }
    }
}

impl fmt::Display for Capability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Reason why something cannot be profiled. It is displayed as "not available on this device (the reason)".
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Unavailable(&'static str);

impl Unavailable {
    /// Reason why a capability is missing that the caller left out on purpose.
    pub const LEFT_OUT: Self = Self("left out as asked");
}

impl fmt::Display for Unavailable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "not available on this device ({})", self.0)
    }
}

/// Capabilities of a device for profiling, with a reason for each that is missing.
#[derive(Clone, Debug, PartialEq)]
pub struct Capabilities {
    /// Clock of the queue.
    pub timestamps: Result<Clock, Unavailable>,
    /// Whether the device counts invocations.
    pub statistics: Result<(), Unavailable>,
    /// Whether the driver reports the registers of pipelines.
    pub executables: Result<(), Unavailable>,
    /// Extension for calibrated timestamps: `VK_KHR_calibrated_timestamps` if the device has it, otherwise
    /// its predecessor `VK_EXT_calibrated_timestamps`.
    pub calibration: Result<&'static CStr, Unavailable>,
    /// Whether tools receive labels and names.
    pub labels: Result<(), Unavailable>,
}

impl Capabilities {
    /// Queries a device that meets the [requirements](crate::vulkan::device::requirements), and its queue
    /// family. `debug_utils` says whether the instance has `VK_EXT_debug_utils` enabled.
    pub fn of(
        instance: &ash::Instance,
        physical_device: vk::PhysicalDevice,
        queue_family: u32,
        debug_utils: bool,
    ) -> Self {
        let clock = Clock::of(instance, physical_device, queue_family);
        // SAFETY: the physical device is from this instance.
        let (features, extensions) = unsafe {
            (
                instance.get_physical_device_features(physical_device),
                instance.enumerate_device_extension_properties(physical_device).unwrap_or_default(),
            )
        };
        let has = |name| have(&extensions, name);
        let or = |there: bool, reason| if there { Ok(()) } else { Err(Unavailable(reason)) };
        let calibration = [khr::calibrated_timestamps::NAME, ext::calibrated_timestamps::NAME];
        let executables = has(khr::pipeline_executable_properties::NAME)
            && executable_info(instance, physical_device);
        Self {
            timestamps: clock.ok_or(Unavailable("its queue for compute writes no timestamps")),
            statistics: or(
                features.pipeline_statistics_query != 0,
                "it counts no invocations: pipelineStatisticsQuery is missing",
            ),
            executables: or(
                executables,
                "VK_KHR_pipeline_executable_properties or its feature pipelineExecutableInfo is missing",
            ),
            calibration: calibration.into_iter().find(|name| has(name)).ok_or(Unavailable(
                "VK_KHR_calibrated_timestamps and VK_EXT_calibrated_timestamps are missing",
            )),
            labels: or(debug_utils, "VK_EXT_debug_utils is missing or not enabled"),
        }
    }

    /// Returns the capabilities of a device that lacks those in `left_out`.
    pub fn without(mut self, left_out: &[Capability]) -> Self {
        const GONE: Unavailable = Unavailable::LEFT_OUT;
        for capability in left_out {
            match capability {
                Capability::Timestamps => self.timestamps = Err(GONE),
                Capability::Statistics => self.statistics = Err(GONE),
                Capability::Executables => self.executables = Err(GONE),
                Capability::Calibration => self.calibration = Err(GONE),
                Capability::Labels => self.labels = Err(GONE),
            }
        }
        self
    }

    /// Returns the reason why a capability is missing; `None` if it is available.
    pub fn reason(&self, capability: Capability) -> Option<Unavailable> {
        match capability {
            Capability::Timestamps => self.timestamps.err(),
            Capability::Statistics => self.statistics.err(),
            Capability::Executables => self.executables.err(),
            Capability::Calibration => self.calibration.err(),
            Capability::Labels => self.labels.err(),
        }
    }

    /// Returns the device extensions to enable for these capabilities.
    pub fn device_extensions(&self) -> Vec<&'static CStr> {
        let executables = self.executables.map(|()| khr::pipeline_executable_properties::NAME);
        executables.into_iter().chain(self.calibration).collect()
    }
}

fn executable_info(instance: &ash::Instance, physical_device: vk::PhysicalDevice) -> bool {
    let mut executables = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut executables);
    // SAFETY: the physical device is from this instance, and it supports Vulkan 1.1 and the extension.
    unsafe { instance.get_physical_device_features2(physical_device, &mut features) };
    executables.pipeline_executable_info != 0
}
