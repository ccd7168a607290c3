//! Records distance maps into the host's command buffer.

use ash::vk;

use super::access::Access;
use super::host_sets::HostSet;
use super::inputs::{PointMemory, PointSource, SourceInput};
use super::map_sources::Given;
use super::names::Labelled;
use super::numbered::nth;
use super::plan::Plan;
use super::solver::{PipelineSet, Solver};
use super::state::number_of_preparation;
use super::surface::FrameSurface;
use crate::constants::{NEVER_MEASURED, SOURCES_TOGETHER, SURROUNDINGS_TEXELS, WORKGROUP};
use crate::surface::{Chart, EdgeRule};
use crate::update::Wavefront;
use crate::vulkan::device::bands::{POINT_BYTES, bands, frame_bytes, rows_around};
use crate::vulkan::device::barrier::{PASS, SHADER, SHADER_WRITE, TRANSFER};
use crate::vulkan::device::labels::Group;
use crate::vulkan::device::passes::{
    GLUED_POINTS_FROM_BUFFER, GLUED_POINTS_FROM_IMAGE, MERGE_SURROUNDINGS, POINTS_FROM_BUFFER,
    POINTS_FROM_IMAGE, SOURCES, Variant,
};
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::shaders::{
    merge_surroundings, points_from_buffer, sources, surroundings,
};
use crate::vulkan::grid_images::INLINE_SOURCES;
use crate::vulkan::point_kind::PointKind;
use crate::vulkan::profile::{PassKind, Profile, Work};
use crate::vulkan::record::{Commands, Recorder};
use crate::vulkan::schedules::progress::offset;
use crate::vulkan::upload::SEED_BYTES;
use crate::vulkan::{MapLimit, VulkanError};

/// Recorder that appends commands for a surface to a command buffer of the host.
///
/// No method submits, waits, maps memory, or allocates on the device or the heap. A method that returns an
/// error has recorded nothing.
///
/// Recordings of one surface must run one after another, in the order in which they were recorded: on one
/// queue, or with semaphores between queues. The solver, the surface and the inputs that a recording reads
/// must stay alive until it has run.
///
/// A recording changes the pipeline, the descriptor sets and the push constants of the compute bind point.
/// Push constants of graphics pipelines become undefined too. Other graphics state stays as it was. Active
/// queries count the passes. Conditional rendering must not be active.
#[derive(Clone, Copy)]
pub struct Recording<'a> {
    pub(super) recorder: Recorder<'a>,
    pub(super) solver: &'a Solver,
    pub(super) surface: &'a FrameSurface,
    /// Offset in bytes, added to the surface's own offset of the points.
    points_at: u64,
    /// Limit of the maps.
    limit: MapLimit<'a>,
    profile: Option<&'a Profile>,
}

/// Minimum number of grid points per source for solving the sources' surroundings first, if there are more
/// than [`FEW_SOURCES`]. Solving a source's surroundings updates 400 points from all sides about sixteen
/// times. That takes as long as two to four iterations over 1,500 to 3,000 points, and two to four iterations
/// are saved.
const POINTS_FOR_SURROUNDINGS: usize = 4000;
/// Number of sources whose surroundings are solved on a grid of any size.
const FEW_SOURCES: usize = 8;

impl<'a> Recording<'a> {
    pub(super) fn new(
        device: &'a ash::Device,
        commands: vk::CommandBuffer,
        solver: &'a Solver,
        surface: &'a FrameSurface,
    ) -> Self {
        let commands = Commands::new(device, commands, &solver.pipelines);
        let recorder = Recorder { commands, grid: &surface.grid };
        Self { recorder, solver, surface, points_at: 0, limit: MapLimit::NONE, profile: None }
    }

    /// Returns this recording with `profile`, which receives the passes recorded by the returned value.
    /// Starts the profile anew: resets its queries in the command buffer and writes the first timestamp. All
    /// calls on the returned value must run in one submission.
    ///
    /// # Errors
    /// [`VulkanError::ProfileInFlight`] with [`super::Tools::checks`], if an earlier recording with this profile has not
    /// run.
    pub fn profiled(mut self, profile: &'a Profile) -> Result<Self, VulkanError> {
        if self.solver.checks {
            profile.check_use(self.recorder.buffer)?;
        }
        profile.start(self.recorder.device, self.recorder.buffer);
        self.recorder.commands.observer = Some(profile);
        self.profile = Some(profile);
        Ok(self)
    }

