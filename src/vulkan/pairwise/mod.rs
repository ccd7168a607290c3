//! Computes the maps of many sources of one surface at once, for all pairs of points.
//!
//! If a map fits the shared memory of a workgroup, each source has a workgroup. The workgroup runs all four
//! scans, iteration after iteration, without the host. The lengths around the points are common to all maps.
//! They lie in a buffer in the order in which scans use them. Larger maps lie in the layers of two images,
//! with 2 x 2 points a texel, and a dispatch processes a block of lines of all maps. Each map is iterated
//! until it has converged by itself, so that its row does not depend on the other sources.

mod creation;
mod layout;
mod pipelines;
mod progress;
mod record;
mod resources;
mod schedule;
mod steps;
mod tally;

use std::sync::Arc;
use std::time::Instant;

use ash::vk;
use rayon::prelude::*;

use super::device::staging::HALVES;
use super::headless::context::{Context, Flight, Submitter, Unwatched};
use super::profile::steps::records;
use super::profile::{Detail, Grain, Session, SolveProfile};
use super::record::Commands;
use super::schedules::plan;
use super::schedules::plan::{Portions, Reached};
use super::{HeadlessSolver, Schedule, SurfaceOnDevice, TexelChart, Tuning, VulkanError};
use crate::update::Wavefront;
use crate::{Convergence, Stop};
use layout::BatchLayout;
use pipelines::BatchPipelines;
use progress::{BatchOutcome, MapProgress};
use record::BatchRecorder;
use resources::Resources;
pub use schedule::PairwiseSchedule;
use tally::Tally;

/// Resources on a device for the maps of a batch of sources of one surface.
///
/// ```no_run
/// use geosweep::Stop;
/// use geosweep::vulkan::HeadlessSolver;
/// use geosweep::{DeviceChoice, Spacing, Surface, Wavefront};
/// let surface = Surface::from_heights(32, 32, vec![0.0; 1024], Spacing::square(1.0))?;
/// let solver = HeadlessSolver::new(&DeviceChoice::Any)?;
/// let on_device = solver.upload(&surface)?;
/// let mut pairwise = solver.pairwise(&on_device, Wavefront::Circular, None)?;
/// let sources: Vec<_> = (0..1024).map(Some).collect();
/// let mut distances = vec![0.0; 1024 * 1024];
/// pairwise.solve(&solver, &on_device, &sources, Stop::within(1e-6).or_after(100), &mut distances)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct PairwiseOnDevice {
    context: Arc<Context>,
    /// Image of the edge lengths that are bound.
    edges: vk::Image,
    texels: TexelChart,
    wavefront: Wavefront,
    layout: BatchLayout,
    passes: BatchPipelines,
    resources: Resources,
    flight: Flight,
}

impl PairwiseOnDevice {
    /// Returns the number of sources whose maps are computed at a time. Further sources are computed in
    /// batches one after another.
    pub fn batch(&self) -> usize {
        self.layout.maps as usize
    }

    /// Returns the wavefront of the maps. It is the requested one, except that curved fronts replace anchored
    /// ones, and over an uneven slowness also circular ones.
    pub fn wavefront(&self) -> Wavefront {
        self.wavefront
    }

    /// Returns where the maps lie.
    pub fn schedule(&self) -> PairwiseSchedule {
        self.layout.schedule()
    }

    /// Returns the bytes of device and staging memory held, without those of the surface.
    pub fn bytes(&self) -> u64 {
        self.resources.bytes()
    }

    /// Computes the distances from grid points, given by their row-major index, to all points. `into` has a
    /// row for each source; its values are +infinity where the source does not reach. A source that is `None`
    /// leaves a row of +infinity; use it for holes. Returns the largest number of iterations that a map took,
    /// and the largest change in the last iteration of any map.
    ///
    /// If maps lie in images, the sources of a batch should be neighbours: the first iteration visits only
    /// what the fronts of the batch can have reached.
    ///
    /// If the monitor of `solver` cancels the maps ([`HeadlessSolver::with_monitor`]), each batch ends after its
    /// current submission, and its rows are incomplete.
    ///
    /// # Panics
    /// If this was made for another solver or another surface, if `into` does not have a row for each source and a
    /// value a row for each point, or if a source is not a grid point.
    pub fn solve(
        &mut self,
        solver: &HeadlessSolver,
        surface: &SurfaceOnDevice,
        sources: &[Option<usize>],
        stop: Stop,
        into: &mut [f32],
    ) -> Result<Convergence, VulkanError> {
        self.check(solver, surface);
        self.solve_watched(solver, sources, stop, into, &mut Unwatched)
    }

