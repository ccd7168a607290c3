//! Grids whose steps differ from line to line: paths, directions and log maps, which compare times at several points in
//! a row, and maps of several sources in long cells.

use std::f64::consts::{PI, TAU};

use geosweep::geometry::{LogMap, PathTracer};
use geosweep::glam::{DVec2, DVec3};
use geosweep::surface::{CompletedGrid, EdgeLengths, Gluing, Layout};
use geosweep::{DistanceMap, Sources, Surface, distance_map};

use crate::common::closed::{globe, grid};
use crate::common::{Random, curved};

const ROWS: usize = 20;
const COLS: usize = 30;

fn map(surface: &Surface, sources: &Sources) -> DistanceMap {
    distance_map(surface, sources, &curved()).unwrap()
}

/// Returns the coordinates of lines: each step is the one before it times what `next` returns for its number.
fn lines(count: usize, mut next: impl FnMut(usize) -> f64) -> Vec<f64> {
    let (mut at, mut step) = (vec![0.0], 1.0);
    for number in 1..count {
        step *= next(number);
        at.push(at[number - 1] + step);
    }
    at
}

/// Returns rows with a name: alternating, growing and random steps, a single jump, and even steps.
fn uneven() -> Vec<(&'static str, Vec<f64>)> {
    let mut random = Random::new(3);
    let mut before = 1.0;
    let jitter = |_| {
        let step = 1.0 + 0.6 * (random.next() - 0.5);
        std::mem::replace(&mut before, step).recip() * step
    };
    vec![
        ("alternating", lines(ROWS, |number| if number % 2 == 0 { 2.0 } else { 0.5 })),
        ("half a step at the border", lines(ROWS, |number| if number == 2 { 2.0 } else { 1.0 })),
        ("growing", lines(ROWS, |_| 1.2)),
        ("random", lines(ROWS, jitter)),
        ("one jump", lines(ROWS, |number| if number == 9 { 1.5 } else { 1.0 })),
        ("even", lines(ROWS, |_| 1.0)),
    ]
}

/// Returns planes with uneven rows, or uneven columns, and with cells of several shapes. Places are (x, y).
fn planes() -> impl Iterator<Item = (String, Surface, Vec<DVec2>)> {
    let shapes = [1.0, 3.0, 8.0].into_iter().flat_map(|aspect| [(aspect, false), (aspect, true)]);
    shapes.flat_map(|(aspect, is_turned)| {
        uneven().into_iter().map(move |(name, y)| {
            let step = y[ROWS - 1] / (ROWS - 1) as f64 / aspect;
            let [rows, cols] = if is_turned { [COLS, ROWS] } else { [ROWS, COLS] };
            let place = |index: usize| {
                let (row, col) = (index / cols, index % cols);
                match is_turned {
                    true => DVec2::new(y[col], row as f64 * step),
                    false => DVec2::new(col as f64 * step, y[row]),
                }
            };
            let places: Vec<_> = (0..rows * cols).map(place).collect();
            let positions = places.iter().map(|at| at.extend(0.0)).collect();
            let surface = Surface::from_positions(rows, cols, positions).unwrap();
            (format!("{name} {aspect} {is_turned}"), surface, places)
        })
    })
}

/// The bound is a tenth of the excess of straight lines between grid points that are rounded to the nearest one.
/// Measured: 3e-7. With second differences for even steps, paths were up to 14 % too long.
#[test]
fn paths_over_uneven_steps_are_straight() {
    for (name, surface, places) in planes() {
        let edges = EdgeLengths::new(&surface).unwrap();
        for [row, col] in [[1, 0], [7, 11], [0, 5]] {
            let sources = Sources::point(row as f64, col as f64);
            let map = map(&surface, &sources);
            let tracer = PathTracer::new(&surface, &edges, &sources, &map.distances).unwrap();
            let (taut, along) = (tracer.clone(), tracer.along_the_map());
            for index in (0..places.len()).step_by(7) {
                let (at, cols) = (places[index], surface.cols());
                let exact = at.distance(places[row * cols + col]);
                let start = [(index / cols) as f64, (index % cols) as f64];
                for (way, tracer) in [("taut", &taut), ("along the map", &along)] {
                    let length = tracer.trace(start).unwrap().length;
                    let excess = length - exact;
                    assert!(
                        excess.abs() <= 1e-4 * exact,
                        "{name} {row},{col} from {start:?} {way}: {length} {exact}"
                    );
                }
            }
        }
    }
}

