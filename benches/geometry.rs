//! Measures the time of what is computed from a distance map of 1200 x 1200 points, relative to the time of the
//! map from the same sources: `cargo bench --bench geometry`. With `-- WORD`, only the maps and the cases whose
//! names contain the word are measured.
//!
//! Edge lengths are computed outside the measured time, as for a surface that is kept. The time of
//! `distance_map` includes them.
//!
//! All cases run in turn, round by round, so that other load on the machine affects all of them equally. The
//! ratio to a map's time is therefore more meaningful than the times themselves.

use std::hint::black_box;
use std::time::{Duration, Instant};

use geosweep::Stop;
use geosweep::cpu::RotatedScan;
use geosweep::geometry::{
    FarthestPoints, Levels, PathTracer, Side, Voronoi, contours, offset_curves, ridges,
};
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{DistanceMap, Engine, Options, Sources, Surface, Wavefront, distance_map};

const STOP: Stop = Stop::within(1e-6).or_after(1000);
const PATHS: usize = 1000;

/// A case to measure.
struct Case<'a> {
    sources: &'static str,
    name: String,
    run: Box<dyn FnMut() + 'a>,
    times: Vec<Duration>,
}

/// The cases on one surface, which are measured in turn.
struct Cases<'a> {
    words: &'a [String],
    cases: Vec<Case<'a>>,
}

impl<'a> Cases<'a> {
    /// Adds a case if its name contains all words. Maps are always added.
    fn add<T>(
        &mut self,
        sources: &'static str,
        name: impl Into<String>,
        mut run: impl FnMut() -> T + 'a,
    ) {
        let name = name.into();
        let full = format!("{name}, {sources}");
        let is_wanted = self.words.iter().all(|word| full.contains(word.as_str()));
        if is_wanted || name.starts_with("map") {
            let run = Box::new(move || {
                black_box(run());
            });
            self.cases.push(Case { sources, name, run, times: Vec::new() });
        }
    }

    /// Measures all cases and prints medians. The first run of each case is not counted.
    fn time(mut self, rounds: usize) {
        for round in 0..=rounds {
            for Case { run, times, .. } in &mut self.cases {
                let start = Instant::now();
                run();
                if round > 0 {
                    times.push(start.elapsed());
                }
            }
        }
        for case in &self.cases {
            let median = case.median();
            let same = |map: &&Case| map.is_map() && map.sources == case.sources;
            let maps = self.cases.iter().filter(same).map(Case::median);
            let shares: String = maps.map(|map| format!("{:>9.2}", median / map)).collect();
            let name = format!("{}, {}", case.name, case.sources);
            println!("{name:<40} {:>9.2}{shares}", 1e3 * median);
        }
    }
}

impl Case<'_> {
    fn is_map(&self) -> bool {
        self.name.starts_with("map")
    }

    /// Returns the median time in seconds.
    fn median(&self) -> f64 {
        let mut times = self.times.clone();
        times.sort();
        times[times.len() / 2].as_secs_f64()
    }
}

/// Returns `count` places along a spiral around the middle. The places are far from one another.
fn spiral(side: usize, count: usize) -> Vec<[f64; 2]> {
    let turn = std::f64::consts::PI * (3.0 - f64::sqrt(5.0));
    let place = |k: usize| {
        let radius = 0.45 * ((k as f64 + 0.5) / count as f64).sqrt();
        let (sin, cos) = (turn * k as f64).sin_cos();
        [sin, cos].map(|x| ((side - 1) as f64 * (0.5 + radius * x)).round())
    };
    (0..count).map(place).collect()
}

/// Returns at least `count` places of a spiral that are points of the surface.
fn spiral_on(surface: &Surface, count: usize) -> Vec<[f64; 2]> {
    let is_there = |&[row, col]: &[f64; 2]| surface.has(row as usize, col as usize);
    let on = |all| spiral(surface.rows(), all).into_iter().filter(is_there).collect::<Vec<_>>();
    (count..).map(on).find(|places| places.len() >= count).unwrap_or_default()
}

