//! Measures the device's time for the distance passes by timestamps, which are read frames later.

use geosweep::ash::vk;

use crate::Result;
use crate::frames::{Frame, IN_FLIGHT};
use crate::gpu::Gpu;

pub struct Timing {
    pool: vk::QueryPool,
    /// Mask of the valid bits of a timestamp; 0 if the queue has none.
    mask: u64,
    /// Nanoseconds per tick.
    tick: f64,
    /// Whether each of the frames in flight was timed.
    timed: [bool; IN_FLIGHT],
    /// Times of the last few frames, the newest last.
    milliseconds: Vec<f64>,
}

impl Timing {
    pub fn new(gpu: &Gpu) -> Result<Self> {
        // SAFETY: the physical device is from this instance.
        let bits = unsafe {
            gpu.instance.get_physical_device_queue_family_properties(gpu.physical_device)
        }[gpu.family as usize]
            .timestamp_valid_bits;
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(2 * IN_FLIGHT as u32);
        Ok(Self {
            pool: unsafe { gpu.device.create_query_pool(&info, None)? },
            mask: if bits == 0 { 0 } else { u64::MAX >> (64 - bits) },
            tick: gpu.properties.limits.timestamp_period.into(),
            timed: [false; IN_FLIGHT],
            milliseconds: Vec::new(),
        })
    }

    pub fn start(&mut self, gpu: &Gpu, frame: Frame) {
        self.timed[frame.index] = self.mask != 0;
        let first = 2 * frame.index as u32;
        // SAFETY: the commands are being recorded. The device has finished with these queries.
        unsafe { gpu.device.cmd_reset_query_pool(frame.commands, self.pool, first, 2) };
        self.stamp(gpu, frame, first);
    }

    pub fn stop(&self, gpu: &Gpu, frame: Frame) {
        self.stamp(gpu, frame, 2 * frame.index as u32 + 1);
    }

    fn stamp(&self, gpu: &Gpu, frame: Frame, query: u32) {
        if self.mask != 0 {
            let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
            // SAFETY: the commands are being recorded, and the query has been reset.
            unsafe { gpu.device.cmd_write_timestamp(frame.commands, stage, self.pool, query) };
        }
    }

    /// Reads the times of a frame, after its fence.
    pub fn collect(&mut self, gpu: &Gpu, frame: Frame) -> Result<()> {
        if !std::mem::take(&mut self.timed[frame.index]) {
            return Ok(());
        }
        let mut ticks = [0u64; 2];
        let (first, flags) = (2 * frame.index as u32, vk::QueryResultFlags::TYPE_64);
        // SAFETY: the pool is alive. Both queries are available, since the fence has been waited for.
        unsafe { gpu.device.get_query_pool_results(self.pool, first, &mut ticks, flags)? };
        let elapsed = ticks[1].wrapping_sub(ticks[0]) & self.mask;
        self.milliseconds.push(elapsed as f64 * self.tick * 1e-6);
        if self.milliseconds.len() > 15 {
            self.milliseconds.remove(0);
        }
        Ok(())
    }

    /// Forgets the times, since something else is timed from now on.
    pub fn forget(&mut self) {
        self.milliseconds.clear();
    }

    /// Returns the median of the last few times.
    pub fn milliseconds(&self) -> Option<f64> {
        let mut sorted = self.milliseconds.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied()
    }

    pub fn destroy(&self, gpu: &Gpu) {
        // SAFETY: nothing is in flight.
        unsafe { gpu.device.destroy_query_pool(self.pool, None) };
    }
}
