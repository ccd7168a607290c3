//! Computes maps on the CPU, and ways back, nearest sources, log maps and signed distances from them, in one
//! call.

use super::arguments::{chart, list, reference, usable};
use super::choices::{EdgeRuleNumber, WavefrontNumber, choose};
use super::frame::{GeosweepSource, check_needed};
use super::points::{Form, GeosweepPoints};
use super::status::{Failure, calls};
use geosweep::geometry::{BackDirections, LogMap, Nearest, signed_distances_by_mask};
use geosweep::surface::{Chart, EdgeLengths, Sources, Surface};
use geosweep::{Engine, Options, Targets, Wavefront, distance_map};

/// Largest number of sources, and of targets, of a map on the CPU.
const MOST_PLACES: usize = 1 << 24;

/// A map on the CPU: its surface, its sources, and the part of it that is needed.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepMapInfo {
    /// Number of rows of grid points.
    pub rows: u32,
    /// Number of columns of grid points.
    pub cols: u32,
    /// Points in the program's memory: `points.data` is not null.
    pub points: GeosweepPoints,
    /// Rule by which edges are measured.
    pub edge_rule: EdgeRuleNumber,
    /// Shape of the wavefront.
    pub wavefront: WavefrontNumber,
    /// Point sources. Their `curvature` is not used.
    pub sources: *const GeosweepSource,
    /// Number of sources; at least 1.
    pub source_count: u32,
    /// Number of targets, or 0 for no targets.
    pub target_count: u32,
    /// Targets, two numbers each: row and column of a grid point. The map ends when the nearest
    /// `targets_needed` of them have their distances. Points that are farther than these targets are not
    /// reached.
    pub targets: *const u32,
    /// Number of targets whose distances are needed, or 0 for all of them.
    pub targets_needed: u32,
    /// Largest distance of the map, or 0 for no limit. Points that are farther are not reached.
    pub radius: f64,
}

/// Arrays to which a map on the CPU is written, row by row. Each may be null.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepMapOutputs {
    /// Distances: a float for each point, `INFINITY` where no source reaches.
    pub distances: *mut f32,
    /// The way back from each point: two floats, the changes of row and column of a step of length 1 in grid
    /// steps. It is 0 at sources and NaN where no source reaches.
    pub back_directions: *mut f32,
    /// The next grid point on the way back: 0 at sources, 1 to 8 for the neighbours clockwise from east, -1
    /// where no source reaches.
    pub back_links: *mut i8,
    /// The index of the nearest source, or -1.
    pub nearest: *mut i32,
    /// The log map: two floats for each point, the direction in which its shortest path leaves the source
    /// times the distance. The first is the component in the direction of increasing columns, the second the
    /// component at a right angle to it, on the side of increasing rows. NaN where no source reaches. The
    /// computation takes nine maps in double precision.
    pub log_map: *mut f32,
    /// Distances that are negative where `inside` is not 0.
    pub signed_distances: *mut f32,
    /// Points inside, for `signed_distances`: a byte for each point, 0 outside.
    pub inside: *const u8,
}

impl GeosweepMapInfo {
    /// Reads the surface.
    ///
    /// # Safety
    /// The arrays have the sizes that the layout requires.
    unsafe fn surface(&self, chart: Chart) -> Result<Surface, Failure> {
        let Form::InProgram(layout, arrays) = Form::of(&self.points, "info->points")? else {
            let reason = "is null: a map on the CPU reads points in the program's memory";
            return Err(Failure::argument("info->points.data", reason));
        };
        let rule = choose(self.edge_rule, "info->edge_rule")?;
        // SAFETY: the caller's promise.
        unsafe { layout.read(arrays, chart, rule, "info->points.") }
    }

    /// Returns the sources and the options.
    ///
    /// # Safety
    /// The arrays have as many entries as their counts say.
    unsafe fn problem(&self) -> Result<(Sources, Options), Failure> {
        let fault = |name: &str, reason: &str| Err(Failure::argument(name, reason));
        // SAFETY: the caller's promise.
        let (given, targets) = unsafe {
            (
                list(self.sources, self.source_count, MOST_PLACES, "info->sources")?,
                list(
                    self.targets,
                    self.target_count.saturating_mul(2),
                    MOST_PLACES,
                    "info->targets",
                )?,
            )
        };
        if given.is_empty() {
            return fault("info->source_count", "is 0: a map has at least one source");
        }
        let mut sources = Sources::default();
        for &GeosweepSource { row, col, time, .. } in given {
            sources = sources.and_point(row.into(), col.into(), time.into());
        }
        let front: Wavefront = choose(self.wavefront, "info->wavefront")?;
        let mut options = Options::default().with_engine(Engine::Cpu).with_wavefront(front);
        if self.radius != 0.0 {
            options = options.with_radius(self.radius);
        }
        check_needed(self.targets_needed, self.target_count, "info->targets_needed")?;
        if !targets.is_empty() {
            let points = targets.chunks_exact(2).map(|at| [at[0] as usize, at[1] as usize]);
            let needed = match self.targets_needed {
                0 => usize::MAX,
                needed => needed as usize,
            };
            options = options.with_targets(Targets::nearest(needed, points));
        }
        Ok((sources, options))
    }
}

