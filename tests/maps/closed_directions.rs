//! Ways back, back links and log maps on closed surfaces, against closed forms.

use geosweep::geometry::{BackDirections, LogMap, MapError, NO_LINK};
use geosweep::glam::{DVec2, DVec3};
use geosweep::surface::{Direction, EdgeLengths, Gluing, Run};
use geosweep::{Sources, Surface};

use crate::common::closed::{angle as angle_between, *};
use crate::common::cpu_map;

/// The angles between ways back and exact ones: their mean, the mean at points with copies, and the largest.
struct Angles {
    mean: f64,
    on_seams: f64,
    largest: f64,
}

/// Compares ways with exact ways. `angle` returns the angle between the two at a point, given its index, row and
/// column, or `None` to leave the point out.
fn angles(
    name: &str,
    surface: &Surface,
    angle: impl Fn(usize, usize, usize) -> Option<f64>,
) -> Angles {
    let copies = surface.copies().unwrap().members();
    let (mut sums, mut counts, mut largest) = ([0.0; 2], [0; 2], 0f64);
    for index in 0..surface.chart().points() {
        let (row, col) = surface.chart().position(index);
        let Some(angle) = angle(index, row, col) else { continue };
        largest = largest.max(angle);
        for k in 0..=usize::from(copies.contains(&(index as u32))) {
            (sums[k], counts[k]) = (sums[k] + angle, counts[k] + 1);
        }
    }
    let [mean, on_seams] = [0, 1].map(|k| sums[k] / f64::from(counts[k]));
    println!("{name}: mean {mean:.1e}, on seams {on_seams:.1e}, largest {largest:.1e}");
    assert!(counts[1] > 50, "{name}: {counts:?}");
    Angles { mean, on_seams, largest }
}

/// Walks along back links from every point. Each walk must descend, and end at a point with code 0 and a distance of
/// at most `near`.
fn walk(name: &str, ways: &BackDirections, distances: &[f32], near: f32) {
    let links = ways.links();
    for from in 0..links.len() {
        assert_eq!(links[from] == NO_LINK, !distances[from].is_finite(), "{name} {from}");
        let way = ways.walk(&links, from);
        let end = *way.last().unwrap();
        if links[from] == NO_LINK {
            assert_eq!(way, [from]);
            continue;
        }
        assert!(links[end] == 0 && distances[end] <= near, "{name}: {from} ends at {end}");
        // Copies of a point may differ by rounding.
        let descends = |a: &usize, b: &usize| distances[*b] <= distances[*a] * (1.0 + 1e-6);
        assert!(way.is_sorted_by(descends), "{name} {from}");
    }
}

#[test]
fn ways_back_pass_the_seams_of_flat_surfaces() {
    for (name, gluing, shape) in shapes() {
        let surface = flat(41, 65).with_gluing(gluing).unwrap();
        let edges = EdgeLengths::new(&surface).unwrap();
        for source in [[12.0, 5.0], [20.3, 63.6], [9.0, 0.0]] {
            let sources = Sources::point(source[0], source[1]);
            let distances = cpu_map(&surface, &sources).distances;
            let ways = BackDirections::new(&surface, &edges, &sources, &distances).unwrap();
            let (found, compass) = (ways.in_chart(), ways.compass());
            let angle = |index: usize, row: usize, col: usize| {
                let at = [row as f64, col as f64];
                let exact = shape.way(at, source);
                if !shape.is_smooth(at, source) || exact.length() < 1e-9 {
                    return None;
                }
                let way = DVec2::from(found[index].map(f64::from));
                let degrees = f64::from(compass[index]).to_radians();
                assert!(DVec2::new(-degrees.cos(), degrees.sin()).distance(way) < 1e-5);
                Some(way.angle_to(exact).abs())
            };
            let name = format!("{name} from {source:?}");
            let Angles { mean, on_seams, largest } = angles(&name, &surface, angle);
            assert!(mean < 4e-6 && on_seams < 4e-6 && largest < 1e-4, "{name}");
            walk(&name, &ways, &distances, 1.0);
        }
    }
}

/// Returns the angles on a sphere in space, and checks the walks on it.
fn on_sphere(name: &str, surface: &Surface, source: [usize; 2]) -> Angles {
    let edges = EdgeLengths::new(surface).unwrap();
    let sources = Sources::point(source[0] as f64, source[1] as f64);
    let distances = cpu_map(surface, &sources).distances;
    let ways = BackDirections::new(surface, &edges, &sources, &distances).unwrap();
    let found = ways.in_space().unwrap();
    let from = surface.position(source[0], source[1]).unwrap();
    let angle = |index: usize, row, col| {
        let at = surface.position(row, col)?;
        let exact = (from - at * from.dot(at)).normalize();
        // The antipode has a shortest path in every direction.
        if at.dot(from) < -0.995 || at.dot(from) > 1.0 - 1e-9 {
            return None;
        }
        let way = DVec3::from(found[index].map(f64::from));
        assert!((way.length() - 1.0).abs() < 1e-5, "{name} {row},{col}: {way}");
        Some(angle_between(way, exact))
    };
    let name = format!("{name} from {source:?}");
    walk(&name, &ways, &distances, 0.2);
    angles(&name, surface, angle)
}

