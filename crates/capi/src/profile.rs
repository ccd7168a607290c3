//! Times of the passes of a frame.

use std::ffi::c_char;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::arguments::Output;
use super::choices::{choices, choose};
use super::objects::{check_landed, hand_out, kind_of_object, object, take};
use super::plan::{GeosweepPlan, plan};
use super::shared::Shared;
use super::status::{Failure, calls};
use super::surface::GeosweepSurface;
use geosweep::vulkan::VulkanError;
use geosweep::vulkan::embed::{self, Buffer, BufferInfo};
use geosweep::vulkan::profile::{
    Clock, Decided, Grain, PassRecord, Profile, QueryRange, Resolved, Slots,
};

/// Value of a member of `GeosweepPass` that is not known.
pub const GEOSWEEP_UNKNOWN: u64 = u64::MAX;

/// Unit of work that gets its own time. Timestamps take time: the finer the grain, the longer the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum GeosweepGrain {
    /// Scans or rounds of tiles, and the passes around them.
    Scans = 0,
    /// Blocks of lines of each scan.
    Blocks = 1,
    /// Iterations, and the passes around them.
    Iterations = 2,
    /// Portions: all of a map from its sources to its outcome, and the passes before and after it.
    Portions = 3,
}

/// Number of a `GeosweepGrain`, not checked yet.
type GrainNumber = i32;

/// Profile of a frame, with its own queries and buffer. Each profiled frame in flight needs its own profile.
pub struct GeosweepProfile {
    pub(super) shared: Arc<Shared>,
    pub(super) profile: Profile,
    /// Number of passes for which there is room, and what makes a pass.
    room: (u32, Grain),
    clock: Clock,
    pool: vk::QueryPool,
    decisions: Buffer,
    is_recorded: AtomicBool,
}

kind_of_object! { GeosweepProfile, profile: GeosweepProfile }

/// A pass of a frame, or several passes that are timed together. Unknown members are `GEOSWEEP_UNKNOWN`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepPass {
    /// Name of the pass in captures, such as "scan down". It is never freed.
    pub name: *const c_char,
    /// Iteration or round of tiles to which the pass belongs, from 0. It is `UINT32_MAX` outside iterations.
    pub iteration: u32,
    /// Number of dispatches; 0 for copies and clears.
    pub dispatches: u32,
    /// Time on the device in nanoseconds, from the end of the previous pass to the end of this one. It
    /// includes the barrier between them.
    pub nanoseconds: u64,
    /// Bytes that the pass had to read, each counted once.
    pub bytes_read: u64,
    /// Bytes that the pass had to write.
    pub bytes_written: u64,
    /// Number of texels of 2 x 2 points that the pass visited.
    pub texels: u64,
    /// Whether the pass was dispatched and visited nothing, since the map had converged or nothing could
    /// change where the pass works.
    pub is_idle: bool,
}

impl AsRef<Shared> for GeosweepProfile {
    fn as_ref(&self) -> &Shared {
        &self.shared
    }
}

choices! { Grain = GeosweepGrain: Scans, Blocks, Iterations, Portions; }

impl GeosweepProfile {
    fn new(
        surface: &GeosweepSurface,
        plan: &embed::Plan,
        grain: Grain,
        queue_family: u32,
    ) -> Result<Self, Failure> {
        let GeosweepSurface { shared, surface, .. } = surface;
        let Shared { device, instance, physical_device, .. } = &**shared;
        let clock = Clock::of(instance, *physical_device, queue_family).ok_or_else(|| {
            Failure::unsupported(format!("queues of the family {queue_family} write no timestamps"))
        })?;
        let passes = shared.solver.passes_of_frame(surface, plan, grain);
        let location = MemoryLocation::GpuToCpu;
        let info = BufferInfo { name: "decisions", size: Slots::DECISION_BYTES, location };
        let mut decisions = Buffer::new(device, &mut shared.allocator(), info)?;
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(passes + 1);
        // SAFETY: the device is alive.
        let pool = unsafe { device.create_query_pool(&info, None) };
        let pool = pool.map_err(|result| {
            decisions.destroy(device, &mut shared.allocator());
            VulkanError::Call { call: "vkCreateQueryPool", result }
        })?;
        let slots = Slots::default()
            .with_timestamps(QueryRange { pool, first: 0, count: passes + 1 })
            .with_decisions(Decided { buffer: decisions.buffer, offset: 0, portions: 1 });
        let profile = Profile::new(passes, grain, slots);
        let (shared, is_recorded) = (Arc::clone(shared), AtomicBool::new(false));
        let room = (passes, grain);
        Ok(Self { shared, profile, room, clock, pool, decisions, is_recorded })
    }

