//! Resolution of a surface by a grid, as the device determines it while measuring a host's points, compared with
//! `Surface::resolution` on the same surface.

use geosweep::surface::EdgeRule;
use geosweep::surface::builtin::Builtin;
use geosweep::vulkan::Schedule;
use geosweep::vulkan::embed::SourceInput;
use geosweep::{Spacing, Surface, Wavefront};

use crate::common::rough;
use crate::embed::stage::{Kept, RASTER, Stage, numbers_of, source};

/// Returns random heights from 0 to `relief`, in units of the spacing.
fn noise(rows: usize, cols: usize, relief: f64) -> Surface {
    let heights = (0..rows * cols).map(|index| {
        let mixed = (index as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        relief
            * (((mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) as f64
                / (1 << 24) as f64)
    });
    Surface::from_heights(rows, cols, heights.collect(), Spacing::square(1.0)).unwrap()
}

#[test]
fn outcomes_tell_whether_the_grid_resolves_the_surface() {
    let torus = Builtin::Torus.surface(61, 70).unwrap();
    let holed = rough(60, 50, 7);
    // The last surface is measured in bands.
    let surfaces = [torus, holed, noise(20, 90, 8.0), noise(700, 500, 2.0)];
    let (mut rough, mut sharp) = (0, 0);
    for surface in surfaces {
        let chart = surface.chart();
        let surface = surface.with_edge_rule(EdgeRule::Chord);
        let (host, numbers) = (Kept::unwatched(), numbers_of(&surface));
        let stage = Stage::on(host, &RASTER[..1], (&surface, None), numbers);
        let plan = stage.plan(Schedule::Raster, Wavefront::Planar, 1);
        // A second measurement counts anew.
        for _ in 0..2 {
            stage.solve(SourceInput::Inline(&source(3.0, 4.0)), &plan);
        }
        let found = stage.surface.outcome(0).unwrap().resolution.expect("something was looked at");
        let expected = surface.resolution().unwrap();
        // Rounding may decide whether an edge that turns by 30 degrees is sharp.
        let (found_share, share) = (found.sharp_edges, expected.sharp_edges);
        assert!((found_share - share).abs() < 1e-3, "{chart:?}: {found_share} {share}");
        assert_eq!(found.is_rough(), expected.is_rough(), "{chart:?}: {found:?} {expected:?}");
        rough += usize::from(found.is_rough());
        sharp += usize::from(found.sharp_edges > 0.1);
        stage.end([]);
    }
    assert!((1..4).contains(&rough) && (1..4).contains(&sharp), "{rough} rough, {sharp} sharp");
}