    /// Computes distances as [`PairwiseOnDevice::solve`] does and returns a record of every pass of every
    /// batch. The work of a pass is counted over all maps of its batch: an iteration visits the maps that have
    /// not converged. Maps in shared memory are processed by pairs of points, so that no texels are counted.
    ///
    /// # Errors
    /// As [`PairwiseOnDevice::solve`], and [`VulkanError::NotForProfiling`] unless the solver was made by
    /// [`HeadlessSolver::for_profiling`].
    ///
    /// # Panics
    /// As [`PairwiseOnDevice::solve`].
    pub fn profile(
        &mut self,
        solver: &HeadlessSolver,
        surface: &SurfaceOnDevice,
        sources: &[Option<usize>],
        stop: Stop,
        into: &mut [f32],
        detail: Detail,
    ) -> Result<(Convergence, SolveProfile), VulkanError> {
        self.check(solver, surface);
        let capabilities = solver.capabilities().ok_or(VulkanError::NotForProfiling)?;
        let scans = self.scans(solver.tuning(), None, stop.iterations);
        let passes = records(&scans, detail.grain) + PASSES_AROUND;
        // Each map converges by itself, so that the work is known for whole iterations only.
        let grain = match detail.grain {
            Grain::Portions => Grain::Iterations,
            finer => finer,
        };
        let detail = Detail { grain, tiles: false, ..detail };
        let mut session = Session::new(&self.context, capabilities, passes, 0, detail)?;
        let begin = Instant::now();
        session.restart();
        let convergence = self.solve_watched(solver, sources, stop, into, &mut session)?;
        let time = begin.elapsed();
        Ok((convergence, session.finish(time)))
    }

    fn check(&self, solver: &HeadlessSolver, surface: &SurfaceOnDevice) {
        assert!(Arc::ptr_eq(&self.context, &solver.context), "another solver");
        assert_eq!(self.edges, surface.images.edges.image, "another surface");
    }

    fn solve_watched(
        &mut self,
        solver: &HeadlessSolver,
        sources: &[Option<usize>],
        stop: Stop,
        into: &mut [f32],
        submitter: &mut impl Submitter,
    ) -> Result<Convergence, VulkanError> {
        let points = self.layout.chart.points();
        assert_eq!(into.len(), sources.len() * points, "there must be one row for each source");
        assert!(sources.iter().flatten().all(|&source| source < points), "sources are grid points");
        let batch = self.batch();
        let mut convergence = Convergence::NONE;
        let mut before: Option<Rows> = None;
        for (sources, into) in sources.chunks(batch).zip(into.chunks_mut(batch * points)) {
            // The host still reads the half of the last batch that had sources. A batch without sources takes
            // no half.
            let half = before.as_ref().map_or(0, |rows| (rows.half + 1) % HALVES);
            let rows = Rows { sources, into, half };
            let of_batch = self.solve_batch(solver, rows, stop, &mut before, submitter)?;
            convergence = convergence.worse(of_batch);
        }
        self.write_rows(before);
        self.context.check_validation()?;
        Ok(convergence)
    }

    /// Writes the distances of a batch that has been computed.
    fn write_rows(&self, rows: Option<Rows>) {
        let Some(Rows { sources, into, half }) = rows else { return };
        let points = self.layout.chart.points();
        let maps: &[f32] = bytemuck::cast_slice(self.resources.read_distances(half));
        let rows = into.par_chunks_exact_mut(points).zip(maps.par_chunks_exact(points));
        rows.zip(sources).for_each(|((row, map), source)| match source {
            Some(_) => row.copy_from_slice(map),
            None => row.fill(f32::INFINITY),
        });
    }

