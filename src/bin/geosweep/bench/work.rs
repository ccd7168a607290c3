//! What a map takes at least, and how long that takes at the ceilings of a machine.
//!
//! Counted is what a point's update needs by itself, once: what is computed twice at the borders of
//! workgroups, and what caches save, is not.

use geosweep::surface::Seed;
use geosweep::vulkan::plan::{self, Reached, Step};
use geosweep::vulkan::profile::{self, PassRecord};
use geosweep::vulkan::{Schedule, TexelChart, Tuning};
use geosweep::{Wavefront, cpu, vulkan};
use serde::Serialize;

/// Bytes and updates of a map, and the commands that bring them about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Work {
    /// Bytes read and written; unknown for tiles, of which the host does not learn how many were
    /// visited.
    pub bytes: Option<u64>,
    /// Updates from one triangle.
    pub triangles: Option<u64>,
    /// Dispatches, each with its barrier.
    pub dispatches: u64,
    /// Those recorded beyond convergence, which visit nothing.
    pub skipped_dispatches: u64,
    pub submissions: u64,
}

/// The share of a map's time that a part of its work would take at the ceiling, on its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Shares {
    /// Moving the bytes.
    pub data: Option<f64>,
    /// Computing the updates.
    pub arithmetic: Option<f64>,
    /// Empty dispatches and submissions.
    pub dispatches: Option<f64>,
}

impl Work {
    /// Of rotated scans on the CPU: for each visit a point's arrival time read and written, four
    /// lengths of edges; curved fronts have their curvature and the surface's besides.
    pub fn on_cpu((visits, updates): (u64, u64), wavefront: Wavefront) -> Self {
        let bytes = if wavefront == Wavefront::Curved { 36 } else { 24 };
        Self { bytes: Some(bytes * visits), triangles: Some(2 * updates), ..Self::default() }
    }

    /// Of a schedule on a device from some seeds, after so many iterations.
    pub fn on_device(
        schedule: Schedule,
        wavefront: Wavefront,
        texels: TexelChart,
        tuning: Tuning,
        seeds: &[Seed],
        iterations: u32,
    ) -> Self {
        let places = seeds.iter().map(|seed| TexelChart::texel_of(seed.row, seed.col));
        let mut reached = Reached::around(places.map(|(row, col, _)| (row, col)));
        let mut work = Self::default();
        let portions = tuning.portions(wavefront, texels);
        let mut done = 0;
        // What rounds of tiles visit, the host does not learn from the plan.
        let counts = schedule != Schedule::Tiles;
        let (mut bytes, mut triangles) = (0, 0);
        while done < iterations {
            let recording = plan::recording(schedule, texels, portions, reached.take(), u32::MAX);
            work.submissions += 1;
            let passes = profile::planned(&recording, texels, tuning, wavefront);
            let steps = recording.iter().filter(|step| **step != Step::Barrier);
            for (step, PassRecord { work: needed, .. }) in steps.zip(&passes) {
                let settles = matches!(step, Step::Settle { .. } | Step::Count);
                if done < iterations || settles {
                    work.dispatches += 1;
                    bytes += needed.bytes().unwrap_or(0);
                    triangles += needed.triangles.unwrap_or(0);
                } else {
                    work.skipped_dispatches += 1;
                }
                done += u32::from(matches!(step, Step::Count | Step::Tiles { .. }));
            }
        }
        Self { bytes: counts.then_some(bytes), triangles: counts.then_some(triangles), ..work }
    }
}

impl Shares {
    pub fn on_cpu(
        work: Work,
        seconds: f64,
        wavefront: Wavefront,
        ceilings: &cpu::Ceilings,
    ) -> Self {
        let rates = [ceilings.copy, ceilings.triangles[wavefront as usize]];
        Self { dispatches: None, ..Self::at(work, seconds, rates) }
    }

    pub fn on_device(
        work: Work,
        seconds: f64,
        wavefront: Wavefront,
        ceilings: &vulkan::Ceilings,
    ) -> Self {
        let vulkan::Ceilings { dispatch, skipped_dispatch, submission, .. } = *ceilings;
        let commands = work.dispatches as f64 * dispatch.as_secs_f64()
            + work.skipped_dispatches as f64 * skipped_dispatch.as_secs_f64()
            + work.submissions as f64 * submission.as_secs_f64();
        let rates = [ceilings.copy, ceilings.triangles[wavefront as usize]];
        Self { dispatches: Some(commands / seconds), ..Self::at(work, seconds, rates) }
    }

    fn at(work: Work, seconds: f64, [copy, triangles]: [f64; 2]) -> Self {
        let share = |count: Option<u64>, rate| count.map(|count| count as f64 / rate / seconds);
        Self {
            data: share(work.bytes, copy),
            arithmetic: share(work.triangles, triangles),
            dispatches: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use geosweep::surface::Chart;

    use super::*;

    fn work(schedule: Schedule, iterations: u32) -> Work {
        let texels = TexelChart::new(Chart { rows: 64, cols: 64 }).unwrap();
        let tuning = Tuning { scan_width: 64, scan_lines: 4, tile: 16, inner: 4 };
        let seeds = [Seed { row: 0, col: 0, time: 0.0, curvature: 0.0 }];
        Work::on_device(schedule, Wavefront::Planar, texels, tuning, &seeds, iterations)
    }

    #[test]
    fn whole_iterations_visit_every_texel_four_times_or_twice() {
        // 32 lines of texels in blocks of four, four scans and the count.
        let (one, two) = (work(Schedule::Raster, 1), work(Schedule::Raster, 2));
        assert_eq!(one.dispatches + one.skipped_dispatches, 4 * (4 * 8) + 4);
        assert_eq!(two.dispatches - one.dispatches, 4 * 8);
        assert_eq!(two.bytes.unwrap() - one.bytes.unwrap(), 4 * 32 * 32 * 96);
        assert!(one.bytes.unwrap() < 4 * 32 * 32 * 96, "the first scan sees half of it");
        let all_points = work(Schedule::AllPoints, 33);
        assert_eq!(all_points.triangles, Some(33 * 2 * 32 * 32 * 32));
        // Two recordings of 32 iterations.
        assert_eq!((all_points.submissions, all_points.dispatches), (2, 33 * 2 + 64));
        assert_eq!(all_points.skipped_dispatches, 31 * 2);
    }

    #[test]
    fn rounds_of_tiles_are_dispatches() {
        let tiles = work(Schedule::Tiles, 5);
        assert_eq!((tiles.bytes, tiles.dispatches, tiles.skipped_dispatches), (None, 5 + 1, 3));
    }

    #[test]
    fn shares_are_times_at_the_ceiling() {
        let work = Work::on_cpu((1000, 250), Wavefront::Planar);
        let ceilings = cpu::Ceilings { threads: 1, copy: 24e3, triangles: [1e3, 1.0, 1.0] };
        let shares = Shares::on_cpu(work, 4.0, Wavefront::Planar, &ceilings);
        assert_eq!((shares.data, shares.arithmetic), (Some(0.25), Some(0.125)));
    }
}
