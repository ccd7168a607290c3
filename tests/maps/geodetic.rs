//! The Earth by latitudes and longitudes, against geodesics of the WGS84 ellipsoid.

use geosweep::{Engine, Options, Sources, distance_map};

use crate::common::earth::{Earth, SOURCES, lines};
use crate::common::vincenty::{EQUATOR, vincenty};

/// The truth itself is checked: the quarter of a meridian, the equator, and a length from GeographicLib.
#[test]
fn vincenty_agrees_with_known_geodesics() {
    let quarter = vincenty([12.0, 0.0], [12.0, 90.0]).unwrap();
    assert!((quarter - 10_001_965.729).abs() < 1e-3, "{quarter}");
    let along_equator = vincenty([0.0, 0.0], [90.0, 0.0]).unwrap();
    assert!((along_equator - EQUATOR * std::f64::consts::FRAC_PI_2).abs() < 1e-3);
    // From JFK to LHR, in the documentation of GeographicLib.
    let near = vincenty([-73.8, 40.6], [-0.5, 51.6]).unwrap();
    assert!((near - 5_551_759.4).abs() < 0.1, "{near}");
}

/// Checks maps of the whole Earth.
fn check_whole_earth(step: f64, mean_bound: f64, largest_bound: f64) {
    let earth = Earth::whole(step);
    for source in SOURCES {
        let [mean, largest] = earth.errors(source, &earth.map(source));
        println!("{step} degrees from {source:?}: mean {mean:.1e}, largest {largest:.1e}");
        assert!(mean < mean_bound && largest < largest_bound, "{source:?}: {mean:e} {largest:e}");
    }
}

#[test]
fn distances_on_the_earth_are_those_of_geodesics() {
    check_whole_earth(1.0, 6e-6, 1e-4);
    check_whole_earth(0.5, 2e-6, 5e-5);
}

/// The shortest ways between places of a polar cap stay in it. `cargo bench --bench closed -- Earth` measures the whole
/// Earth.
#[test]
fn distances_at_a_tenth_of_a_degree_are_those_of_geodesics() {
    let cap = Earth::new(lines(151, 90.0, -0.1), lines(3601, -180.0, 0.1));
    for source in [[13.0, 82.0], [180.0, 78.0], [75.0, 89.0], [0.0, 90.0]] {
        let [mean, largest] = cap.errors(source, &cap.map(source));
        println!("a cap from {source:?}: mean {mean:.1e}, largest {largest:.1e}");
        assert!(mean < 1e-7 && largest < 1e-4, "{source:?}: {mean:e} {largest:e}");
    }
}

/// Other grids of the Earth give maps of the same accuracy: from south to north, from 0 to 359 degrees, at the middles
/// of cells.
#[test]
fn grids_of_any_order_and_place_are_the_same_earth() {
    let step = 1.0;
    let grids = [
        ("southwards", lines(181, 90.0, -step), lines(361, -180.0, step)),
        ("northwards", lines(181, -90.0, step), lines(361, 0.0, step)),
        ("without a repeated column", lines(181, 90.0, -step), lines(360, 0.0, step)),
        ("westwards", lines(181, 90.0, -step), lines(360, 180.0, -step)),
        ("cells", lines(180, 89.5, -step), lines(360, 0.5, step)),
        ("without poles", lines(179, -89.0, step), lines(360, -179.5, step)),
    ];
    for (name, latitudes, longitudes) in grids {
        let earth = Earth::new(latitudes, longitudes);
        let on_lines = |lines: &[f64], wanted: f64| {
            let near = |a: &&f64, b: &&f64| (*a - wanted).abs().total_cmp(&(*b - wanted).abs());
            *lines.iter().min_by(near).unwrap()
        };
        let source = [on_lines(&earth.longitudes, 13.0), on_lines(&earth.latitudes, 52.0)];
        let [mean, largest] = earth.errors(source, &earth.map(source));
        println!("{name}: mean {mean:.1e}, largest {largest:.1e}");
        assert!(mean < 6e-6 && largest < 2e-4, "{name}: {mean:e} {largest:e}");
    }
}

/// Measured: mean 1.1e-6, largest 6.9e-6. In double precision: mean 1.0e-6, largest 1.9e-6.
#[test]
fn single_precision_costs_few_digits_at_half_a_degree() {
    let earth = Earth::new(lines(361, 90.0, -0.5), lines(721, -180.0, 0.5));
    let source = [13.0, 52.0];
    let [row, col] = earth.grid.place(source).unwrap();
    let options = Options::default().with_engine(Engine::Cpu);
    let map = distance_map(&earth.surface, &Sources::point(row, col), &options).unwrap();
    let distances: Vec<_> = map.distances.iter().map(|&distance| f64::from(distance)).collect();
    let [mean, largest] = earth.errors(source, &distances);
    println!("single precision: mean {mean:.1e}, largest {largest:.1e}");
    assert!(mean < 3e-6 && largest < 5e-5, "{mean:e} {largest:e}");
}
