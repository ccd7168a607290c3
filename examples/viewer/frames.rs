//! Frames in flight: resources that exist twice, so that the program prepares one frame while the device
//! draws the other.

use geosweep::ash::vk;

use crate::Result;
use crate::gpu::Gpu;

/// Number of frames in flight.
pub const IN_FLIGHT: usize = 2;

pub struct Frames {
    pool: vk::CommandPool,
    frames: Vec<Frame>,
    next: usize,
}

#[derive(Clone, Copy)]
pub struct Frame {
    pub index: usize,
    pub commands: vk::CommandBuffer,
    /// Signalled when the window's image may be drawn into.
    pub acquired: vk::Semaphore,
    /// Signalled when the device has finished the frame.
    pub fence: vk::Fence,
}

impl Frames {
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let device = &gpu.device;
        // SAFETY: everything that the infos point to is alive.
        unsafe {
            let info = vk::CommandPoolCreateInfo::default()
                .queue_family_index(gpu.family)
                .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
            let pool = device.create_command_pool(&info, None)?;
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(pool)
                .command_buffer_count(IN_FLIGHT as u32);
            let signaled = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
            let frames = device
                .allocate_command_buffers(&info)?
                .into_iter()
                .enumerate()
                .map(|(index, commands)| {
                    let acquired = device.create_semaphore(&Default::default(), None)?;
                    let fence = device.create_fence(&signaled, None)?;
                    Ok(Frame { index, commands, acquired, fence })
                })
                .collect::<Result<_>>()?;
            Ok(Self { pool, frames, next: 0 })
        }
    }

    /// Returns the next frame, after the device has finished its previous use.
    pub fn wait(&self, gpu: &Gpu) -> Result<Frame> {
        let frame = self.frames[self.next];
        // SAFETY: the fence is signalled at first and by every submission.
        unsafe { gpu.device.wait_for_fences(&[frame.fence], true, u64::MAX)? };
        Ok(frame)
    }

    /// Submits the frame that was waited for.
    pub fn submit(&mut self, gpu: &Gpu, drawn: vk::Semaphore) -> Result<()> {
        let frame = self.frames[self.next];
        let (commands, acquired, drawn) = ([frame.commands], [frame.acquired], [drawn]);
        let stages = [vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT];
        let info = vk::SubmitInfo::default()
            .command_buffers(&commands)
            .wait_semaphores(&acquired)
            .wait_dst_stage_mask(&stages)
            .signal_semaphores(&drawn);
        // SAFETY: the fence has been waited for. All objects are alive until the next wait.
        unsafe {
            gpu.device.reset_fences(&[frame.fence])?;
            gpu.device.queue_submit(gpu.queue, &[info], frame.fence)?;
        }
        self.next = (self.next + 1) % IN_FLIGHT;
        Ok(())
    }

    /// Submits commands that are needed once and waits for them, before the first frame.
    pub fn now(
        &self,
        gpu: &Gpu,
        record: impl FnOnce(vk::CommandBuffer) -> Result<()>,
    ) -> Result<()> {
        let commands = self.frames[self.next].commands;
        begin(gpu, commands)?;
        record(commands)?;
        let buffers = [commands];
        let info = vk::SubmitInfo::default().command_buffers(&buffers);
        // SAFETY: nothing is in flight.
        unsafe {
            gpu.device.end_command_buffer(commands)?;
            gpu.device.queue_submit(gpu.queue, &[info], vk::Fence::null())?;
            Ok(gpu.device.queue_wait_idle(gpu.queue)?)
        }
    }

    pub fn destroy(&self, gpu: &Gpu) {
        // SAFETY: nothing is in flight.
        unsafe {
            for frame in &self.frames {
                gpu.device.destroy_semaphore(frame.acquired, None);
                gpu.device.destroy_fence(frame.fence, None);
            }
            gpu.device.destroy_command_pool(self.pool, None);
        }
    }
}

/// Begins a command buffer that the device has finished.
pub fn begin(gpu: &Gpu, commands: vk::CommandBuffer) -> Result<()> {
    let info =
        vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
    // SAFETY: the command buffer is from a pool whose buffers can be reset.
    unsafe { gpu.device.begin_command_buffer(commands, &info)? };
    Ok(())
}