    /// Returns an error if a frame with this plan has more passes than there is room for.
    pub(super) fn check_room(
        &self,
        surface: &GeosweepSurface,
        plan: &embed::Plan,
    ) -> Result<(), Failure> {
        let (room, grain) = self.room;
        let passes = self.shared.solver.passes_of_frame(&surface.surface, plan, grain);
        match passes > room {
            true => {
                let reason = format!(
                    "has room for {room} passes, and the frame has up to {passes}: create it with the surface and the \
                     plan of the frame"
                );
                Err(Failure::argument("frame->profile", reason))
            }
            false => Ok(()),
        }
    }

    /// Notes that a frame is about to be recorded.
    pub(super) fn note_recording(&self) {
        self.is_recorded.store(true, Ordering::Relaxed);
    }

    /// Reads the times of the last frame.
    ///
    /// # Errors
    /// If the driver fails, or the last recording has not run.
    fn resolve(&self) -> Result<Resolved, Failure> {
        let not_ready =
            || Failure::not_ready("the profile's frame has not run: ask after its fence");
        if !self.is_recorded.load(Ordering::Relaxed) {
            return Err(not_ready());
        }
        let decisions = Some(self.decisions.read());
        let resolved = self.profile.resolve(&self.shared.device, Some(self.clock), decisions)?;
        resolved.ok_or_else(not_ready)
    }

    fn destroy(&mut self) {
        let Self { shared, pool, decisions, .. } = self;
        // SAFETY: the program ensures that no submitted work uses the pool.
        unsafe { shared.device.destroy_query_pool(*pool, None) };
        decisions.destroy(&shared.device, &mut shared.allocator());
    }
}

impl From<&PassRecord> for GeosweepPass {
    fn from(record: &PassRecord) -> Self {
        let known = |number: Option<u64>| number.unwrap_or(GEOSWEEP_UNKNOWN);
        Self {
            name: record.kind.label().as_ptr(),
            iteration: record.iteration.unwrap_or(u32::MAX),
            dispatches: record.dispatches,
            nanoseconds: known(record.nanoseconds),
            bytes_read: known(record.work.bytes_read),
            bytes_written: known(record.work.bytes_written),
            texels: known(record.work.texels),
            is_idle: record.is_idle(),
        }
    }
}

calls! {
    /// Creates a profile for frames of a surface with this plan on a queue of this family.
    /// `geosweep_profile_destroy` destroys it. If the family's queues cannot write timestamps, the status is
    /// `GEOSWEEP_STATUS_UNSUPPORTED`.
    fn geosweep_profile_create(
        surface: *const GeosweepSurface,
        plan: *const GeosweepPlan,
        grain: GrainNumber,
        queue_family: u32,
        profile: *mut *mut GeosweepProfile,
    ) {
        let surface = object(surface)?;
        let (plan, output) = (self::plan(plan, surface, "plan")?, Output::new(profile, "profile")?);
        hand_out(output, GeosweepProfile::new(surface, plan, choose(grain, "grain")?, queue_family)?);
    }

    /// Reads the times of the passes of the last frame that was recorded with this profile, after its fence.
    /// Writes the number of passes to `count`, and at most `capacity` passes to `passes`. If that frame has not
    /// run, the status is `GEOSWEEP_STATUS_NOT_READY`.
    fn geosweep_profile_passes(
        profile: *const GeosweepProfile,
        passes: *mut GeosweepPass,
        capacity: u32,
        count: *mut u32,
    ) {
        let (profile, output) = (object(profile)?, Output::new(count, "count")?);
        let resolved = profile.resolve()?;
        if capacity > 0 {
            let passes = Output::new(passes, "passes")?;
            for (index, pass) in resolved.passes.iter().take(capacity as usize).enumerate() {
                passes.write_at(index, pass.into());
            }
        }
        output.write(resolved.passes.len() as u32);
    }

    /// Destroys a profile. No submitted work may still use it; a solver with checks verifies that. Null is
    /// allowed.
    fn geosweep_profile_destroy(profile: *mut GeosweepProfile) {
        let check = |of: &GeosweepProfile| {
            check_landed::<GeosweepProfile>(of, of.profile.is_in_flight())
        };
        if let Some(mut profile) = take(profile, check)? {
            profile.destroy();
        }
    }
}
