//! Recording into the host's command buffer.

use ash::vk;

use super::access::{Access, Reader};
use super::host_sets::{self, HostSet};
use super::inputs::{PointMemory, PointSource, SourceInput};
use super::plan::Plan;
use super::solver::Solver;
use super::state::number_of_preparation;
use super::surface::{Outcome, ResultImage, Surface};
use crate::constants::{NEVER_MEASURED, SOURCES_TOGETHER, SURROUNDINGS_TEXELS, WORKGROUP};
use crate::surface::{Chart, EdgeRule};
use crate::vulkan::VulkanError;
use crate::vulkan::barrier::{CLEAR, PASS, SHADER, SHADER_WRITE, TRANSFER};
use crate::vulkan::grid_images::{INLINE_SOURCES, POINT_BYTES, bands, frame_bytes, rows_around};
use crate::vulkan::passes::{
    CommonPass, LOOKUP, MERGE_SURROUNDINGS, POINTS_FROM_BUFFER, POINTS_FROM_IMAGE, RESULT, SOURCES,
    Variant,
};
use crate::vulkan::profile::{Grain, PassKind, PassRecord, Profile, Work};
use crate::vulkan::progress::offset;
use crate::vulkan::record::{Commands, Recorder, dispatched};
use crate::vulkan::shaders::{
    lookup, merge_surroundings, points_from_buffer, result, sources, surroundings,
};
use crate::vulkan::upload::SEED_BYTES;

/// Appends commands for a surface to a command buffer of the host's.
///
/// No call submits, waits, maps, or allocates, on the device or the heap. Where a call returns an
/// error, it has recorded nothing. Recordings of one surface are to run one after another, in the
/// order in which they are recorded: on one queue, or with semaphores between queues.
#[derive(Clone, Copy)]
pub struct Recording<'a> {
    pub(super) recorder: Recorder<'a>,
    pub(super) solver: &'a Solver,
    pub(super) surface: &'a Surface,
    /// Bytes beyond where the surface has its points.
    points_at: u64,
}

/// What one frame takes: [`Recording::frame`].
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// How the host has written points and sources since the frame before.
    pub before: Access,
    /// The surface's points to measure; `None` if they have not changed since the last frame.
    pub points: Option<usize>,
    /// Where the fronts start.
    pub sources: SourceInput<'a>,
    /// The passes.
    pub plan: &'a Plan,
    /// Which image of distances is written.
    pub slot: usize,
    /// Who reads it.
    pub reader: Reader,
    /// What stands in it for points that are not reached; +infinity, which filters would turn to
    /// NaN beside such points, or what suits the reader.
    pub unreached: f32,
}

/// So many points has a grid for each source of a crowd that has surroundings. Updating these, 400 points
/// from all sides some sixteen times, takes as long as two to four iterations of 1,500 to 3,000 points, which
/// is what it saves.
const POINTS_FOR_SURROUNDINGS: usize = 4000;
/// So many sources have surroundings on any grid.
const FEW_SOURCES: usize = 8;

const RECORD_BYTES: u64 = Outcome::BYTES as u64;

impl<'a> Recording<'a> {
    pub(super) fn new(
        device: &'a ash::Device,
        commands: vk::CommandBuffer,
        solver: &'a Solver,
        surface: &'a Surface,
    ) -> Self {
        let commands = Commands::new(device, commands, &solver.pipelines);
        let recorder = Recorder { commands, grid: &surface.grid };
        Self { recorder, solver, surface, points_at: 0 }
    }

    /// The same, with the passes taken down in a profile, which starts anew here: resets its
    /// queries and takes the time. All other calls go to what this returns, and are to run in one
    /// submission.
    pub fn profiled(mut self, profile: &'a Profile) -> Self {
        profile.begin(self.recorder.device, self.recorder.buffer);
        self.recorder.commands.profile = Some(profile);
        self
    }

    /// The same, with points read so many bytes beyond where the surface has them, as in a ring of which each
    /// frame has another part: by [`Recording::measure`], and where contours and paths are lifted. A multiple of 4,
    /// and 0 for points in an image; looked at where points are read.
    pub fn points_at(self, offset: u64) -> Self {
        Self { points_at: offset, ..self }
    }

    /// Brings the new surface's images into their layouts. To be recorded once, before anything
    /// else. Recorded again, it forgets the edge lengths: [`Recording::measure`] has to follow.
    /// If it never runs, outcomes tell ([`VulkanError::PreparationLost`]).
    pub fn prepare(&self) {
        let number = number_of_preparation();
        self.recorder.prepare();
        self.recorder.set_known(offset::PREPARED, number);
        self.recorder.set_known(offset::POINTS, NEVER_MEASURED);
        self.surface.state.prepare(number);
        self.note();
    }

