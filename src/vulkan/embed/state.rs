//! Tracks what has been recorded for a surface: which recordings may follow, and which slots wait for the
//! device.

use std::hash::{BuildHasher, RandomState};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use ash::vk;

use super::map_sources::{Given, MapSources};
use super::plan::Plan;
use crate::update::Wavefront;
use crate::vulkan::flight::{half, later};
use crate::vulkan::{MapLimit, VulkanError};

/// State of a surface whose recordings follow one another.
#[derive(Debug)]
pub(super) struct State {
    /// Number that the last recorded preparation writes, see [`number_of_preparation`]; 0 without one.
    prepared: AtomicU32,
    /// [`EDGES`], [`CURVATURE`] or 0.
    measured: AtomicU32,
    destroyed: AtomicBool,
    /// Schedule and wavefront of the map, see [`number_of`]; 0 without a map.
    map: AtomicU32,
    /// Serial of the recording that measures the edges, or of an earlier one.
    measured_by: AtomicU32,
    /// Number of maps that were started. It identifies the last map.
    maps: AtomicU32,
    /// Sources of the map.
    sources: Mutex<MapSources>,
    /// Whether the map has a limit, and whether it has targets.
    is_limited: AtomicBool,
    has_targets: AtomicBool,
    slots: Box<[Slot]>,
}

/// Last recording of a slot's outcome.
#[derive(Debug, Default)]
struct Slot {
    /// Serial of the recording; 0 if there is none.
    serial: AtomicU32,
    map: AtomicU32,
    /// Hash of the command buffer's handle.
    commands: AtomicU32,
    /// Number of the preparation that the recording follows.
    prepared: AtomicU32,
}

impl State {
    pub(super) fn new(slots: usize) -> Self {
        Self {
            prepared: 0.into(),
            measured: 0.into(),
            destroyed: false.into(),
            map: 0.into(),
            measured_by: 0.into(),
            maps: 0.into(),
            sources: Mutex::new(MapSources::new()),
            is_limited: false.into(),
            has_targets: false.into(),
            slots: (0..slots).map(|_| Slot::default()).collect(),
        }
    }

    /// Notes that the surface is prepared by a recording that writes this number.
    pub(super) fn prepare(&self, number: u32) {
        self.prepared.store(number, Relaxed);
        self.measured.store(0, Relaxed);
        self.map.store(0, Relaxed);
    }

    /// Returns whether the preparation that was recorded last has this number.
    pub(super) fn is_prepared_by(&self, number: u32) -> bool {
        number != 0 && number == self.prepared.load(Relaxed)
    }

    /// Notes that the recording with the serial `coming`, or a later one, measures the edges.
    pub(super) fn measure(&self, with_curvature: bool, coming: u32) {
        self.measured_by.store(coming, Relaxed);
        self.measured.store(if with_curvature { CURVATURE } else { EDGES }, Relaxed);
        self.map.store(0, Relaxed);
    }

    fn sources(&self) -> MutexGuard<'_, MapSources> {
        self.sources.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes a new map from these sources.
    pub(super) fn solve(&self, plan: &Plan, limit: MapLimit, sources: Given) {
        self.sources().set(sources);
        self.note_map(plan, limit);
    }

    /// Notes that sources are added to the map.
    pub(super) fn add(&self, plan: &Plan, limit: MapLimit, sources: Given) {
        self.sources().add(sources);
        self.note_map(plan, limit);
    }

    fn note_map(&self, plan: &Plan, limit: MapLimit) {
        self.map.store(number_of(plan), Relaxed);
        self.maps.fetch_add(1, Relaxed);
        self.is_limited.store(limit.is_there(), Relaxed);
        self.has_targets.store(!limit.targets.is_empty(), Relaxed);
    }

    /// Returns whether the map ends at a radius or at targets.
    pub(super) fn is_limited(&self) -> bool {
        self.is_limited.load(Relaxed)
    }

    /// Returns whether the map ends at targets.
    pub(super) fn has_targets(&self) -> bool {
        self.has_targets.load(Relaxed)
    }

    pub(super) fn destroy(&self) {
        self.destroyed.store(true, Relaxed);
    }

