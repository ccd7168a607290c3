//! Random surfaces on which nothing was tuned, and bounds that hold for every map on them, with any
//! wavefront, engine and schedule.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use geosweep::Stop;
use geosweep::glam::DVec3;
use geosweep::surface::{Chart, Direction, EdgeLengths, Real, Seed};
use geosweep::{EdgeRule, Sources, Spacing, Surface, Wavefront};

use super::Random;

/// Iterations within which fronts must converge. Otherwise the map must report that it has not converged.
pub const SETTLED: Stop = Stop::within(1e-6).or_after(500);

/// Difference, relative to the largest distance, above which two maps have converged to different results.
pub const APART: f64 = 1e-4;

/// Returns the numbers of the cases that a test runs. Their count is `usual` or `GEOSWEEP_CASES`, and the
/// first one is 0 or `GEOSWEEP_FIRST_CASE`.
pub fn cases(usual: u64) -> std::ops::Range<u64> {
    let of = |name| std::env::var(name).ok().and_then(|text| text.parse().ok());
    let first = of("GEOSWEEP_FIRST_CASE").unwrap_or(0);
    first..first + of("GEOSWEEP_CASES").unwrap_or(usual)
}

/// A surface and its sources.
pub struct Case {
    pub name: String,
    pub surface: Surface,
    pub sources: Sources,
    /// Whether distances in space are lower bounds of those along the surface.
    pub(super) has_positions: bool,
    /// Whether curved fronts keep their origins.
    pub(super) has_origins: bool,
}

impl Case {
    /// Returns a random case. The relief is from a hundredth to a hundred times the spacing, smooth or rough.
    /// Grids are sheared by up to three cells and stretched up to tenfold. They may have holes and a
    /// slowness. There are up to eight sources, possibly inside cells, with later start values, or with a
    /// curve beside them.
    pub fn new(number: u64) -> Self {
        let mut random = Random::new(number);
        let mut one_in = |many: f64| random.next() < 1.0 / many;
        let [flat, sheared, stretched] = [one_in(4.0), one_in(2.0), one_in(2.0)];
        let [holed, slow, chords, later, inside, curved] =
            [one_in(3.0), one_in(4.0), one_in(2.0), one_in(5.0), one_in(3.0), one_in(5.0)];
        let mut between = |low: f64, high: f64| low + (high - low) * random.next();
        let (rows, cols) = (between(3.0, 32.0) as usize, between(3.0, 32.0) as usize);
        let relief = if flat { 0.0 } else { 10f64.powf(between(-2.0, 2.0)) };
        let shear = if sheared { between(-3.0, 3.0) } else { 0.0 };
        let stretch = if stretched { between(1.0, 10.0) } else { 1.0 };
        let mut heights: Vec<f64> = (0..rows * cols).map(|_| between(-1.7, 1.7)).collect();
        let rounds = between(0.0, 10.0) as usize;
        (0..rounds).for_each(|_| smooth(rows, cols, &mut heights));
        let height = heights.iter().fold(1e-9, |most: f64, height| most.max(height.abs()));
        let present: Vec<bool> = (0..heights.len()).map(|_| between(0.0, 1.0) > 0.12).collect();
        let positions = heights.iter().enumerate().map(|(index, z)| {
            let (row, col) = ((index / cols) as f64, (index % cols) as f64);
            DVec3::new(stretch * (col + shear * row), row, relief * z / height)
        });
        let surface = Surface::from_positions(rows, cols, positions.collect()).unwrap();
        let surface = surface.with_edge_rule(if chords { EdgeRule::Chord } else { EdgeRule::Arc });
        let surface = if holed && present.contains(&true) {
            surface.with_mask(&present).unwrap()
        } else {
            surface
        };
        let points = rows * cols;
        let surface = if slow {
            let slowness = (0..points).map(|_| between(0.3, 3.0)).collect();
            surface.with_slowness(slowness).unwrap()
        } else {
            surface
        };
        let count = between(1.0, 9.0) as usize;
        let there: Vec<usize> = (0..points).filter(|&index| surface.present()[index]).collect();
        let mut sources = Sources::default();
        for _ in 0..count {
            let index = there[(between(0.0, 1.0) * there.len() as f64) as usize];
            let (row, col) = ((index / cols) as f64, (index % cols) as f64);
            let [down, right] = [between(-0.9, 0.9), between(-0.9, 0.9)];
            let place =
                [row + if inside { down } else { 0.0 }, col + if inside { right } else { 0.0 }];
            let start = if later { between(0.0, 2.0) } else { 0.0 };
            // Some places inside cells are not on the surface.
            let wanted = sources.clone().and_point(place[0], place[1], start);
            let beside = || sources.clone().and_point(row, col, start);
            sources = on(&surface, wanted).unwrap_or_else(beside);
        }
        if curved {
            let ends = [(); 2].map(|()| {
                let index = there[(between(0.0, 1.0) * there.len() as f64) as usize];
                (index / cols, index % cols)
            });
            let line = ends.map(|(row, col)| [row as f64, col as f64]);
            sources = on(&surface, sources.clone().and_curve(line, 0.0)).unwrap_or(sources);
        }
        let name = format!(
            "case {number}: {rows} x {cols}, relief {relief:.3}, smoothed {rounds} times, sheared by {shear:.2}, \
             stretched by {stretch:.2}, {count} sources{}{}{}{}",
            if slow { ", slowness" } else { "" },
            if inside { ", inside cells" } else { "" },
            if curved { ", a curve" } else { "" },
            if chords { ", chords" } else { "" },
        );
        let has_positions = !slow && !inside && !curved;
        Self { name, surface, sources, has_positions, has_origins: false }
    }

