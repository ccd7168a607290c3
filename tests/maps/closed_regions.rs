//! Regions on closed surfaces, against closed forms.

use geosweep::geometry::{NO_REGION, Nearest, Voronoi, area};
use geosweep::surface::{EdgeLengths, Gluing};
use geosweep::{Sources, Surface};

use crate::common::closed::*;
use crate::common::{cpu_map, points};

/// Returns the regions of sources. Asserts that the nearest sources are the same.
fn regions(surface: &Surface, sources: &Sources) -> Voronoi {
    let map = cpu_map(surface, sources);
    let edges = EdgeLengths::new(surface).unwrap();
    let regions = Voronoi::new(surface, &edges, sources, &map.distances).unwrap();
    let nearest = Nearest::new(surface, &edges, sources, &map.distances).unwrap();
    assert!(nearest.sources.iter().zip(&regions.labels).all(|(a, b)| *a as u32 == *b));
    regions
}

/// Compares labels with closed-form distances. No label may be that of a source that is farther than the nearest
/// source by more than `slack`.
fn check(
    name: &str,
    surface: &Surface,
    places: &[[f64; 2]],
    distance: impl Fn([f64; 2], [f64; 2]) -> f64,
    slack: f64,
) -> Voronoi {
    let found = regions(surface, &points(places));
    let mut worst = 0f64;
    for (row, col) in (0..surface.rows()).flat_map(|r| (0..surface.cols()).map(move |c| (r, c))) {
        let label = found.labels[row * surface.cols() + col];
        if !surface.has(row, col) {
            assert_eq!(label, NO_REGION);
            continue;
        }
        let to = |place: &[f64; 2]| distance([row as f64, col as f64], *place);
        let nearest = places.iter().map(to).fold(f64::INFINITY, f64::min);
        worst = worst.max(to(&places[label as usize]) - nearest);
    }
    for group in surface.copies().unwrap().iter() {
        let label = found.labels[group[0] as usize];
        assert!(group.iter().all(|&copy| found.labels[copy as usize] == label), "{name}: copies");
    }
    let (parts, whole): (f64, f64) = (found.areas(surface).iter().sum(), area(surface));
    assert!((parts - whole).abs() < 1e-9 * whole, "{name}: {parts} of {whole}");
    println!("{name}: {} borders, labels off by {worst:.1e}", found.borders.len());
    assert!(worst <= slack, "{name}: {worst:e}");
    found
}

#[test]
fn regions_of_flat_surfaces_pass_seams() {
    let sources = [[12.0, 4.0], [30.0, 61.0], [25.5, 0.0], [3.25, 40.75], [40.0, 22.0]];
    for (name, gluing, shape) in shapes() {
        let surface = flat(41, 65).with_gluing(gluing).unwrap();
        let distance = |a, b| shape.way(a, b).length();
        check(name, &surface, &sources, distance, 1e-3);
        // Two sources across the seam from each other.
        check(name, &surface, &[[20.0, 2.0], [20.0, 60.0]], distance, 1e-3);
    }
}

#[test]
fn borders_go_on_over_seams() {
    let shape = Flat { cols: true, rows: true, ..Flat::default() };
    let torus = flat(41, 65).with_gluing(Gluing::both()).unwrap();
    let found =
        check("torus", &torus, &[[20.0, 1.0], [20.0, 33.0]], |a, b| shape.way(a, b).length(), 1e-3);
    // Both borders are circles around the torus, halfway between the sources.
    assert_eq!(found.borders.len(), 2);
    for border in &found.borders {
        assert!(border.curve.closed);
        let col = border.curve.vertices[0][1];
        assert!((col - 17.0).abs() < 0.01 || (col - 49.0).abs() < 0.01, "{col}");
        assert!((border.curve.length(&torus).unwrap() - 40.0).abs() < 0.01);
    }
}

#[test]
fn regions_of_a_globe_meet_at_poles_and_the_date_line() {
    for (name, surface, sources) in [
        ("globe", globe(61, 121), &[[30.0, 3.0], [20.0, 118.0], [0.0, 7.0], [57.0, 60.0]][..]),
        ("globe", globe(61, 121), &[[30.0, 0.0], [30.0, 60.0]]),
        ("cube", cube(31), &[[10.0, 20.0], [40.0, 40.0], [15.0, 80.0]]),
    ] {
        let place = |[row, col]: [f64; 2]| surface.position(row as usize, col as usize).unwrap();
        check(name, &surface, sources, |a, b| angle(place(a), place(b)), 2e-3);
    }
}
