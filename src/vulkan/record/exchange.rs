//! Records the exchange of fronts, seeds and curvatures between the copies of each point of a glued surface.

use super::commands::{Commands, Groups};
use super::pass_kind::PassKind;
use super::recorder::Recorder;
use crate::update::Wavefront;
use crate::vulkan::Schedule;
use crate::vulkan::copies::{Copies, NO_ROUND};
use crate::vulkan::device::barrier::{PASS, SHADER, SHADER_WRITE, TRANSFER_WRITE};
use crate::vulkan::device::passes::{EXCHANGE, SHARE_CURVATURE, Variant};

/// Largest number of bytes that one update of a buffer writes.
const MOST_BYTES: usize = 65_536;

impl Commands<'_> {
    /// Writes a list of copies to its buffer. A barrier after transfer writes must follow.
    pub(in crate::vulkan) fn write_copies(&self, copies: &Copies) {
        let (buffer, bytes) = copies.contents();
        self.barrier(SHADER, TRANSFER_WRITE);
        for (part, number) in bytes.chunks(MOST_BYTES).zip(0..) {
            self.update(buffer, number * MOST_BYTES as u64, part);
        }
    }
}

impl Recorder<'_> {
    /// Gives all copies of each point the earliest front among them, if the surface is glued. The fronts lie in
    /// `image`. If a round of tiles follows, `next_round` is its number, and the fronts of each tile lie in the image
    /// that the tile's state names. The pipeline must have been made for `variant`.
    pub(in crate::vulkan) fn exchange(
        &self,
        variant: Variant,
        image: usize,
        next_round: Option<u32>,
    ) {
        let Some(copies) = &self.grid.copies else { return };
        let pipeline = self.pipelines.made(EXCHANGE, variant);
        let pipeline = pipeline.expect("maps are only recorded once their pipelines are made");
        self.bind(pipeline, copies.sets(image));
        let next_round = next_round.map_or(NO_ROUND, |round| round as i32);
        let push = copies.push(self.grid.texels, self.tile() as i32 / 2, next_round);
        self.dispatch(pipeline, &push, Groups::line(1));
    }

    /// Gives all copies of each point the mean of their Gaussian curvatures, if the surface is glued. The surface's
    /// points must be measured on the device.
    pub(in crate::vulkan) fn share_curvature(&self) {
        let Some(copies) = &self.grid.copies else { return };
        let pipeline = self.pipelines.made(SHARE_CURVATURE, Wavefront::Curved);
        let pipeline = pipeline.expect("a glued surface is only made once its pipelines are");
        let _pass = self.pass_moving(PassKind::Curvature, copies.bytes_of_curvature().map(Some));
        self.bind(pipeline, copies.sets(0));
        self.dispatch(pipeline, &copies.push_to_share(), Groups::line(1));
        self.barrier(SHADER_WRITE, SHADER);
    }

    /// Gives the seeds of a point to all its copies, if the surface is glued. `schedule` is the schedule of the map.
    pub(in crate::vulkan) fn exchange_seeds(&self, variant: Variant, schedule: Schedule) {
        let Some(copies) = &self.grid.copies else { return };
        let _pass = self.pass_moving(PassKind::Seed, copies.bytes_moved().map(Some));
        self.exchange(variant, 0, schedule.has_rounds().then_some(0));
        self.barrier(PASS, PASS);
    }
}