#[test]
fn ways_back_pass_poles_and_folds() {
    // The last source lies beside a pole, where cells are thin.
    for (source, largest) in [([30, 10], 0.06), ([22, 0], 0.06), ([0, 40], 0.06), ([59, 100], 0.2)]
    {
        let found = on_sphere("globe", &globe(61, 121), source);
        assert!(found.mean < 1e-3 && found.on_seams < 2e-4 && found.largest < largest);
    }
    for source in [[30, 20], [0, 40], [0, 25]] {
        // Rows and columns bend at the equator, where they have no tangents.
        let found = on_sphere("octahedral map", &octahedral(40), source);
        assert!(found.mean < 1e-2 && found.on_seams < 2e-2 && found.largest < 0.9);
    }
    let found = on_sphere("cube", &cube(31), [10, 20]);
    assert!(found.mean < 1e-3 && found.on_seams < 1e-3 && found.largest < 0.06);
}

#[test]
fn runs_of_points_without_positions_are_refused() {
    let run = |row| Run { from: (row, 0), to: Direction::East, points: 9 };
    let plane = flat(9, 9).with_gluing(Gluing::Runs(vec![[run(0), run(8)]])).unwrap();
    let edges = EdgeLengths::new(&plane).unwrap();
    let sources = Sources::point(3.0, 3.0);
    let distances = cpu_map(&plane, &sources).distances;
    let refused = BackDirections::new(&plane, &edges, &sources, &distances);
    assert!(matches!(refused, Err(MapError::Glued(_))), "{refused:?}");
}

/// Returns the mean and the largest error of a log map, both divided by the farthest distance. Points at which
/// `exact` is `None` are left out.
fn log_errors(
    name: &str,
    surface: &Surface,
    source: [f64; 2],
    exact: impl Fn(&LogMap, usize, usize) -> Option<DVec2>,
) -> [f64; 2] {
    let log_map = LogMap::new(surface, &Sources::point(source[0], source[1])).unwrap();
    let (mut sum, mut count, mut largest, mut farthest) = (0.0, 0, 0f64, 0f64);
    for (index, found) in log_map.coordinates.iter().enumerate() {
        let (row, col) = surface.chart().position(index);
        let Some(exact) = exact(&log_map, row, col) else { continue };
        let error = exact.distance(DVec2::from(found.map(f64::from)));
        assert!(!error.is_nan(), "{name} {row},{col}");
        (sum, count) = (sum + error, count + 1);
        (largest, farthest) = (largest.max(error), farthest.max(exact.length()));
    }
    let errors = [sum / f64::from(count) / farthest, largest / farthest];
    println!("{name}: log map off by {:.1e}, at most {:.1e}", errors[0], errors[1]);
    for group in surface.copies().unwrap().iter() {
        let first = log_map.coordinates[group[0] as usize].map(f32::to_bits);
        let is_first = |copy: &u32| log_map.coordinates[*copy as usize].map(f32::to_bits) == first;
        assert!(group.iter().all(is_first), "{name}: copies");
    }
    errors
}

#[test]
fn log_maps_go_on_over_seams() {
    for (name, gluing, shape) in shapes() {
        let surface = flat(41, 65).with_gluing(gluing).unwrap();
        for source in [[12.0, 5.0], [20.3, 63.6], [9.0, 0.0]] {
            let exact = |_: &LogMap, row: usize, col: usize| {
                let at = [row as f64, col as f64];
                let way = shape.way(source, at);
                shape.is_smooth(at, source).then(|| DVec2::new(way.y, way.x))
            };
            let [mean, largest] = log_errors(name, &surface, source, exact);
            assert!(mean < 1e-7 && largest < 2e-6, "{name} {source:?}");
        }
    }
    let globe = globe(91, 181);
    for source in [[45, 15], [33, 0], [37, 177]] {
        let from = globe.position(source[0], source[1]).unwrap();
        let exact = |log_map: &LogMap, row: usize, col: usize| {
            let at = globe.position(row, col)?;
            let way = (at - from * from.dot(at)).normalize_or_zero();
            let way = way * angle_between(at, from);
            let axes = log_map.bases[0].in_space?;
            // Farther from the source, moving it by a grid step turns the ways by too much for the differences
            // from which log maps are computed.
            (at.dot(from) > f64::cos(2.0))
                .then(|| DVec2::from(axes.map(|axis| way.dot(axis.into()))))
        };
        let [mean, largest] = log_errors("globe", &globe, source.map(|at| at as f64), exact);
        assert!(mean < 1e-4 && largest < 6e-4, "globe {source:?}: {mean} {largest}");
    }
}

/// A source that moves along a row beside a pole turns away from its straight lines. Errors grow with the square of the
/// angle between columns.
#[test]
fn log_maps_beside_poles_are_those_of_the_sphere() {
    let cases = [
        (91, 181, [5, 33]),
        (91, 181, [2, 90]),
        (91, 181, [88, 7]),
        (61, 121, [55, 33]),
        (33, 65, [27, 0]),
        (32, 17, [2, 6]),
        (41, 101, [39, 77]),
    ];
    for (rows, cols, source) in cases {
        let globe = globe(rows, cols);
        let from = globe.position(source[0], source[1]).unwrap();
        let exact = |log_map: &LogMap, row: usize, col: usize| {
            let at = globe.position(row, col)?;
            let way = (at - from * from.dot(at)).normalize_or_zero() * angle_between(at, from);
            let axes = log_map.bases[0].in_space?;
            (at.dot(from) > f64::cos(1.8))
                .then(|| DVec2::from(axes.map(|axis| way.dot(axis.into()))))
        };
        let name = format!("{rows} x {cols} from {source:?}");
        let [mean, largest] = log_errors(&name, &globe, source.map(|at| at as f64), exact);
        let angle = std::f64::consts::TAU / (cols - 1) as f64;
        assert!(mean < 0.1 * angle * angle, "{name}: {mean} {largest}");
        assert!(largest < 0.5 * angle * angle, "{name}: {mean} {largest}");
    }
}
