//! What obtuse triangles cost, and what splitting them gains: the tables of
//! `docs/obtuse-triangles.md`.
//!
//!     cargo run --release --example obtuse_triangles
//!
//! The surface is a plane sheared by an angle, x = u + v tan(angle), y = v, whose exact distances
//! are straight lines. From 45 degrees on, two of the eight triangles around a point are obtuse
//! there.

use std::time::{Duration, Instant};

use geosweep::Stop;
use geosweep::cpu::{self, Connections};
use geosweep::glam::DVec2;
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::update::{Triangle, planar};
use geosweep::{Sources, Wavefront};

const ANGLES: [f64; 9] = [0.0, 15.0, 30.0, 45.0, 50.0, 60.0, 70.0, 75.0, 80.0];

fn main() {
    for points in [257, 513] {
        println!("### The raster scans, {points} x {points} points\n");
        engine_table(points);
    }
    println!("### Scans with split triangles, planar front, 257 x 257 points\n");
    split_scan_table(257);
    println!("### Fast marching with split triangles, 257 x 257 points\n");
    fast_marching_table(257);
}

/// Mean and largest relative error.
fn errors(map: &[f64], exact: &[f64]) -> (f64, f64) {
    let relative = map.iter().zip(exact).filter(|(_, exact)| **exact > 0.0);
    let relative: Vec<_> = relative.map(|(found, exact)| (found - exact).abs() / exact).collect();
    (relative.iter().sum::<f64>() / relative.len() as f64, relative.into_iter().fold(0.0, f64::max))
}

/// A grid point off every line of symmetry.
fn source(points: usize) -> [usize; 2] {
    [3 * (points - 1) / 10, 2 * (points - 1) / 5]
}

/// Errors of the converged map in single precision: planar and point-source front from a point,
/// and planar front from exact values in a disc of radius 0.1.
fn engine_table(points: usize) {
    println!(
        "| shear | largest angle | planar: mean | max | planar from a disc: mean | max | point-source: mean | max |"
    );
    println!("|---:|---:|---:|---:|---:|---:|---:|---:|");
    for degrees in ANGLES {
        let builtin = Builtin::ShearedPlane { degrees };
        let surface = builtin.surface(points, points).unwrap();
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let from = source(points).map(|x| x as f64);
        let exact = builtin.exact_distances(points, points, from).unwrap();
        let disc = (0..exact.len()).filter(|&index| exact[index] <= 0.1).fold(
            Sources::default(),
            |sources, index| {
                let (row, col) = surface.chart().position(index);
                sources.and_point(row as f64, col as f64, exact[index])
            },
        );
        let point = Sources::point(from[0], from[1]);
        print!("| {degrees} | {:.0} ", Lattice::new(points, degrees).largest_angle());
        for (sources, wavefront) in [
            (&point, Wavefront::Planar),
            (&disc, Wavefront::Planar),
            (&point, Wavefront::PointSource),
        ] {
            let stop = Stop { tolerance: 1e-6, iterations: 1000 };
            let seeds = sources.seeds(&surface).unwrap();
            let map = cpu::rotated_scan(&edges, &seeds, wavefront, stop).distances();
            let map: Vec<_> = map.into_iter().map(f64::from).collect();
            let (mean, max) = errors(&map, &exact);
            print!("| {mean:.1e} | {max:.1e} ");
        }
        println!("|");
    }
    println!();
}

/// Mean errors and times of scans with the planar front, from all triangles around a point.
fn split_scan_table(points: usize) {
    println!("| shear | triangles | longest step, cells | mean, 8 | split | ms, 8 | split |");
    println!("|---:|---:|---:|---:|---:|---:|---:|");
    for degrees in ANGLES {
        let lattice = Lattice::new(points, degrees);
        let from = source(points).map(|x| x as f64);
        let builtin = Builtin::ShearedPlane { degrees };
        let exact = builtin.exact_distances(points, points, from).unwrap();
        let (eight, split) = (lattice.fans(false), lattice.fans(true));
        let count: usize = split.iter().map(|fan| fan.split.len().max(1)).sum();
        let steps = split.iter().flat_map(|fan| &fan.split).flat_map(|t| [t.x1, t.x2]);
        let longest = steps.map(|[r, c]| r.abs().max(c.abs())).max().unwrap_or(1);
        let [(eight, eight_time), (split, split_time)] =
            [eight, split].map(|fans| lattice.scan(&fans));
        let [eight, split] = [eight, split].map(|map| errors(&map, &exact).0);
        print!("| {degrees} | {count} | {longest} | {eight:.1e} | {split:.1e} ");
        println!("| {} | {} |", eight_time.as_millis(), split_time.as_millis());
    }
    println!();
}

/// Mean errors and times of fast marching with the crate's [`Connections`], in single precision.
fn fast_marching_table(points: usize) {
    println!(
        "| shear | planar: mean, 8 | split | point-source: mean, 8 | split | ms, 8 | split | ms to split |"
    );
    println!("|---:|---:|---:|---:|---:|---:|---:|---:|");
    for degrees in ANGLES {
        let builtin = Builtin::ShearedPlane { degrees };
        let surface = builtin.surface(points, points).unwrap();
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let from = source(points).map(|x| x as f64);
        let exact = builtin.exact_distances(points, points, from).unwrap();
        let seeds = Sources::point(from[0], from[1]).seeds(&surface).unwrap();
        let start = Instant::now();
        let split = Connections::split(&surface).unwrap();
        let splitting = start.elapsed();
        let eight = Connections::eight(surface.chart());
        print!("| {degrees} ");
        let mut times = [Duration::ZERO; 2];
        for wavefront in [Wavefront::Planar, Wavefront::PointSource] {
            times = [&eight, &split].map(|connections| {
                let start = Instant::now();
                let map = cpu::fast_marching_with(&edges, connections, &seeds, wavefront);
                let time = start.elapsed();
                let map: Vec<_> = map.distances().into_iter().map(f64::from).collect();
                print!("| {:.1e} ", errors(&map, &exact).0);
                time
            });
        }
        print!("| {} | {} ", times[0].as_millis(), times[1].as_millis());
        println!("| {} |", splitting.as_millis());
    }
}

