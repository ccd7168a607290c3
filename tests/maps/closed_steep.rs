//! Steep and sheared closed surfaces, where triangles beside seams are obtuse: nothing depends on where the grid is
//! cut.

use std::f64::consts::TAU;

use geosweep::geometry::LogMap;
use geosweep::glam::{DVec2, DVec3, Vec2};
use geosweep::pairwise::{Pairwise, pairs_within};
use geosweep::surface::Gluing;
use geosweep::{
    Engine, Error, Options, Sources, Spacing, Surface, Targets, Wavefront, distance_map,
};

use crate::common::closed::grid;
use crate::common::{device_choice, difference};

const ROWS: usize = 17;
/// Number of different columns.
const ROUND: usize = 23;
const COLS: usize = ROUND + 1;

/// Returns the number of each point of a grid whose columns are rolled by `by`. Copies have the same number.
fn numbers(gluing: &Gluing, by: usize) -> Vec<usize> {
    let number = |index: usize| {
        let (row, col) = (index / COLS, index % COLS + by);
        let is_turned = *gluing == Gluing::flipped_columns() && col / ROUND % 2 == 1;
        let row = if is_turned { ROWS - 1 - row } else { row };
        let row = if *gluing == Gluing::both() { row % (ROWS - 1) } else { row };
        row * ROUND + col % ROUND
    };
    (0..ROWS * COLS).map(number).collect()
}

/// Returns a surface whose heights change by up to three times the spacing from point to point.
fn steep(gluing: &Gluing, by: usize) -> Surface {
    let height = |number: usize| 3.0 * (number as f64 * number as f64 * 0.618).fract();
    let heights = numbers(gluing, by).into_iter().map(height).collect();
    let open = Surface::from_heights(ROWS, COLS, heights, Spacing::square(1.0)).unwrap();
    open.with_gluing(gluing.clone()).unwrap()
}

fn gluings() -> [Gluing; 3] {
    [Gluing::columns(), Gluing::flipped_columns(), Gluing::both()]
}

/// Returns the index of a point with a number.
fn point(gluing: &Gluing, by: usize, number: usize) -> usize {
    numbers(gluing, by).iter().position(|&other| other == number).unwrap()
}

/// Returns values at the points of a rolled grid in the order of the grid that is not rolled.
fn unrolled(gluing: &Gluing, by: usize, values: &[f32]) -> Vec<f32> {
    let mut of_number = vec![f32::NAN; ROWS * ROUND];
    numbers(gluing, by).into_iter().zip(values).for_each(|(k, &value)| of_number[k] = value);
    numbers(gluing, 0).into_iter().map(|number| of_number[number]).collect()
}

fn options(engine: &Engine, wavefront: Wavefront) -> Options {
    Options::default().with_engine(engine.clone()).with_wavefront(wavefront)
}

/// Returns the engines. Only one gluing is tested on a device, since creating the device's pipelines takes long.
fn engines(gluing: &Gluing) -> Vec<Engine> {
    let device = (*gluing == Gluing::both()).then(|| Engine::Vulkan(device_choice()));
    [Engine::Cpu, Engine::FastMarching].into_iter().chain(device).collect()
}

const STRAIGHT: [Wavefront; 2] = [Wavefront::Planar, Wavefront::Circular];
/// The number of the source, near the seam of a grid that is not rolled.
const SOURCE: usize = 5 * ROUND + 2;

#[test]
fn maps_do_not_depend_on_where_the_grid_is_cut() {
    for gluing in gluings() {
        for (engine, wavefront) in engines(&gluing)
            .into_iter()
            .flat_map(|engine| STRAIGHT.map(|front| (engine.clone(), front)))
        {
            let map = |by: usize| {
                let surface = steep(&gluing, by);
                let (row, col) = surface.chart().position(point(&gluing, by, SOURCE));
                let sources = Sources::point(row as f64, col as f64);
                let map = distance_map(&surface, &sources, &options(&engine, wavefront)).unwrap();
                unrolled(&gluing, by, &map.distances)
            };
            let expected = map(0);
            for by in [1, 11, ROUND - 1] {
                let apart = difference(&map(by), &expected);
                assert!(apart < 1e-6, "{gluing:?}, {engine:?}, {wavefront}, {by}: {apart:e}");
            }
        }
    }
}

