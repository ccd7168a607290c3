//! Ways back, back links, nearest sources and log maps against closed forms.

use geosweep::geometry::{BackDirections, LogMap, LogMapError, NO_LINK, Nearest};
use geosweep::glam::{DMat2, DVec2};
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{Monitor, Sources, Spacing, Surface};

use crate::common::closed::flat;
use crate::common::{cpu_map, rough};

/// Returns the metric at a place of a built-in surface, from exact lengths of small steps.
fn metric(builtin: Builtin, size: usize, at: DVec2) -> DMat2 {
    let length = |step: DVec2| {
        let ends = [-1e-3, 1e-3].map(|k| (at + k * step).to_array());
        builtin.exact_distance(size, size, ends[0], ends[1]).unwrap() / 2e-3
    };
    let (rr, cc) = (length(DVec2::X).powi(2), length(DVec2::Y).powi(2));
    let rc = 0.5 * (length(DVec2::ONE).powi(2) - rr - cc);
    DMat2::from_cols_array(&[rr, rc, rc, cc])
}

/// Returns the mean and the largest angle between the computed and the exact ways back, at one in `every`
/// points. A point is left out if `counts` is false for the column component of its exact way.
fn angles(
    builtin: Builtin,
    size: usize,
    source: [f64; 2],
    every: usize,
    counts: impl Fn(f64) -> bool,
) -> [f64; 2] {
    let surface = builtin.surface(size, size).unwrap();
    let edges = EdgeLengths::new(&surface).unwrap();
    let sources = Sources::point(source[0], source[1]);
    let distances = cpu_map(&surface, &sources).distances;
    let ways = BackDirections::new(&surface, &edges, &sources, &distances).unwrap().in_chart();
    let exact = |at: DVec2| builtin.exact_distance(size, size, at.to_array(), source).unwrap();
    let (mut sum, mut worst, mut count) = (0.0, 0.0f64, 0);
    for index in (0..size * size).step_by(every) {
        let at = DVec2::new((index / size) as f64, (index % size) as f64);
        let change = [DVec2::X, DVec2::Y].map(|axis| {
            let inside = |at: DVec2| at.clamp(DVec2::ZERO, DVec2::splat((size - 1) as f64));
            let ends = [-1e-4, 1e-4].map(|k| inside(at + k * axis));
            (exact(ends[1]) - exact(ends[0])) / (ends[1] - ends[0]).dot(axis)
        });
        let metric = if builtin == Builtin::Maze {
            DMat2::from_diagonal(DVec2::splat(1.0 / ((size - 1) as f64).powi(2)))
        } else if at.min_element() < 1.0 || at.max_element() > (size - 2) as f64 {
            continue;
        } else {
            metric(builtin, size, at)
        };
        let exact = -(metric.inverse() * DVec2::from(change));
        let length = exact.dot(metric * exact).sqrt();
        let is_unit = (length - 1.0).abs() < 1e-4;
        // Where shortest paths of two directions meet, or in a wall, there is no exact way.
        if at == DVec2::from(source) || !is_unit || !counts(exact.y) {
            continue;
        }
        let way = DVec2::from(ways[index].map(f64::from));
        let cross = exact.perp_dot(way) * metric.determinant().sqrt();
        let angle = cross.atan2(exact.dot(metric * way)).abs();
        assert!(angle < std::f64::consts::FRAC_PI_2, "{builtin} {at}: {angle}");
        (sum, worst, count) = (sum + angle, worst.max(angle), count + 1);
    }
    assert!(count > 100, "{builtin}: {count} points");
    [sum / f64::from(count), worst]
}

#[test]
fn ways_back_are_those_of_closed_forms() {
    for (builtin, mean, largest) in [
        (Builtin::Plane, 3e-6, 1e-4),
        (Builtin::ShearedPlane { degrees: 30.0 }, 5e-6, 1e-4),
        (Builtin::Sphere, 1e-4, 1e-2),
        (Builtin::Cylinder, 1e-5, 1e-3),
        (Builtin::Cone, 1e-3, 0.2),
    ] {
        for source in [[20.0, 30.0], [20.3, 30.6]] {
            let [found, worst] = angles(builtin, 65, source, 1, |_| true);
            assert!(found < mean && worst < largest, "{builtin} {source:?}: {found} {worst}");
        }
    }
}

#[test]
fn ways_back_turn_around_the_corners_of_a_maze() {
    let [mean, worst] = angles(Builtin::Maze, 101, [50.0, 50.0], 11, |_| true);
    assert!(mean < 1e-3 && worst < 0.2, "{mean} {worst}");
}