    /// All of a usual frame: [`Recording::begin`], [`Recording::measure`] if there are new points,
    /// [`Recording::solve`], [`Recording::outcome`] and [`Recording::result`].
    ///
    /// # Errors
    /// As these, and then nothing is recorded.
    pub fn frame(&self, frame: &Frame) -> Result<ResultImage, VulkanError> {
        let result = self.check_frame(frame)?;
        let _group = self.recorder.group(c"geosweep: frame");
        self.begin(frame.before);
        if let Some(points) = frame.points {
            self.record_measure(points, self.points(points)?);
            self.surface.state.measure(self.solver.is_curved());
        }
        self.record_solve(frame.sources, frame.plan);
        self.record_outcome(frame.slot, self.next_outcome(frame.slot));
        self.record_result(result, frame.slot, frame.reader, frame.unreached);
        self.note();
        Ok(result)
    }

    /// With checks, has the device write a number behind what was recorded, so that it is known whether it has
    /// run. The number, if so.
    pub(super) fn note(&self) -> Option<u32> {
        let serial = self.next_note();
        if let Some(serial) = serial {
            self.record_note(serial);
        }
        serial
    }

    pub(super) fn next_note(&self) -> Option<u32> {
        let Self { recorder, surface, solver, .. } = self;
        solver.checks.then(|| surface.flight.next(recorder.buffer, None))
    }

    pub(super) fn record_note(&self, serial: u32) {
        self.recorder.mark(self.surface.grid.slots, serial);
    }

    /// Whether a frame can be recorded; records nothing. The image that it will write.
    pub(crate) fn check_frame(&self, frame: &Frame) -> Result<ResultImage, VulkanError> {
        if let Some(points) = frame.points {
            self.points(points)?;
        }
        self.check(frame.plan)?;
        self.check_sources(frame.sources)?;
        let result = self.surface.result(frame.slot, frame.reader.layout)?;
        match frame.points {
            Some(_) => self.surface.state.check_prepared()?,
            None => self.surface.state.check_measured(frame.plan)?,
        }
        self.check_slot(frame.slot, true)?;
        Ok(result)
    }

    /// Waits for what the host has written, and for recordings of this surface before.
    pub fn begin(&self, before: Access) {
        let (stages, access) = (PASS.0 | TRANSFER.0, PASS.1 | TRANSFER.1);
        let (host_stages, host_access) = before.side();
        self.recorder.barrier((stages | host_stages, access | host_access), (stages, access));
    }

    /// Lets the host read the packed times, or overwrite what was read, after everything so far.
    pub fn end(&self, after: Access) {
        self.recorder.barrier((PASS.0 | TRANSFER.0, PASS.1 | TRANSFER.1), after.side());
    }

    /// Measures the surface's edges, and its curvature if a wavefront of the solver needs it, from
    /// points in the host's memory. The map is lost: [`Recording::solve`] comes next.
    ///
    /// Edges must be shorter than 1e12 units, and those between distinct points longer than 1e-12.
    ///
    /// # Errors
    /// If the surface has no such points, or is not prepared.
    pub fn measure(&self, points: usize) -> Result<(), VulkanError> {
        let read = self.points(points)?;
        self.surface.state.check_prepared()?;
        self.record_measure(points, read);
        self.surface.state.measure(self.solver.is_curved());
        self.note();
        Ok(())
    }

    pub(super) fn record_measure(&self, points: usize, (set, info): (HostSet, super::Points)) {
        let Self { recorder, surface, solver, .. } = self;
        surface.sets.points[points].is_read(&surface.flight);
        let chart = surface.grid.chart;
        let kind = info.kind;
        // Without positions there are no other edges than straight ones.
        let rule = if kind.has_positions() { surface.edge_rule } else { EdgeRule::Chord };
        recorder.set_known(offset::POINTS, 0);
        for rows in bands(chart, POINT_BYTES, frame_bytes(chart)) {
            let around = rows_around(&rows, chart);
            let band = points_from_buffer::Push {
                grid: grid_size(chart),
                first_row: around.start as i32,
                band_rows: around.len() as i32,
                first_own: (rows.start - around.start) as i32,
                own_rows: rows.len() as i32,
                heights: kind.spacing().is_some().into(),
                slowness: info.slowness.map_or(-1, |index| index as i32),
                first_word: set.first_word,
                stride: info.memory.stride_words(),
            };
            let pipeline = recorder.pipelines.of(points_pass(info.memory));
            let size = [chart.cols as u32, around.len() as u32];
            let slowness = u64::from(info.slowness.is_some());
            let each = [4 * (u64::from(kind.floats()) + slowness), kind.uploaded_bytes()];
            let pass = recorder.pass_of_each(PassKind::Points, size, each);
            recorder.host_pass(pipeline, set.set, &band, size);
            drop(pass);
            recorder.barrier(SHADER_WRITE, SHADER);
            recorder.measure(kind, rule == EdgeRule::Arc, rows);
        }
        if solver.is_curved() {
            recorder.bend(rule, false);
        }
    }

