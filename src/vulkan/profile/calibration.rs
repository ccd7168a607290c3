//! Relates the device's clock to the host's.

use std::ffi::CStr;
use std::time::Instant;

use ash::{ext, khr, vk};

use super::clock::Clock;
use crate::vulkan::VulkanError;

/// Readings of the device's and the host's clock at one moment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Calibration {
    ticks: u64,
    at: Instant,
    clock: Clock,
}

impl Calibration {
    /// Reads the device's clock between two readings of the host's clock. The device must have `extension`
    /// enabled. Of several tries, the result is the one that took the shortest time.
    pub(crate) fn new(
        instance: &ash::Instance,
        device: &ash::Device,
        extension: &CStr,
        clock: Clock,
    ) -> Result<Self, VulkanError> {
        let info =
            [vk::CalibratedTimestampInfoKHR::default().time_domain(vk::TimeDomainKHR::DEVICE)];
        // Both extensions have the same function under names with different endings.
        let read = || {
            // SAFETY: the extension is enabled on the device, which offers its own time domain.
            unsafe {
                if extension == khr::calibrated_timestamps::NAME {
                    let loader = khr::calibrated_timestamps::Device::new(instance, device);
                    loader.get_calibrated_timestamps(&info)
                } else {
                    let loader = ext::calibrated_timestamps::Device::new(instance, device);
                    loader.get_calibrated_timestamps(&info)
                }
            }
            .map_err(VulkanError::from_call("vkGetCalibratedTimestampsKHR"))
        };
        const TRIES: usize = 8;
        let mut best = None;
        for _ in 0..TRIES {
            let before = Instant::now();
            let (ticks, _) = read()?;
            let taken = before.elapsed();
            if best.is_none_or(|(shortest, _, _)| taken < shortest) {
                best = Some((taken, ticks[0], before + taken / 2));
            }
        }
        let (_, ticks, at) = best.expect("there was a try");
        Ok(Self { ticks, at, clock })
    }

    /// Returns the nanoseconds from a moment on the host's clock to a timestamp of the device.
    pub(crate) fn since(&self, start: Instant, timestamp: u64) -> f64 {
        let [after, before] = [(self.at, start), (start, self.at)]
            .map(|(to, from)| to.saturating_duration_since(from).as_nanos() as f64);
        after - before + self.clock.signed_ticks(self.ticks, timestamp) as f64 * self.clock.period
    }
}