/// A step in rows and columns.
type Step = [isize; 2];

/// A triangle around every point of the lattice.
#[derive(Clone, Copy)]
struct Spoke {
    x1: Step,
    x2: Step,
    l1: f64,
    l2: f64,
    c: f64,
}

/// One of the eight triangles around a point, and the acute ones it is split into, if it is
/// obtuse. Near the border, where they reach beyond the grid, the obtuse one stands in.
struct Fan {
    whole: Spoke,
    split: Vec<Spoke>,
}

/// The grid points of a sheared plane: the same triangles everywhere.
struct Lattice {
    points: usize,
    down: DVec2,
    right: DVec2,
}

impl Lattice {
    fn new(points: usize, degrees: f64) -> Self {
        let cell = 1.0 / (points - 1) as f64;
        let down = DVec2::new(cell * degrees.to_radians().tan(), cell);
        Self { points, down, right: DVec2::new(cell, 0.0) }
    }

    fn vector(&self, [row, col]: Step) -> DVec2 {
        row as f64 * self.down + col as f64 * self.right
    }

    fn spoke(&self, x1: Step, x2: Step) -> Spoke {
        let (a, b) = (self.vector(x1), self.vector(x2));
        Spoke { x1, x2, l1: a.length(), l2: b.length(), c: a.distance(b) }
    }

    fn pairs() -> impl Iterator<Item = (Step, Step)> {
        const RING: [Step; 8] =
            [[0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0], [1, 1]];
        (0..8).map(|k| (RING[k], RING[(k + 1) % 8]))
    }

    fn largest_angle(&self) -> f64 {
        let angle = |(a, b)| self.vector(a).angle_to(self.vector(b)).abs().to_degrees();
        Self::pairs().map(angle).fold(0.0, f64::max)
    }

    fn fans(&self, split: bool) -> Vec<Fan> {
        Self::pairs()
            .map(|(a, b)| {
                let mut pieces = Vec::new();
                if split && self.is_obtuse(a, b) {
                    self.split(a, b, &mut pieces);
                }
                Fan { whole: self.spoke(a, b), split: pieces }
            })
            .collect()
    }

    fn is_obtuse(&self, a: Step, b: Step) -> bool {
        let (a, b) = (self.vector(a), self.vector(b));
        a.dot(b) < -1e-9 * a.length() * b.length()
    }

    /// Adds the connection a + b between a and b until every angle is acute: the nearest lattice
    /// point in between, since no other lies in the parallelogram.
    fn split(&self, a: Step, b: Step, pieces: &mut Vec<Spoke>) {
        if !self.is_obtuse(a, b) {
            return pieces.push(self.spoke(a, b));
        }
        let middle = [a[0] + b[0], a[1] + b[1]];
        self.split(a, middle, pieces);
        self.split(middle, b, pieces);
    }

    fn neighbour(&self, [row, col]: [usize; 2], [down, right]: Step) -> Option<usize> {
        let row = row.checked_add_signed(down).filter(|&row| row < self.points)?;
        let col = col.checked_add_signed(right).filter(|&col| col < self.points)?;
        Some(row * self.points + col)
    }

    /// The planar update over all triangles of the fans.
    fn update(&self, fans: &[Fan], at: [usize; 2], map: &[f64]) -> f64 {
        let through = |spoke: &Spoke| {
            let x1 = self.neighbour(at, spoke.x1);
            let x2 = self.neighbour(at, spoke.x2);
            let Spoke { l1, l2, c, .. } = *spoke;
            let seen = |x: Option<usize>| x.map_or(1e30, |x| map[x]);
            let triangle = Triangle { t1: seen(x1), t2: seen(x2), l1, l2, c };
            (planar(triangle), x1.is_some() && x2.is_some())
        };
        let mut best = f64::INFINITY;
        for fan in fans {
            let mut complete = !fan.split.is_empty();
            for (time, inside) in fan.split.iter().map(&through) {
                best = best.min(time);
                complete &= inside;
            }
            if !complete {
                best = best.min(through(&fan.whole).0);
            }
        }
        best
    }

    /// Scans in four orders, every point from all its triangles, until nothing changes.
    fn scan(&self, fans: &[Fan]) -> (Vec<f64>, Duration) {
        let start = Instant::now();
        let [row, col] = source(self.points);
        let mut map = vec![1e30; self.points * self.points];
        map[row * self.points + col] = 0.0;
        loop {
            let mut change = 0.0f64;
            for order in 0..4 {
                for index in 0..self.points * self.points {
                    let (row, col) = (index / self.points, index % self.points);
                    let row = if order < 2 { row } else { self.points - 1 - row };
                    let col = if order % 2 == 0 { col } else { self.points - 1 - col };
                    let time = self.update(fans, [row, col], &map);
                    let before = &mut map[row * self.points + col];
                    if time < *before {
                        change = change.max((*before - time) / *before);
                        *before = time;
                    }
                }
            }
            if change <= 1e-12 {
                return (map, start.elapsed());
            }
        }
    }
}
