//! Images of distances of a closed surface, read between grid points: by a linear sampler, and by four texels as the
//! viewer does.

use std::f64::consts::TAU;

use geosweep::Wavefront;
use geosweep::ash::vk;
use geosweep::surface::Gluing;
use geosweep::vulkan::Schedule;
use geosweep::vulkan::embed::{Access, Frame, MapLimit, Reader, SourceInput};

use crate::common::closed::tube;
use crate::embed::closed::stage_on;
use crate::embed::stage::{Kept, Stage, source};

/// Shader that reads one place, a column and a row, by both methods in each invocation.
const READ: &str = concat!(
    include_str!("../../../examples/viewer/shaders/bilinear.wgsl"),
    "
    @group(0) @binding(0) var<storage, read> places: array<vec2<f32>>;
    @group(0) @binding(1) var<storage, read_write> found: array<vec2<f32>>;
    @group(0) @binding(2) var distances: texture_2d<f32>;
    @group(0) @binding(3) var linear: sampler;
    @compute @workgroup_size(64)
    fn main(@builtin(global_invocation_id) id: vec3<u32>) {
        if (id.x >= arrayLength(&places)) { return; }
        let place = places[id.x];
        let at = (place + 0.5) / vec2<f32>(textureDimensions(distances));
        let by_sampler = textureSampleLevel(distances, linear, at, 0.0).r;
        found[id.x] = vec2<f32>(by_sampler, reached_between(around(distances, place)));
    }"
);

const ROWS: usize = 33;
const COLS: usize = 49;
/// Number of columns round the tube.
const ROUND: usize = COLS - 1;
/// Length of a cell's sides.
const CELL: f64 = TAU / ROUND as f64;
/// Row and column of the source, beside the seam.
const FROM: [f64; 2] = [12.0, 45.0];
const RASTER: [(Schedule, Wavefront); 1] = [(Schedule::Raster, Wavefront::Curved)];
const UNREACHED: f32 = -1.0;

/// Returns rows and columns on both sides of the seam and on it, by steps of an eighth of a cell. Beyond the last
/// column, columns count from 0 again.
fn places() -> Vec<[f64; 2]> {
    let eighths = |first: usize, last: usize| (8 * first..=8 * last).map(|k| k as f64 / 8.0);
    let cols: Vec<_> = eighths(ROUND - 9, ROUND).chain(eighths(0, 9)).collect();
    eighths(2, ROWS - 3).flat_map(|row| cols.iter().map(move |&col| [row, col])).collect()
}

/// Runs a frame that ends at `limit`. Returns the two values read at each place: by the sampler, and by four texels.
fn read(stage: &mut Stage, limit: MapLimit, places: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 16).over_seams();
    let own = source(FROM[0] as f32, FROM[1] as f32);
    let numbers: Vec<f32> =
        places.iter().flat_map(|&[row, col]| [col as f32, row as f32]).collect();
    let asked = stage.host.buffer_of(&numbers);
    let found = stage.host.buffer(4 * numbers.len() as u64, true);
    let image = stage.surface.result(0, Reader::COMPUTE.layout).unwrap();
    let pass = stage.host.pass(READ, &[asked.handle, found.handle], Some(image.view));
    let Stage { host, solver, surface, .. } = &*stage;
    host.run(|commands| {
        let frame = Frame::new(&plan, SourceInput::Inline(&own), Reader::COMPUTE)
            .with_points(0)
            .with_limit(limit)
            .with_unreached(UNREACHED);
        solver.record(&host.device, commands, surface).frame(&frame).unwrap();
        host.dispatch(commands, &pass, places.len().div_ceil(64) as u32);
        host.barrier(commands, Access::COMPUTE_WRITE, Access::HOST_READ);
    });
    assert!(stage.surface.outcome(0).unwrap().converged);
    let pairs = found.floats()[..numbers.len()].chunks(2);
    let values = pairs.map(|pair| [pair[0].into(), pair[1].into()]).collect();
    stage.host.destroy_pass(pass);
    [asked, found].into_iter().for_each(|buffer| stage.host.free(buffer));
    values
}