/// The bound is that of smooth grids. Measured: 1e-7. With differences for even steps, half of the directions were
/// wrong by 49 degrees.
#[test]
fn log_maps_over_uneven_steps_are_flat() {
    for (name, surface, places) in planes() {
        for [row, col] in [[7.0, 11.0], [2.0, 3.0], [7.25, 11.5]] {
            let log_map = LogMap::new(&surface, &Sources::point(row, col)).unwrap();
            let cols = surface.cols();
            // Sources between grid points lie on straight lines between them.
            let corner = |row: f64, col: f64| places[row as usize * cols + col as usize];
            let [north, south] = [row.floor(), row.ceil()].map(|row| {
                let [west, east] = [col.floor(), col.ceil()].map(|col| corner(row, col));
                west.lerp(east, col.fract())
            });
            let source = north.lerp(south, row.fract());
            let farthest = places.iter().map(|at| at.distance(source)).fold(0.0, f64::max);
            let axes = log_map.bases[0].in_space.unwrap().map(DVec3::from);
            for (found, at) in log_map.coordinates.iter().zip(&places) {
                let found = DVec2::from(found.map(f64::from));
                let away = (*at - source).extend(0.0);
                let exact = DVec2::new(away.dot(axes[0]), away.dot(axes[1]));
                let off = found.distance(exact);
                assert!(off < 1e-3 * farthest, "{name} at {at}: {found} {exact}");
            }
        }
    }
}

/// The pole of a globe that is sampled at the middles of its cells lies half a step beyond the first row.
#[test]
fn paths_pass_a_pole_half_a_step_away() {
    let (rows, cols) = (45, 90);
    let given = grid(rows, cols, |row, col| {
        let south = PI * (row as f64 + 0.5) / rows as f64;
        let east = TAU * (col as f64 + 0.5) / cols as f64;
        DVec3::new(south.sin() * east.cos(), south.sin() * east.sin(), south.cos())
    });
    let position = |row, col| given.position(row, col).unwrap();
    let lines = CompletedGrid::new(&given, Layout::Globe).unwrap();
    let whole = lines.complete(&given).unwrap();
    let edges = EdgeLengths::new(&whole).unwrap();
    let place = |row: usize, col: usize| lines.to_completed([row as f64, col as f64]).unwrap();
    for [row, col] in [[0, 0], [1, 7], [10, 3]] {
        let [own_row, own_col] = place(row, col);
        let sources = Sources::point(own_row, own_col);
        let map = map(&whole, &sources);
        let tracer = PathTracer::new(&whole, &edges, &sources, &map.distances).unwrap();
        for across in [cols / 6, cols / 4, cols / 3] {
            for from in [0, 1, 5] {
                let to = (col + across) % cols;
                let exact = position(row, col).angle_between(position(from, to));
                let length = tracer.trace(place(from, to)).unwrap().length;
                let excess = length / exact - 1.0;
                assert!(excess.abs() < 5e-3, "{row},{col} from {from},{to}: {length} {exact}");
            }
        }
    }
}

fn ring(rows: usize, cols: usize, width: f64) -> Surface {
    grid(rows, cols, |row, col| {
        let angle = TAU * (col % (cols - 1)) as f64 / (cols - 1) as f64;
        let radius = 1.0 - width + 2.0 * width * row as f64 / (rows - 1) as f64;
        DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
    })
}

/// The front of each of several sources is that of a lone source where it arrives first. Without surroundings of the
/// sources, fronts were late by up to a fifth. The bound is for rings of cells of 60:1, around which rays arrive a
/// third of a percent before the exact time, and the curved front of a lone source as much after it.
#[test]
fn several_sources_in_long_cells_have_the_fronts_of_lone_ones() {
    let open = |rows, cols, width| ring(rows, cols, width);
    let closed =
        |rows, cols, width| ring(rows, cols, width).with_gluing(Gluing::columns()).unwrap();
    let cases = [
        ("ring", open(20, 25, 0.08), [[11.0, 0.0], [0.0, 12.0]]),
        ("ring", open(20, 25, 0.04), [[11.0, 6.0], [11.0, 18.0]]),
        ("ring of more columns", open(40, 49, 0.1), [[20.0, 3.0], [0.0, 30.0]]),
        ("closed ring", closed(20, 25, 0.08), [[11.0, 0.0], [0.0, 12.0]]),
        ("closed ring, inside cells", closed(20, 25, 0.08), [[11.5, 6.25], [0.0, 18.0]]),
        ("globe", globe(61, 121), [[1.0, 0.0], [40.0, 30.0]]),
        ("globe", globe(61, 121), [[2.0, 0.0], [2.0, 60.0]]),
    ];
    for (name, surface, places) in cases {
        let alone = places.map(|[row, col]| map(&surface, &Sources::point(row, col)).distances);
        let [[row, col], [other_row, other_col]] = places;
        let both = map(&surface, &Sources::point(row, col).and_point(other_row, other_col, 0.0));
        for (index, found) in both.distances.iter().enumerate() {
            let expected = alone[0][index].min(alone[1][index]);
            let at = (index / surface.cols(), index % surface.cols());
            assert!(
                (found - expected).abs() <= 7e-3 * expected + 1e-6,
                "{name} {places:?} at {at:?}: {found} {expected}"
            );
        }
    }
}