    /// Returns this recording with `offset` bytes added to the surface's own offset of the points, as for a ring buffer
    /// of which each frame uses another part. The offset applies in [`Recording::measure`] and where contours and paths
    /// are lifted. It must be a multiple of 4, and 0 for points in an image. The methods that read the points check it.
    pub fn points_at(self, offset: u64) -> Self {
        Self { points_at: offset, ..self }
    }

    /// Returns this recording with maps that end at a radius or at targets, in [`Recording::solve`] and
    /// [`Recording::add`], which check the limit. A frame has its own limit: [`super::Frame::limit`]. The map
    /// of [`Recording::add`] should have the limit of the map to which sources are added.
    pub fn limited(self, limit: MapLimit<'a>) -> Self {
        Self { limit, ..self }
    }

    /// Records the layout transitions and clears of a new surface's images. They must be recorded once,
    /// before anything else for the surface. Recording them again discards the edge lengths, so
    /// [`Recording::measure`] must follow. If the commands never run, outcomes report it
    /// ([`VulkanError::PreparationLost`]).
    pub fn prepare(&self) {
        let number = number_of_preparation();
        self.recorder.prepare();
        self.recorder.set_known(offset::PREPARED, number);
        self.recorder.set_known(offset::POINTS, NEVER_MEASURED);
        self.surface.state.prepare(number);
        self.note();
    }

