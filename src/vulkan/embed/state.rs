//! What has been recorded for a surface so far: what a recording may follow, and which slots wait for
//! the device.

use std::hash::{BuildHasher, RandomState};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

use ash::vk;

use super::flight::half;
use super::plan::Plan;
use crate::update::Wavefront;
use crate::vulkan::VulkanError;

/// Of one surface, whose recordings follow one another.
#[derive(Debug)]
pub(super) struct State {
    /// The number that the last preparation writes, see [`number_of_preparation`]; 0 without one.
    prepared: AtomicU32,
    /// [`EDGES`], [`CURVATURE`] or nothing.
    measured: AtomicU32,
    destroyed: AtomicBool,
    /// Schedule and wavefront of the map, see [`number_of`]; 0 without one.
    map: AtomicU32,
    /// Of the last map started, to tell it from others.
    maps: AtomicU32,
    slots: Box<[Slot]>,
}

/// The last recording of a slot's outcome.
#[derive(Debug, Default)]
struct Slot {
    /// 0 if there is none.
    serial: AtomicU32,
    map: AtomicU32,
    /// Half of the command buffer's handle.
    commands: AtomicU32,
    /// The preparation that it follows.
    prepared: AtomicU32,
}

impl State {
    pub(super) fn new(slots: usize) -> Self {
        Self {
            prepared: 0.into(),
            measured: 0.into(),
            destroyed: false.into(),
            map: 0.into(),
            maps: 0.into(),
            slots: (0..slots).map(|_| Slot::default()).collect(),
        }
    }

    /// The surface is prepared, by a recording that writes this number.
    pub(super) fn prepare(&self, number: u32) {
        self.prepared.store(number, Relaxed);
        self.measured.store(0, Relaxed);
        self.map.store(0, Relaxed);
    }

    /// Whether the preparation of this number is the one that was recorded last.
    pub(super) fn is_prepared_by(&self, number: u32) -> bool {
        number != 0 && number == self.prepared.load(Relaxed)
    }

    pub(super) fn measure(&self, with_curvature: bool) {
        self.measured.store(if with_curvature { CURVATURE } else { EDGES }, Relaxed);
        self.map.store(0, Relaxed);
    }

    pub(super) fn solve(&self, plan: &Plan) {
        self.map.store(number_of(plan), Relaxed);
        self.maps.fetch_add(1, Relaxed);
    }

    pub(super) fn destroy(&self) {
        self.destroyed.store(true, Relaxed);
    }

    /// Whether the surface is there.
    pub(super) fn check_there(&self) -> Result<(), VulkanError> {
        if self.destroyed.load(Relaxed) { Err(VulkanError::Destroyed) } else { Ok(()) }
    }

    /// Whether the surface is there and prepared.
    pub(super) fn check_prepared(&self) -> Result<(), VulkanError> {
        self.check_there()?;
        match self.prepared.load(Relaxed) {
            0 => Err(VulkanError::NotPrepared),
            _ => Ok(()),
        }
    }

    /// Whether there is what maps of a plan need of the surface.
    pub(super) fn check_measured(&self, plan: &Plan) -> Result<(), VulkanError> {
        self.check_prepared()?;
        let needed = if plan.wavefront.is_curved() { CURVATURE } else { EDGES };
        let is_there = self.measured.load(Relaxed) >= needed;
        if is_there { Ok(()) } else { Err(VulkanError::NotMeasured) }
    }

    /// Whether there is a map.
    pub(super) fn check_map(&self) -> Result<(), VulkanError> {
        self.check_prepared()?;
        if self.map.load(Relaxed) == 0 { Err(VulkanError::NoMap) } else { Ok(()) }
    }

    /// Whether the map is one of this wavefront.
    pub(super) fn check_wavefront(&self, wavefront: Wavefront) -> Result<(), VulkanError> {
        self.check_map()?;
        match self.map.load(Relaxed) % WAVEFRONTS == wavefront as u32 {
            true => Ok(()),
            false => Err(VulkanError::OtherMap),
        }
    }

    /// Whether the map is one of this plan.
    pub(super) fn check_plan(&self, plan: &Plan) -> Result<(), VulkanError> {
        self.check_map()?;
        if self.map.load(Relaxed) == number_of(plan) { Ok(()) } else { Err(VulkanError::OtherMap) }
    }

    /// A slot's outcome is recorded into a command buffer, with this serial.
    pub(super) fn record_outcome(&self, slot: usize, serial: u32, commands: vk::CommandBuffer) {
        let of = &self.slots[slot];
        of.serial.store(serial, Relaxed);
        of.map.store(self.maps.load(Relaxed), Relaxed);
        of.commands.store(half(commands), Relaxed);
        of.prepared.store(self.prepared.load(Relaxed), Relaxed);
    }

    /// Whether the preparation that the slot's last recording follows is the one that the device has seen.
    pub(super) fn was_prepared_by(&self, slot: usize, number: u32) -> bool {
        self.slots[slot].prepared.load(Relaxed) == number
    }

    /// Whether the slot's last recording has run, as the serial in its record says.
    pub(super) fn has_run(&self, slot: usize, serial: u32) -> bool {
        serial != 0 && serial == self.slots[slot].serial.load(Relaxed)
    }

    /// Whether a slot waits for the device, as the serial in its record says.
    pub(super) fn is_in_flight(&self, slot: usize, serial: u32) -> bool {
        let last = self.slots[slot].serial.load(Relaxed);
        last != 0 && last != serial
    }

    /// The slot's last recording will never run.
    pub(super) fn discard(&self, slot: usize) {
        self.slots[slot].serial.store(0, Relaxed);
    }

    /// The same of all slots whose last recording went into a command buffer.
    pub(super) fn discard_commands(&self, commands: vk::CommandBuffer) {
        for slot in &self.slots {
            if slot.commands.load(Relaxed) == half(commands) {
                slot.serial.store(0, Relaxed);
            }
        }
    }

    /// Whether another map goes to a slot that waits for the device. What was recorded into the same command
    /// buffer before is gone, if it ever ran; and a host with one slot has the device wait.
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

/// The surface's edges are there; with its curvature, which is not measured for solvers without curved fronts.
const EDGES: u32 = 1;
const CURVATURE: u32 = 2;

const WAVEFRONTS: u32 = Wavefront::EVERY.len() as u32;

/// A number for a plan's schedule and wavefront, none of them 0.
fn number_of(plan: &Plan) -> u32 {
    (plan.schedule as u32 + 1) * WAVEFRONTS + plan.wavefront as u32
}

/// A number for the next preparation of a surface, which no other in this process has, and memory hardly ever.
pub(super) fn number_of_preparation() -> u32 {
    static PREPARATIONS: AtomicU32 = AtomicU32::new(0);
    static FIRST: OnceLock<u32> = OnceLock::new();
    let first = FIRST.get_or_init(|| RandomState::new().hash_one(()) as u32);
    let count = PREPARATIONS.fetch_add(1, Relaxed);
    // Odd factors keep all numbers apart; 0 is none.
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