    /// Returns an error if the surface is destroyed.
    pub(super) fn check_there(&self) -> Result<(), VulkanError> {
        if self.destroyed.load(Relaxed) { Err(VulkanError::Destroyed) } else { Ok(()) }
    }

    /// Returns an error unless the surface is prepared and not destroyed.
    pub(super) fn check_prepared(&self) -> Result<(), VulkanError> {
        self.check_there()?;
        match self.prepared.load(Relaxed) {
            0 => Err(VulkanError::NotPrepared),
            _ => Ok(()),
        }
    }

    /// Returns an error unless the surface has the measurements that maps of the plan need.
    pub(super) fn check_measured(&self, plan: &Plan) -> Result<(), VulkanError> {
        self.check_prepared()?;
        let needed = if plan.wavefront.is_curved() { CURVATURE } else { EDGES };
        let is_there = self.measured.load(Relaxed) >= needed;
        if is_there { Ok(()) } else { Err(VulkanError::NotMeasured) }
    }

    /// Returns an error if there is no map.
    pub(super) fn check_map(&self) -> Result<(), VulkanError> {
        self.check_prepared()?;
        if self.map.load(Relaxed) == 0 { Err(VulkanError::NoMap) } else { Ok(()) }
    }

    /// Returns an error unless there is a map, whose sources may be these.
    pub(super) fn check_sources(
        &self,
        sources: Given,
        what: &'static str,
    ) -> Result<(), VulkanError> {
        self.check_map()?;
        match self.sources().may_be(sources) {
            true => Ok(()),
            false => Err(VulkanError::OtherSources { what }),
        }
    }

    /// Returns an error unless there is a map with this wavefront.
    pub(super) fn check_wavefront(&self, wavefront: Wavefront) -> Result<(), VulkanError> {
        self.check_map()?;
        match self.map.load(Relaxed) % WAVEFRONTS == wavefront as u32 {
            true => Ok(()),
            false => Err(VulkanError::OtherMap),
        }
    }

    /// Returns an error unless there is a map with the plan's schedule and wavefront.
    pub(super) fn check_plan(&self, plan: &Plan) -> Result<(), VulkanError> {
        self.check_map()?;
        if self.map.load(Relaxed) == number_of(plan) { Ok(()) } else { Err(VulkanError::OtherMap) }
    }

    /// Notes that a slot's outcome is recorded into a command buffer, with this serial.
    pub(super) fn record_outcome(&self, slot: usize, serial: u32, commands: vk::CommandBuffer) {
        let of = &self.slots[slot];
        of.serial.store(serial, Relaxed);
        of.map.store(self.maps.load(Relaxed), Relaxed);
        of.commands.store(half(commands), Relaxed);
        of.prepared.store(self.prepared.load(Relaxed), Relaxed);
    }

    /// Returns whether the device has seen the preparation that the slot's last recording follows. `number`
    /// is the number in the slot's record.
    pub(super) fn was_prepared_by(&self, slot: usize, number: u32) -> bool {
        self.slots[slot].prepared.load(Relaxed) == number
    }

    /// Returns whether the slot's last recording has run. `serial` is the serial in the slot's record.
    pub(super) fn has_run(&self, slot: usize, serial: u32) -> bool {
        serial != 0 && serial == self.slots[slot].serial.load(Relaxed)
    }

    /// Returns whether the slot's last recording has run, and has seen the edges as they were measured last.
    pub(super) fn has_run_since(&self, slot: usize, serial: u32) -> bool {
        self.has_run(slot, serial) && !later(self.measured_by.load(Relaxed), serial)
    }

    /// Returns whether the slot waits for the device. `serial` is the serial in the slot's record.
    pub(super) fn is_in_flight(&self, slot: usize, serial: u32) -> bool {
        let last = self.slots[slot].serial.load(Relaxed);
        last != 0 && last != serial
    }

    /// Notes that the slot's last recording will never run.
    pub(super) fn discard(&self, slot: usize) {
        self.slots[slot].serial.store(0, Relaxed);
    }

