//! Records the passes that find the sources beside each grid point, with which regions, directions and log maps begin.

use bytemuck::Pod;

use super::host_sets::HostSet;
use super::inputs::{PointSource, SourceInput};
use super::outputs::Output;
use super::recording::{Recording, grid_size};
use super::solver::Solver;
use super::surface::FrameSurface;
use crate::surface::Chart;
use crate::vulkan::VulkanError;
use crate::vulkan::copies::Copies;
use crate::vulkan::device::barrier::{Access, SHADER, SHADER_WRITE, TRANSFER_WRITE};
use crate::vulkan::device::passes::{Pass, SHARE_STARTS, Variant};
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::shaders::share_starts::Push as Share;
use crate::vulkan::profile::PassKind;
use crate::vulkan::record::Moved;

pub(super) const WORD: u64 = size_of::<u32>() as u64;

/// Pass that examines the sources, and pass over the copies of points of a glued surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Starts<P> {
    examine: Pipeline<P>,
    share: Option<Pipeline<Share>>,
}

impl<P: Pod> Starts<P> {
    pub(super) fn new(
        device: &ash::Device,
        (solver, surface): (&Solver, &FrameSurface),
        pass: Pass<P>,
        variant: Variant,
    ) -> Result<Self, VulkanError> {
        let examine = solver.pipelines.make(device, pass, variant)?;
        let share = match surface.is_glued() {
            true => Some(solver.pipelines.make(device, SHARE_STARTS, variant)?),
            false => None,
        };
        Ok(Self { examine, share })
    }
}

/// Returns the largest number of records of the passes that find the sources beside points. These clear words, write
/// the sources, examine them twice, and on a glued surface visit the copies of points twice.
pub(super) fn records_of_starts(surface: &FrameSurface) -> u32 {
    1 + 1 + 2 + if surface.is_glued() { 2 } else { 0 }
}

/// Recorder of the passes over a finished map that fill an output.
pub(super) struct MapPasses<'a> {
    pub(super) recording: &'a Recording<'a>,
    kind: PassKind,
    /// Number of words before those of the points.
    header: u32,
    set: HostSet,
    count: u32,
}

impl<K> Output<K> {
    /// Clears two words of each point, which follow a header: the arrival time of its earliest source, and that
    /// source. Then writes the sources, which were checked before. Commands before these must be finished.
    pub(super) fn begin<'a>(
        &self,
        recording: &'a Recording<'a>,
        (kind, header): (PassKind, u32),
        sources: SourceInput,
    ) -> Result<MapPasses<'a>, VulkanError> {
        let recorder = &recording.recorder;
        let cleared = WORD * (u64::from(header) + 2 * self.chart.points() as u64);
        let pass = recorder.pass(kind);
        recorder.fill(self.buffer(), 0, cleared);
        drop(pass);
        recorder.barrier(TRANSFER_WRITE, SHADER);
        let (set, count) = self.read_sources(recording, sources)?;
        Ok(MapPasses { recording, kind, header, set, count })
    }
}

impl MapPasses<'_> {
    /// Returns the size of the grid, the position of the first source in its buffer, and the number of sources.
    pub(super) fn sources(&self) -> ([i32; 2], i32, i32) {
        (grid_size(self.chart()), self.set.first_word, self.count as i32)
    }

    fn chart(&self) -> Chart {
        self.recording.surface.grid.chart
    }

    /// Records the passes that find the earliest source beside each point: its time in turn 0, and its number in turn
    /// 1. All copies of a point then take the largest of their words. `push` returns the constants of a turn.
    pub(super) fn find_sources<P: Pod>(&self, starts: Starts<P>, push: impl Fn(i32) -> P) {
        let bytes = size_of::<PointSource>() as u64 * u64::from(self.count);
        for turn in [0, 1] {
            // The number of points accessed around the sources depends on the sources' places, and is not
            // counted.
            let moved = [Some(bytes), None];
            self.run(starts.examine, [self.count, 1], &push(turn), moved, SHADER);
            if let Some(share) = starts.share {
                let first_word = self.header as i32 + (1 - turn) * self.chart().points() as i32;
                self.over_copies(share, &Share { grid: grid_size(self.chart()), first_word });
            }
        }
    }

    /// Records a pass over all grid points, and a barrier before the access `after`.
    pub(super) fn over_points<P: Pod>(
        &self,
        pipeline: Pipeline<P>,
        push: &P,
        moved: Moved,
        after: Access,
    ) {
        let Chart { rows, cols } = self.chart();
        self.run(pipeline, [cols as u32, rows as u32], push, moved, after);
    }

    /// Records a pass over the groups of copies of points of a glued surface.
    pub(super) fn over_copies<P: Pod>(&self, pipeline: Pipeline<P>, push: &P) {
        let Recording { recorder, surface, .. } = self.recording;
        let groups = surface.grid.copies.as_ref().map_or(0, Copies::groups_by_rows);
        recorder.pass_over_groups(self.kind, pipeline, self.set.set, push, groups);
        recorder.barrier(SHADER_WRITE, SHADER);
    }

    fn run<P: Pod>(
        &self,
        pipeline: Pipeline<P>,
        size: [u32; 2],
        push: &P,
        moved: Moved,
        after: Access,
    ) {
        let recorder = &self.recording.recorder;
        let _pass = recorder.pass_moving(self.kind, moved);
        recorder.map_pass(pipeline, self.set.set, push, size);
        recorder.barrier(SHADER_WRITE, after);
    }
}