/// Follows back links from every reached point to a point with link 0, and returns the number of these walks.
/// Asserts that times decrease at each step, and that exactly the reached points have links.
fn walk(surface: &Surface, sources: &Sources) -> usize {
    const STEPS: [(isize, isize); 8] =
        [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)];
    let edges = EdgeLengths::new(surface).unwrap();
    let distances = cpu_map(surface, sources).distances;
    let ways = BackDirections::new(surface, &edges, sources, &distances).unwrap();
    let links = ways.links();
    let cols = surface.cols();
    let mut arrived = 0;
    for start in 0..links.len() {
        assert_eq!(links[start] == NO_LINK, !distances[start].is_finite(), "{start}");
        if links[start] == NO_LINK {
            continue;
        }
        let mut at = start;
        while links[at] != 0 {
            let (down, right) = STEPS[links[at] as usize - 1];
            let next = at.checked_add_signed(down * cols as isize + right).unwrap();
            assert_eq!((next % cols) as isize - (at % cols) as isize, right, "over the border");
            assert!(distances[next] < distances[at], "{at} to {next}");
            at = next;
        }
        arrived += 1;
    }
    arrived
}

#[test]
fn back_links_lead_to_a_source_from_every_reached_point() {
    let maze = Builtin::Maze.surface(81, 81).unwrap();
    assert_eq!(walk(&maze, &Sources::point(0.0, 0.0)), maze.points());
    for holes in [0, 5] {
        let surface = rough(60, 47, holes);
        let (row, col) = (0..60 * 47)
            .map(|index| (index / 47, index % 47))
            .find(|&(row, col)| row > 20 && col > 20 && surface.has(row, col))
            .unwrap();
        let sources = Sources::point(row as f64, col as f64);
        assert!(walk(&surface, &sources) > surface.points() / 2);
    }
    for builtin in [Builtin::Sphere, Builtin::Peaks, Builtin::Face] {
        let surface = builtin.surface(50, 61).unwrap();
        let sources = Sources::point(20.4, 30.7).and_point(33.0, 12.0, 0.01);
        assert_eq!(walk(&surface, &sources), surface.points());
    }
    let slope = Sources::curve([[3.2, 2.1], [20.7, 36.9]]);
    assert_eq!(walk(&flat(30, 40), &slope), 1200);
}

#[test]
fn hand_made_grids_have_the_published_codes_and_degrees() {
    let surface = flat(3, 3);
    let edges = EdgeLengths::new(&surface).unwrap();
    let sources = Sources::point(1.0, 1.0);
    let distances = cpu_map(&surface, &sources).distances;
    let ways = BackDirections::new(&surface, &edges, &sources, &distances).unwrap();
    assert_eq!(ways.links(), [2, 3, 4, 1, 0, 5, 8, 7, 6]);
    let near = |found: Vec<f32>, expected: [f32; 9]| {
        for (found, expected) in found.into_iter().zip(expected) {
            approx::assert_abs_diff_eq!(found, expected, epsilon = 1e-3);
        }
    };
    near(ways.compass(), [135.0, 180.0, 225.0, 90.0, 0.0, 270.0, 45.0, 360.0, 315.0]);
    near(ways.grass(), [315.0, 270.0, 225.0, 360.0, 0.0, 180.0, 45.0, 90.0, 135.0]);

    // A wall cuts the last column off. Rows are farther apart than columns, which bearings take into account.
    let mut heights = vec![0.0; 20];
    (0..4).for_each(|row| heights[row * 5 + 3] = f64::NAN);
    let surface = Surface::from_heights(4, 5, heights, Spacing { dx: 1.0, dy: 2.0 }).unwrap();
    let edges = EdgeLengths::new(&surface).unwrap();
    let sources = Sources::point(0.0, 0.0);
    let distances = cpu_map(&surface, &sources).distances;
    let ways = BackDirections::new(&surface, &edges, &sources, &distances).unwrap();
    let (compass, links) = (ways.compass(), ways.links());
    approx::assert_abs_diff_eq!(compass[5 + 2], 315.0, epsilon = 1e-3);
    assert_eq!([compass[4], compass[3]], [-1.0; 2]);
    assert_eq!([links[4], links[3], links[0], links[1]], [NO_LINK, NO_LINK, 0, 5]);
    assert!(ways.in_chart()[4][0].is_nan() && ways.in_space().unwrap()[4][0].is_nan());
    assert_eq!(ways.in_space().unwrap()[0], [0.0; 3]);
}

/// Returns the mean error of a log map, divided by the farthest distance. The exact log map is the negative
/// gradient of half the squared distance with respect to the source's place.
fn log_error(builtin: Builtin, size: usize, source: [f64; 2], step: f64) -> f64 {
    let surface = builtin.surface(size, size).unwrap();
    let log_map = LogMap::new(&surface, &Sources::point(source[0], source[1])).unwrap();
    let from = |moved: DVec2| {
        builtin.reference_distances(size, size, (DVec2::from(source) + moved).to_array())
    };
    let slopes = [DVec2::X, DVec2::Y].map(|axis| {
        let (back, ahead) = (from(-step * axis), from(step * axis));
        let slope = |(a, b): (f64, f64)| (b * b - a * a) / (4.0 * step);
        back.into_iter().zip(ahead).map(slope).collect::<Vec<_>>()
    });
    let farthest = from(DVec2::ZERO).into_iter().fold(0.0, f64::max);
    let basis = log_map.bases[0];
    let error = |(index, found): (usize, &[f32; 2])| {
        let slope = DVec2::new(slopes[0][index], slopes[1][index]);
        let exact = [basis.u, basis.v].map(|axis| -slope.dot(axis.into()));
        DVec2::from(exact).distance(DVec2::from(found.map(f64::from)))
    };
    let errors = log_map.coordinates.iter().enumerate().map(error);
    errors.sum::<f64>() / (size * size) as f64 / farthest
}