    /// Returns a case with the test's own surface and sources.
    pub fn of(name: String, surface: Surface, sources: Sources) -> Self {
        Self { name, surface, sources, has_positions: false, has_origins: false }
    }

    /// Returns a case on a surface of [`Self::new`], [`Self::irregular`] or [`Self::patches`]. It has clusters of
    /// sources at grid points, which may start later, and perhaps a line across the grid.
    pub fn clusters(number: u64) -> Self {
        let surface = match number % 3 {
            0 => Self::new(number),
            1 => Self::irregular(number),
            _ => Self::patches(number),
        }
        .surface;
        let mut random = Random::new(number ^ 0xc105);
        let mut between = |low: f64, high: f64| low + (high - low) * random.next();
        let chart = surface.chart();
        let [last_row, last_col] = [chart.rows, chart.cols].map(|lines| lines as f64 - 1.0);
        let (clusters, is_late) = (between(1.0, 4.0) as usize, between(0.0, 1.0) < 0.3);
        let mut sources = Sources::default();
        let mut count = 0;
        for _ in 0..clusters {
            let middle = [between(0.0, last_row), between(0.0, last_col)];
            for _ in 0..between(2.0, 7.0) as usize {
                let row = (middle[0] + between(-2.0, 2.0)).round().clamp(0.0, last_row);
                let col = (middle[1] + between(-2.0, 2.0)).round().clamp(0.0, last_col);
                let start = if is_late { between(0.0, 1.0) } else { 0.0 };
                if let Some(with) = on(&surface, sources.clone().and_point(row, col, start)) {
                    sources = with;
                    count += 1;
                }
            }
        }
        if between(0.0, 1.0) < 0.3 {
            let row = between(0.0, last_row);
            let line = [[row, 0.0], [row, last_col]];
            sources = on(&surface, sources.clone().and_curve(line, 0.0)).unwrap_or(sources);
        }
        let name = format!(
            "clusters {number}: {} x {}, {count} sources in {clusters} clusters",
            chart.rows, chart.cols
        );
        Self { has_origins: true, ..Self::of(name, surface, sources) }
    }