    /// Computes a batch. If distances are copied, the host writes the rows of the batch `before` while the
    /// device computes this batch. The rows of this batch are left to the next call.
    fn solve_batch<'a>(
        &mut self,
        solver: &HeadlessSolver,
        rows: Rows<'a>,
        stop: Stop,
        before: &mut Option<Rows<'a>>,
        submitter: &mut impl Submitter,
    ) -> Result<Convergence, VulkanError> {
        let Rows { sources, half, .. } = rows;
        let chart = self.layout.chart;
        let texel = |source: usize| {
            let (row, col) = chart.position(source);
            let (row, col, _) = TexelChart::texel_of(row, col);
            (row, col)
        };
        let Some(reached) = Reached::around(sources.iter().flatten().map(|&source| texel(source)))
        else {
            rows.into.fill(f32::INFINITY);
            return Ok(Convergence::NONE);
        };
        let tuning = solver.for_device.pipelines.tuning;
        let texels = self.texels.inner();
        let groups = texels.map(|texels| texels.div_ceil(tuning.scan_texels()));
        progress::start(chart, sources, stop, groups, self.resources.write_staging());

        let schedule = self.schedule();
        let bring = self.resources.is_staged().then_some(half);
        let scans = self.scans(tuning, Some(reached), stop.iterations);
        let mut steps = steps::first(schedule, scans, bring, self.is_glued());
        let mut gone = Vec::new();
        if submitter.is_watching() {
            gone = MapProgress::read(sources.len(), self.resources.write_staging());
        }
        let outcome = loop {
            self.start(solver, sources.len(), submitter, |recorder| recorder.steps(&steps))?;
            self.write_rows(before.take());
            self.flight.wait()?;
            if let Some(passes) = submitter.last() {
                let before = gone;
                gone = MapProgress::read(sources.len(), self.resources.read_outcome());
                let tally = Tally { layout: &self.layout, sources };
                tally.settle(passes, &before, &gone);
            }
            let outcome = BatchOutcome::read(sources.len(), self.resources.read_outcome());
            if outcome.is_done || solver.monitor.is_cancelled() {
                break outcome;
            }
            let left = stop.iterations - outcome.convergence.iterations;
            steps = steps::further(schedule, self.scans(tuning, None, left), bring);
        };
        if schedule == PairwiseSchedule::Images {
            let steps = steps::last(bring);
            self.start(solver, sources.len(), submitter, |recorder| recorder.steps(&steps))?;
            self.flight.wait()?;
        }
        *before = Some(rows);
        if bring.is_none() {
            // The next batch writes its distances to the same place.
            self.write_rows(before.take());
        }
        Ok(outcome.convergence)
    }

    /// Returns the steps of a recording of the raster schedule. They are empty for maps in shared memory.
    fn scans(&self, tuning: Tuning, reached: Option<Reached>, most: u32) -> Vec<plan::Step> {
        if self.schedule() == PairwiseSchedule::SharedMemory {
            return Vec::new();
        }
        // Each map has workgroups of its own. They are enough to keep a device busy without blocks in turn
        // and without pairs of scans.
        let portions = tuning.portions(self.wavefront, self.texels);
        let portions = Portions { across: 0, pairs: false, ..portions };
        if self.is_glued() {
            return plan::with_exchanges(Schedule::Raster.plan(self.texels, portions, None, most));
        }
        Schedule::Raster.plan(self.texels, portions, reached, most)
    }

    fn is_glued(&self) -> bool {
        self.resources.copies.is_some()
    }

    /// Records commands for `maps` maps and submits them. The commands submitted before have finished.
    fn start(
        &mut self,
        solver: &HeadlessSolver,
        maps: usize,
        submitter: &mut impl Submitter,
        append: impl FnOnce(BatchRecorder),
    ) -> Result<(), VulkanError> {
        submitter.record(&self.flight.commands, |device, buffer, observer| {
            let pipelines = &solver.for_device.pipelines;
            append(BatchRecorder {
                commands: Commands { device, buffer, pipelines, observer, turn: None },
                passes: &self.passes,
                resources: &self.resources,
                layout: &self.layout,
                texels: self.texels,
                maps: maps as u32,
            });
        })?;
        submitter.start(&mut self.flight)
    }
}

