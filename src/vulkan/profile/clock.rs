//! Converts ticks of a queue's timestamps to nanoseconds.

use ash::vk;

/// Properties of a queue family's timestamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Length of a tick in nanoseconds.
    pub period: f64,
    /// Number of valid bits of a timestamp, from 1 to 64. The other bits are undefined.
    pub valid_bits: u32,
}

impl Clock {
    /// Returns the clock of a queue family; `None` if its queues write no timestamps.
    pub fn of(
        instance: &ash::Instance,
        physical_device: vk::PhysicalDevice,
        queue_family: u32,
    ) -> Option<Self> {
        // SAFETY: the physical device is from this instance.
        let (properties, families) = unsafe {
            (
                instance.get_physical_device_properties(physical_device),
                instance.get_physical_device_queue_family_properties(physical_device),
            )
        };
        let valid_bits = families.get(queue_family as usize)?.timestamp_valid_bits;
        let period = f64::from(properties.limits.timestamp_period);
        (valid_bits > 0 && period > 0.0).then_some(Self { period, valid_bits })
    }

    /// Returns the ticks from one timestamp to a later one. The counter may wrap at most once between them.
    pub fn ticks(&self, from: u64, to: u64) -> u64 {
        to.wrapping_sub(from) & self.mask()
    }

    /// Returns the ticks from one timestamp to another, which may be earlier. The counter wraps, so the ticks
    /// are counted in the direction in which there are fewer.
    pub fn signed_ticks(&self, from: u64, to: u64) -> i64 {
        let unused = u64::BITS - self.valid_bits;
        (to.wrapping_sub(from) << unused) as i64 >> unused
    }

    /// Returns the nanoseconds from one timestamp to a later one.
    ///
    /// ```
    /// use geosweep::vulkan::profile::Clock;
    /// let clock = Clock { period: 10.0, valid_bits: 36 };
    /// assert_eq!(clock.nanoseconds((1 << 36) - 2, 3), 50);
    /// ```
    pub fn nanoseconds(&self, from: u64, to: u64) -> u64 {
        (self.ticks(from, to) as f64 * self.period).round() as u64
    }

    fn mask(&self) -> u64 {
        u64::MAX >> (u64::BITS - self.valid_bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_wrap_and_what_lies_above_them_is_ignored() {
        for valid_bits in [20, 36, 48, 63, 64] {
            let clock = Clock { period: 1.0, valid_bits };
            let last = clock.mask();
            assert_eq!(clock.ticks(last, 0), 1);
            assert_eq!(clock.ticks(last - 4, 5), 10);
            assert_eq!(clock.ticks(3, 3), 0);
            assert_eq!(clock.signed_ticks(last - 4, 5), 10);
            assert_eq!(clock.signed_ticks(5, last - 4), -10);
            if valid_bits < 64 {
                let garbage = !last;
                assert_eq!(clock.ticks(7, garbage | 12), 5);
                assert_eq!(clock.signed_ticks(garbage | 12, 7), -5);
            }
        }
    }

    #[test]
    fn ticks_are_periods() {
        let clock = Clock { period: 52.083, valid_bits: 64 };
        assert_eq!(clock.nanoseconds(1000, 1192), 10_000);
    }
}
