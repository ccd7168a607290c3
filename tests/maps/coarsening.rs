//! Surfaces of every second line, which estimates are made on.

use geosweep::{Sources, Spacing, Surface, Wavefront};

use crate::common::marched;

/// Walls one point thick, straight and diagonal, that do not lie on a line that stays.
#[test]
fn no_wall_gets_a_gap() {
    let walls: [fn(usize, usize) -> bool; 3] =
        [|_, col| col == 5, |row, col| row + col == 11, |row, col| row + 1 == col];
    for wall in walls {
        let mask: Vec<_> = (0..121).map(|index| !wall(index / 11, index % 11)).collect();
        let flat = Surface::from_heights(11, 11, vec![0.0; 121], Spacing::square(1.0));
        let surface = flat.unwrap().with_mask(&mask).unwrap();
        for through in [[0, 0], [10, 0], [1, 0]] {
            let coarse = surface.coarsened(&[through]).unwrap();
            let reached = |surface: &Surface, sources: &Sources| {
                marched::<f32>(surface, sources, Wavefront::Planar)
            };
            let source = Sources::point(through[0] as f64, through[1] as f64);
            let fine = reached(&surface, &source);
            let found = reached(coarse.surface(), &coarse.sources(&source));
            for (index, distance) in coarse.indices().zip(found) {
                assert!(fine[index].is_finite() || distance.is_infinite(), "{through:?}");
            }
        }
    }
}