    /// Notes that the last recordings of all slots that went into this command buffer will never run.
    pub(super) fn discard_commands(&self, commands: vk::CommandBuffer) {
        for slot in &self.slots {
            if slot.commands.load(Relaxed) == half(commands) {
                slot.serial.store(0, Relaxed);
            }
        }
    }

    /// Returns an error if another map would go to a slot that waits for the device. An earlier recording
    /// into the same command buffer no longer exists, whether it has run or not. With a single slot there is
    /// no error, since the commands wait on the device.
    pub(super) fn check_slot(
        &self,
        slot: usize,
        serial: u32,
        commands: vk::CommandBuffer,
        starts_map: bool,
    ) -> Result<(), VulkanError> {
        let of = &self.slots[slot];
        let is_other = starts_map || of.map.load(Relaxed) != self.maps.load(Relaxed);
        let elsewhere = of.commands.load(Relaxed) != half(commands);
        if self.slots.len() > 1 && is_other && elsewhere && self.is_in_flight(slot, serial) {
            return Err(VulkanError::InFlight { slot });
        }
        Ok(())
    }
}

/// State of the measurements: edge lengths alone, or edge lengths and curvature. Solvers without curved
/// fronts do not compute the curvature.
const EDGES: u32 = 1;
const CURVATURE: u32 = 2;

const WAVEFRONTS: u32 = Wavefront::ALL.len() as u32;

/// Returns a number for the plan's schedule and wavefront. It is never 0.
fn number_of(plan: &Plan) -> u32 {
    (plan.schedule as u32 + 1) * WAVEFRONTS + plan.wavefront as u32
}

/// Returns the number of the next preparation of a surface. It is unique in this process, and uninitialized
/// memory hardly ever holds it.
pub(super) fn number_of_preparation() -> u32 {
    static PREPARATIONS: AtomicU32 = AtomicU32::new(0);
    static FIRST: OnceLock<u32> = OnceLock::new();
    let first = FIRST.get_or_init(|| RandomState::new().hash_one(()) as u32);
    let count = PREPARATIONS.fetch_add(1, Relaxed);
    // Multiples of an odd factor are all different. 0 means no preparation.
    first.wrapping_add(count.wrapping_mul(0x9E37_79B9)).max(1)
}

#[cfg(test)]
mod tests {
    use ash::vk::Handle;

    use super::*;

    #[test]
    fn a_slot_waits_until_its_own_serial_is_there() {
        let state = State::new(2);
        let [one, other] = [1, 2].map(vk::CommandBuffer::from_raw);
        assert!(!state.has_run(0, 0) && !state.is_in_flight(0, 0));
        let (first, second) = (7, 8);
        state.record_outcome(0, first, one);
        assert!(state.is_in_flight(0, 0) && !state.has_run(0, 0) && state.has_run(0, first));
        assert!(state.check_slot(0, 0, other, true).is_err());
        for (serial, commands, starts_map) in
            [(first, other, true), (0, one, true), (0, other, false)]
        {
            state.check_slot(0, serial, commands, starts_map).unwrap();
        }
        assert!(state.check_slot(1, 0, other, true).is_ok(), "nothing was recorded for that slot");
        state.record_outcome(0, second, other);
        assert!(state.is_in_flight(0, first) && !state.has_run(0, first));
    }

    #[test]
    fn with_one_slot_the_device_waits() {
        let state = State::new(1);
        let [one, other] = [1, 2].map(vk::CommandBuffer::from_raw);
        state.record_outcome(0, 1, one);
        state.check_slot(0, 0, other, true).unwrap();
    }

    #[test]
    fn an_outcome_tells_of_the_preparation_before_it() {
        let state = State::new(1);
        let [first, second] = [(); 2].map(|()| number_of_preparation());
        assert!(first != second && first != 0);
        assert!(!state.is_prepared_by(0));
        state.prepare(first);
        state.record_outcome(0, 1, vk::CommandBuffer::null());
        state.prepare(second);
        assert!(state.was_prepared_by(0, first) && !state.was_prepared_by(0, second));
        assert!(state.is_prepared_by(second) && !state.is_prepared_by(first));
    }
}
