//! The table of passes.

use std::marker::PhantomData;

use bytemuck::Pod;

use super::Tuning;
use super::plan::Scan::{self, Down, Left, Right, Up};
use super::profile::PassKind::{self, *};
use super::shaders::{self, Constant, Shader};
use crate::update::Wavefront;

/// A row of the table.
#[derive(Debug)]
pub(crate) struct Row {
    /// What it sees, how it is specialized and what is pushed to it stand there.
    pub(crate) shader: &'static Shader,
    /// What profiles say of it.
    pub(crate) kind: PassKind,
    /// Whether each wavefront has a pipeline of its own.
    pub(crate) depends_on_wavefront: bool,
}

impl Row {
    const fn new(shader: &'static Shader, kind: PassKind) -> Self {
        let depends_on_wavefront = shader.depends_on(Constant::Wavefront);
        Self { shader, kind, depends_on_wavefront }
    }
}

/// A pass to which these constants are pushed.
#[derive(Debug)]
pub(crate) struct Pass<P> {
    number: usize,
    constants: PhantomData<fn(P)>,
}

impl<P> Clone for Pass<P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<P> Copy for Pass<P> {}

impl<P: Pod> Pass<P> {
    /// Its place in the [`TABLE`].
    pub(crate) const fn number(self) -> usize {
        self.number
    }

    pub(crate) fn row(self) -> &'static Row {
        &TABLE[self.number]
    }
}

macro_rules! passes {
    ($($name:ident: $shader:ident, $kind:expr;)*) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Number { $($name),* }

        $(pub(crate) const $name: Pass<shaders::$shader::Push> =
            Pass { number: Number::$name as usize, constants: PhantomData };)*

        /// All passes.
        pub(crate) static TABLE: [Row; [$(Number::$name),*].len()] =
            [$(Row::new(&shaders::$shader::SHADER, $kind)),*];

        /// Room for the largest block of push constants; every device offers 128 bytes.
        pub(crate) const PUSH_CONSTANT_BYTES: u32 =
            largest(&[$(shaders::$shader::SHADER.push_constant_bytes),*]);
    };
}

// The name of a pass, its shader, and its kind in profiles.
passes! {
    POINTS_FROM_BUFFER: points_from_buffer, Points;
    POINTS_FROM_IMAGE: points_from_image, Points;
    EDGES_FROM_POSITIONS: edges_from_positions, Edges;
    EDGES_FROM_HEIGHTS: edges_from_heights, Edges;
    EDGES_FROM_METRIC: edges_from_metric, Edges;
    FAN_CURVATURE: fan_curvature, Curvature;
    GAUSSIAN_CURVATURE: gaussian_curvature, Curvature;
    SOURCES: sources, Sources;
    SURROUNDINGS: surroundings, Surroundings;
    SEED: seed, Seed;
    SCAN_DOWN: scan, Scan(Down);
    SCAN_UP: scan, Scan(Up);
    SCAN_RIGHT: scan, Scan(Right);
    SCAN_LEFT: scan, Scan(Left);
    ALL_POINTS: all_points, AllPoints;
    TILES: tiles, Tiles;
    SETTLE: settle, Settle;
    COUNT: progress, Count;
    RESULT: result, Distances;
    UNPACK: unpack, Unpack;
    LOOKUP: lookup, Lookup;
    CONTOUR_COUNTS: contour_counts, Contours;
    CONTOUR_OFFSETS: contour_offsets, Contours;
    CONTOUR_SEGMENTS: contour_segments, Contours;
    PATH_STARTS: path_starts, Paths;
    PATHS: paths, Paths;
    LIFT_FROM_BUFFER: lift_from_buffer, Lift;
    LIFT_FROM_IMAGE: lift_from_image, Lift;
    REGION_STARTS: region_starts, Regions;
    REGION_WAYS: region_ways, Regions;
    REGION_FLOW: region_flow, Regions;
    REGION_LABELS: region_labels, Regions;
    PAIRWISE_FANS: pairwise_fans, Fans;
    PAIRWISE_SHARED: pairwise_shared, Workgroups;
    PAIRWISE_START: pairwise_start, Seed;
    PAIRWISE_SCAN_DOWN: pairwise_scan, Scan(Down);
    PAIRWISE_SCAN_UP: pairwise_scan, Scan(Up);
    PAIRWISE_SCAN_RIGHT: pairwise_scan, Scan(Right);
    PAIRWISE_SCAN_LEFT: pairwise_scan, Scan(Left);
    PAIRWISE_COUNT: pairwise_count, Count;
}

