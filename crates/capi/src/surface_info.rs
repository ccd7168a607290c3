//! Parameters of a surface.

use std::borrow::Cow;
use std::ffi::{CStr, c_char};

use ash::vk;

use super::arguments::{chart, list};
use super::choices::{EdgeRuleNumber, GeosweepGluing, GluingNumber, choose};
use super::points::{Form, GeosweepPoints};
use super::shared::{Shared, same_fields};
use super::status::Failure;
use geosweep::surface::{Chart, Direction, EdgeRule, Gluing, Run};
use geosweep::vulkan::embed;

/// Largest number of entries in an array that describes a surface.
const MOST: usize = 1024;
/// Largest number of pairs of runs.
const MOST_RUNS: usize = 1 << 20;
/// Largest number of slots.
const MOST_SLOTS: u32 = 64;

/// A buffer of sources, each a `GeosweepSource`, that your shaders write. An entry is skipped if it is off
/// the grid or in a hole, or if its time is NaN or not below 1e30. Write NaN for an unused entry.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepSourceBuffer {
    /// Buffer with usage `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`.
    pub buffer: vk::Buffer,
    /// Offset of the first source in bytes; a multiple of 4.
    pub offset: u64,
    /// Number of sources.
    pub count: u32,
}

/// Buffers for looking up distances: places are read, and distances are written. Both have usage
/// `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepLookup {
    /// Buffer with two floats per place: row and column, with fractions between grid points.
    pub places: vk::Buffer,
    /// Offset of the first place in bytes; a multiple of 4.
    pub places_offset: u64,
    /// Buffer with one float per place.
    pub distances: vk::Buffer,
    /// Offset of the first distance in bytes; a multiple of 4.
    pub distances_offset: u64,
    /// Number of places.
    pub count: u32,
}

/// Your own image for the distances of a slot, in place of one that the surface allocates. A render graph may
/// use its memory for other resources between frames. The image is 2D with `VK_FORMAT_R32_SFLOAT` and at
/// least cols x rows texels and one array layer; its usage contains `VK_IMAGE_USAGE_STORAGE_BIT` and what its
/// readers need. The old content of the image is discarded, whatever its layout. `GeosweepFrame::before`, or
/// a barrier of yours, must wait for earlier uses of the memory. Slots may share an image, and so may
/// surfaces that are recorded one after another. For directions and log maps, `geosweep_directions_create`
/// and `geosweep_log_map_create` name the format and the usage.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepHostImage {
    /// The image.
    pub image: vk::Image,
    /// A 2D view of the image's first mip level.
    pub view: vk::ImageView,
}

/// Grid points along a line.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepRun {
    /// Row of the first point.
    pub row: u32,
    /// Column of the first point.
    pub col: u32,
    /// Rows from point to point: -1, 0 or 1.
    pub row_step: i32,
    /// Columns from point to point: -1, 0 or 1. It is not 0 if `row_step` is 0.
    pub col_step: i32,
}

/// Two runs of points that coincide pair by pair.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepRunPair {
    /// One run.
    pub first: GeosweepRun,
    /// The other run.
    pub second: GeosweepRun,
    /// Number of points of each run.
    pub points: u32,
}