/// Returns the distance on the cylinder.
fn truth([row, col]: [f64; 2]) -> f64 {
    let across = (col - FROM[1]).abs();
    CELL * (row - FROM[0]).hypot(across.min(ROUND as f64 - across))
}

fn filters_distances(stage: &Stage) -> bool {
    let (instance, device) = (&stage.host.instance, stage.host.physical_device);
    let format = vk::Format::R32_SFLOAT;
    // SAFETY: the physical device is from this instance.
    let known = unsafe { instance.get_physical_device_format_properties(device, format) };
    let linear = vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR;
    known.optimal_tiling_features.contains(linear)
}

/// Between grid points, bilinear values are late by up to the square of a cell's side divided by eight times the radius
/// of the front.
#[test]
fn values_between_points_are_right_up_to_the_seam() {
    let mut stage = stage_on(&tube(ROWS, COLS), &Gluing::columns(), Kept::watched(), &RASTER);
    let places = places();
    let values = read(&mut stage, MapLimit::NONE, &places);
    // A sampler has at least 8 bits for the place between two texels.
    let weights = [CELL / 256.0, 0.0];
    let ways = if filters_distances(&stage) { 0..2 } else { 1..2 };
    let mut largest = [0.0f64; 2];
    for (&place, values) in places.iter().zip(&values) {
        let exact = truth(place);
        if exact < 2.0 * CELL {
            continue;
        }
        for way in ways.clone() {
            let late = values[way] - exact;
            let bound = CELL * CELL / (8.0 * (exact - CELL)) + 1e-5;
            let range = -1e-5 - weights[way]..bound + weights[way];
            assert!(range.contains(&late), "{place:?}, way {way}: {late:e}, {range:?}");
            largest[way] = largest[way].max(late);
        }
    }
    println!("late by up to {largest:.5?}");
    // The last column and the first one are one place.
    let on = |col: f64| places.iter().zip(&values).filter(move |(place, _)| place[1] == col);
    for ((_, last), (_, first)) in on(ROUND as f64).zip(on(0.0)) {
        assert!((0..2).all(|way| (last[way] - first[way]).abs() < 1e-5), "{last:?} {first:?}");
    }
    stage.end([]);
}

/// The map ends at a radius on both sides of the seam. Values that are read from four texels do not depend on the value
/// of unreached points.
#[test]
fn unreached_points_have_no_part_in_values_beside_the_seam() {
    let mut stage = stage_on(&tube(ROWS, COLS), &Gluing::columns(), Kept::watched(), &RASTER);
    let places = places();
    let radius = 6.3 * CELL;
    let values = read(&mut stage, MapLimit::NONE.with_radius(radius as f32), &places);
    let [mut mixed, mut beyond, mut at_border] = [0; 3];
    for (&[row, col], &[by_sampler, by_texels]) in places.iter().zip(&values) {
        let (low, left) = (row.floor(), col.floor().min(ROUND as f64 - 1.0));
        let (down, right) = (row - low, col - left);
        let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)];
        let weight = |(y, x): (f64, f64)| {
            (1.0 - (y - down).abs()).max(0.0) * (1.0 - (x - right).abs()).max(0.0)
        };
        let at = |(y, x): (f64, f64)| truth([low + y, left + x]);
        let reached: Vec<_> = corners.into_iter().filter(|&c| at(c) <= radius).collect();
        let part: f64 = reached.iter().map(|&corner| weight(corner)).sum();
        if part <= 0.5 {
            assert_eq!(by_texels, f64::from(UNREACHED), "{row}, {col}");
            beyond += 1;
            continue;
        }
        let mean: f64 = reached.iter().map(|&corner| weight(corner) * at(corner)).sum();
        assert!((by_texels - mean / part).abs() < 1e-3 * CELL, "{row}, {col}: {by_texels}");
        at_border += usize::from(part < 1.0);
        mixed += usize::from(by_texels - by_sampler > 0.1 * CELL);
    }
    println!("{beyond} beyond, {at_border} at the border, of which the sampler mixes {mixed}");
    assert!(beyond > 500 && at_border > 500);
    // This is the reason for reading four texels.
    assert!(!filters_distances(&stage) || mixed > at_border / 2);
    stage.end([]);
}
