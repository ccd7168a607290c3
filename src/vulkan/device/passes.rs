//! Contains the table of passes.

use std::marker::PhantomData;

use bytemuck::Pod;

use super::shaders;
use super::shaders::{Constant, Shader};
use crate::surface::constants::{FARTHEST_SPLIT, SPLIT_REACH};
use crate::update::Wavefront;
use crate::vulkan::schedules::plan::Scan;
use crate::vulkan::schedules::plan::Scan::{Down, Left, Right, Up};
use crate::vulkan::{TileLanes, Tuning};

/// Row of the table.
#[derive(Debug)]
pub(crate) struct Row {
    /// Shader, with its bindings, specialization constants and push constants.
    pub(crate) shader: &'static Shader,
    /// Whether each wavefront has a pipeline of its own.
    pub(crate) depends_on_wavefront: bool,
    /// Width of the workgroups, if a constant sets it.
    width: Option<Width>,
    /// Scan that the pass runs, if it is one.
    scan: Option<Scan>,
    /// Shaders that replace `shader` with [`TileLanes::Points`] and with [`TileLanes::Shuffled`]. All three
    /// have the same interface.
    pub(crate) of_points: Option<[&'static Shader; 2]>,
}

/// Width of a workgroup in invocations.
#[derive(Clone, Copy, Debug)]
enum Width {
    /// [`Tuning::scan_width`].
    Scans,
    /// One invocation for each texel or point on a side of a tile.
    Tiles,
    /// [`MapSize::invocations`].
    Maps,
}

impl Row {
    const fn new(shader: &'static Shader, width: Option<Width>, scan: Option<Scan>) -> Self {
        assert!(
            shader.depends_on(Constant::LocalSizeX) == width.is_some(),
            "the row of a shader with a constant for the width of its workgroups says the width"
        );
        let depends_on_wavefront = shader.depends_on(Constant::Wavefront);
        Self { shader, depends_on_wavefront, width, scan, of_points: None }
    }

    const fn of_points(self, points: &'static Shader, shuffled: &'static Shader) -> Self {
        assert!(
            points.is_like(self.shader) && shuffled.is_like(self.shader),
            "one shader can be dispatched in the place of another"
        );
        Self { of_points: Some([points, shuffled]), ..self }
    }

    /// Returns the shader from which a pipeline is made.
    pub(crate) fn shader_of(&self, tuning: &Tuning) -> &'static Shader {
        match (self.of_points, tuning.tile_lanes) {
            (None, _) | (_, TileLanes::Pairs) => self.shader,
            (Some([points, _]), TileLanes::Points) => points,
            (Some([_, shuffled]), TileLanes::Shuffled) => shuffled,
        }
    }
}

/// Pass whose push constants are of type `P`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pass<P> {
    number: usize,
    constants: PhantomData<fn(P)>,
}

impl<P: Pod> Pass<P> {
    const fn new(number: usize) -> Self {
        Self { number, constants: PhantomData }
    }

    /// Returns the number of the pass in the [`TABLE`].
    pub(crate) const fn number(self) -> usize {
        self.number
    }

    pub(crate) fn row(self) -> &'static Row {
        &TABLE[self.number]
    }
}

/// Pass for every surface and wavefront. A solver has its pipeline from the start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CommonPass<P>(Pass<P>);

impl<P: Pod> CommonPass<P> {
    /// Returns the pass as a [`Pass`], as for passes that are not common.
    pub(crate) const fn pass(self) -> Pass<P> {
        self.0
    }

    pub(crate) const fn number(self) -> usize {
        self.0.number
    }
}

