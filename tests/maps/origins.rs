//! Neighbouring sources, and lines across the grid, compared with exact distances on surfaces that unroll
//! into a plane.

use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{
    Options, Sources, Spacing, Stop, Surface, Wavefront, cpu, distance_map, distance_map_f64,
};

use crate::common::bounds::cases;
use crate::common::sheets::{Kind, Sheet};

const STOP: Stop = Stop::within(1e-6).or_after(500);

/// Returns how much the maps of a sheet in double and in single precision differ from the exact distances at most,
/// relative to the longer side of a cell.
fn errors(sheet: &Sheet) -> [f64; 2] {
    let Sheet { surface, sources, cell, exact, .. } = sheet;
    let options = Options::default();
    let double = distance_map_f64(surface, sources, &options).unwrap().distances;
    let single = distance_map(surface, sources, &options).unwrap().distances;
    let single: Vec<_> = single.into_iter().map(f64::from).collect();
    [double, single].map(|map| {
        let late = map.iter().zip(exact).map(|(found, exact)| (found - exact).abs() / cell);
        late.fold(0.0, f64::max)
    })
}

#[test]
fn sources_side_by_side_are_exact_whatever_the_cells() {
    for (rolled, kind) in [false, true].into_iter().flat_map(|on| Kind::ALL.map(|kind| (on, kind)))
    {
        for number in cases(100) {
            let sheet = Sheet::new(number, kind, rolled);
            let [double, single] = errors(&sheet);
            // Single precision has the rounding of the largest distance, some hundred cells.
            assert!(double < 1e-9 && single < 3e-5, "{}: {double:.1e} {single:.1e}", sheet.name);
        }
    }
}

/// The front of many sources in a row is scalloped. If each scallop counted as part of a circle, the map would differ
/// from the map of a line.
#[test]
fn rows_of_sources_are_lines_whatever_the_relief() {
    for relief in [0.0, 1e-3] {
        let mut heights = vec![0.0; 61 * 61];
        heights[0] = relief;
        let surface = Surface::from_heights(61, 61, heights, Spacing::square(1.0)).unwrap();
        let sources =
            (0..61).fold(Sources::default(), |all, col| all.and_point(0.0, f64::from(col), 0.0));
        let seeds = sources.seeds_with_origins(&surface).unwrap();
        let seeds = cpu::seeds_for(Wavefront::Curved, &surface, seeds);
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let map = cpu::rotated_scan(&edges, &seeds, Wavefront::Curved, STOP).distances();
        for (index, distance) in map.iter().enumerate().skip(61 * 2) {
            approx::assert_relative_eq!(*distance, (index / 61) as f32, max_relative = 1e-5);
        }
    }
}

/// Compares the map of several point sources with the minimum of the sources' own maps. Returns the largest
/// amounts by which the map is early and late, and its mean absolute difference, relative to the largest
/// distance.
fn from_single_maps(surface: &Surface, places: &[[f64; 2]]) -> [f64; 3] {
    let options = Options::default().with_wavefront(Wavefront::Curved);
    let map = |sources: &Sources| distance_map_f64(surface, sources, &options).unwrap().distances;
    let all = places.iter().fold(Sources::default(), |all, at| all.and_point(at[0], at[1], 0.0));
    let together = map(&all);
    let mut earliest = vec![f64::INFINITY; together.len()];
    for at in places {
        let single = map(&Sources::point(at[0], at[1]));
        earliest.iter_mut().zip(single).for_each(|(first, other)| *first = first.min(other));
    }
    let finite = || together.iter().zip(&earliest).filter(|(_, exact)| exact.is_finite());
    let largest = finite().map(|(_, exact)| *exact).fold(0.0, f64::max);
    let late: Vec<_> = finite().map(|(found, exact)| (found - exact) / largest).collect();
    let mean = late.iter().map(|late| late.abs()).sum::<f64>() / late.len() as f64;
    let most = |sign: f64| late.iter().map(|late| sign * late).fold(0.0, f64::max);
    [most(-1.0), most(1.0), mean]
}

/// If cells differ, fronts carry their ray. With a curvature alone, two neighbouring sources would have a mean error of
/// 3e-5 to 2e-4 here.
#[test]
fn sources_side_by_side_on_curved_surfaces_are_as_good_as_single_ones() {
    for builtin in [Builtin::Sphere, Builtin::Torus, Builtin::Peaks] {
        let surface = builtin.surface(121, 121).unwrap();
        for places in [
            &[[80.0, 90.0], [81.0, 90.0]][..],
            &[[30.0, 60.0], [30.0, 61.0], [31.0, 62.0]],
            &[[60.0, 20.0], [61.0, 21.0]],
            &[[90.0, 50.0], [90.0, 51.0], [90.0, 52.0], [90.0, 53.0], [91.0, 50.0]],
            // Other sources are further away, one of them near the cluster's surroundings.
            &[[40.0, 40.0], [41.0, 40.0], [40.0, 60.0], [60.3, 41.6], [100.0, 100.0]],
        ] {
            // Behind the hills of peaks, single maps with curved fronts are early where the front meets itself.
            let most = if builtin == Builtin::Peaks { 5e-3 } else { 3e-4 };
            let [early, late, mean] = from_single_maps(&surface, places);
            assert!(
                early < 5e-3 && late < most && mean < 3e-4,
                "{builtin} {places:?}: early {early:.1e}, late {late:.1e}, mean {mean:.1e}"
            );
        }
    }
}

/// Fronts reach distant points on the sources' side of a wall earlier over fast ground behind the wall.
#[test]
fn exact_seeds_do_not_block_earlier_fronts() {
    let mut slowness = vec![1.0; 41 * 41];
    // The ground is fast behind a wall, which has two gaps.
    slowness.iter_mut().enumerate().filter(|(k, _)| k % 41 > 24).for_each(|(_, s)| *s = 1e-3);
    let mask: Vec<_> = (0..41 * 41).map(|k| k % 41 != 22 || k / 41 == 2 || k / 41 == 38).collect();
    let surface = Surface::from_heights(41, 41, vec![0.0; 41 * 41], Spacing::square(1.0)).unwrap();
    let surface = surface.with_slowness(slowness).unwrap().with_mask(&mask).unwrap();
    let [early, late, _] = from_single_maps(&surface, &[[4.0, 20.0], [5.0, 20.0], [5.0, 19.0]]);
    assert!(early < 5e-3 && late < 2e-3, "early {early:.1e}, late {late:.1e}");
}