#[test]
fn log_maps_are_those_of_closed_forms() {
    for (builtin, limit) in
        [(Builtin::Plane, 1e-6), (Builtin::Sphere, 1e-5), (Builtin::Cylinder, 1e-6)]
    {
        for source in [[64.0, 64.0], [30.3, 40.6]] {
            let error = log_error(builtin, 129, source, 1e-3);
            assert!(error < limit, "{builtin} {source:?}: {error}");
        }
    }
    let torus = log_error(Builtin::Torus, 129, [64.0, 64.0], 0.25);
    assert!(torus < 1e-5, "torus: {torus}");
}

#[test]
fn places_of_a_log_map_are_found_again() {
    let surface = Builtin::Sphere.surface(65, 65).unwrap();
    let sources = Sources::point(20.3, 30.6).and_point(50.0, 50.0, 0.1);
    let log_map = LogMap::new(&surface, &sources).unwrap();
    let (mut found, mut count) = (0, 0);
    for index in (0..65 * 65).step_by(7) {
        let source = log_map.labels[index] as usize;
        let coordinates = log_map.coordinates[index].map(f64::from);
        count += 1;
        // A walk that grazes the border of its region may find no place.
        let Some(place) = log_map.place(source, coordinates) else { continue };
        found += 1;
        let at = DVec2::new((index / 65) as f64, (index % 65) as f64);
        assert!(DVec2::from(place).distance(at) < 1e-4, "{at} {place:?}");
    }
    assert!(found * 10 > count * 9, "{found} of {count}");
    assert_eq!(log_map.place(0, [3.0, 0.0]), None);
}

#[test]
fn paths_leave_their_source_in_the_direction_of_the_log_map() {
    // Behind a wall, all ways leave the source towards the wall's end.
    let mut heights = vec![0.0; 21 * 21];
    (0..15).for_each(|row| heights[row * 21 + 10] = f64::NAN);
    let surface = Surface::from_heights(21, 21, heights, Spacing::square(1.0)).unwrap();
    let log_map = LogMap::new(&surface, &Sources::point(10.0, 4.0)).unwrap();
    let compass = log_map.source_compass(&surface);
    let exact = (6.0f32).atan2(-5.0).to_degrees();
    for (row, col) in [(3, 15), (10, 18), (0, 12)] {
        approx::assert_abs_diff_eq!(compass[row * 21 + col], exact, epsilon = 0.5);
    }
    approx::assert_abs_diff_eq!(compass[4], 360.0, epsilon = 0.01);
    assert_eq!((compass[10 * 21 + 4], compass[10]), (0.0, -1.0));
    let curve = LogMap::new(&surface, &Sources::curve([[1.0, 1.0], [5.0, 2.0]]));
    assert!(matches!(curve, Err(LogMapError::Curve { source_index: 0 })));
    assert!(LogMap::new(&surface, &Sources::point(0.0, 10.0)).is_err());
}

#[test]
fn a_cancelled_log_map_is_an_error() {
    let monitor = Monitor::default();
    let found = |monitor| LogMap::watched(&flat(15, 15), &Sources::point(3.0, 4.0), monitor);
    assert!(found(&monitor).is_ok());
    monitor.cancel();
    assert!(matches!(found(&monitor), Err(LogMapError::Cancelled(_))));
}

#[test]
fn nearest_sources_and_their_places() {
    let surface = flat(25, 31);
    let edges = EdgeLengths::new(&surface).unwrap();
    let sources = Sources::curve([[2.0, 3.0], [2.0, 27.0]]).and_point(20.0, 15.0, 0.0);
    let distances = cpu_map(&surface, &sources).distances;
    let nearest = Nearest::new(&surface, &edges, &sources, &distances).unwrap();
    for (index, (&source, &[row, col])) in nearest.sources.iter().zip(&nearest.places).enumerate() {
        let at = DVec2::new((index / 31) as f64, (index % 31) as f64);
        let exact = match source {
            0 => DVec2::new(2.0, at.y.clamp(3.0, 27.0)),
            1 => DVec2::new(20.0, 15.0),
            other => panic!("{other}"),
        };
        assert!(exact.distance(DVec2::new(row, col)) < 0.05, "{at}: {row},{col}");
    }
}
