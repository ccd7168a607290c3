//! Tiles of small grids in frames.

use geosweep::Wavefront;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{SourceInput, SurfaceInfo, Tools};
use geosweep::vulkan::{Schedule, Tuning};

use crate::embed::stage::{Kept, Stage, source};
use crate::host::Host;

const CHART: Chart = Chart { rows: 40, cols: 48 };

/// Returns the maps by the schedule of tiles with curved and with planar fronts: for each, the number of rounds in a
/// recording, the distances, and the number of visits to tiles.
fn maps(change: impl FnOnce(Tuning) -> Tuning) -> Vec<(u32, Vec<f32>, u32)> {
    let host = Kept::tuned(Host::new(), Tools::default(), change);
    let passes = [(Schedule::Tiles, Wavefront::Curved)];
    let mut stage = Stage::of_waves(host, &passes, SurfaceInfo::new(CHART), 0.4);
    // Pipelines that are added later serve surfaces that were made before.
    let device = stage.host.device.clone();
    stage.solver.add_passes(&device, Schedule::Tiles, Wavefront::Planar).unwrap();
    let maps = [Wavefront::Curved, Wavefront::Planar].map(|wavefront| {
        let plan = stage.plan(Schedule::Tiles, wavefront, 100);
        let map = stage.map(0, SourceInput::Inline(&source(12.25, 30.0)), &plan);
        (plan.iterations(), map, stage.surface.outcome(0).unwrap().visits)
    });
    stage.end([]);
    maps.into()
}

/// The grid is small to one solver, and not to another. Each map is the same as that of a solver with tiles of that
/// size on all grids.
#[test]
fn frames_on_small_grids_have_small_tiles() {
    let tiles = |tile, tile_edges, small_grid| {
        move |old| Tuning { tile, tile_edges, small_grid, inner: 1, ..old }
    };
    let small = maps(tiles(24, false, 48));
    let large = maps(tiles(24, false, 47));
    assert!(small == maps(tiles(16, true, 0)));
    assert!(large == maps(tiles(24, false, 0)));
    assert_ne!(small[0].2, large[0].2, "tiles of both sides are visited as often");
}