/// Parameters of a surface. The images and buffers remain yours, and they must be alive whenever a recording
/// that uses them runs. The arrays are not needed after the call, and may be null where their count is 0.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepSurfaceInfo {
    /// Number of rows of grid points.
    pub rows: u32,
    /// Number of columns of grid points.
    pub cols: u32,
    /// Rule by which edges are measured.
    pub edge_rule: EdgeRuleNumber,
    /// Number of images of distances, which recordings write in turn: the number of frames in flight, from 1
    /// to 64.
    pub slots: u32,
    /// Queue families that use the images of distances and the packed distances: the family of the queue to
    /// which you submit recordings, and the families of the readers. If this lists different families, no
    /// ownership transfers are needed. If it is empty, other families need ownership transfers.
    pub queue_families: *const u32,
    /// Number of queue families.
    pub queue_family_count: u32,
    /// Your own images for the distances, one per slot; null for images that the surface allocates.
    pub results: *const GeosweepHostImage,
    /// Number of entries in `results`: 0 or the number of slots.
    pub result_count: u32,
    /// Points that recordings select by number, for instance one entry for each frame in flight.
    pub points: *const GeosweepPoints,
    /// Number of entries in `points`.
    pub point_count: u32,
    /// Source buffers that recordings select by number.
    pub sources: *const GeosweepSourceBuffer,
    /// Number of entries in `sources`.
    pub source_count: u32,
    /// Buffers for lookups, which recordings select by number.
    pub lookups: *const GeosweepLookup,
    /// Number of entries in `lookups`.
    pub lookup_count: u32,
    /// Sides of the grid that coincide, so that distances pass from one to the other. Copies of a point take
    /// the values of the first copy, and are holes if any copy is a hole. `GeosweepOutcome::seam_gap` says how
    /// far copies lie apart. Plans for a glued surface need `GeosweepMethod::over_seams`.
    pub gluing: GluingNumber,
    /// Points that coincide, for `GEOSWEEP_GLUING_RUNS`.
    pub runs: *const GeosweepRunPair,
    /// Number of entries in `runs`.
    pub run_count: u32,
    /// Whether cells may be so skewed that fronts arrive from points more than six rows or columns away. Updates then look
    /// for points up to 16 away, which resolves axes of the metric with a ratio of 30 instead of 10.
    /// `GeosweepOutcome::unresolved_distance` says whether it is enough. The sides of such a grid cannot be glued.
    pub has_skewed_cells: bool,
    /// Name of the surface in labels and names of objects, for debugging tools and the validation layers; null for
    /// "surface" and a number. The text is UTF-8, and is not needed after the call.
    pub name: *const c_char,
}

same_fields! {
    GeosweepHostImage => embed::HostImage { image, view };
    GeosweepSourceBuffer => embed::SourceBuffer { buffer, offset, count };
    GeosweepLookup => embed::Lookup { places, places_offset, distances, distances_offset, count };
}

/// Parameters of a surface, checked.
pub(super) struct Wanted<'a> {
    pub(super) chart: Chart,
    pub(super) edge_rule: EdgeRule,
    slots: usize,
    families: &'a [u32],
    results: Vec<embed::HostImage>,
    pub(super) points: Vec<Form>,
    sources: Vec<embed::SourceBuffer>,
    lookups: Vec<embed::Lookup>,
    gluing: Option<Gluing>,
    has_skewed_cells: bool,
    name: Option<Cow<'a, str>>,
}

impl<'a> Wanted<'a> {
    /// Checks the parameters of a surface.
    ///
    /// # Safety
    /// The arrays have as many entries as their counts say.
    pub(super) unsafe fn new(info: &'a GeosweepSurfaceInfo) -> Result<Self, Failure> {
        let GeosweepSurfaceInfo { rows, cols, slots, .. } = *info;
        if !(1..=MOST_SLOTS).contains(&slots) {
            let reason = format!(
                "is {slots}, but must be the number of frames in flight, from 1 to {MOST_SLOTS}"
            );
            return Err(Failure::argument("info->slots", reason));
        }
        // SAFETY: the caller's promise.
        let (families, results, points, sources, lookups) = unsafe {
            let families = info.queue_families;
            (
                list(families, info.queue_family_count, MOST, "info->queue_families")?,
                list(info.results, info.result_count, MOST, "info->results")?,
                list(info.points, info.point_count, MOST, "info->points")?,
                list(info.sources, info.source_count, MOST, "info->sources")?,
                list(info.lookups, info.lookup_count, MOST, "info->lookups")?,
            )
        };
        let form = |(index, points)| Form::of(points, &name(index));
        Ok(Self {
            chart: chart(rows, cols)?,
            edge_rule: choose(info.edge_rule, "info->edge_rule")?,
            slots: slots as usize,
            families,
            results: results.iter().map(|&image| image.into()).collect(),
            points: points.iter().enumerate().map(form).collect::<Result<_, _>>()?,
            sources: sources.iter().map(|&sources| sources.into()).collect(),
            lookups: lookups.iter().map(|&lookup| lookup.into()).collect(),
            // SAFETY: the caller's promise.
            gluing: unsafe { gluing_of(info) }?,
            has_skewed_cells: info.has_skewed_cells,
            // SAFETY: the text ends with a zero.
            name: (!info.name.is_null())
                .then(|| unsafe { CStr::from_ptr(info.name) }.to_string_lossy()),
        })
    }