macro_rules! passes {
    (@width) => { None };
    (@width $width:ident) => { Some(Width::$width) };
    (@scan) => { None };
    (@scan $scan:ident) => { Some($scan) };
    (@row $row:expr) => { $row };
    (@row $row:expr, $points:ident, $shuffled:ident) => {
        $row.of_points(&shaders::$points::SHADER, &shaders::$shuffled::SHADER)
    };
    (
        common { $($common:ident: $common_shader:ident;)* }
        others { $($name:ident: $shader:ident $(or $points:ident or $shuffled:ident)? $(, $width:ident $($scan:ident)?)?;)* }
    ) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Number { $($common,)* $($name),* }

        $(pub(crate) const $common: CommonPass<shaders::$common_shader::Push> = {
            assert!(!shaders::$common_shader::SHADER.depends_on(Constant::Wavefront));
            CommonPass(Pass::new(Number::$common as usize))
        };)*
        $(pub(crate) const $name: Pass<shaders::$shader::Push> =
            Pass::new(Number::$name as usize);)*

        /// Numbers of the common passes.
        pub(crate) const COMMON: &[usize] = &[$($common.number()),*];

        /// All passes.
        pub(crate) static TABLE: [Row; [$(Number::$common,)* $(Number::$name),*].len()] = [
            $(Row::new(&shaders::$common_shader::SHADER, None, None),)*
            $(passes!(@row Row::new(&shaders::$shader::SHADER, passes!(@width $($width)?), passes!(@scan $($($scan)?)?)) $(, $points, $shuffled)?)),*
        ];

        /// Size of the largest block of push constants, in bytes. Every device offers 128 bytes.
        pub(crate) const PUSH_CONSTANT_BYTES: u32 = largest(&[
            $(shaders::$common_shader::SHADER.push_constant_bytes,)*
            $(shaders::$shader::SHADER.push_constant_bytes),*
        ]);
    };
}

// The columns are the name of a pass, its shader (and the shaders of [`Row::of_points`]), and the width of
// its workgroups if a constant sets it, with the direction of a scan.
passes! {
    common {
        POINTS_FROM_BUFFER: points_from_buffer;
        POINTS_FROM_IMAGE: points_from_image;
        EDGES_FROM_POSITIONS: edges_from_positions;
        EDGES_FROM_HEIGHTS: edges_from_heights;
        EDGES_FROM_METRIC: edges_from_metric;
        TYPICAL_EDGE: typical_edge;
        FAN_CURVATURE: fan_curvature;
        GAUSSIAN_CURVATURE: gaussian_curvature;
        SOURCES: sources;
        SEED: seed;
        MERGE_SURROUNDINGS: merge_surroundings;
        SETTLE: settle;
        COUNT: progress;
        TARGETS: targets;
        TRIM: trim;
        RESULT: result;
        UNPACK: unpack;
        LOOKUP: lookup;
    }
    others {
        SURROUNDINGS: surroundings;
        SCAN_DOWN: scan, Scans Down;
        SCAN_UP: scan, Scans Up;
        SCAN_RIGHT: scan, Scans Right;
        SCAN_LEFT: scan, Scans Left;
        EXCHANGE: exchange;
        GLUED_POINTS_FROM_BUFFER: glued_points_from_buffer;
        GLUED_POINTS_FROM_IMAGE: glued_points_from_image;
        SHARE_CURVATURE: share_curvature;
        TILES: tiles or tiles_points or tiles_shuffled, Tiles;
        CONTOUR_COUNTS: contour_counts;
        CONTOUR_OFFSETS: contour_offsets;
        CONTOUR_SEGMENTS: contour_segments;
        PATH_STARTS: path_starts;
        PATHS: paths;
        PATH_DOUBLES: path_doubles;
        PATH_SLIDES: path_slides;
        PATH_LENGTHS: path_lengths;
        LIFT_FROM_BUFFER: lift_from_buffer;
        LIFT_FROM_IMAGE: lift_from_image;
        REGION_STARTS: region_starts;
        REGION_WAYS: region_ways;
        REGION_FLOW: region_flow;
        REGION_COPIES: region_copies;
        REGION_LABELS: region_labels;
        SHARE_STARTS: share_starts;
        WAY_STARTS: way_starts;
        DIRECTIONS: directions;
        LOG_MAP_WAYS: log_map_ways;
        LOG_MAP_STEPS: log_map_steps;
        LOG_MAP_ROUNDS: log_map_rounds;
        PAIRWISE_FANS: pairwise_fans;
        PAIRWISE_SHARED: pairwise_shared, Maps;
        PAIRWISE_START: pairwise_start;
        PAIRWISE_SCAN_DOWN: pairwise_scan, Scans Down;
        PAIRWISE_SCAN_UP: pairwise_scan, Scans Up;
        PAIRWISE_SCAN_RIGHT: pairwise_scan, Scans Right;
        PAIRWISE_SCAN_LEFT: pairwise_scan, Scans Left;
        PAIRWISE_EXCHANGE: pairwise_exchange;
        PAIRWISE_COUNT: pairwise_count;
        CEILING_COPY: ceiling_copy;
        CEILING_UPDATES: ceiling_updates;
    }
}

/// Passes of the scans, in the order of [`Scan::ALL`].
pub(crate) const SCANS: [Pass<shaders::scan::Push>; 4] =
    [SCAN_DOWN, SCAN_UP, SCAN_RIGHT, SCAN_LEFT];
