//! Small surfaces of any kind with sources: a map consists of numbers, and reaches all connected points.

use std::f64::consts::TAU;

use geosweep::glam::DVec3;
use geosweep::surface::{Direction, Real};
use geosweep::{
    DistanceMap, EdgeRule, Engine, Error, MetricTensor, Options, Sources, Spacing, Surface,
    Wavefront, distance_map, distance_map_f64,
};

use super::dice::Dice;

/// Largest number of rows and columns.
const LARGEST_SIDE: usize = 24;
const MOST_SOURCES: usize = 8;

/// A surface with its sources, and the method of its map.
struct Case {
    surface: Surface,
    sources: Sources,
    wavefront: Option<Wavefront>,
    engine: Engine,
    double: bool,
}

/// A map in either precision.
struct Solved {
    distances: Vec<f64>,
    iterations: u32,
    reached: usize,
}

/// Properties of every map. A new property needs only an entry here.
const CHECKS: [fn(&Case, &Solved); 3] = [is_of_numbers, reaches_what_is_connected, ends];

pub fn surface(data: &[u8]) {
    let case = Case::of(&mut Dice::new(data));
    match case.solved() {
        Ok(solved) => CHECKS.iter().for_each(|check| check(&case, &solved)),
        // The source is in a hole, the wavefront is not suitable, or single precision cannot hold the
        // lengths.
        Err(Error::Source(_) | Error::Options(_) | Error::Surface(_)) => {}
        Err(other) => panic!("{other}"),
    }
}

/// Asserts that no distance is NaN, and that the number of finite distances is the reported number of reached points.
fn is_of_numbers(_: &Case, solved: &Solved) {
    assert!(solved.distances.iter().all(|distance| *distance > f64::NEG_INFINITY), "NaN or less");
    let finite = solved.distances.iter().filter(|distance| distance.is_finite()).count();
    assert_eq!(finite, solved.reached);
}

/// Asserts that exactly the points that edges connect with a source have a distance.
fn reaches_what_is_connected(case: &Case, solved: &Solved) {
    let chart = case.surface.chart();
    let seeds = case.sources.seeds(&case.surface).unwrap();
    let mut connected = vec![false; chart.points()];
    let mut front: Vec<_> = seeds.iter().map(|seed| (seed.row, seed.col)).collect();
    while let Some((row, col)) = front.pop() {
        if std::mem::replace(&mut connected[chart.index(row, col)], true) {
            continue;
        }
        let edges = Direction::ALL.into_iter().filter(|&to| case.surface.has_edge(row, col, to));
        front.extend(edges.filter_map(|to| chart.neighbour(row, col, to)));
    }
    for (index, (distance, connected)) in solved.distances.iter().zip(connected).enumerate() {
        let place = chart.position(index);
        assert_eq!(distance.is_finite(), connected, "{place:?}: {distance}");
    }
}

/// Asserts that a map ends within a number of iterations that depends on its size, even if it does not converge.
fn ends(case: &Case, solved: &Solved) {
    let enough = 10 * (case.surface.rows() + case.surface.cols());
    assert!(solved.iterations as usize <= enough, "{} iterations", solved.iterations);
}

impl Case {
    fn of(dice: &mut Dice) -> Self {
        let surface = any_surface(dice);
        let sources = any_sources(dice, &surface);
        let fronts = [
            None,
            Some(Wavefront::Curved),
            Some(Wavefront::Circular),
            Some(Wavefront::Planar),
            Some(Wavefront::Anchored),
        ];
        let marches = dice.once_in(8);
        Self {
            surface,
            sources,
            wavefront: dice.one_of(&fronts),
            engine: if marches { Engine::FastMarching } else { Engine::Cpu },
            double: dice.once_in(4),
        }
    }

    fn solved(&self) -> Result<Solved, Error> {
        let options =
            Options::default().with_engine(self.engine.clone()).with_wavefront(self.wavefront);
        if self.double {
            return distance_map_f64(&self.surface, &self.sources, &options).map(Solved::of);
        }
        distance_map(&self.surface, &self.sources, &options).map(Solved::of)
    }
}

impl Solved {
    fn of<R: Real>(map: DistanceMap<R>) -> Self {
        Self {
            distances: map.distances.iter().map(|distance| distance.wide()).collect(),
            iterations: map.report.iterations,
            reached: map.report.reached,
        }
    }
}