    /// Returns a case with flat ground or hills, square patches of a slowness up to a thousand times as large, and
    /// up to four sources.
    pub fn patches(number: u64) -> Self {
        let mut random = Random::new(number ^ 0x5eed);
        let mut between = |low: f64, high: f64| low + (high - low) * random.next();
        let (rows, cols) = (between(4.0, 40.0) as usize, between(4.0, 40.0) as usize);
        let (side, slow) = (between(1.0, 8.0) as usize, 10f64.powf(between(0.1, 3.0)));
        let relief = if between(0.0, 1.0) < 0.5 { 0.0 } else { between(0.1, 1.0) };
        let patch: Vec<bool> = (0..41 * 41).map(|_| between(0.0, 1.0) < 0.4).collect();
        let place = |index: usize| (index / cols, index % cols);
        let slowness = (0..rows * cols).map(|index| {
            let (row, col) = place(index);
            if patch[row / side * 41 + col / side] { slow } else { 1.0 }
        });
        let heights = (0..rows * cols).map(|index| {
            let (row, col) = place(index);
            relief * ((0.5 * row as f64).sin() + (0.4 * col as f64).cos())
        });
        let spacing = Spacing { dx: between(0.5, 2.0), dy: 1.0 };
        let surface = Surface::from_heights(rows, cols, heights.collect(), spacing).unwrap();
        let surface = surface.with_slowness(slowness.collect()).unwrap();
        let count = between(1.0, 5.0) as usize;
        let mut sources = Sources::default();
        for _ in 0..count {
            let place = [between(0.0, rows as f64), between(0.0, cols as f64)].map(f64::floor);
            sources = sources.and_point(place[0], place[1], between(0.0, 1.0));
        }
        let name = format!(
            "patches {number}: {rows} x {cols}, relief {relief:.2}, {side} cells wide, slowness {slow:.1}, {count} sources"
        );
        Self::of(name, surface, sources)
    }

    /// Returns the wavefronts for this case. The circular one is only for a single point source without a slowness,
    /// see [`Wavefront::Circular`].
    pub fn wavefronts(&self) -> Vec<Wavefront> {
        let is_circular = self.sources.are_points()
            && self.sources.iter().count() == 1
            && self.surface.slowness().is_none();
        let all = Wavefront::FOR_ANY_SURFACE.into_iter();
        all.filter(|&wavefront| wavefront != Wavefront::Circular || is_circular).collect()
    }

    pub fn seeds(&self) -> Vec<Seed> {
        self.sources.seeds(&self.surface).unwrap()
    }

    /// Returns the seeds from which fronts of this kind start.
    pub fn starts(&self, wavefront: Wavefront) -> Vec<Seed> {
        if !self.has_origins || !wavefront.is_curved() {
            return self.seeds();
        }
        let seeds = self.sources.seeds_with_origins(&self.surface).unwrap();
        geosweep::cpu::seeds_for(wavefront, &self.surface, seeds)
    }

    /// Computes the bounds of the map.
    pub fn bounds(&self) -> Bounds {
        let (chart, seeds) = (self.surface.chart(), self.seeds());
        let edges = EdgeLengths::<f64>::new(&self.surface).unwrap();
        let shortest = dijkstra(&edges, &seeds);
        let longest_edge = places(chart)
            .flat_map(|(row, col)| Direction::ALL.map(|to| edges.length(row, col, to)))
            .filter(|&length| length < f64::FAR)
            .fold(0.0, f64::max);
        let place = |row, col| self.surface.position(row, col);
        let straight = if self.has_positions {
            let from =
                seeds.iter().filter_map(|seed| Some((place(seed.row, seed.col)?, seed.time)));
            let from: Vec<_> = from.collect();
            let to = |(row, col)| {
                let to = place(row, col)?;
                Some(
                    from.iter()
                        .map(|(at, time)| time + at.distance(to))
                        .fold(f64::INFINITY, f64::min),
                )
            };
            places(chart).map(|place| to(place).unwrap_or(0.0)).collect()
        } else {
            Vec::new()
        };
        let start = seeds.iter().map(|seed| seed.time).fold(f64::INFINITY, f64::min);
        let finite = shortest.iter().copied().filter(|time| time.is_finite());
        let largest = finite.fold(f64::MIN_POSITIVE, f64::max);
        Bounds { start, shortest, straight, longest_edge, largest }
    }
}

/// Returns the sources if they are on a surface.
pub(super) fn on(surface: &Surface, sources: Sources) -> Option<Sources> {
    sources.seeds(surface).is_ok().then_some(sources)
}