/// Passes of the scans over the maps of a batch, in the same order.
pub(crate) const PAIRWISE_SCANS: [Pass<shaders::pairwise_scan::Push>; 4] =
    [PAIRWISE_SCAN_DOWN, PAIRWISE_SCAN_UP, PAIRWISE_SCAN_RIGHT, PAIRWISE_SCAN_LEFT];

const fn largest(sizes: &[u32]) -> u32 {
    let (mut largest, mut place) = (0, 0);
    while place < sizes.len() {
        if sizes[place] > largest {
            largest = sizes[place];
        }
        place += 1;
    }
    largest
}

/// Values by which pipelines are specialized.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Specialization {
    pub(crate) tuning: Tuning,
    pub(crate) on_processor: bool,
    pub(crate) variant: Variant,
    pub(crate) map: MapSize,
    /// See [`Pipelines::group_order`](super::pipelines::Pipelines::group_order).
    pub(crate) group_order: i32,
}

/// Properties of a map that determine its pipelines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Variant {
    pub(crate) wavefront: Wavefront,
    pub(crate) splits: Splits,
    /// Whether the slowness of the surface is not the same everywhere.
    pub(crate) slowed: bool,
    /// Whether tiles have the size for small grids.
    pub(crate) small_tiles: bool,
    /// Whether passes over a finished map look for copies of points.
    pub(crate) glued: bool,
}

/// The distance up to which points split obtuse triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Splits {
    /// There are no obtuse triangles. This is said only of surfaces that are known to have none.
    None,
    /// Up to [`SPLIT_REACH`] rows and columns away.
    Near,
    /// Up to [`FARTHEST_SPLIT`] rows and columns away.
    Far,
}

impl Splits {
    const ALL: [Self; 3] = [Self::None, Self::Near, Self::Far];

    /// Returns the kind for the distance of [`geosweep_surface::EdgeLengths::reach`].
    pub(crate) fn within(reach: usize) -> Self {
        match reach {
            0..=1 => Self::None,
            _ if reach <= SPLIT_REACH as usize => Self::Near,
            _ => Self::Far,
        }
    }

    /// Returns whether there are obtuse triangles.
    pub(crate) fn any(self) -> bool {
        self != Self::None
    }

    /// Returns the largest distance in rows and columns, or 0 if no triangle is split.
    fn reach(self) -> i32 {
        [0, SPLIT_REACH as i32, FARTHEST_SPLIT as i32][self as usize]
    }
}

impl From<Wavefront> for Variant {
    fn from(wavefront: Wavefront) -> Self {
        let [slowed, small_tiles, glued] = [false; 3];
        Self { wavefront, splits: Splits::Near, slowed, small_tiles, glued }
    }
}

impl Variant {
    pub(crate) const COUNT: usize = 8 * Splits::ALL.len() * Wavefront::ALL.len();

    /// Returns all variants, in the order of their indices among a pass's pipelines.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let bits = (0..8).flat_map(|bits| Splits::ALL.map(|splits| (bits, splits)));
        bits.flat_map(|(bits, splits)| {
            let [slowed, small_tiles, glued] = [0, 1, 2].map(|bit| bits >> bit & 1 != 0);
            let of = |wavefront| Self { wavefront, splits, slowed, small_tiles, glued };
            Wavefront::ALL.map(of)
        })
    }
}

/// Size of maps in the shared memory of workgroups; zeros for other passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct MapSize {
    /// Largest number of points.
    pub(crate) room: u32,
    pub(crate) invocations: u32,
    /// Size of the maps, if the pipeline is for one size alone.
    pub(crate) known: KnownSize,
}

/// Size of maps as specialization constants; zeros if the size is pushed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct KnownSize {
    pub(crate) rows: u32,
    pub(crate) cols: u32,
    /// Distance in shared memory from a point to the one below it.
    pub(crate) pitch: u32,
    /// Largest number of iterations in a dispatch.
    pub(crate) iterations: u32,
}

impl Row {
    /// Returns the index of the pipeline for a variant among all pipelines that the pass may have.
    pub(crate) fn place_of(&self, variant: Variant) -> usize {
        let is_split = self.shader.depends_on(Constant::Splits);
        let splits = if is_split { variant.splits as usize } else { 0 };
        let wavefront = if self.depends_on_wavefront { variant.wavefront as usize } else { 0 };
        let slowed = self.shader.depends_on(Constant::Slowed) && variant.slowed;
        let small_tiles = self.has_small_tiles(variant);
        let glued = self.shader.depends_on(Constant::Seams) && variant.glued;
        let bits = [glued, small_tiles, slowed].map(usize::from);
        let number = bits.into_iter().fold(0, |number, bit| 2 * number + bit);
        (number * Splits::ALL.len() + splits) * Wavefront::ALL.len() + wavefront
    }

