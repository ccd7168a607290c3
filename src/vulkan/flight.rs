//! Tracks which recordings of a surface the device has not finished. The device writes a serial number after
//! each recording.

use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};

use ash::vk::{self, Handle};

use crate::vulkan::schedules::progress::Record;

/// Recordings of a surface. They run in the order in which they were recorded.
///
/// A surface shares this value with its contours, paths and regions, which may be destroyed after it, and with profiles
/// of its recordings.
#[derive(Debug)]
pub(in crate::vulkan) struct Flight {
    /// Serial of the last recording.
    serial: AtomicU32,
    kept: Mutex<InFlight>,
}

#[derive(Debug)]
struct InFlight {
    recordings: [Recorded; MOST],
    records: Option<Records>,
}

/// Last recording into a command buffer. With a `serial` of 0 there is none.
#[derive(Clone, Copy, Debug, Default)]
struct Recorded {
    serial: u32,
    /// Hash of the command buffer's handle, half as long as the handle, by which the host's command buffers differ.
    commands: u32,
    slot: Option<usize>,
}

/// Records in mapped memory. The device writes their serials.
#[derive(Debug)]
struct Records {
    first: NonNull<Record>,
    count: usize,
}

// SAFETY: the memory is mapped for the process, not for a thread. It is only read, with volatile reads.
unsafe impl Send for Records {}

/// Largest number of command buffers that are tracked at once. If more of them wait, the oldest is forgotten.
const MOST: usize = 64;

impl Flight {
    /// Creates the tracker. `records` lies in mapped memory that stays mapped until [`Flight::land`].
    pub(in crate::vulkan) fn new(records: &[Record]) -> Self {
        let records = Records { first: NonNull::from(records).cast(), count: records.len() };
        let recordings = [Recorded::default(); MOST];
        Self { serial: 0.into(), kept: Mutex::new(InFlight { recordings, records: Some(records) }) }
    }

    fn kept(&self) -> MutexGuard<'_, InFlight> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the serial of the next recording. The device must write the serial after that recording. Any
    /// earlier recording into the same command buffer has run, is part of this recording, or will never run.
    pub(in crate::vulkan) fn next(&self, commands: vk::CommandBuffer, slot: Option<usize>) -> u32 {
        // 0 is not a serial, even after 2^32 - 1 recordings.
        let serial = self.serial.fetch_add(1, Relaxed).wrapping_add(1).max(1);
        let commands = half(commands);
        let mut kept = self.kept();
        let place = kept.place_for(commands);
        let before = kept.recordings[place];
        let same = before.serial != 0 && before.commands == commands;
        let slot = slot.or(before.slot.filter(|_| same));
        kept.recordings[place] = Recorded { serial, commands, slot };
        serial
    }

    /// Returns the serial that the next recording will get.
    pub(in crate::vulkan) fn coming(&self) -> u32 {
        self.serial.load(Relaxed).wrapping_add(1).max(1)
    }

    /// Returns the serial of the last recording.
    pub(in crate::vulkan) fn last(&self) -> u32 {
        self.serial.load(Relaxed)
    }

    /// Returns whether the recording with this serial or an earlier one may still be pending. The result is false for
    /// serial 0, which belongs to no recording, and for serials that were never assigned.
    pub(in crate::vulkan) fn waits_for(&self, serial: u32) -> bool {
        if serial == 0 || later(serial, self.serial.load(Relaxed)) {
            return false;
        }
        let kept = self.kept();
        let run = kept.last_run();
        later(serial, run) && kept.waiting(run).next().is_some()
    }

    /// Returns a recording that may still be pending, if there is one. The inner value is its slot, if it has one.
    pub(in crate::vulkan) fn waiting(&self) -> Option<Option<usize>> {
        let kept = self.kept();
        kept.waiting(kept.last_run()).map(|recorded| recorded.slot).next()
    }

    /// Notes that the last recording for a slot will never run.
    pub(in crate::vulkan) fn discard_slot(&self, slot: usize) {
        let mut kept = self.kept();
        let of_slot = kept.recordings.iter_mut().filter(|recorded| recorded.slot == Some(slot));
        let last = of_slot.reduce(|a, b| if later(a.serial, b.serial) { a } else { b });
        if let Some(last) = last {
            *last = Recorded::default();
        }
    }

    /// Notes that the commands in a command buffer will never run.
    pub(in crate::vulkan) fn discard_commands(&self, commands: vk::CommandBuffer) {
        let commands = half(commands);
        for recorded in &mut self.kept().recordings {
            if recorded.commands == commands {
                *recorded = Recorded::default();
            }
        }
    }

