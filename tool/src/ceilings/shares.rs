//! Estimates the least work of a map, and how long it takes at the peak rates of a machine.
//!
//! The estimate counts the data and computation of each point's update once. It ignores repeated work at the borders of
//! workgroups, and savings by caches.

use geosweep::vulkan::profile::{PassRecord, SolveProfile, SubmissionRecord};
use geosweep::{Wavefront, cpu, vulkan};
use serde::Serialize;

/// The bytes and updates of a map, and the commands that perform them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Work {
    /// The number of bytes read and written.
    pub bytes: Option<u64>,
    /// The number of updates from one triangle. It is unknown for tiles, which do not report their
    /// iterations.
    pub triangles: Option<u64>,
    /// The number of dispatches, each with its barrier.
    pub dispatches: u64,
    /// The number of dispatches that visit nothing, since the map has converged or nothing can change.
    pub skipped_dispatches: u64,
    pub submissions: u64,
}

/// The time that each part of a map's work would take alone at the peak rate, as a fraction of the map's
/// time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Shares {
    /// The share of moving the bytes.
    pub data: Option<f64>,
    /// The share of computing the updates.
    pub arithmetic: Option<f64>,
    /// The share of the dispatches and submissions alone, as if they were empty.
    pub dispatches: Option<f64>,
}

impl Work {
    /// Estimates the work of rotated scans on the CPU.
    ///
    /// Each visit reads and writes the arrival time of a point, and reads four edge lengths. Curved fronts
    /// also access their own curvature and that of the surface. Anchored fronts access the anchor and the
    /// hole flags instead of edges.
    pub fn on_cpu((visits, updates): (u64, u64), wavefront: Wavefront) -> Self {
        let bytes = match wavefront {
            Wavefront::Planar | Wavefront::Circular => 24,
            Wavefront::Curved => 36,
            Wavefront::Rays => 60,
            Wavefront::Anchored => 20,
        };
        Self { bytes: Some(bytes * visits), triangles: Some(2 * updates), ..Self::default() }
    }

    /// Sums the work of a map on a device, from a profile of every dispatch.
    pub fn on_device(profile: &SolveProfile) -> Self {
        let is_step = |pass: &&PassRecord| pass.kind.is_step();
        let steps: Vec<_> = profile.passes().filter(is_step).collect();
        let idle = steps.iter().filter(|pass| pass.is_idle()).count();
        let has_steps = |found: &&SubmissionRecord| found.passes.iter().any(|pass| is_step(&pass));
        // Only passes that visit texels update them.
        let updates = steps.iter().filter(|pass| pass.area.is_some());
        Self {
            bytes: steps.iter().map(|pass| pass.work.bytes()).sum(),
            triangles: updates.map(|pass| pass.work.triangles).sum(),
            dispatches: (steps.len() - idle) as u64,
            skipped_dispatches: idle as u64,
            submissions: profile.submissions.iter().filter(has_steps).count() as u64,
        }
    }
}

/// Returns the peak rate of a wavefront's updates. Anchored fronts are not updated from triangles and have
/// none.
fn rate_of(wavefront: Wavefront, triangles: [f64; 3]) -> Option<f64> {
    triangles.get(wavefront as usize).copied()
}

impl Shares {
    pub fn on_cpu(
        work: Work,
        seconds: f64,
        wavefront: Wavefront,
        ceilings: &cpu::CpuCeilings,
    ) -> Self {
        let triangles = rate_of(wavefront, ceilings.triangles);
        Self { dispatches: None, ..Self::at(work, seconds, ceilings.copy, triangles) }
    }

    pub fn on_device(
        work: Work,
        seconds: f64,
        wavefront: Wavefront,
        ceilings: &vulkan::DeviceCeilings,
    ) -> Self {
        let vulkan::DeviceCeilings { dispatch, skipped_dispatch, submission, .. } = *ceilings;
        let commands = work.dispatches as f64 * dispatch.as_secs_f64()
            + work.skipped_dispatches as f64 * skipped_dispatch.as_secs_f64()
            + work.submissions as f64 * submission.as_secs_f64();
        let triangles = rate_of(wavefront, ceilings.triangles);
        let dispatches = Some(commands / seconds);
        Self { dispatches, ..Self::at(work, seconds, ceilings.copy, triangles) }
    }

    fn at(work: Work, seconds: f64, copy: f64, triangles: Option<f64>) -> Self {
        let share = |count: Option<u64>, rate| count.map(|count| count as f64 / rate / seconds);
        Self {
            data: share(work.bytes, copy),
            arithmetic: triangles.and_then(|rate| share(work.triangles, rate)),
            dispatches: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use geosweep::surface::Chart;
    use geosweep::vulkan::profile::PassKind;
    use geosweep::vulkan::{Schedule, TexelChart, Tuning, planned};

    use super::*;

    /// Returns the work of a map of two planned recordings, and of a submission without counted passes.
    fn work(schedule: Schedule) -> Work {
        let texels = TexelChart::new(Chart { rows: 64, cols: 64 }).unwrap();
        let tuning = Tuning::ON_CPU;
        let portions = tuning.portions(Wavefront::Planar, texels);
        let steps = schedule.plan(texels, portions, None, 2);
        let mut passes = planned(&steps, texels, tuning, Wavefront::Planar);
        let mut submission = |more: Option<PassKind>| {
            passes.extend(more.map(|kind| PassRecord { kind, ..passes[0] }));
            let (submitted, ended) = Default::default();
            let (begin, nanoseconds, lead) = Default::default();
            let (passes, tiles) = (passes.clone(), Vec::new());
            SubmissionRecord { submitted, ended, begin, nanoseconds, lead, passes, tiles }
        };
        let first = submission(None);
        let mut second = submission(Some(PassKind::Outcome));
        // A block of lines in which nothing was due.
        second.passes[0].groups = Some([0, 1, 1]);
        let empty = SubmissionRecord { passes: Vec::new(), ..first.clone() };
        let submissions = vec![first, second, empty];
        Work::on_device(&SolveProfile { submissions, time: Default::default() })
    }

    #[test]
    fn dispatches_are_counted() {
        // Two recordings of two iterations each: an iteration has four scans, each of which takes 32 lines of
        // texels in turn, and a count.
        let raster = work(Schedule::Raster);
        assert_eq!((raster.dispatches, raster.skipped_dispatches), (4 * (4 + 1) - 1, 1));
        let bytes = 2 * 2 * (4 * 32 * 32 * 96 + 28 + 20);
        assert_eq!((raster.submissions, raster.bytes), (2, Some(bytes)));
        assert_eq!(raster.triangles, Some(2 * 2 * 4 * 32 * 32 * 8));
    }

    #[test]
    fn shares_are_times_at_the_ceiling() {
        let work = Work::on_cpu((1000, 250), Wavefront::Planar);
        let ceilings = cpu::CpuCeilings { threads: 1, copy: 24e3, triangles: [1e3, 1.0, 1.0] };
        let shares = Shares::on_cpu(work, 4.0, Wavefront::Planar, &ceilings);
        assert_eq!((shares.data, shares.arithmetic), (Some(0.25), Some(0.125)));
        let work = Work::on_cpu((1200, 250), Wavefront::Anchored);
        let shares = Shares::on_cpu(work, 4.0, Wavefront::Anchored, &ceilings);
        assert_eq!((shares.data, shares.arithmetic), (Some(0.25), None));
    }
}