/// Smooths heights: half of a point's own height and half of its neighbours' mean.
fn smooth(rows: usize, cols: usize, heights: &mut [f64]) {
    let before = heights.to_vec();
    let at = |row: usize, col: usize| before[row.min(rows - 1) * cols + col.min(cols - 1)];
    for row in 0..rows {
        for col in 0..cols {
            let around = at(row.saturating_sub(1), col)
                + at(row + 1, col)
                + at(row, col.saturating_sub(1))
                + at(row, col + 1);
            heights[row * cols + col] = 0.5 * at(row, col) + 0.125 * around;
        }
    }
}

/// Bounds of a map that need no other map; see [`Bounds::check`].
pub struct Bounds {
    start: f64,
    /// Lengths of the shortest paths along edges, infinite where there is none.
    shortest: Vec<f64>,
    /// Lengths of straight lines in space; empty if they are not known.
    straight: Vec<f64>,
    longest_edge: f64,
    pub largest: f64,
}

impl Bounds {
    /// Returns the largest difference of two maps, relative to the largest distance.
    pub fn difference<R: Real, S: Real>(&self, a: &[R], b: &[S]) -> f64 {
        let apart = |(a, b): (&R, &S)| {
            let (a, b) = (a.wide(), b.wide());
            if a.is_finite() { (a - b).abs() } else { 0.0 }
        };
        a.iter().zip(b).map(apart).fold(0.0, f64::max) / self.largest
    }

    /// Checks a map. No distance may be below the earliest start, or above the shortest path along edges. No
    /// distance may be below the straight line by more than half the longest edge, which is the largest
    /// error where fronts meet inside a cell. The map must reach the connected points and no others.
    pub fn check<R: Real>(&self, distances: &[R]) -> Result<(), String> {
        // Rounding in single precision: some units in the last place for each point on the way, up to this
        // limit.
        let rounding = 1e-5 * self.largest;
        for (index, (distance, &shortest)) in distances.iter().zip(&self.shortest).enumerate() {
            let distance = distance.wide();
            if distance.is_nan() || distance.is_finite() != shortest.is_finite() {
                return Err(format!("{distance} at {index}, {shortest} along edges"));
            }
            if !distance.is_finite() {
                continue;
            }
            if distance < self.start - rounding {
                return Err(format!("{distance} at {index} is before the start, {}", self.start));
            }
            if distance > shortest + rounding {
                return Err(format!("{distance} at {index} is above {shortest}, along edges"));
            }
            let straight = self.straight.get(index).copied().unwrap_or(0.0);
            if distance < straight - 0.5 * self.longest_edge - rounding {
                let edge = self.longest_edge;
                return Err(format!(
                    "{distance} at {index} is below the line {straight}, edge {edge}"
                ));
            }
        }
        Ok(())
    }
}

fn places(chart: Chart) -> impl Iterator<Item = (usize, usize)> {
    (0..chart.points()).map(move |index| chart.position(index))
}

/// Returns the lengths of the shortest paths along edges, row by row.
fn dijkstra(edges: &EdgeLengths<f64>, seeds: &[Seed]) -> Vec<f64> {
    let chart = edges.chart();
    let mut times = vec![f64::INFINITY; chart.points()];
    let mut heap = BinaryHeap::new();
    // The bits of positive floats have the same order as their values.
    let key = |time: f64| (time + 1e3).to_bits();
    for seed in seeds {
        let index = chart.index(seed.row, seed.col);
        if seed.time < times[index] {
            times[index] = seed.time;
            heap.push(Reverse((key(seed.time), index)));
        }
    }
    while let Some(Reverse((at, index))) = heap.pop() {
        if at != key(times[index]) {
            continue;
        }
        let (row, col) = chart.position(index);
        for to in Direction::ALL {
            let length = edges.length(row, col, to);
            let Some((row, col)) = chart.neighbour(row, col, to) else { continue };
            let (next, time) = (chart.index(row, col), times[index] + length);
            if length < f64::FAR && time < times[next] {
                times[next] = time;
                heap.push(Reverse((key(time), next)));
            }
        }
    }
    times
}