impl GeosweepMapOutputs {
    /// Returns an error if nothing is asked for, or an input has no output.
    fn check(&self) -> Result<(), Failure> {
        let wants_floats =
            [self.distances, self.back_directions, self.log_map, self.signed_distances];
        let wants_any = wants_floats.iter().any(|output| !output.is_null())
            || !self.back_links.is_null()
            || !self.nearest.is_null();
        if !wants_any {
            return Err(Failure::argument("outputs", "has no array that is not null"));
        }
        if !self.inside.is_null() && self.signed_distances.is_null() {
            let reason = "is not null, and outputs->signed_distances is";
            return Err(Failure::argument("outputs->inside", reason));
        }
        Ok(())
    }
}

/// Copies values to an array of the program, unless it is null.
///
/// # Safety
/// `to` is null or has room for as many entries as `values`.
unsafe fn put<T: Copy>(to: *mut T, values: &[T], name: &str) -> Result<(), Failure> {
    if to.is_null() {
        return Ok(());
    }
    usable(to, name)?;
    // SAFETY: the caller's promise.
    unsafe { std::ptr::copy_nonoverlapping(values.as_ptr(), to, values.len()) };
    Ok(())
}

calls! {
    /// Computes a map on the CPU, without a solver and a device, and writes what is asked for. The call lasts until
    /// the map is finished. With a radius or targets, only the part of the map that is reached takes time. If the
    /// targets cannot be reached, the map is whole.
    fn geosweep_cpu_map(info: *const GeosweepMapInfo, outputs: *const GeosweepMapOutputs) {
        let (info, to) = (reference(info, "info")?, reference(outputs, "outputs")?);
        to.check()?;
        let chart = chart(info.rows, info.cols)?;
        let (surface, (sources, options)) = (info.surface(chart)?, info.problem()?);
        let map = distance_map(&surface, &sources, &options).map_err(failed)?;
        let edges = || EdgeLengths::<f32>::new(&surface).map_err(failed);
        // All is computed before anything is written, so that a failure leaves the arrays as they were.
        let wants_ways = !to.back_directions.is_null() || !to.back_links.is_null();
        let edges_of_ways = unless(!wants_ways, edges)?;
        let ways = unless(!wants_ways, || {
            let edges = edges_of_ways.as_ref().expect("they were measured above");
            BackDirections::new(&surface, edges, &sources, &map.distances).map_err(failed)
        })?;
        let nearest = unless(to.nearest.is_null(), || {
            Nearest::new(&surface, &edges()?, &sources, &map.distances).map_err(failed)
        })?;
        let log_map = unless(to.log_map.is_null(), || {
            let log_map = LogMap::new(&surface, &sources).map_err(failed)?;
            Ok(log_map.where_reached(&map.distances))
        })?;
        let signed = unless(to.signed_distances.is_null(), || {
            let points = u32::try_from(chart.points()).unwrap_or(u32::MAX);
            let inside = list(to.inside, points, usize::MAX, "outputs->inside")?;
            let inside: Vec<_> = inside.iter().map(|&inside| inside != 0).collect();
            signed_distances_by_mask(chart, &map.distances, &inside).map_err(failed)
        })?;
        put(to.distances, &map.distances, "outputs->distances")?;
        if let Some(ways) = ways {
            let steps = ways.in_chart();
            put(to.back_directions, steps.as_flattened(), "outputs->back_directions")?;
            put(to.back_links, &ways.links(), "outputs->back_links")?;
        }
        if let Some(nearest) = nearest {
            put(to.nearest, &nearest.sources, "outputs->nearest")?;
        }
        if let Some(log_map) = log_map {
            put(to.log_map, log_map.coordinates.as_flattened(), "outputs->log_map")?;
        }
        if let Some(signed) = signed {
            put(to.signed_distances, &signed, "outputs->signed_distances")?;
        }
    }
}

fn failed(error: impl std::fmt::Display) -> Failure {
    Failure::argument("info:", error)
}

/// Computes a value unless nothing asks for it.
fn unless<T>(
    is_unasked: bool,
    compute: impl FnOnce() -> Result<T, Failure>,
) -> Result<Option<T>, Failure> {
    if is_unasked { Ok(None) } else { compute().map(Some) }
}