    /// Computes a map: as many iterations as the plan holds, less those after convergence.
    ///
    /// # Errors
    /// If the plan or the sources do not fit the surface, or its edges were never measured.
    pub fn solve(&self, sources: SourceInput, plan: &Plan) -> Result<(), VulkanError> {
        self.check(plan)?;
        self.check_sources(sources)?;
        self.surface.state.check_measured(plan)?;
        self.record_solve(sources, plan);
        self.note();
        Ok(())
    }

    fn record_solve(&self, sources: SourceInput, plan: &Plan) {
        self.surface.state.solve(plan);
        self.recorder.forget();
        self.start(sources, plan, false);
        self.steps(plan);
    }

    /// Adds sources to the map, which has converged with the same wavefront.
    ///
    /// # Errors
    /// If the plan or the sources do not fit the surface, or there is no map of that wavefront.
    pub fn add(&self, sources: SourceInput, plan: &Plan) -> Result<(), VulkanError> {
        self.check(plan)?;
        self.check_sources(sources)?;
        self.surface.state.check_wavefront(plan.wavefront)?;
        self.surface.state.solve(plan);
        self.start(sources, plan, true);
        self.steps(plan);
        self.note();
        Ok(())
    }

    /// Goes on with a map that may not have converged, by as many iterations again. In a later
    /// command buffer or the same; with the plan that it was started with. Visits nothing if
    /// the map has converged.
    ///
    /// # Errors
    /// If the plan does not fit the surface, or there is no map of that plan's wavefront and schedule.
    pub fn resume(&self, plan: &Plan) -> Result<(), VulkanError> {
        self.check(plan)?;
        self.surface.state.check_plan(plan)?;
        self.recorder.go_on(plan.schedule, plan.steps());
        self.steps(plan);
        self.note();
        Ok(())
    }

    /// Copies how the iterations have gone to the slot's record, for [`Surface::outcome`].
    ///
    /// # Errors
    /// If there is no such slot, or no map; with [`super::Tools::checks`] also if the slot's last recording
    /// has not run.
    pub fn outcome(&self, slot: usize) -> Result<(), VulkanError> {
        self.surface.check_slot(slot)?;
        self.surface.state.check_map()?;
        self.check_slot(slot, false)?;
        self.record_outcome(slot, self.next_outcome(slot));
        Ok(())
    }

    /// The serial of a slot's outcome that is recorded next.
    pub(super) fn next_outcome(&self, slot: usize) -> u32 {
        let Self { recorder, surface, .. } = self;
        let serial = surface.flight.next(recorder.buffer, Some(slot));
        surface.state.record_outcome(slot, serial, recorder.buffer);
        serial
    }

    pub(super) fn record_outcome(&self, slot: usize, serial: u32) {
        self.recorder.outcome_with_serial(slot, serial);
    }