    pub(super) fn info(&'a self, points: &'a [embed::Points]) -> embed::SurfaceInfo<'a> {
        embed::SurfaceInfo::new(self.chart)
            .with_edge_rule(self.edge_rule)
            .with_slots(self.slots)
            .with_queue_families(self.families)
            .with_results(&self.results)
            .with_points(points)
            .with_sources(&self.sources)
            .with_lookups(&self.lookups)
            .with_gluing(&self.gluing)
            .with_skewed_cells(self.has_skewed_cells)
            .with_name(self.name.as_deref())
    }

    /// Returns an error if the physical device has no queue family with one of the numbers.
    fn check_families(&self, shared: &Shared) -> Result<(), Failure> {
        let Shared { instance, physical_device, .. } = shared;
        // SAFETY: the physical device is from this instance.
        let families =
            unsafe { instance.get_physical_device_queue_family_properties(*physical_device) };
        let count = families.len();
        match self.families.iter().find(|&&family| family as usize >= count) {
            Some(family) => {
                let reason = format!("has {family}, and the device has {count} families");
                Err(Failure::argument("info->queue_families", reason))
            }
            None => Ok(()),
        }
    }

    pub(super) fn bytes(&self, shared: &Shared) -> Result<u64, Failure> {
        self.check_families(shared)?;
        let mut bytes = shared.solver.bytes_for(&shared.device, &self.info(&[]))?;
        for form in &self.points {
            if let Form::InProgram(layout, _) = form {
                bytes += layout.buffer(self.chart).bytes(&shared.device)?;
            }
        }
        Ok(bytes)
    }
}

/// Returns the gluing of a surface, if it has one.
///
/// # Safety
/// There are as many runs as their count says.
unsafe fn gluing_of(info: &GeosweepSurfaceInfo) -> Result<Option<Gluing>, Failure> {
    // SAFETY: the caller's promise.
    let runs = unsafe { list(info.runs, info.run_count, MOST_RUNS, "info->runs") }?;
    let chosen = choose(info.gluing, "info->gluing")?;
    if !runs.is_empty() && !matches!(chosen, GeosweepGluing::Runs) {
        let reason =
            "is not 0: runs are for the gluing GEOSWEEP_GLUING_RUNS, and info->gluing is another";
        return Err(Failure::argument("info->run_count", reason));
    }
    let gluing = match chosen {
        GeosweepGluing::None => return Ok(None),
        GeosweepGluing::Columns => Gluing::columns(),
        GeosweepGluing::Rows => Gluing::rows(),
        GeosweepGluing::Both => Gluing::both(),
        GeosweepGluing::FlippedColumns => Gluing::flipped_columns(),
        GeosweepGluing::FlippedRows => Gluing::flipped_rows(),
        GeosweepGluing::Globe => Gluing::globe(),
        GeosweepGluing::Octahedral => Gluing::Octahedral,
        GeosweepGluing::Runs => {
            let pair = |(index, pair): (usize, &GeosweepRunPair)| {
                let GeosweepRunPair { first, second, points } = *pair;
                let name = format!("info->runs[{index}]");
                Ok([run(first, points, &name)?, run(second, points, &name)?])
            };
            let pairs = runs.iter().enumerate().map(pair);
            Gluing::Runs(pairs.collect::<Result<_, Failure>>()?)
        }
    };
    Ok(Some(gluing))
}

fn run(given: GeosweepRun, points: u32, name: &str) -> Result<Run, Failure> {
    let GeosweepRun { row, col, row_step, col_step } = given;
    let is_step = |to: &Direction| to.step() == (row_step as isize, col_step as isize);
    let to = Direction::ALL.into_iter().find(is_step).ok_or_else(|| {
        let reason = format!("has the step {row_step}, {col_step}, which leads to no neighbour");
        Failure::argument(name, reason)
    })?;
    Ok(Run { from: (row as usize, col as usize), to, points: points as usize })
}

/// Returns the name by which error messages refer to an entry of `GeosweepSurfaceInfo::points`.
pub(super) fn name(index: usize) -> String {
    format!("info->points[{index}]")
}
