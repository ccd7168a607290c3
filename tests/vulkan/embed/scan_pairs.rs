//! Raster scans that go in pairs, in frames of a surface that moves.

use geosweep::Wavefront;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{PointSource, Points, SourceInput, SurfaceInfo, Tools};
use geosweep::vulkan::{Schedule, Tuning};

use crate::common::difference;
use crate::embed::stage::{Kept, RASTER, Stage, source, vertices};
use crate::host::Host;

/// Rows and columns of the grid. Its rows fit a workgroup of 64 texels, which takes blocks in turn. They do not fit a
/// workgroup of 16 texels.
const CHART: Chart = Chart { rows: 47, cols: 62 };

/// Largest difference of converged maps, relative to the largest distance.
const AGREEMENT: f64 = 1e-6;

/// Number of frames. The surface moves from frame to frame.
const FRAMES: usize = 3;

/// Returns a host and a solver whose scans go in pairs or in turn.
fn solver(host: Host, sizes: (u32, u32), scan_pairs: bool, checks: bool) -> Kept {
    let tools = Tools { checks, ..Tools::default() };
    let (scan_width, scan_lines) = sizes;
    Kept::tuned(host, tools, |old| Tuning { scan_width, scan_lines, scan_pairs, ..old })
}

/// Returns the map of each frame and wavefront with its number of iterations, and after each of them the map to which a
/// source was added. A recording has two iterations, so that most maps take several recordings.
fn maps(mut host: Kept) -> Vec<(Vec<f32>, u32)> {
    let phases = (0..FRAMES).map(|frame| host.buffer_of(&vertices(CHART, 0.7 * frame as f32)));
    let buffers: Vec<_> = phases.collect();
    let points: Vec<_> =
        buffers.iter().map(|buffer| Points::positions(buffer.handle, 32)).collect();
    let info = SurfaceInfo::new(CHART).with_points(&points);
    let stage = Stage::new(host, &RASTER, &info);
    let several = [PointSource::at(12.0, 30.0), PointSource::at(40.25, 7.5)];
    let mut maps = Vec::new();
    for frame in 0..FRAMES {
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let plan = stage.plan(Schedule::Raster, wavefront, 2);
            let sources = &several[..1 + frame % 2];
            let map = stage.map(frame, SourceInput::Inline(sources), &plan);
            maps.push((map, stage.surface.outcome(0).unwrap().iterations));
            let both = stage.add(SourceInput::Inline(&source(3.0, 55.0)), &plan);
            maps.push((both, stage.surface.outcome(0).unwrap().iterations));
        }
    }
    stage.end(buffers);
    maps
}

/// Maps are compared with the layers and without them. Without the layers, no barrier separates the scans of a pair.
/// The layers report nothing.
#[test]
fn frames_in_pairs_have_the_maps_of_frames_in_turn() {
    for sizes in [(64, 4), (16, 2)] {
        let in_turn = maps(solver(Host::without_validation(), sizes, false, false));
        let in_pairs = maps(solver(Host::without_validation(), sizes, true, false));
        let watched = maps(solver(Host::new(), sizes, true, true));
        assert_eq!(in_turn.len(), 2 * FRAMES * RASTER.len());
        assert!(in_pairs == watched, "{sizes:?}");
        for (number, (wanted, found)) in in_turn.iter().zip(&in_pairs).enumerate() {
            let apart = difference(&wanted.0, &found.0);
            assert!(apart < AGREEMENT, "{sizes:?}, {number}: {apart:e}");
            let more = wanted.1.abs_diff(found.1);
            assert!(more <= 2, "{sizes:?}, {number}: {} and {}", wanted.1, found.1);
        }
    }
}