    /// Copies how the iterations have gone, [`super::Outcome::BYTES`] bytes for
    /// [`Surface::outcome_from`], into a buffer of the host's with usage `TRANSFER_DST`;
    /// `offset` is a multiple of 4. Shaders find the number of iterations in the third 32-bit
    /// number.
    ///
    /// # Errors
    /// If there is no map, or the record does not lie in the buffer.
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
        self.recorder.barrier(CLEAR, after.side());
        self.note();
        Ok(())
    }

    /// Unpacks the map into the slot's image of distances. The commands wait until the `reader` of
    /// commands before has done with that image, and the reader of commands after waits for them.
    ///
    /// # Errors
    /// If there is no such slot, or no map.
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
        let work = Work::of_bytes(points, points);
        let record = PassRecord { work, ..dispatched(PassKind::Distances, texels) };
        let _pass = recorder.pass_with(record);
        let chart = surface.grid.chart;
        // Writers of the same slot in commands before are waited for as well.
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

    /// Looks distances up at the places in a buffer of the host's, bilinear between grid points.
    /// What is not reached, or not on the grid, is `unreached`. The commands wait for what `before`
    /// has written.
    ///
    /// # Errors
    /// If the surface has no such lookup, or no map.
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
        // A place and the points around it.
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

    /// Whether another map may go to a slot, if the host wants to know.
    fn check_slot(&self, slot: usize, starts_map: bool) -> Result<(), VulkanError> {
        let Self { recorder, surface, solver, .. } = self;
        if !solver.checks {
            return Ok(());
        }
        let serial = surface.grid.record(slot).serial;
        surface.state.check_slot(slot, serial, recorder.buffer, starts_map)
    }

    fn check(&self, plan: &Plan) -> Result<(), VulkanError> {
        if plan.texels != self.surface.grid.texels {
            return Err(VulkanError::OtherGrid);
        }
        let (schedule, wavefront) = (plan.schedule, plan.wavefront);
        match self.solver.has_passes(schedule, self.variant(plan)) {
            true => Ok(()),
            false => Err(VulkanError::NoPasses { schedule, wavefront }),
        }
    }

    /// By which a plan's pipelines are chosen for the surface.
    pub(super) fn variant(&self, plan: &Plan) -> Variant {
        Variant { slowed: self.surface.grid.is_slowed(), ..plan.wavefront.into() }
    }

    pub(super) fn check_sources(&self, sources: SourceInput) -> Result<(), VulkanError> {
        match sources {
            SourceInput::Inline(sources) if sources.len() > INLINE_SOURCES => {
                let (given, most) = (sources.len(), INLINE_SOURCES);
                Err(VulkanError::TooManySources { given, most })
            }
            SourceInput::Inline(sources) => {
                let chart = self.surface.grid.chart;
                Ok(sources.iter().try_for_each(|source| source.check(chart))?)
            }
            SourceInput::Buffer(_) | SourceInput::BufferAt { .. } => {
                let (number, offset) = sources.buffer().unwrap_or_default();
                let set = nth(&self.surface.sets.sources, "source buffers", number)?.set();
                set.at("sources", offset).map(drop)
            }
        }
    }

    /// Where a pass finds sources that were checked, and how many they are: in these sets of the inline ones, or
    /// of a buffer with a number.
    pub(super) fn sources_in(
        &self,
        sources: SourceInput,
        inline: HostSet,
        of_buffer: impl FnOnce(usize) -> HostSet,
    ) -> (HostSet, u32) {
        let SourceInput::Inline(sources) = sources else {
            let (number, offset) = sources.buffer().unwrap_or_default();
            let surface = self.surface;
            surface.sets.sources[number].is_read(&surface.flight);
            let set = of_buffer(number).at("sources", offset).expect("the sources were checked");
            return (set, surface.sources[number].count);
        };
        (inline, sources.len() as u32)
    }

    /// Runs the plan's steps.
    fn steps(&self, plan: &Plan) {
        self.recorder.steps(self.variant(plan), plan.steps());
        self.recorder.end_portion();
    }

    /// Starts a map on what is there; the plan's steps follow.
    pub(super) fn start(&self, sources: SourceInput, plan: &Plan, is_added: bool) {
        let Self { recorder, surface, .. } = self;
        let sets = &surface.sets;
        let (set, count) =
            self.sources_in(sources, sets.inline_sources, |number| sets.sources[number].set());
        // Which of them count the device alone knows.
        let causal = count > 1 || is_added || surface.grid.is_slowed();
        recorder.start(plan.stop, plan.schedule, causal, is_added);
        if let SourceInput::Inline(sources) = sources {
            recorder.write_sources(bytemuck::cast_slice(sources));
        }
        for first in (0..count).step_by(SOURCES_TOGETHER as usize) {
            let together = (count - first).min(SOURCES_TOGETHER);
            let portion = sources::Push {
                grid: grid_size(surface.grid.chart),
                first_word: set.first_word + 4 * first as i32,
                count: together as i32,
            };
            let pipeline = recorder.pipelines.of(SOURCES);
            let size = [4 * together, 1];
            // Four invocations share a source. How many edges around it they need, its place says.
            let each = [size_of::<PointSource>() as u64 / 4, SEED_BYTES];
            let pass = recorder.pass_of_each(PassKind::Sources, size, each);
            recorder.host_pass(pipeline, set.set, &portion, size);
            drop(pass);
            recorder.barrier(SHADER_WRITE, SHADER);
            recorder.seed(4 * together, plan.schedule.follows());
        }
        let gains = plan.schedule.gains_by_surroundings() && sources.may_lie_inside_cells();
        if gains || count > 1 && plan.wavefront.is_curved() {
            self.surroundings(set, count, plan);
        }
    }

    /// Goes on from so many sources to what they reach first, if maps of the plan gain by it.
    fn surroundings(&self, set: HostSet, count: u32, plan: &Plan) {
        let Self { recorder, surface, solver, .. } = self;
        let chart = surface.grid.chart;
        let Some(pipeline) = solver.surroundings(plan.schedule, self.variant(plan)) else { return };
        if count == 0 || count > most_surrounded(chart) {
            return;
        }
        let sources = surroundings::Push { grid: grid_size(chart), first_word: set.first_word };
        let each = SURROUNDINGS_TEXELS * SURROUNDINGS_TEXELS;
        let work = Work::of_surroundings(count.into(), each.into(), plan.wavefront.is_curved());
        let record = PassRecord {
            groups: Some([count, 1, 1]),
            work,
            ..PassRecord::new(PassKind::Surroundings)
        };
        let pass = recorder.pass_with(record);
        // A group for each source.
        recorder.host_pass(pipeline, set.set, &sources, [count * WORKGROUP, 1]);
        drop(pass);
        recorder.barrier(SHADER_WRITE, SHADER);
        if count > 1 {
            let size = [count * each, 1];
            let pass =
                recorder.pass_of_each(PassKind::Surroundings, size, [SEED_BYTES, SEED_BYTES]);
            let push = merge_surroundings::Push { count: count as i32 };
            recorder.run(recorder.pipelines.of(MERGE_SURROUNDINGS), 0, &push, size);
            drop(pass);
            recorder.barrier(SHADER_WRITE, SHADER);
        }
        recorder.seed(count * each, plan.schedule.follows());
    }

    pub(super) fn points(&self, number: usize) -> Result<(HostSet, super::Points), VulkanError> {
        let set = nth(&self.surface.sets.points, "point inputs", number)?.set();
        Ok((set.at("points", self.points_at)?, self.surface.points[number]))
    }

    /// A set of points in place of the surface's own, read from where this recording does.
    pub(super) fn points_in(&self, set: HostSet) -> HostSet {
        set.at("points", self.points_at).expect("the points were checked")
    }
}

