//! Which recordings of a surface wait for the device, as serial numbers tell that the device writes behind them.

use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};

use ash::vk::{self, Handle};

use crate::vulkan::progress::Record;

/// The recordings of a surface, which run in the order in which they were recorded.
///
/// Surfaces share it with their contours, paths and regions, which may be destroyed after them.
#[derive(Debug)]
pub(super) struct Flight {
    /// Serial of the last recording.
    serial: AtomicU32,
    kept: Mutex<Kept>,
}

#[derive(Debug)]
struct Kept {
    recordings: [Recorded; MOST],
    records: Option<Records>,
}

/// The last recording into a command buffer; of serial 0 none.
#[derive(Clone, Copy, Debug, Default)]
struct Recorded {
    serial: u32,
    /// Half of the command buffer's handle, which tells those of a host apart.
    commands: u32,
    slot: Option<usize>,
}

/// Records in mapped memory whose serials the device writes.
#[derive(Debug)]
struct Records {
    first: NonNull<Record>,
    count: usize,
}

// SAFETY: the memory is mapped for the process, not for a thread, and is only read, as volatile.
unsafe impl Send for Records {}

/// Command buffers that are remembered at once. Of more that wait, the oldest is forgotten.
const MOST: usize = 64;

impl Flight {
    /// `records` are mapped, and stay so until [`Flight::land`].
    pub(super) fn new(records: &[Record]) -> Self {
        let records = Records { first: NonNull::from(records).cast(), count: records.len() };
        let recordings = [Recorded::default(); MOST];
        Self { serial: 0.into(), kept: Mutex::new(Kept { recordings, records: Some(records) }) }
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The serial of the next recording, which the device is to write behind it. What was recorded into the same
    /// command buffer before has run, or is a part of the recording, or never will run.
    pub(super) fn next(&self, commands: vk::CommandBuffer, slot: Option<usize>) -> u32 {
        // 0 is no serial, 2^32 - 1 recordings later either.
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

    /// The serial that the next recording will have.
    pub(super) fn coming(&self) -> u32 {
        self.serial.load(Relaxed).wrapping_add(1).max(1)
    }

    /// The serial of the last recording.
    pub(super) fn last(&self) -> u32 {
        self.serial.load(Relaxed)
    }

    /// Whether the device may still be at a recording of this serial or one before; 0 is none. Of one whose serial
    /// was never given out nothing is known.
    pub(super) fn waits_for(&self, serial: u32) -> bool {
        if serial == 0 || later(serial, self.serial.load(Relaxed)) {
            return false;
        }
        let kept = self.kept();
        let run = kept.last_run();
        later(serial, run) && kept.waiting(run).next().is_some()
    }

    /// A recording that has not run, and its slot if it has one.
    pub(super) fn waiting(&self) -> Option<Option<usize>> {
        let kept = self.kept();
        kept.waiting(kept.last_run()).map(|recorded| recorded.slot).next()
    }

    /// The last recording for a slot will never run.
    pub(super) fn discard_slot(&self, slot: usize) {
        let mut kept = self.kept();
        let of_slot = kept.recordings.iter_mut().filter(|recorded| recorded.slot == Some(slot));
        let last = of_slot.reduce(|a, b| if later(a.serial, b.serial) { a } else { b });
        if let Some(last) = last {
            *last = Recorded::default();
        }
    }

    /// What was recorded into a command buffer will never run.
    pub(super) fn discard_commands(&self, commands: vk::CommandBuffer) {
        let commands = half(commands);
        for recorded in &mut self.kept().recordings {
            if recorded.commands == commands {
                *recorded = Recorded::default();
            }
        }
    }

    /// All have run, or never will: the records may go.
    pub(super) fn land(&self) {
        let mut kept = self.kept();
        kept.records = None;
        kept.recordings = [Recorded::default(); MOST];
    }
}

impl Kept {
    /// The serial of the last recording that has run, as far as it has one.
    fn last_run(&self) -> u32 {
        let Some(Records { first, count }) = self.records else { return 0 };
        // SAFETY: the records are mapped until `records` is taken. The device may be writing them: a serial is a
        // single word.
        let serial = |at| unsafe { (&raw const (*first.as_ptr().add(at)).serial).read_volatile() };
        (0..count).map(serial).fold(0, |last, serial| match serial != 0 && later(serial, last) {
            true => serial,
            false => last,
        })
    }

    fn waiting(&self, run: u32) -> impl Iterator<Item = &Recorded> {
        self.recordings.iter().filter(move |of| of.serial != 0 && later(of.serial, run))
    }

    /// Where a recording into a command buffer is kept: in place of the one before, of one that has run, or of
    /// the oldest.
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

/// Whether a serial was given out after another, 0 before all.
fn later(serial: u32, other: u32) -> bool {
    other == 0 && serial != 0 || serial.wrapping_sub(other) as i32 > 0
}

pub(super) fn half(commands: vk::CommandBuffer) -> u32 {
    let handle = commands.as_raw();
    // Handles are addresses on many drivers: their low halves differ.
    handle as u32 ^ (handle >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn commands(number: u64) -> vk::CommandBuffer {
        vk::CommandBuffer::from_raw(number)
    }

    /// What the device would do.
    fn run(records: &mut [Record], at: usize, serial: u32) {
        records[at].serial = serial;
    }

    #[test]
    fn what_was_recorded_waits_until_it_or_a_later_one_has_run() {
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
    fn what_is_thrown_away_is_not_waited_for() {
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
