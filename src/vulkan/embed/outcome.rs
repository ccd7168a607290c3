//! Reads the outcome of a recording from its record.

use crate::constants::NEVER_MEASURED;
use crate::surface::{Chart, Resolution, Unresolved};
use crate::vulkan::schedules::progress::{Record, offset};

/// Outcome of the iterations of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Number of iterations, or of rounds of tiles, since the start of the map.
    pub iterations: u32,
    /// Largest relative change of a front in the last iteration.
    pub residual: f64,
    /// Number of visits since the start of the map, each by one workgroup: to a tile, or to the part of a block
    /// of lines that a workgroup updates. A smaller radius takes fewer visits.
    pub visits: u32,
    /// Whether the map has converged, over edges that were measured. If it has not,
    /// [`super::Recording::resume`] continues it.
    pub converged: bool,
    /// Whether the surface's edges have been measured on the device. They have not if the recording that
    /// measures them has never run.
    pub measured: bool,
    /// Number of grid points that are holes. A point is a hole if one of its values is not finite or too
    /// large, if it lies outside an image that is too small, or if its slowness is negative.
    pub holes: u32,
    /// Number of edges without a length between points that are not holes. The measured length of such an
    /// edge is 0, as between points at the same place, or too large. A pole or a seam has a number of such
    /// edges, which the host knows. A larger number means that vertices were zeroed or not written yet.
    pub edges_without_length: u32,
    /// Number of the map's sources that reach no point: those off the grid, in holes, or with a time that is
    /// NaN or not below 1e30. Unused entries of a buffer count.
    pub passed_over: u32,
    /// Largest gap between copies of a point of a glued surface, relative to the longest edge at these copies; 0 if the
    /// surface is not glued. It is rounded down by up to a sixteenth. A gap above a twentieth usually means that
    /// other sides are glued than those that coincide, or that one side runs in the reverse order. For a metric it
    /// is the difference between entries, relative to the larger diagonal entry.
    pub seam_gap: f64,
    /// Resolution of the surface by the grid, for the points that were measured last.
    /// [`crate::Surface::resolution`] is the same on the CPU. It is `None` for a metric, or if the grid is too
    /// small to tell.
    pub resolution: Option<Resolution>,
    /// Place whose cells are skewed most, of some thousands that were looked at, if that is too much for updates: then
    /// fronts may be late around it. [`super::SurfaceInfo::has_skewed_cells`] lets updates look farther. If that is set already,
    /// the grid has to follow the direction in which lengths are short. [`crate::Surface::unresolved`] is the same on the
    /// CPU.
    pub unresolved: Option<Unresolved>,
}

impl Outcome {
    /// Size in bytes of the record that [`super::Recording::outcome_to`] copies.
    pub const BYTES: usize = offset::SERIAL_IN_RECORD as usize;

    /// Returns the outcome in the record of a surface with this grid. Updates look for points up to `seen` rows and columns
    /// away.
    pub(super) fn of(record: &Record, chart: Chart, seen: usize) -> Self {
        let Record { outcome, holes, no_length, passed_over, .. } = *record;
        let Record { sharp, compared, continued, turns, .. } = *record;
        let measured = holes != NEVER_MEASURED;
        let resolution = Resolution::counted(sharp, compared, continued, turns);
        let unresolved = Unresolved::found_by_device(chart, record.skew, seen);
        Self {
            iterations: outcome.iterations,
            residual: outcome.residual(),
            visits: outcome.visited,
            converged: outcome.has_converged() && measured,
            measured,
            holes: if measured { holes } else { 0 },
            edges_without_length: if measured { no_length } else { 0 },
            passed_over,
            seam_gap: if measured { record.seam_gap().0.into() } else { 0.0 },
            resolution: resolution.filter(|_| measured),
            unresolved: unresolved.filter(|_| measured),
        }
    }
}