fn points_pass(memory: PointMemory) -> CommonPass<points_from_buffer::Push> {
    match memory {
        PointMemory::Buffer { .. } => POINTS_FROM_BUFFER,
        PointMemory::Image { .. } => POINTS_FROM_IMAGE,
    }
}

impl Solver {
    /// Most records that [`Recording::frame`] makes for a surface, and [`Recording::resume`] with
    /// the same plan: room for so many in a [`Profile`]. What else is recorded with them
    /// comes on top: [`super::Contours::passes`], [`super::Paths::passes`], [`super::Regions::passes`], and one for each
    /// lookup.
    pub fn passes_of_frame(&self, surface: &Surface, plan: &Plan, grain: Grain) -> u32 {
        surface.passes_around() + plan.records(grain)
    }

    /// Records for a surface into a command buffer that the host has begun, on a queue family for
    /// compute and outside a render pass. Costs nothing by itself.
    pub fn record<'a>(
        &'a self,
        device: &'a ash::Device,
        commands: vk::CommandBuffer,
        surface: &'a Surface,
    ) -> Recording<'a> {
        Recording::new(device, commands, self, surface)
    }
}

/// Sources of a recording that have surroundings on such a grid, at most: some are worth it on any, a crowd
/// if its surroundings are a small part of the grid.
fn most_surrounded(chart: Chart) -> u32 {
    let share = chart.points() / POINTS_FOR_SURROUNDINGS;
    share.clamp(FEW_SOURCES, SOURCES_TOGETHER as usize) as u32
}

pub(super) fn nth<'a, T>(
    all: &'a [T],
    what: &'static str,
    number: usize,
) -> Result<&'a T, VulkanError> {
    all.get(number).ok_or(VulkanError::NoSuch { what, number, count: all.len() })
}

pub(super) fn grid_size(chart: Chart) -> [i32; 2] {
    [chart.cols as i32, chart.rows as i32]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vulkan::grid_images::upload_bytes;
    use crate::vulkan::upload::SeedTexel;

    #[test]
    fn there_is_room_for_the_seeds_of_all_surroundings() {
        let each = (SURROUNDINGS_TEXELS * SURROUNDINGS_TEXELS) as usize * size_of::<SeedTexel>();
        for (rows, cols) in [(1, 1), (1, 70_000), (89, 90), (400, 400), (1012, 1012), (9000, 114)] {
            let chart = Chart { rows, cols };
            let sources = most_surrounded(chart) as usize;
            assert!((FEW_SOURCES..=SOURCES_TOGETHER as usize).contains(&sources));
            assert!(sources * each <= upload_bytes(chart, frame_bytes(chart)), "{chart:?}");
        }
    }
}