    /// Notes that each recording has run or will never run. The records may be unmapped afterwards.
    pub(in crate::vulkan) fn land(&self) {
        let mut kept = self.kept();
        kept.records = None;
        kept.recordings = [Recorded::default(); MOST];
    }
}

impl InFlight {
    /// Returns the serial of the last recording that has run; 0 if there is none.
    fn last_run(&self) -> u32 {
        let Some(Records { first, count }) = self.records else { return 0 };
        // SAFETY: the records stay mapped until `records` is taken. The device may write them at the same
        // time, but a serial is a single word.
        let serial = |at| unsafe { (&raw const (*first.as_ptr().add(at)).serial).read_volatile() };
        (0..count).map(serial).fold(0, |last, serial| match serial != 0 && later(serial, last) {
            true => serial,
            false => last,
        })
    }

    fn waiting(&self, run: u32) -> impl Iterator<Item = &Recorded> {
        self.recordings.iter().filter(move |of| of.serial != 0 && later(of.serial, run))
    }

    /// Returns the entry for a recording into a command buffer. In order of preference it is the entry of the previous
    /// recording into the same buffer, an empty entry, the entry of a recording that has run, or the oldest entry.
    fn place_for(&self, commands: u32) -> usize {
        let all = &self.recordings;
        let find = |is: &dyn Fn(&Recorded) -> bool| all.iter().position(is);
        find(&|of| of.serial != 0 && of.commands == commands)
            .or_else(|| find(&|of| of.serial == 0))
            .or_else(|| {
                let run = self.last_run();
                find(&|of| !later(of.serial, run))
            })
            .unwrap_or_else(|| {
                let older =
                    |a: usize, b: usize| if later(all[a].serial, all[b].serial) { b } else { a };
                (0..MOST).reduce(older).expect("there are places")
            })
    }
}

/// Returns whether a serial was assigned after another. 0 precedes all serials.
pub(in crate::vulkan) fn later(serial: u32, other: u32) -> bool {
    other == 0 && serial != 0 || serial.wrapping_sub(other) as i32 > 0
}

pub(in crate::vulkan) fn half(commands: vk::CommandBuffer) -> u32 {
    let handle = commands.as_raw();
    // On many drivers handles are addresses, whose low halves differ.
    handle as u32 ^ (handle >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn commands(number: u64) -> vk::CommandBuffer {
        vk::CommandBuffer::from_raw(number)
    }

    /// Writes the serial, as the device does after a recording.
    fn run(records: &mut [Record], at: usize, serial: u32) {
        records[at].serial = serial;
    }

    #[test]
    fn recordings_wait_until_they_or_later_ones_have_run() {
        let mut records = vec![Record::zeroed(); 3];
        let flight = Flight::new(&records);
        assert_eq!(flight.waiting(), None);
        assert!(!flight.waits_for(0) && !flight.waits_for(flight.coming()));
        let first = flight.next(commands(1), Some(0));
        let second = flight.next(commands(2), None);
        assert!(flight.waits_for(first) && flight.waits_for(second));
        run(&mut records, 0, first);
        assert!(!flight.waits_for(first) && flight.waits_for(second));
        assert_eq!(flight.waiting(), Some(None));
        run(&mut records, 2, second);
        assert_eq!((flight.waiting(), flight.waits_for(second)), (None, false));
    }

    #[test]
    fn discarded_recordings_are_not_waited_for() {
        let records = vec![Record::zeroed(); 2];
        let flight = Flight::new(&records);
        let first = flight.next(commands(1), Some(0));
        flight.next(commands(1), None);
        assert_eq!(flight.waiting(), Some(Some(0)), "one command buffer");
        flight.discard_slot(1);
        assert!(flight.waits_for(first));
        flight.discard_slot(0);
        assert!(!flight.waits_for(first));
        let second = flight.next(commands(2), None);
        flight.discard_commands(commands(1));
        assert!(flight.waits_for(second));
        flight.discard_commands(commands(2));
        assert_eq!((flight.waiting(), flight.waits_for(second)), (None, false));
    }

    #[test]
    fn more_command_buffers_than_there_are_places_forget_the_oldest() {
        let mut records = vec![Record::zeroed(); 2];
        let flight = Flight::new(&records);
        let serials: Vec<_> =
            (1..=MOST as u64 + 1).map(|number| flight.next(commands(number), None)).collect();
        run(&mut records, 1, serials[MOST - 1]);
        assert_eq!(flight.waiting(), Some(None));
        run(&mut records, 1, serials[MOST]);
        assert_eq!(flight.waiting(), None);
        flight.land();
        drop(records);
        assert!(!flight.waits_for(serials[0]));
    }
}