/// In the order of [`Scan::ALL`].
pub(crate) const SCANS: [Pass<shaders::scan::Push>; 4] =
    [SCAN_DOWN, SCAN_UP, SCAN_RIGHT, SCAN_LEFT];
/// The same over the maps of a batch.
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

/// What pipelines are specialized by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Specialization {
    pub(crate) tuning: Tuning,
    pub(crate) wavefront: Wavefront,
    pub(crate) batch: BatchSizes,
}

/// Of passes over the maps of many sources; zeros for others.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BatchSizes {
    /// Maps, at most.
    pub(crate) maps: u32,
    pub(crate) rows: u32,
    pub(crate) cols: u32,
    /// From a point in shared memory to the one below it.
    pub(crate) pitch: u32,
    pub(crate) invocations: u32,
    /// In a dispatch, at most.
    pub(crate) iterations: u32,
}

impl Row {
    /// Its direction, if it is a scan's.
    fn scan(&self) -> Option<Scan> {
        if let Scan(scan) = self.kind { Some(scan) } else { None }
    }

    /// The numbers and values of its specialization constants.
    pub(crate) fn constants(&self, of: &Specialization) -> Vec<(u32, i32)> {
        let Specialization { tuning, wavefront, batch } = *of;
        let ahead = self.scan().map_or((0, 0), Scan::ahead);
        let value = |constant| match constant {
            Constant::AheadX => ahead.0,
            Constant::AheadY => ahead.1,
            Constant::Wavefront => wavefront as i32,
            Constant::LocalSizeX => match self.kind {
                Tiles => tuning.tile as i32 / 2,
                Workgroups => batch.invocations as i32,
                _ => tuning.scan_width as i32,
            },
            Constant::Lines => tuning.scan_lines as i32,
            Constant::Tile => tuning.tile as i32,
            Constant::Inner => tuning.inner as i32,
            Constant::Maps => batch.maps as i32,
            Constant::Rows => batch.rows as i32,
            Constant::Cols => batch.cols as i32,
            Constant::Pitch => batch.pitch as i32,
            Constant::Iterations => batch.iterations as i32,
        };
        self.shader.constants.iter().map(|&(number, constant)| (number, value(constant))).collect()
    }

    /// What debuggers and drivers call its pipeline.
    pub(crate) fn name(&self, wavefront: Wavefront) -> String {
        let scan = self.scan().map_or(String::new(), |scan| format!(" {}", scan.name()));
        let wavefront = match self.depends_on_wavefront {
            true => format!(", {wavefront}"),
            false => String::new(),
        };
        format!("{}{scan}{wavefront}", self.shader.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shaders_of_the_four_scans_differ_in_what_lies_ahead() {
        let tuning = Tuning { scan_width: 64, scan_lines: 4, tile: 16, inner: 4 };
        let of =
            Specialization { tuning, wavefront: Wavefront::Curved, batch: BatchSizes::default() };
        for (pass, scan) in SCANS.into_iter().zip(Scan::ALL) {
            let constants = pass.row().constants(&of);
            let (x, y) = scan.ahead();
            for wanted in [(0, x), (1, y), (2, Wavefront::Curved as i32), (3, 64), (4, 4)] {
                assert!(constants.contains(&wanted), "{constants:?}");
            }
            assert_eq!(pass.row().name(Wavefront::Curved), format!("scan {}, curved", scan.name()));
        }
    }

    #[test]
    fn every_shader_is_in_the_table_or_measures_the_device() {
        let listed = |name: &str| TABLE.iter().any(|row| row.shader.name == name);
        for entry in std::fs::read_dir("glsl/spirv").unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            if let Some(name) = name.strip_suffix(".spv") {
                assert!(listed(name) || name.starts_with("ceiling_"), "{name}");
            }
        }
    }
}
