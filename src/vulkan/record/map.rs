//! Records the parts of a map other than its steps: its start, its sources, and the read-back of results.

use std::ops::Range;

use ash::vk;

use super::pass_kind::PassKind;
use super::recorder::Recorder;
use crate::constants::{CARRIED, FAR, LAYERS, TIME};
use crate::vulkan::device::barrier::{
    HOST_READ, PASS, SHADER, SHADER_WRITE, TRANSFER, TRANSFER_READ, TRANSFER_WRITE,
};
use crate::vulkan::device::passes::{SEED, TRIM, UNPACK};
use crate::vulkan::device::shaders::{seed, trim, unpack};
use crate::vulkan::schedules::progress::{Outcome, Record, offset};
use crate::vulkan::upload::{SEED_BYTES, SeedTexel};

fn record_offset(number: usize) -> u64 {
    (number * size_of::<Record>()) as u64
}

impl Recorder<'_> {
    /// Clears the map: all points become unreached in both images.
    pub(crate) fn forget(&self) {
        let _pass = self.pass_over_images(PassKind::Forget, 2 * u64::from(LAYERS) * 16);
        self.barrier(SHADER, TRANSFER_WRITE);
        self.clear_fronts();
        self.barrier(TRANSFER_WRITE, SHADER);
    }

    pub(super) fn clear_fronts(&self) {
        for image in &self.grid.fronts {
            self.clear(image.image, TIME, FAR);
            self.clear(image.image, CARRIED, 0.0);
        }
    }

    /// Writes seeds to their texels in image 0. `count` texels with seeds are in the upload buffer. The pass also makes
    /// the tiles or blocks of lines around them due, for the passes that `follows` names
    /// ([`crate::vulkan::Schedule::follows`]).
    pub(crate) fn seed(&self, count: u32, follows: u32) {
        // The pass reads a texel's seeds and its fronts, and writes its fronts.
        let fronts = 16 * u64::from(LAYERS);
        let each = [SEED_BYTES + fronts, fronts];
        let _pass = self.pass_of_each(PassKind::Seed, [count, 1], each);
        self.bring_inputs(count);
        let texels = self.grid.texels.inner().map(|texels| texels as i32);
        let tile_texels = self.tile() as i32 / 2;
        let push = seed::Push { texels, count: count as i32, follows, tile_texels };
        self.run(self.pipelines.of(SEED), 0, &push, [count, 1]);
        self.barrier(SHADER_WRITE, PASS);
    }

    /// Resets points in image 0 to unreached if their fronts arrive after the end of the map.
    pub(crate) fn trim(&self) {
        let texels = self.grid.texels.inner();
        // Few texels are written: those that have fronts after the end. They are not counted.
        let _pass = self.pass_of_each(PassKind::Trim, texels, [16, 0]);
        let push = trim::Push { texels: texels.map(|texels| texels as i32) };
        self.run(self.pipelines.of(TRIM), 0, &push, texels);
        self.barrier(SHADER_WRITE, PASS);
    }

    /// Copies `count` texels with seeds, and the anchors, to the buffers that shaders read, unless the program has
    /// written them there directly. The device must have finished reading the texels and anchors of the last map.
    fn bring_inputs(&self, count: u32) {
        let bytes = u64::from(count) * size_of::<SeedTexel>() as u64;
        let Some(parts) = self.grid.inputs(bytes) else { return };
        for (from, to, size) in parts.into_iter().filter(|(.., size)| *size > 0) {
            self.copy(from, to, size);
        }
        self.barrier(TRANSFER_WRITE, SHADER);
    }

    /// Writes sources into the buffer from which `sources.comp` reads them.
    pub(crate) fn write_sources(&self, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        let _pass = self.pass(PassKind::Sources);
        self.barrier(SHADER, TRANSFER_WRITE);
        self.update(self.grid.download.buffer, 0, bytes);
        self.barrier(TRANSFER_WRITE, SHADER);
    }

    /// Copies the outcome of the iterations to one of the records that the host reads.
    pub(crate) fn outcome(&self, number: usize) {
        self.outcome_to(self.grid.outcome.buffer, record_offset(number));
        self.barrier(TRANSFER_WRITE, HOST_READ);
    }

    /// Copies the outcome, and then writes a serial to the record. The host knows by the serial that the record is
    /// complete.
    pub(crate) fn outcome_with_serial(&self, number: usize, serial: u32) {
        let (buffer, at) = (self.grid.outcome.buffer, record_offset(number));
        self.outcome_to(buffer, at);
        self.barrier(TRANSFER_WRITE, TRANSFER_WRITE);
        self.fill_with(buffer, at + offset::SERIAL_IN_RECORD, size_of::<u32>() as u64, serial);
        self.barrier(TRANSFER_WRITE, HOST_READ);
    }

    /// Writes a serial to the record with this number once all passes recorded so far have run. The host reads it
    /// there.
    pub(crate) fn mark(&self, number: usize, serial: u32) {
        let at = record_offset(number) + offset::SERIAL_IN_RECORD;
        let passes = (PASS.0 | TRANSFER.0, PASS.1 | TRANSFER.1);
        self.barrier(passes, TRANSFER_WRITE);
        self.fill_with(self.grid.outcome.buffer, at, size_of::<u32>() as u64, serial);
        self.barrier(TRANSFER_WRITE, HOST_READ);
    }

    /// Copies the outcome of the iterations, and the state of the input, to the offset `at` of a buffer, which must
    /// have room for them.
    pub(crate) fn outcome_to(&self, to: vk::Buffer, at: u64) {
        let size = size_of::<Outcome>() as u64;
        let parts = [
            vk::BufferCopy::default().dst_offset(at).size(size),
            vk::BufferCopy::default()
                .src_offset(offset::INPUT)
                .dst_offset(at + offset::INPUT_IN_RECORD)
                .size(offset::INPUT_BYTES),
        ];
        let _pass = self.pass(PassKind::Outcome);
        self.barrier(PASS, TRANSFER_READ);
        self.copy_parts(self.grid.progress.buffer, to, &parts);
    }

    /// Sets a part of the state of a renderer's input between passes: the number of its preparation, or the
    /// properties of its points.
    pub(crate) fn set_known(&self, bytes: Range<u64>, number: u32) {
        self.barrier(PASS, TRANSFER_WRITE);
        let count = bytes.end - bytes.start;
        self.fill_with(self.grid.progress.buffer, bytes.start, count, number);
        self.barrier(TRANSFER_WRITE, SHADER);
    }

    /// Unpacks the arrival times in image 0 for a band of rows into the read-back buffer, which the host reads. With a
    /// staging buffer, they are then copied to one `half` of it, and the host reads them there.
    pub(crate) fn unpack(&self, rows: Range<usize>, half: usize) {
        let chart = self.grid.chart;
        let bytes = 4 * (rows.len() * chart.cols) as u64;
        let size = [chart.cols as u32, rows.len().div_ceil(2) as u32];
        let _pass = self.pass_moving(PassKind::Unpack, [Some(bytes); 2]);
        let band = unpack::Push {
            grid: [chart.cols as i32, chart.rows as i32],
            first_row: rows.start as i32,
            band_rows: rows.len() as i32,
            layers: LAYERS as i32,
        };
        let staging = self.grid.read_back_at(half);
        if staging.is_some() {
            // The copy of the previous band may still be running.
            self.barrier(TRANSFER_READ, SHADER_WRITE);
        }
        self.host_pass(self.pipelines.of(UNPACK), self.grid.sets.read_back, &band, size);
        if let Some(to) = staging {
            self.barrier(SHADER_WRITE, TRANSFER_READ);
            self.copy((self.grid.download.buffer, 0), to, bytes);
            self.barrier(TRANSFER_WRITE, HOST_READ);
        } else {
            self.barrier(SHADER_WRITE, HOST_READ);
        }
    }
}