    fn has_small_tiles(&self, variant: Variant) -> bool {
        self.shader.depends_on(Constant::Tile) && variant.small_tiles
    }

    /// Returns the numbers and values of the specialization constants.
    pub(crate) fn constants(&self, of: &Specialization) -> Vec<(u32, i32)> {
        let Specialization { tuning, on_processor, variant, map, group_order } = *of;
        let Variant { wavefront, splits, slowed, small_tiles, glued } = variant;
        let tuning = if small_tiles { tuning.with_small_tiles() } else { tuning };
        let ahead = self.scan.map_or((0, 0), Scan::ahead);
        let width = self.width.map_or(0, |width| match width {
            Width::Scans => tuning.scan_width,
            Width::Tiles if tuning.tile_lanes == TileLanes::Pairs => tuning.tile / 2,
            Width::Tiles => tuning.tile,
            Width::Maps => map.invocations,
        });
        let value = |constant| match constant {
            Constant::AheadX => ahead.0,
            Constant::AheadY => ahead.1,
            Constant::Wavefront => wavefront as i32,
            Constant::Splits => splits.reach(),
            Constant::Slowed => slowed.into(),
            Constant::Seams => glued.into(),
            Constant::OnProcessor => on_processor.into(),
            Constant::GroupOrder => group_order,
            Constant::LocalSizeX => width as i32,
            Constant::Lines => tuning.scan_lines as i32,
            Constant::Pairs => tuning.scan_pairs.into(),
            Constant::Tile => tuning.tile as i32,
            Constant::Inner => tuning.inner as i32,
            Constant::EdgesShared => tuning.tile_edges.into(),
            Constant::Room => map.room as i32,
            Constant::Rows => map.known.rows as i32,
            Constant::Cols => map.known.cols as i32,
            Constant::Pitch => map.known.pitch as i32,
            Constant::Iterations => map.known.iterations as i32,
        };
        self.shader.constants.iter().map(|&(number, constant)| (number, value(constant))).collect()
    }

    /// Returns the pipeline's name in debuggers and drivers.
    pub(crate) fn name(&self, variant: Variant) -> String {
        let wavefront = variant.wavefront;
        let scan = self.scan.map_or(String::new(), |scan| format!(" {}", scan.name()));
        let wavefront = match self.depends_on_wavefront {
            true => format!(", {wavefront}"),
            false => String::new(),
        };
        let tiles = if self.has_small_tiles(variant) { ", small grids" } else { "" };
        format!("{}{scan}{wavefront}{tiles}", self.shader.name)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::iter;

    use super::*;

    #[test]
    fn shaders_of_the_four_scans_differ_in_what_lies_ahead() {
        let tuning = Tuning::ON_CPU;
        let (wavefront, map) = (Wavefront::Curved, MapSize::default());
        let of = Specialization {
            tuning,
            on_processor: true,
            variant: wavefront.into(),
            map,
            group_order: 0,
        };
        for (pass, scan) in SCANS.into_iter().zip(Scan::ALL) {
            let constants = pass.row().constants(&of);
            let (x, y) = scan.ahead();
            for wanted in [(0, x), (1, y), (2, Wavefront::Curved as i32), (3, 64), (4, 4)] {
                assert!(constants.contains(&wanted), "{constants:?}");
            }
            assert_eq!(
                pass.row().name(Wavefront::Curved.into()),
                format!("scan {}, curved", scan.name())
            );
        }
    }

    #[test]
    fn every_shader_is_in_the_table() {
        let all = TABLE
            .iter()
            .flat_map(|row| iter::once(row.shader).chain(row.of_points.into_iter().flatten()));
        let of_modules = all.flat_map(|shader| match shader.modules {
            [_] => vec![shader.name.to_owned()],
            modules => (Wavefront::ALL.iter().zip(modules))
                .map(|(wavefront, _)| format!("{}_{wavefront}", shader.name))
                .collect(),
        });
        let listed: BTreeSet<_> = of_modules.collect();
        for entry in std::fs::read_dir("glsl/spirv").unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            if let Some(name) = name.strip_suffix(".spv") {
                assert!(listed.contains(name), "{name}");
            }
        }
    }
}