    /// Opens the surface's label over the commands of a kind, until the returned value is dropped.
    pub(super) fn group(&self, of: Labelled) -> Option<Group<'a>> {
        self.recorder.group(self.surface.labels.as_ref()?.label(of))
    }

    /// With checks, records a write of a serial after the commands so far. The serial shows that these
    /// commands have run. Returns the serial, or `None` without checks.
    pub(super) fn note(&self) -> Option<u32> {
        let serial = self.next_note();
        if let Some(serial) = serial {
            self.record_note(serial);
        }
        serial
    }

    pub(super) fn next_note(&self) -> Option<u32> {
        self.solver.checks.then(|| self.next_serial(None))
    }

    /// Returns the serial of the commands that are recorded next.
    pub(super) fn next_serial(&self, slot: Option<usize>) -> u32 {
        let Self { recorder, surface, .. } = self;
        let serial = surface.flight.next(recorder.buffer, slot);
        if let Some(profile) = self.profile {
            profile.is_used(&surface.flight, serial, recorder.buffer);
        }
        serial
    }

    pub(super) fn record_note(&self, serial: u32) {
        self.recorder.mark(self.surface.grid.slots, serial);
    }

    /// Records a barrier that waits for the accesses in `before`, by which the host has written points and
    /// sources. The barrier also waits for all earlier compute shaders and transfers on the queue, and so for
    /// earlier recordings of this surface.
    pub fn begin(&self, before: Access) {
        let (stages, access) = (PASS.0 | TRANSFER.0, PASS.1 | TRANSFER.1);
        let (host_stages, host_access) = before.side();
        self.recorder.barrier((stages | host_stages, access | host_access), (stages, access));
    }

    /// Records a barrier after everything so far. The accesses in `after` may then read the packed times, or
    /// overwrite what the passes have read.
    pub fn end(&self, after: Access) {
        self.recorder.barrier((PASS.0 | TRANSFER.0, PASS.1 | TRANSFER.1), after.side());
    }

    /// Records the passes that measure the surface's edges, from its points with the number `points`. If a
    /// wavefront of the solver needs it, they also compute the curvature. The current map is lost, and
    /// [`Recording::solve`] must follow. The host's points must stay alive until the commands have run.
    ///
    /// Edges must be shorter than 1e12 units, and edges between distinct points longer than 1e-12.
    ///
    /// # Errors
    /// If the surface has no such points, the offset of [`Recording::points_at`] does not fit them, or the
    /// surface is not prepared.
    pub fn measure(&self, points: usize) -> Result<(), VulkanError> {
        let read = self.points(points)?;
        self.surface.state.check_prepared()?;
        self.record_measure(points, read);
        self.surface.measures(self.solver);
        self.note();
        Ok(())
    }

    pub(super) fn record_measure(&self, points: usize, (set, info): (HostSet, super::Points)) {
        let Self { recorder, surface, solver, .. } = self;
        surface.sets.points[points].is_read(&surface.flight);
        let chart = surface.grid.chart;
        let kind = info.kind;
        // Arcs need positions. Other edges are straight.
        let rule = if kind.has_positions() { surface.edge_rule } else { EdgeRule::Chord };
        recorder.set_known(offset::POINTS, 0);
        let (lattice, [halo_cols, halo_rows]) = (surface.grid.lattice, surface.grid.lattice.halo());
        let wide = lattice.with_halo(chart);
        for rows in bands(wide, POINT_BYTES, frame_bytes(chart)) {
            let around = rows_around(&rows, chart, halo_rows);
            let band = points_from_buffer::Push {
                grid: grid_size(chart),
                first_row: around.start as i32,
                band_rows: around.len() as i32,
                first_own: (rows.start as isize - around.start) as i32,
                own_rows: rows.len() as i32,
                heights: kind.spacing().is_some().into(),
                slowness: info.slowness.map_or(-1, |index| index as i32),
                first_word: set.first_word,
                stride: info.memory.stride_words(),
                halo: [halo_cols as i32, halo_rows as i32],
                lattice: lattice.codes(),
                spacing: kind.spacing_in_single(),
                is_metric: (kind == PointKind::Metric).into(),
            };
            let pipeline = self.points_pass(info.memory);
            let size = [wide.cols as u32, around.len() as u32];
            let slowness = u64::from(info.slowness.is_some());
            let each = [4 * (u64::from(kind.floats()) + slowness), kind.uploaded_bytes()];
            let pass = recorder.pass_of_each(PassKind::Points, size, each);
            recorder.host_pass(pipeline, set.set, &band, size);
            drop(pass);
            recorder.barrier(SHADER_WRITE, SHADER);
            recorder.measure(kind, rule == EdgeRule::Arc, rows);
        }
        if solver.is_curved() {
            recorder.compute_gaussian_curvature(rule, false);
            recorder.share_curvature();
        }
    }

    /// Returns the pass that reads points from a type of memory.
    fn points_pass(&self, memory: PointMemory) -> Pipeline<points_from_buffer::Push> {
        let pipelines = self.recorder.pipelines;
        let (open, glued) = match memory {
            PointMemory::Buffer { .. } => (POINTS_FROM_BUFFER, GLUED_POINTS_FROM_BUFFER),
            PointMemory::Image { .. } => (POINTS_FROM_IMAGE, GLUED_POINTS_FROM_IMAGE),
        };
        match self.surface.grid.copies.is_some() {
            true => pipelines
                .made(glued, Wavefront::Curved)
                .expect("a glued surface is only made once its pipelines are"),
            false => pipelines.of(open),
        }
    }

    /// Records the passes of a new map from `sources`: as many iterations as the plan holds. Iterations after
    /// convergence visit nothing. A buffer of sources must stay alive until the commands have run.
    ///
    /// # Errors
    /// If the plan, the sources or the limit do not fit the surface, the solver has no pipelines for the plan, or
    /// the edges were never measured.
    pub fn solve(&self, sources: SourceInput, plan: &Plan) -> Result<(), VulkanError> {
        self.check(plan)?;
        self.check_sources(sources)?;
        self.limit.check(self.surface.grid.chart)?;
        self.surface.state.check_measured(plan)?;
        self.record_solve(sources, plan);
        self.note();
        Ok(())
    }

    pub(super) fn record_solve(&self, sources: SourceInput, plan: &Plan) {
        self.surface.state.solve(plan, self.limit, Given::new(sources, self.surface));
        self.recorder.forget();
        self.start(sources, plan, false);
        self.steps(plan);
    }

    /// Records the passes that add sources to the current map, which must have converged with the wavefront
    /// of `plan`.
    ///
    /// # Errors
    /// If the plan, the sources or the limit do not fit the surface, the solver has no pipelines for the plan, or
    /// there is no map of that wavefront.
    pub fn add(&self, sources: SourceInput, plan: &Plan) -> Result<(), VulkanError> {
        self.check(plan)?;
        self.check_sources(sources)?;
        self.limit.check(self.surface.grid.chart)?;
        self.surface.state.check_wavefront(plan.wavefront)?;
        self.surface.state.add(plan, self.limit, Given::new(sources, self.surface));
        self.start(sources, plan, true);
        self.steps(plan);
        self.note();
        Ok(())
    }

    /// Records further iterations of a map that may not have converged, as many as the plan holds. The plan
    /// has the schedule and the wavefront that the map was started with, and any number of iterations. The
    /// iterations may follow in the same command buffer or in a later one. They visit nothing if the map has
    /// converged.
    ///
    /// # Errors
    /// If the plan does not fit the surface, the solver has no pipelines for it, or there is no map with the
    /// plan's wavefront and schedule.
    pub fn resume(&self, plan: &Plan) -> Result<(), VulkanError> {
        self.check(plan)?;
        self.surface.state.check_plan(plan)?;
        self.recorder.go_on(plan.schedule);
        self.steps(plan);
        self.note();
        Ok(())
    }

    /// With checks, returns an error if the slot is still in flight and cannot receive this map.
    pub(super) fn check_slot(&self, slot: usize, starts_map: bool) -> Result<(), VulkanError> {
        let Self { recorder, surface, solver, .. } = self;
        if !solver.checks {
            return Ok(());
        }
        let serial = surface.grid.record(slot).serial;
        surface.state.check_slot(slot, serial, recorder.buffer, starts_map)
    }

    pub(super) fn check(&self, plan: &Plan) -> Result<(), VulkanError> {
        if plan.texels != self.surface.grid.texels {
            return Err(VulkanError::OtherGrid);
        }
        let is_glued = self.surface.grid.copies.is_some();
        if plan.is_over_seams != is_glued {
            return Err(VulkanError::OtherGluing { is_glued });
        }
        let (schedule, wavefront) = (plan.schedule, plan.wavefront);
        match self.solver.has_passes(schedule, self.variant(plan)) {
            true => Ok(()),
            false => Err(VulkanError::NoPasses { schedule, wavefront }),
        }
    }

    /// Returns the variant of the plan's pipelines for this surface.
    pub(super) fn variant(&self, plan: &Plan) -> Variant {
        let grid = &self.surface.grid;
        let small_tiles = self.solver.tuning().has_small_tiles(grid.texels);
        let glued = grid.copies.is_some();
        let (slowed, skewed) = (grid.is_slowed(), self.surface.has_skewed_cells);
        PipelineSet { slowed, small_tiles, glued, skewed }.variant(plan.wavefront.into())
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

    /// Returns the set from which a pass reads the sources, and their number. The set is `inline` for inline
    /// sources. Otherwise it is the result of `of_buffer` for the number of the buffer. The sources were
    /// checked before.
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

    /// Records the steps of the plan.
    fn steps(&self, plan: &Plan) {
        let state = &self.surface.state;
        self.recorder.steps(self.variant(plan), plan.steps(), state.has_targets());
        self.recorder.end_portion();
        self.trim();
    }

    /// Resets points beyond the limit of the map to unreached, if the map has a limit.
    pub(super) fn trim(&self) {
        if self.surface.state.is_limited() {
            self.recorder.trim();
        }
    }

    /// Starts a map from `sources`, whose fronts are added to the current fronts. The plan's steps must
    /// follow.
    pub(super) fn start(&self, sources: SourceInput, plan: &Plan, is_added: bool) {
        let Self { recorder, surface, .. } = self;
        let sets = &surface.sets;
        let (set, count) =
            self.sources_in(sources, sets.inline_sources, |number| sets.sources[number].set());
        // Only the device knows which of the sources are skipped.
        let causal = count > 1 || is_added || surface.grid.is_slowed();
        recorder.start((plan.stop, self.limit), plan.schedule, causal, is_added);
        if let SourceInput::Inline(sources) = sources {
            recorder.write_sources(bytemuck::cast_slice(sources));
        }
        let lattice = surface.grid.lattice;
        // The seed of a source at a grid point passes to the copies of that point with the other seeds.
        let has_copies = sources.may_lie_inside_cells();
        let copies = lattice.copies().filter(|&copy| has_copies || copy == 0);
        let portions = (0..count).step_by(SOURCES_TOGETHER as usize);
        for (copy, first) in copies.flat_map(|copy| portions.clone().map(move |at| (copy, at))) {
            let together = (count - first).min(SOURCES_TOGETHER);
            let portion = sources::Push {
                grid: grid_size(surface.grid.chart),
                lattice: lattice.codes(),
                first_word: set.first_word + 4 * first as i32,
                count: together as i32,
                copy,
            };
            let pipeline = recorder.pipelines.of(SOURCES);
            let size = [4 * together, 1];
            // Four invocations share a source. The number of edges that they read around it depends on its position,
            // and is not counted.
            let each = [size_of::<PointSource>() as u64 / 4, SEED_BYTES];
            let pass = recorder.pass_of_each(PassKind::Sources, size, each);
            recorder.host_pass(pipeline, set.set, &portion, size);
            drop(pass);
            recorder.barrier(SHADER_WRITE, SHADER);
            recorder.seed(4 * together, plan.schedule.follows());
        }
        // Over a slowness, sources inside cells have straight lines to the points around them.
        let gains = plan.schedule.gains_by_surroundings() || surface.grid.is_slowed();
        if gains && sources.may_lie_inside_cells()
            || surface.has_skewed_cells
            || count > 1 && plan.wavefront.is_curved()
        {
            self.surroundings(set, count, plan);
        }
        recorder.exchange_seeds(self.variant(plan), plan.schedule);
    }

    /// Records the passes that solve the surroundings of `count` sources, if the maps of the plan gain by it.
    fn surroundings(&self, set: HostSet, count: u32, plan: &Plan) {
        let Self { recorder, surface, solver, .. } = self;
        let chart = surface.grid.chart;
        let Some(pipeline) = solver.surroundings(plan.schedule, self.variant(plan)) else { return };
        if count == 0 || count > most_surrounded(chart) {
            return;
        }
        let is_glued = surface.grid.copies.is_some().into();
        let (grid, first_word) = (grid_size(chart), set.first_word);
        let sources = surroundings::Push { grid, first_word, is_glued };
        let each = SURROUNDINGS_TEXELS * SURROUNDINGS_TEXELS;
        let moved = Work::of_surroundings(count.into(), each.into(), plan.wavefront.is_curved());
        let pass = recorder.pass_moving(PassKind::Surroundings, moved);
        // Each source takes one workgroup.
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

    /// Returns a set that reads the surface's points, with this recording's offset into their buffer.
    ///
    /// # Panics
    /// If the offset was not checked before.
    pub(super) fn at_points_offset(&self, set: HostSet) -> HostSet {
        set.at("points", self.points_at).expect("the points were checked")
    }
}

impl Solver {
    /// Returns a recorder for a surface and a command buffer. The host has begun the command buffer, on a
    /// queue family with compute, and records outside of render passes. The call itself records nothing. See
    /// [`Recording`] for what must stay alive, and for the state that recordings change.
    pub fn record<'a>(
        &'a self,
        device: &'a ash::Device,
        commands: vk::CommandBuffer,
        surface: &'a FrameSurface,
    ) -> Recording<'a> {
        Recording::new(device, commands, self, surface)
    }
}

/// Returns the largest number of sources of a recording whose surroundings are solved on a grid of this size. Solving
/// them always pays for a few sources, and for many only if they are a small part of the grid.
fn most_surrounded(chart: Chart) -> u32 {
    let share = chart.points() / POINTS_FOR_SURROUNDINGS;
    share.clamp(FEW_SOURCES, SOURCES_TOGETHER as usize) as u32
}

pub(super) fn grid_size(chart: Chart) -> [i32; 2] {
    [chart.cols as i32, chart.rows as i32]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vulkan::device::bands::upload_bytes;
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