#[test]
fn rows_of_matrices_are_maps() {
    let sources = [SOURCE, 7 * ROUND + 11, 12 * ROUND];
    for gluing in gluings() {
        let surface = steep(&gluing, 4);
        let chart = surface.chart();
        let sources = sources.map(|number| point(&gluing, 4, number));
        for (engine, wavefront) in engines(&gluing)
            .into_iter()
            .flat_map(|engine| Wavefront::FOR_ANY_SURFACE.map(|front| (engine.clone(), front)))
        {
            let options = options(&engine, wavefront);
            let mut found = Vec::new();
            let mut pairwise = Pairwise::new(&surface, &options).unwrap();
            let report = pairwise.rows(&sources, |rows| {
                found.extend_from_slice(rows.distances);
                Ok::<_, Error>(())
            });
            assert!(report.unwrap().converged());
            for (&source, row) in sources.iter().zip(found.chunks_exact(chart.points())) {
                let (r, c) = chart.position(source);
                let map = distance_map(&surface, &Sources::point(r as f64, c as f64), &options);
                let map = map.unwrap();
                let apart = difference(row, &map.distances);
                // Rows have curved fronts where maps have rays.
                let most = if map.report.wavefront == Wavefront::Rays { 0.1 } else { 1e-5 };
                assert!(apart < most, "{gluing:?}, {engine:?}, {wavefront}: {apart:e}");
            }
        }
        let within = options(&Engine::Cpu, Wavefront::Planar).with_radius(6.0);
        let (pairs, _) = pairs_within(&surface, &sources, &within).unwrap();
        for (k, &source) in sources.iter().enumerate() {
            let (r, c) = chart.position(source);
            let map = distance_map(&surface, &Sources::point(r as f64, c as f64), &within).unwrap();
            let reached = (0..chart.points()).filter(|&index| map.distances[index].is_finite());
            assert!(pairs.row(k).map(|(index, _)| index).eq(reached), "{gluing:?}");
            assert!(pairs.row(k).all(|(index, distance)| {
                (distance - map.distances[index]).abs() <= 1e-5 * distance
            }));
        }
        let mut pairwise =
            Pairwise::new(&surface, &options(&Engine::Cpu, Wavefront::Planar)).unwrap();
        let refused = pairwise.matrix_by_symmetry(|_| Ok::<_, Error>(())).unwrap_err();
        assert!(refused.to_string().contains("not for glued surfaces"), "{refused}");
    }
}

#[test]
fn limited_maps_are_parts_of_whole_ones() {
    for gluing in gluings() {
        let surface = steep(&gluing, 9);
        let chart = surface.chart();
        let (row, col) = chart.position(point(&gluing, 9, SOURCE));
        let sources = Sources::point(row as f64, col as f64);
        let whole_options = options(&Engine::Cpu, Wavefront::Planar);
        let whole = distance_map(&surface, &sources, &whole_options).unwrap();
        let (r, c) = chart.position(point(&gluing, 9, SOURCE + 4));
        let target = whole.distance(r, c);
        for options in [
            whole_options.clone().with_radius(f64::from(target)),
            whole_options.with_targets(Targets::any([[r, c], [ROWS - 1, 12]])),
        ] {
            let map = distance_map(&surface, &sources, &options).unwrap();
            for (part, whole) in map.distances.iter().zip(&whole.distances) {
                let expected = if *whole <= target * 1.000_001 { *whole } else { f32::INFINITY };
                let apart = (part - expected).abs();
                assert!(
                    apart <= 1e-6 * expected || *part == expected,
                    "{part} {expected} {target}"
                );
            }
        }
    }
}

/// Returns a tube whose rows are turned against each other by `shear` columns.
fn sheared_tube(rows: usize, cols: usize, shear: f64) -> Surface {
    let step = TAU / (cols - 1) as f64;
    let tube = grid(rows, cols, |row, col| {
        let angle = step * ((col % (cols - 1)) as f64 + shear * row as f64);
        DVec3::new(angle.cos(), angle.sin(), step * row as f64)
    });
    tube.with_gluing(Gluing::columns()).unwrap()
}

#[test]
fn a_sheared_tube_is_a_tube() {
    let (rows, cols) = (41, 65);
    for shear in [-2.3, 1.5] {
        let surface = sheared_tube(rows, cols, shear);
        for source in [[20usize, 3], [12, 0], [30, 63]] {
            let at =
                |row: usize, col: usize| DVec2::new(row as f64, col as f64 + shear * row as f64);
            let from = at(source[0], source[1]);
            let step = TAU / 64.0;
            let way = |row: usize, col: usize| {
                let way = at(row, col) - from;
                step * DVec2::new(way.x, way.y - 64.0 * (way.y / 64.0).round())
            };
            let places = Sources::point(source[0] as f64, source[1] as f64);
            let options = options(&Engine::Cpu, Wavefront::Curved);
            let map = distance_map(&surface, &places, &options).unwrap();
            let log_map = LogMap::new(&surface, &places).unwrap();
            let (mut sums, mut counts, mut largest) = ([0.0; 3], [0; 3], 0f64);
            for index in 0..surface.chart().points() {
                let (row, col) = surface.chart().position(index);
                let way = way(row, col);
                // At the opposite line two paths are equally short.
                if (row, col) == (source[0], source[1])
                    || way.y.abs() > 0.45 * TAU
                    || way.length() == 0.0
                {
                    continue;
                }
                let error = (f64::from(map.distance(row, col)) / way.length() - 1.0).abs();
                let found = Vec2::from(log_map.coordinates[index]).as_dvec2();
                let of_log_map = (found.length() / way.length() - 1.0).abs();
                largest = largest.max(error);
                let is_beside = col < 4 || col + 4 >= cols;
                sums[usize::from(is_beside)] += error;
                counts[usize::from(is_beside)] += 1;
                (sums[2], counts[2]) = (sums[2] + of_log_map, counts[2] + 1);
            }
            let [inside, beside, logs] = [0, 1, 2].map(|k| sums[k] / f64::from(counts[k]));
            println!(
                "{shear} {source:?}: {inside:.1e} inside, {beside:.1e} beside seams, largest {largest:.1e}, log map {logs:.1e}"
            );
            assert!(map.report.converged);
            assert!(beside < 3.0 * inside + 1e-6 && largest < 1e-3 && logs < 1e-4);
        }
    }
}