/// Rows of the matrix for a batch of sources.
struct Rows<'a> {
    sources: &'a [Option<usize>],
    into: &'a mut [f32],
    /// Half of the staging buffer for the distances, if they are copied.
    half: usize,
}

/// Largest number of passes in a submission in addition to scans and counts: copies, the first texels, their exchange,
/// and iterations in shared memory.
const PASSES_AROUND: u32 = 6;

impl Drop for PairwiseOnDevice {
    fn drop(&mut self) {
        // After an error the device may still run the last submission.
        let _ = self.flight.wait();
        let context = &self.context;
        self.resources.destroy(&context.device, &mut context.allocator());
    }
}

#[cfg(test)]
mod tests {
    use super::layout::Workgroup;
    use super::*;
    use crate::Monitor;
    use crate::surface::{Gluing, Spacing, Surface};
    use crate::vulkan::device::barrier::tests::{number as barrier_number, without};
    use crate::vulkan::headless::testing::{self, is_between_passes, validated as solver};

    const STOP: Stop = Stop::within(1e-6).or_after(100);

    fn hill() -> Surface {
        testing::hill(20, 30, |i| i)
    }

    /// Returns the hill with a copy of its first column in place of the last one. Both columns are glued.
    fn closed_hill() -> Surface {
        let hill = testing::hill(20, 30, |i| i / 30 * 30 + i % 30 % 29);
        hill.with_gluing(Gluing::columns()).unwrap()
    }

    const SOURCES: [Option<usize>; 3] = [Some(15), None, Some(411)];

    /// Leaves out one barrier of a recording: after the copy of what the host has written, after the start,
    /// or before the copy of what the host reads.
    #[test]
    fn missing_barriers_are_reported() {
        let surface = hill();
        for (schedule, which) in [
            (PairwiseSchedule::SharedMemory, 2),
            (PairwiseSchedule::SharedMemory, 4),
            (PairwiseSchedule::Images, 2),
            (PairwiseSchedule::Images, 3),
        ] {
            let solver = solver();
            let on_device = solver.upload(&surface).unwrap();
            let mut pairwise =
                solver.pairwise(&on_device, Wavefront::Planar, Some(schedule)).unwrap();
            let mut rows = vec![0.0; 3 * 600];
            let result = without(barrier_number(which), || {
                pairwise.solve(&solver, &on_device, &SOURCES, STOP, &mut rows)
            });
            let Err(VulkanError::Validation(messages)) = result else {
                panic!("{schedule}, barrier {which}: {result:?}")
            };
            assert!(messages.iter().any(|m| m.contains("SYNC-HAZARD-")), "{messages:?}");
        }
    }

    /// Checks that a pipeline for all sizes with the same room, as GPUs use it, gives the same maps as one
    /// for a single size, in one dispatch or several.
    #[test]
    fn a_size_that_is_pushed_makes_no_difference() {
        let solver = solver();
        for (rows, cols) in [(20, 30), (31, 13), (1, 40), (40, 1)] {
            let heights = (0..rows * cols).map(|i| f64::from((i % 7) as u32).sin()).collect();
            let surface = Surface::from_heights(rows, cols, heights, Spacing::square(1.0)).unwrap();
            let on_device = solver.upload(&surface).unwrap();
            let sources = [Some(0), None, Some(rows * cols / 2)];
            for wavefront in Wavefront::FOR_ANY_SURFACE {
                let shared = Some(PairwiseSchedule::SharedMemory);
                let mut pairwise = solver.pairwise(&on_device, wavefront, shared).unwrap();
                let layout = pairwise.layout;
                let mut known = vec![0.0; 3 * rows * cols];
                pairwise.solve(&solver, &on_device, &sources, STOP, &mut known).unwrap();
                for iterations in [1, 32] {
                    let own = layout.workgroup.unwrap();
                    let room = own.room.next_multiple_of(512);
                    let workgroup = Workgroup { room, iterations, is_known: false, ..own };
                    let layout = BatchLayout { workgroup: Some(workgroup), ..layout };
                    let mut pushed = vec![0.0; 3 * rows * cols];
                    let mut pairwise = solver.pairwise_in(&on_device, layout).unwrap();
                    pairwise.solve(&solver, &on_device, &sources, STOP, &mut pushed).unwrap();
                    assert_eq!(known, pushed, "{rows} x {cols}, {wavefront}, {iterations}");
                }
            }
        }
    }

