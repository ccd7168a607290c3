//! Compares maps on the CPU in one call of C, and what C derives from them, with the library in Rust.

use std::ptr::null;

use geosweep::geometry::{BackDirections, LogMap};
use geosweep::surface::EdgeLengths;
use geosweep::{Engine, Options, Sources, Spacing, Surface, Targets, Wavefront, distance_map};
use geosweep_capi::*;

use crate::session::{all_wrong, ok, zero};

const ROWS: usize = 31;
const COLS: usize = 45;
const POINTS: usize = ROWS * COLS;

fn heights() -> Vec<f32> {
    let height = |index: usize| {
        let (row, col) = (index / COLS, index % COLS);
        (0.3 * row as f32).sin() * (0.2 * col as f32).cos()
    };
    (0..POINTS).map(height).collect()
}

fn info(heights: &[f32], sources: &[GeosweepSource]) -> GeosweepMapInfo {
    let kind = GeosweepPointKind::Heights as i32;
    let points =
        GeosweepPoints { kind, dx: 1.0, dy: 1.0, data: heights.as_ptr(), stride: 4, ..zero() };
    GeosweepMapInfo {
        rows: ROWS as u32,
        cols: COLS as u32,
        points,
        wavefront: GeosweepWavefront::Curved as i32,
        sources: sources.as_ptr(),
        source_count: sources.len() as u32,
        ..zero()
    }
}

/// Returns the distances of a call without other outputs.
fn distances(info: &GeosweepMapInfo) -> Vec<f32> {
    let mut distances = vec![0.0; POINTS];
    let outputs = GeosweepMapOutputs { distances: distances.as_mut_ptr(), ..zero() };
    ok(unsafe { geosweep_cpu_map(info, &outputs) });
    distances
}

#[test]
fn maps_and_what_is_made_of_them_are_those_of_the_library() {
    let heights = heights();
    let wide = heights.iter().map(|&height| height.into()).collect();
    let surface = Surface::from_heights(ROWS, COLS, wide, Spacing::square(1.0)).unwrap();
    let sources = Sources::point(15.0, 20.0).and_point(4.0, 40.0, 1.5);
    let options = Options::default().with_engine(Engine::Cpu).with_wavefront(Wavefront::Curved);
    let given = [
        GeosweepSource { row: 15.0, col: 20.0, ..zero() },
        GeosweepSource { row: 4.0, col: 40.0, time: 1.5, ..zero() },
    ];
    let whole = info(&heights, &given);
    let expected = distance_map(&surface, &sources, &options).unwrap();
    assert_eq!(distances(&whole), expected.distances);

    let near = GeosweepMapInfo { radius: 9.0, ..whole };
    let expected = distance_map(&surface, &sources, &options.clone().with_radius(9.0)).unwrap();
    assert!(expected.report.reached < POINTS / 2);
    assert_eq!(distances(&near), expected.distances);

    let targets = [15_u32, 28, 2, 2];
    let to_one =
        GeosweepMapInfo { targets: targets.as_ptr(), target_count: 2, targets_needed: 1, ..whole };
    let any = options.with_targets(Targets::any([[15, 28], [2, 2]]));
    assert_eq!(distances(&to_one), distance_map(&surface, &sources, &any).unwrap().distances);

    let (mut back, mut links) = (vec![[0_f32; 2]; POINTS], vec![0_i8; POINTS]);
    let (mut nearest, mut log) = (vec![0_i32; POINTS], vec![[0_f32; 2]; POINTS]);
    let (mut signed, inside) = (vec![0_f32; POINTS], vec![1_u8; POINTS]);
    let outputs = GeosweepMapOutputs {
        back_directions: back.as_mut_ptr().cast(),
        back_links: links.as_mut_ptr(),
        nearest: nearest.as_mut_ptr(),
        log_map: log.as_mut_ptr().cast(),
        signed_distances: signed.as_mut_ptr(),
        inside: inside.as_ptr(),
        ..zero()
    };
    ok(unsafe { geosweep_cpu_map(&near, &outputs) });
    let edges = EdgeLengths::new(&surface).unwrap();
    let ways = BackDirections::new(&surface, &edges, &sources, &expected.distances).unwrap();
    assert_eq!(links, ways.links());
    let bits =
        |vectors: &[[f32; 2]]| vectors.iter().map(|v| v.map(f32::to_bits)).collect::<Vec<_>>();
    assert_eq!(bits(&back), bits(&ways.in_chart()));
    let expected_log = LogMap::new(&surface, &sources).unwrap().where_reached(&expected.distances);
    assert_eq!(bits(&log), bits(&expected_log.coordinates));
    for (index, distance) in expected.distances.iter().enumerate() {
        assert_eq!(nearest[index] == -1, distance.is_infinite(), "{index}");
        assert_eq!(log[index][0].is_nan(), distance.is_infinite(), "{index}");
        let inner = if distance.is_finite() { -distance } else { *distance };
        assert_eq!(signed[index], inner + 0.0, "{index}");
    }
}

#[test]
fn maps_that_cannot_be_are_refused() {
    let (heights, source) = (heights(), [zero::<GeosweepSource>()]);
    let good = info(&heights, &source);
    let (outside, targets) =
        ([zero::<GeosweepSource>(); 1].map(|s| GeosweepSource { row: 99.0, ..s }), [99, 2]);
    let no_points = GeosweepPoints { data: null(), ..good.points };
    let mut distances = vec![0.0; POINTS];
    let outputs = GeosweepMapOutputs { distances: distances.as_mut_ptr(), ..zero() };
    let inside = vec![1_u8; POINTS];
    let of = |info: &GeosweepMapInfo| unsafe { geosweep_cpu_map(info, &outputs) };
    unsafe {
        all_wrong! {
            geosweep_cpu_map(null(), &zero()) => "info is null",
            geosweep_cpu_map(&good, null()) => "outputs is null",
            geosweep_cpu_map(&good, &zero()) => "outputs has no array that is not null",
            geosweep_cpu_map(&good, &GeosweepMapOutputs { inside: inside.as_ptr(), ..outputs })
                => "outputs->inside is not null, and outputs->signed_distances is",
            of(&GeosweepMapInfo { targets_needed: 1, ..good }) => "info->targets_needed is 1, and there are 0",
            of(&GeosweepMapInfo { targets: targets.as_ptr(), target_count: 1, targets_needed: 7, ..good })
                => "info->targets_needed is 7, and there are 1",
            of(&GeosweepMapInfo { rows: 0, ..good }) => "rows is 0",
            of(&GeosweepMapInfo { source_count: 0, ..good }) => "info->source_count is 0",
            of(&GeosweepMapInfo { sources: outside.as_ptr(), ..good }) => "outside",
            of(&GeosweepMapInfo { radius: -1.0, ..good }) => "radius -1",
            of(&GeosweepMapInfo { radius: f64::NAN, ..good }) => "radius NaN",
            of(&GeosweepMapInfo { targets: targets.as_ptr(), target_count: 1, ..good })
                => "(99, 2) is outside the grid",
            of(&GeosweepMapInfo { wavefront: 9, ..good }) => "info->wavefront is 9",
            of(&GeosweepMapInfo { points: no_points, ..good }) => "exactly one of",
        }
    }
}
