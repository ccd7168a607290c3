//! Records what the host reads of a map: the outcome of its iterations, the image of distances, and distances
//! at places.

use ash::vk;

use super::access::{Access, Reader};
use super::host_sets;
use super::numbered::nth;
use super::outcome::Outcome;
use super::recording::{Recording, grid_size};
use super::surface::ResultImage;
use crate::vulkan::VulkanError;
use crate::vulkan::device::barrier::{SHADER, SHADER_WRITE, TRANSFER_WRITE};
use crate::vulkan::device::passes::{LOOKUP, RESULT};
use crate::vulkan::device::shaders::{lookup, result};
use crate::vulkan::profile::PassKind;

const RECORD_BYTES: u64 = Outcome::BYTES as u64;

impl Recording<'_> {
    /// Records a copy of the iterations' outcome to the record of `slot`. [`super::FrameSurface::outcome`]
    /// reads it after the fence of the submission.
    ///
    /// # Errors
    /// If there is no such slot or no map. With [`super::Tools::checks`], also if the last recording for the
    /// slot has not run.
    pub fn outcome(&self, slot: usize) -> Result<(), VulkanError> {
        self.surface.check_slot(slot)?;
        self.surface.state.check_map()?;
        self.check_slot(slot, false)?;
        self.record_outcome(slot, self.next_outcome(slot));
        Ok(())
    }

    /// Returns the serial of the outcome that is recorded next for a slot.
    pub(super) fn next_outcome(&self, slot: usize) -> u32 {
        let Self { recorder, surface, .. } = self;
        let serial = self.next_serial(Some(slot));
        surface.state.record_outcome(slot, serial, recorder.buffer);
        serial
    }

    pub(super) fn record_outcome(&self, slot: usize, serial: u32) {
        self.recorder.outcome_with_serial(slot, serial);
    }

    /// Records a copy of the iterations' outcome into a buffer of the host, for
    /// [`super::FrameSurface::outcome_from`]. It takes [`super::Outcome::BYTES`] bytes at `offset`, which is
    /// a multiple of 4. The buffer has the usage `TRANSFER_DST`, and must stay alive until the commands have
    /// run. Shaders find the number of iterations in the third 32-bit word. The accesses in `after` wait for
    /// the copy.
    ///
    /// # Errors
    /// If there is no map, or the record does not fit into the buffer at this offset.
    pub fn outcome_to(
        &self,
        buffer: vk::Buffer,
        offset: u64,
        after: Access,
    ) -> Result<(), VulkanError> {
        host_sets::check_copied(
            self.recorder.device,
            "the outcome",
            (buffer, offset),
            RECORD_BYTES,
        )?;
        self.surface.state.check_map()?;
        self.recorder.outcome_to(buffer, offset);
        self.recorder.barrier(TRANSFER_WRITE, after.side());
        self.note();
        Ok(())
    }

    /// Records the pass that unpacks the map into the image of distances of `slot`, and returns the image.
    /// Points that are not reached become `unreached`. The commands wait for earlier reads of the image by
    /// `reader`, and later reads by `reader` wait for the commands. The previous contents of the image are
    /// discarded. Afterwards the image has the layout of `reader`.
    ///
    /// # Errors
    /// If there is no such slot or no map.
    pub fn result(
        &self,
        slot: usize,
        reader: Reader,
        unreached: f32,
    ) -> Result<ResultImage, VulkanError> {
        let result = self.surface.result(slot, reader.layout)?;
        self.surface.state.check_map()?;
        self.record_result(result, slot, reader, unreached);
        self.note();
        Ok(result)
    }

    pub(super) fn record_result(
        &self,
        result: ResultImage,
        slot: usize,
        reader: Reader,
        unreached: f32,
    ) {
        let Self { recorder, surface, .. } = self;
        let texels = surface.grid.texels.inner();
        let points = size_of::<f32>() as u64 * surface.grid.chart.points() as u64;
        let _pass = recorder.pass_moving(PassKind::Distances, [Some(points); 2]);
        let chart = surface.grid.chart;
        // The barrier also waits for earlier writes of the same slot.
        let (stages, access) = reader.access.side();
        let before = (stages | SHADER_WRITE.0, access | SHADER_WRITE.1);
        let general = vk::ImageLayout::GENERAL;
        let layouts = (vk::ImageLayout::UNDEFINED, general);
        recorder.image_barrier(result.image, before, SHADER_WRITE, layouts);
        let size = result::Push { grid: grid_size(chart), unreached };
        let results = &surface.sets.results[slot];
        results.is_written(&surface.flight, self.solver.checks);
        let set = results.set().set;
        recorder.host_pass(recorder.pipelines.of(RESULT), set, &size, texels);
        let layouts = (general, reader.layout);
        recorder.image_barrier(result.image, SHADER_WRITE, reader.access.side(), layouts);
    }

    /// Records the pass that looks up distances at the places in a buffer of the host. It interpolates
    /// bilinearly between grid points. The result is `unreached` at places that are not reached or off the
    /// grid. `number` selects one of the lookups in [`super::SurfaceInfo::lookups`], whose buffers must stay
    /// alive until the commands have run. The commands wait for the accesses in `before`, and those in
    /// `after` wait for the commands.
    ///
    /// # Errors
    /// If the surface has no such lookup or no map.
    pub fn lookup(
        &self,
        number: usize,
        unreached: f32,
        before: Access,
        after: Access,
    ) -> Result<(), VulkanError> {
        let Self { recorder, surface, .. } = self;
        let set = *nth(&surface.sets.lookups, "lookups", number)?;
        surface.state.check_map()?;
        let count = surface.lookup_counts[number];
        // Each lookup reads a place, and the times of the four points around it.
        let _pass = recorder.pass_of_each(PassKind::Lookup, [count, 1], [2 * 4 + 4 * 4, 4]);
        recorder.barrier(before.side(), SHADER);
        let places = lookup::Push {
            grid: grid_size(surface.grid.chart),
            count: count as i32,
            first_word: set.first_word,
            first_distance: set.first_output,
            unreached,
        };
        recorder.host_pass(recorder.pipelines.of(LOOKUP), set.set, &places, [count, 1]);
        recorder.barrier(SHADER_WRITE, after.side());
        self.note();
        Ok(())
    }
}