    #[test]
    fn a_cancelled_batch_ends_after_its_submission() {
        let solver = solver();
        let tuning = Tuning { together: Some(1), ..solver.tuning() };
        let monitor = Monitor::default();
        let solver = solver.with_tuning(tuning).unwrap().with_monitor(monitor.clone());
        let on_device = solver.upload(&hill()).unwrap();
        let images = Some(PairwiseSchedule::Images);
        let mut pairwise = solver.pairwise(&on_device, Wavefront::Planar, images).unwrap();
        let mut rows = [0.0; 3 * 600];
        let mut iterations = || {
            let solved = pairwise.solve(&solver, &on_device, &SOURCES, STOP, &mut rows);
            solved.unwrap().iterations
        };
        let whole = iterations();
        monitor.cancel();
        assert!(whole > 1 && iterations() == 1, "{whole}");
    }

    /// A missing barrier between scans is reported, with the names that a host's tools see.
    #[test]
    fn passes_and_images_have_names_while_profiling() {
        let solver = testing::profiling();
        let on_device = solver.upload(&hill()).unwrap();
        let images = Some(PairwiseSchedule::Images);
        let mut pairwise = solver.pairwise(&on_device, Wavefront::Planar, images).unwrap();
        let rows = &mut [0.0; 3 * 600];
        let result = without(is_between_passes, || {
            pairwise.solve(&solver, &on_device, &SOURCES, STOP, rows)
        });
        let Err(VulkanError::Validation(messages)) = result else { panic!("{result:?}") };
        let named = |name: &str| messages.iter().any(|message| message.contains(name));
        assert!(
            named("[geosweep: pairwise_scan") && named("[geosweep: batch of fronts"),
            "{messages:?}"
        );
    }

    #[test]
    fn profiles_leave_no_message_to_the_end() {
        let solver = testing::profiling();
        let log = solver.validation_log().unwrap().clone();
        let on_device = solver.upload(&hill()).unwrap();
        for schedule in PairwiseSchedule::ALL {
            let mut pairwise =
                solver.pairwise(&on_device, Wavefront::Curved, Some(schedule)).unwrap();
            for grain in Grain::ALL {
                let rows = &mut [0.0; 3 * 600];
                let detail = Detail { grain, invocations: true, ..Detail::default() };
                pairwise.profile(&solver, &on_device, &SOURCES, STOP, rows, detail).unwrap();
            }
        }
        drop((on_device, solver));
        assert_eq!(log.messages(), Vec::<String>::new());
    }

    #[test]
    fn all_barriers_in_place_leave_no_message_to_the_end() {
        let solver = solver();
        let log = solver.validation_log().unwrap().clone();
        for surface in [hill(), closed_hill()] {
            let on_device = solver.upload(&surface).unwrap();
            for wavefront in Wavefront::FOR_ANY_SURFACE {
                for schedule in PairwiseSchedule::ALL {
                    let mut pairwise =
                        solver.pairwise(&on_device, wavefront, Some(schedule)).unwrap();
                    let mut rows = [0.0; 3 * 600];
                    pairwise.solve(&solver, &on_device, &SOURCES, STOP, &mut rows).unwrap();
                    let row = &mut rows[..600];
                    pairwise.solve(&solver, &on_device, &SOURCES[..1], STOP, row).unwrap();
                }
            }
        }
        drop(solver);
        assert_eq!(log.messages(), Vec::<String>::new());
    }
}
