//! Numbers of visits to tiles and of rounds, if tiles that are due much later than the first one wait. The work
//! of a map grows linearly with its number of points, on any surface.

use geosweep::Stop;
use geosweep::cpu::twins::{Rounds, tile_rounds_within};
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{Sources, Spacing, Surface, Wavefront};

use crate::common::difference;

/// Returns hills as steep as they are wide.
fn steep_hills(side: usize) -> Surface {
    let per_point = 6.0 / (side - 1) as f64;
    let height = |index: usize| {
        let (v, u) = ((index / side) as f64 * per_point, (index % side) as f64 * per_point);
        (2.0 * u).sin() * (1.7 * v).cos()
    };
    let heights = (0..side * side).map(height).collect();
    Surface::from_heights(side, side, heights, Spacing::square(per_point / 4.0)).unwrap()
}

/// Returns one path to and fro between walls, each three points thick and open at one end.
fn serpentine(side: usize) -> Surface {
    let (every, end) = (side / 8, side / 10);
    let floor: Vec<_> = (0..side * side)
        .map(|index| {
            let (row, col) = (index / side, index % side);
            let is_open = if row / every % 2 == 1 { col >= side - end } else { col <= end };
            row < 4 || row % every >= 3 || is_open
        })
        .collect();
    let plane = Surface::from_heights(side, side, vec![0.0; side * side], Spacing::square(1.0));
    plane.unwrap().with_mask(&floor).unwrap()
}

/// The grid has `GEOSWEEP_SIDE` points per side, or 384. The test takes one minute with 1024, and five minutes
/// with 2048.
#[test]
fn tiles_in_order_are_visited_some_six_times() {
    let side = std::env::var("GEOSWEEP_SIDE").map_or(384, |side| side.parse().unwrap());
    let sphere = Builtin::Sphere.surface(side, side).unwrap();
    let middle = [0.37 * side as f64, 0.61 * side as f64].map(f64::floor);
    for (name, surface, [row, col], wavefront) in [
        ("sphere", &sphere, middle, Wavefront::Planar),
        ("sphere", &sphere, middle, Wavefront::Curved),
        ("steep hills", &steep_hills(side), middle, Wavefront::Planar),
        ("serpentine", &serpentine(side), [0.0, 0.0], Wavefront::Planar),
    ] {
        let edges = EdgeLengths::<f32>::new(surface).unwrap();
        let seeds = Sources::point(row, col).seeds(surface).unwrap();
        let stop = Stop::within(1e-6).or_after(20_000);
        for (tile, inner) in [(32, 1), (16, 4)] {
            let [(any, of_any), (ordered, of_ordered)] = [None, Some(0)].map(|few| {
                let rounds = Rounds { tile, inner, recorded: 20_000, few };
                tile_rounds_within(&edges, &seeds, wavefront, stop, rounds, f64::INFINITY)
            });
            let tiles = side.div_ceil(tile).pow(2) as f64;
            let [before, after] = [of_any, of_ordered].map(|visits| visits as f64 / tiles);
            println!(
                "{name} {side}, {wavefront}, tiles of {tile}, {inner} iterations a visit: {before:.2} visits a tile in \
                 {} rounds, in order {after:.2} in {}",
                any.iterations, ordered.iterations
            );
            assert!(difference(&any.distances(), &ordered.distances()) < 3e-6, "{name}");
            assert!(after <= before.min(7.0), "{name}");
            assert!(f64::from(ordered.iterations) <= 1.5 * f64::from(any.iterations), "{name}");
        }
    }
}