/// Returns a surface of any kind. Its relief is from 0 to 100 row spacings, its shear up to 3 row spacings from row
/// to row, and its cells are up to ten times as long as wide or as wide as long. It may have holes and a slowness.
fn any_surface(dice: &mut Dice) -> Surface {
    let (rows, cols) = (1 + dice.below(LARGEST_SIDE), 1 + dice.below(LARGEST_SIDE));
    let unit = if dice.once_in(4) { dice.magnitude(1e-6..1e6) } else { 1.0 };
    let stretch = if dice.once_in(2) { dice.magnitude(0.1..10.0) } else { 1.0 };
    let spacing = Spacing { dx: unit * stretch, dy: unit };
    let relief = if dice.once_in(4) { 0.0 } else { unit * dice.magnitude(0.01..100.0) };
    let heights = any_heights(dice, rows, cols);
    let height = |index: usize| relief * heights[index];
    let shear = if dice.once_in(2) { dice.within(-3.0..3.0) } else { 0.0 };
    let surface = match dice.below(3) {
        0 => {
            let heights = (0..rows * cols).map(height).collect();
            Surface::from_heights(rows, cols, heights, spacing)
        }
        1 => {
            let position = |index: usize| {
                let (row, col) = ((index / cols) as f64, (index % cols) as f64);
                DVec3::new(
                    spacing.dx * col + shear * spacing.dy * row,
                    spacing.dy * row,
                    height(index),
                )
            };
            Surface::from_positions(rows, cols, (0..rows * cols).map(position).collect())
        }
        _ => {
            let tensor = |index: usize| {
                let scale = (1.0 + relief / unit * heights[index].abs()).powi(2);
                let (down, right) = (spacing.dy, spacing.dx);
                MetricTensor {
                    rr: scale * down * down * (1.0 + shear * shear),
                    rc: scale * right * shear * down,
                    cc: scale * right * right,
                }
            };
            Surface::from_metric(rows, cols, (0..rows * cols).map(tensor).collect())
        }
    };
    let mut surface = surface.expect("a finite surface");
    if dice.once_in(3) {
        let share = dice.within(0.0..1.0);
        let mut mask: Vec<_> = (0..rows * cols).map(|_| dice.within(0.0..1.0) >= share).collect();
        mask[dice.below(rows * cols)] = true;
        surface = surface.with_mask(&mask).expect("a point is left");
    }
    if dice.once_in(4) {
        let jump = dice.magnitude(1.0..100.0);
        let slowness = (0..rows * cols).map(|_| dice.magnitude(1.0 / jump..jump)).collect();
        surface = surface.with_slowness(slowness).expect("all are positive");
    }
    surface.with_edge_rule(dice.one_of(&[EdgeRule::Arc, EdgeRule::Chord]))
}

/// Returns heights of about -1 to 1: noise, waves or steps.
fn any_heights(dice: &mut Dice, rows: usize, cols: usize) -> Vec<f64> {
    let form = dice.below(3);
    let waves = [0; 4].map(|_| dice.within(0.0..1.5));
    let mut height = |index: usize| {
        let (row, col) = ((index / cols) as f64, (index % cols) as f64);
        match form {
            0 => dice.within(-1.0..1.0),
            1 => (waves[0] * row + waves[1] * col).sin() * (waves[2] * row - waves[3] * col).cos(),
            _ => ((waves[0] * row + waves[1] * col + TAU * waves[2]) % 2.0).floor(),
        }
    };
    (0..rows * cols).map(&mut height).collect()
}

/// Returns points and curves, on grid points or between them, with equal or different start values.
fn any_sources(dice: &mut Dice, surface: &Surface) -> Sources {
    let (rows, cols) = (surface.rows(), surface.cols());
    let together = dice.once_in(2);
    let mut sources = Sources::default();
    for _ in 0..=dice.below(MOST_SOURCES) {
        let on_points = dice.once_in(2);
        let mut place = || {
            let place = [(rows - 1) as f64, (cols - 1) as f64].map(|end| dice.within(0.0..end));
            if on_points { place.map(f64::round) } else { place }
        };
        let vertices: Vec<_> = (0..6).map(|_| place()).collect();
        let start = if together { 0.0 } else { dice.within(-10.0..10.0) };
        sources = match dice.below(4) {
            0 => sources.and_curve(vertices[..1 + dice.below(6)].to_vec(), start),
            _ => sources.and_point(vertices[0][0], vertices[0][1], start),
        };
    }
    sources
}