fn points(places: &[[f64; 2]]) -> Sources {
    places.iter().fold(Sources::default(), |sources, &[row, col]| sources.and_point(row, col, 0.0))
}

fn solve(surface: &Surface, sources: &Sources) -> DistanceMap {
    let options = Options::default().with_engine(Engine::Cpu);
    distance_map(surface, sources, &options).expect("the surface fits")
}

fn main() {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    // Cargo passes `--bench` for measurements, and not for tests.
    let is_bench = words.iter().any(|word| word == "--bench");
    words.retain(|word| !word.starts_with('-'));
    let (side, rounds) = if is_bench { (1200, 11) } else { (60, 1) };
    for builtin in [Builtin::Sphere, Builtin::Peaks, Builtin::Maze] {
        let surface = builtin.surface(side, side).expect("built-in surfaces fit");
        let edges = EdgeLengths::<f32>::new(&surface).expect("built-in surfaces fit");
        println!(
            "\n{builtin}, {side} x {side} points: median ms, and shares of the times of the map by \
             a kept solver and by distance_map"
        );
        let (corner, middle) = (side as f64 / 20.0, (side / 2) as f64);
        let from_corner = points(&[[corner; 2]]);
        let sets = [
            ("1 source", from_corner.clone()),
            ("2 sources", points(&spiral_on(&surface, 2))),
            ("2 close sources", points(&[[corner; 2], [corner + 4.0, corner + 6.0]])),
            ("50 sources", points(&spiral_on(&surface, 50))),
        ];
        let maps: Vec<_> = sets.iter().map(|(_, sources)| solve(&surface, sources)).collect();
        let starts = spiral_on(&surface, PATHS);
        // In the maze the curve lies in the outermost corridor.
        let row = if builtin == Builtin::Maze { 0.1 * middle } else { middle };
        let curve = Sources::curve([[row, 0.3 * middle], [1.15 * row, 1.6 * middle]]);
        let curve_map = solve(&surface, &curve);
        let levels = Levels::Count(10).on(&curve_map, &curve).expect("ten are not too many");

        let mut cases = Cases { words: &words, cases: Vec::new() };
        let with_curve = sets.iter().map(|(name, sources)| (*name, sources));
        for (name, sources) in with_curve.chain([("a curve", &curve)]) {
            let (mut solver, surface) = (RotatedScan::new(&edges, Wavefront::Curved), &surface);
            let seeds = sources.seeds(surface).expect("they lie on the surface");
            cases.add(name, "map, kept solver", move || solver.solve(&seeds, STOP).iterations);
            cases.add(name, "map", move || solve(surface, sources));
        }
        for ((name, sources), map) in sets.iter().zip(&maps) {
            let (surface, edges, starts) = (&surface, &edges, &starts);
            if sources.iter().count() > 1 {
                cases.add(name, "Voronoi regions", move || {
                    Voronoi::new(surface, edges, sources, &map.distances)
                });
            }
            cases.add(name, "10 contours", move || {
                let levels = Levels::Count(10).on(map, sources).expect("ten are not too many");
                contours(map, sources, &levels)
            });
            cases.add(name, format!("{PATHS} paths"), move || {
                let paths = PathTracer::new(surface, edges, sources, &map.distances);
                paths.expect("they lie on the surface").trace_all(starts)
            });
            cases.add(name, "ridges", move || ridges(edges, &map.distances, 30.0));
        }
        cases.add("a curve", "10 offset curves", || {
            offset_curves(&surface, &edges, &curve, &curve_map, &levels, Side::Left)
        });
        cases.add("1 source", "50 farthest points", || {
            let points = FarthestPoints::new(&surface, &edges, &from_corner);
            points.expect("it lies on the surface").take(49).count()
        });
        cases.time(rounds);
    }
}
