//! What has been recorded for a surface so far: what a recording may follow, and which slots wait for
//! the device.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

use ash::vk::{self, Handle};

use super::plan::Plan;
use crate::update::Wavefront;
use crate::vulkan::VulkanError;

/// Of one surface, whose recordings follow one another.
#[derive(Debug)]
pub(super) struct State {
    prepared: AtomicBool,
    /// [`EDGES`], [`CURVATURE`] or nothing.
    measured: AtomicU32,
    destroyed: AtomicBool,
    /// Schedule and wavefront of the map, see [`number_of`]; 0 without one.
    map: AtomicU32,
    /// Of the last map started, to tell it from others.
    maps: AtomicU32,
    /// Of the last record of an outcome.
    serial: AtomicU32,
    slots: Box<[Slot]>,
}

/// The last recording of a slot's outcome.
#[derive(Debug, Default)]
struct Slot {
    /// 0 if there is none.
    serial: AtomicU32,
    map: AtomicU32,
    /// Half of the command buffer's handle, which tells those of a host apart.
    commands: AtomicU32,
}

impl State {
    pub(super) fn new(slots: usize) -> Self {
        Self {
            prepared: false.into(),
            measured: 0.into(),
            destroyed: false.into(),
            map: 0.into(),
            maps: 0.into(),
            serial: 0.into(),
            slots: (0..slots).map(|_| Slot::default()).collect(),
        }
    }

    pub(super) fn prepare(&self) {
        self.prepared.store(true, Relaxed);
        self.measured.store(0, Relaxed);
        self.map.store(0, Relaxed);
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

    /// Whether the surface is there and prepared.
    pub(super) fn check_prepared(&self) -> Result<(), VulkanError> {
        if self.destroyed.load(Relaxed) {
            return Err(VulkanError::Destroyed);
        }
        if self.prepared.load(Relaxed) { Ok(()) } else { Err(VulkanError::NotPrepared) }
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

    /// The next serial, for a slot whose outcome is recorded into a command buffer.
    pub(super) fn next_serial(&self, slot: usize, commands: vk::CommandBuffer) -> u32 {
        // 0 is no serial, 2^32 - 1 recordings later either.
        let serial = self.serial.fetch_add(1, Relaxed).wrapping_add(1).max(1);
        let of = &self.slots[slot];
        of.serial.store(serial, Relaxed);
        of.map.store(self.maps.load(Relaxed), Relaxed);
        of.commands.store(half(commands), Relaxed);
        serial
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

fn half(commands: vk::CommandBuffer) -> u32 {
    let handle = commands.as_raw();
    // Handles are addresses on many drivers: their low halves differ.
    handle as u32 ^ (handle >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slot_waits_until_its_own_serial_is_there() {
        let state = State::new(2);
        let [one, other] = [1, 2].map(vk::CommandBuffer::from_raw);
        assert!(!state.has_run(0, 0) && !state.is_in_flight(0, 0));
        let first = state.next_serial(0, one);
        assert!(state.is_in_flight(0, 0) && !state.has_run(0, 0) && state.has_run(0, first));
        assert!(state.check_slot(0, 0, other, true).is_err());
        for (serial, commands, starts_map) in
            [(first, other, true), (0, one, true), (0, other, false)]
        {
            state.check_slot(0, serial, commands, starts_map).unwrap();
        }
        assert!(state.check_slot(1, 0, other, true).is_ok(), "nothing was recorded for that slot");
        let second = state.next_serial(0, other);
        assert!(state.is_in_flight(0, first) && !state.has_run(0, first) && second != first);
    }

    #[test]
    fn with_one_slot_the_device_waits() {
        let state = State::new(1);
        let [one, other] = [1, 2].map(vk::CommandBuffer::from_raw);
        state.next_serial(0, one);
        state.check_slot(0, 0, other, true).unwrap();
    }
}
