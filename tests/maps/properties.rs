//! Properties that every distance map has, on random small surfaces.
//!
//! Tolerances of 1e-12 (double precision) allow for rounding only: the properties with such a tolerance hold
//! exactly. The other tolerances allow for the discretisation error of grids of at most 16 x 16 points, which
//! the comments state as measured.

use geosweep::Stop;
use geosweep::glam::DVec3;
use geosweep::surface::{Geometry, Gluing};
use geosweep::{
    EdgeRule, Engine, MetricTensor, Options, Sources, Spacing, Surface, Wavefront, distance_map,
    distance_map_f64,
};
use proptest::prelude::*;

use crate::common::{CONVERGED, CONVERGED_F64, cases, difference, marched, rotated};

const ROUNDING: f64 = 1e-12;

fn wavefront() -> impl Strategy<Value = Wavefront> {
    prop_oneof![Just(Wavefront::Planar), Just(Wavefront::Circular)]
}

/// Returns a grid point, for any size of the grid.
fn place() -> impl Strategy<Value = (prop::sample::Index, prop::sample::Index)> {
    any::<(prop::sample::Index, prop::sample::Index)>()
}

type Place = (prop::sample::Index, prop::sample::Index);

fn point(surface: &Surface, (row, col): Place) -> (usize, usize) {
    (row.index(surface.rows()), col.index(surface.cols()))
}

fn sources((row, col): (usize, usize)) -> Sources {
    Sources::point(row as f64, col as f64)
}

fn map(surface: &Surface, sources: &Sources, wavefront: Wavefront) -> Vec<f64> {
    rotated::<f64>(surface, sources, wavefront, CONVERGED_F64).distances()
}

/// Returns a gently curved patch without holes, sheared by up to 30 degrees.
fn smooth() -> impl Strategy<Value = Surface> {
    let size = 6..=16usize;
    (size.clone(), size, 0.0..3.0, 0.0..3.0, -0.6..0.6).prop_map(|(rows, cols, a, b, shear)| {
        let positions = (0..rows * cols).map(|index| {
            let (u, v) = ((index % cols) as f64 / 10.0, (index / cols) as f64 / 10.0);
            DVec3::new(u + shear * v, v, 0.15 * f64::sin(a * u + b * v) * f64::cos(b * u - v))
        });
        Surface::from_positions(rows, cols, positions.collect()).unwrap()
    })
}

/// Returns a height field with steep random steps, down to a single row or column.
fn rough() -> impl Strategy<Value = Surface> {
    (1..=12usize, 1..=12usize)
        .prop_flat_map(|(rows, cols)| {
            (Just(rows), prop::collection::vec(0.0..3.0, rows * cols), 0.2..5.0, 0.2..5.0)
        })
        .prop_map(|(rows, heights, dx, dy)| {
            let cols = heights.len() / rows;
            Surface::from_heights(rows, cols, heights, Spacing { dx, dy }).unwrap()
        })
}

/// Returns a rough surface with holes. The first point is never a hole.
fn holed() -> impl Strategy<Value = Surface> {
    (rough(), 0.3..1.0)
        .prop_flat_map(|(surface, filled)| {
            let count = surface.rows() * surface.cols();
            let mask = prop::collection::vec(prop::bool::weighted(filled), count);
            (Just(surface), mask)
        })
        .prop_map(|(surface, mut mask)| {
            mask[0] = true;
            surface.with_mask(&mask).unwrap()
        })
}

/// Returns a surface with holes and a slowness that changes at random from point to point.
fn slow() -> impl Strategy<Value = Surface> {
    holed().prop_flat_map(|surface| {
        let count = surface.rows() * surface.cols();
        (Just(surface), prop::collection::vec(0.3..3.0, count))
            .prop_map(|(surface, slowness)| surface.with_slowness(slowness).unwrap())
    })
}

/// Random heights, holes and slownesses on a grid whose first and last column are glued, and perhaps also its first and
/// last row.
#[derive(Clone, Debug)]
struct Wrapped {
    rows: usize,
    /// Number of columns around the surface. The grid has one more.
    round: usize,
    /// Whether the last column is glued to the first one in reverse order.
    flipped: bool,
    /// Whether the last row is glued to the first one too.
    both: bool,
    /// Height and slowness of each point. Where the height is NaN, the surface has a hole.
    values: Vec<(f64, f64)>,
    is_slowed: bool,
}

fn wrapped() -> impl Strategy<Value = Wrapped> {
    // Triangles of steep heights are obtuse.
    let steepness = prop_oneof![0.0..0.4, 0.4..4.0];
    (4..=12usize, 3..=12usize, any::<[bool; 3]>(), steepness)
        .prop_flat_map(|(rows, round, flags, steepness)| {
            let height = prop_oneof![9 => 0.0..steepness, 1 => Just(f64::NAN)];
            let values = prop::collection::vec((height, 0.9..1.1), rows * round);
            (Just(rows), Just(round), Just(flags), values)
        })
        .prop_map(|(rows, round, [flipped, both, is_slowed], values)| {
            let values = [vec![(0.2, 1.0)], values[1..].to_vec()].concat();
            Wrapped { rows, round, flipped, both, values, is_slowed }
        })
}

impl Wrapped {
    /// Returns the number of the point at a row and an unrolled column, which is the same for all copies of a point.
    fn number(&self, row: usize, col: usize) -> usize {
        let last = self.rows - 1;
        let row = if self.flipped && col / self.round % 2 == 1 { last - row } else { row };
        let row = if self.both && row == last { 0 } else { row };
        row * self.round + col % self.round
    }

    /// Returns the surface and the number of each point, with columns in the given order.
    fn surface(&self, col: impl Fn(usize) -> usize) -> (Surface, Vec<usize>) {
        let cols = self.round + 1;
        let numbers: Vec<_> =
            (0..self.rows * cols).map(|at| self.number(at / cols, col(at % cols))).collect();
        let [heights, slowness] = [0, 1].map(|k| {
            let value = |&number: &usize| <[f64; 2]>::from(self.values[number])[k];
            numbers.iter().map(value).collect::<Vec<_>>()
        });
        let spacing = Spacing { dx: 1.0, dy: 1.3 };
        let surface = Surface::from_heights(self.rows, cols, heights, spacing).unwrap();
        let surface = match self.is_slowed {
            true => surface.with_slowness(slowness).unwrap(),
            false => surface,
        };
        let round = if self.flipped { Gluing::flipped_columns() } else { Gluing::columns() };
        let surface = surface.with_gluing(round).unwrap();
        match self.both {
            true => (surface.with_gluing(Gluing::rows()).unwrap(), numbers),
            false => (surface, numbers),
        }
    }
}

fn any_surface() -> impl Strategy<Value = Surface> {
    prop_oneof![smooth(), rough(), holed(), slow()]
}

/// Returns the first grid point from a place on, in row-major order, that is not a hole.
fn present(surface: &Surface, place: Place) -> (usize, usize) {
    let (row, col) = point(surface, place);
    let chart = surface.chart();
    let start = chart.index(row, col);
    let index = (0..chart.points()).map(|step| (start + step) % chart.points());
    chart.position(index.into_iter().find(|&index| surface.present()[index]).unwrap())
}

/// Returns the largest finite distance.
fn largest(map: &[f64]) -> f64 {
    map.iter().copied().filter(|distance| distance.is_finite()).fold(0.0, f64::max)
}

/// Returns the same surface with its points renumbered: `from` returns the old row and column of a new one.
fn renumbered(
    surface: &Surface,
    (rows, cols): (usize, usize),
    from: impl Fn(usize, usize) -> (usize, usize),
) -> Surface {
    let old = |index: usize| {
        let (row, col) = from(index / cols, index % cols);
        surface.chart().index(row, col)
    };
    let position = |index: usize| {
        let (row, col) = surface.chart().position(old(index));
        surface.position(row, col).unwrap_or(DVec3::NAN)
    };
    let positions = (0..rows * cols).map(position).collect();
    let renumbered = Surface::from_positions(rows, cols, positions).unwrap();
    match surface.slowness() {
        None => renumbered,
        Some(slowness) => {
            let slowness = (0..rows * cols).map(|index| slowness[old(index)]).collect();
            renumbered.with_slowness(slowness).unwrap()
        }
    }
}

/// Checks that the transposed grid and the grid with reversed rows have the same map. Over them, scans visit points in
/// another order.
fn check_turned(
    surface: &Surface,
    (row, col): (usize, usize),
    wavefront: Wavefront,
) -> Result<(), TestCaseError> {
    let (rows, cols) = (surface.rows(), surface.cols());
    let straight = map(surface, &sources((row, col)), wavefront);
    let transposed = renumbered(surface, (cols, rows), |row, col| (col, row));
    let turned = map(&transposed, &sources((col, row)), wavefront);
    let back: Vec<f64> = (0..rows * cols).map(|i| turned[(i % cols) * rows + i / cols]).collect();
    prop_assert!(difference(&back, &straight) < ROUNDING);
    let flipped = renumbered(surface, (rows, cols), |row, col| (rows - 1 - row, col));
    let turned = map(&flipped, &sources((rows - 1 - row, col)), wavefront);
    let back: Vec<f64> = turned.chunks(cols).rev().flatten().copied().collect();
    prop_assert!(difference(&back, &straight) < ROUNDING);
    Ok(())
}

proptest! {
    #![proptest_config(cases(1000))]

    /// The scheme is not symmetric, only its limit is. On these coarse grids, distances agree within 4% and
    /// 2% in 20 000 cases.
    #[test]
    fn the_way_back_is_as_long(surface in smooth(), a in place(), b in place()) {
        let (a, b) = (point(&surface, a), point(&surface, b));
        for (wavefront, tolerance) in [(Wavefront::Planar, 0.05), (Wavefront::Circular, 0.025)] {
            let there = map(&surface, &sources(a), wavefront)[surface.chart().index(b.0, b.1)];
            let back = map(&surface, &sources(b), wavefront)[surface.chart().index(a.0, a.1)];
            let difference = (there - back).abs();
            prop_assert!(difference <= tolerance * there, "{wavefront}: {there} {back}");
        }
    }

    /// The triangle inequality holds exactly for the planar front, on every surface: its update is monotone, and
    /// a constant added to its inputs is added to its result, so that d(a, b) + d(b, .) lies above d(a, .). The
    /// circular front has neither property. On smooth surfaces it satisfies the inequality within 1% of the largest
    /// distance in 20 000 cases.
    #[test]
    fn no_detour_is_shorter(surface in any_surface(), gentle in smooth(), a in place(), b in place()) {
        let fronts = [(surface, Wavefront::Planar, 0.0), (gentle, Wavefront::Circular, 0.02)];
        for (surface, wavefront, slack) in fronts {
            let (a, b) = (present(&surface, a), present(&surface, b));
            let from_a = map(&surface, &sources(a), wavefront);
            let to_b = from_a[surface.chart().index(b.0, b.1)];
            let from_b = map(&surface, &sources(b), wavefront);
            let slack = slack * largest(&from_a);
            for (direct, rest) in from_a.iter().zip(&from_b) {
                if to_b.is_finite() && rest.is_finite() {
                    let detour = (to_b + rest) * (1.0 + ROUNDING) + slack;
                    prop_assert!(*direct <= detour, "{wavefront}: {direct} {to_b} {rest}");
                }
            }
        }
    }

    /// This holds exactly for both fronts on a polyhedron: the length of the chord from the source is a convex
    /// function along every edge. With arcs, each of which is longer than its chord by its own bend, distances
    /// can be shorter than the chord (by 3e-5 on coarse grids).
    #[test]
    fn no_distance_is_below_the_chord(
        surface in prop_oneof![smooth(), rough(), holed()],
        a in place(),
        wavefront in wavefront(),
    ) {
        let surface = surface.with_edge_rule(EdgeRule::Chord);
        let a = present(&surface, a);
        let source = surface.position(a.0, a.1).unwrap();
        let distances = map(&surface, &sources(a), wavefront);
        for (index, distance) in distances.iter().enumerate().filter(|(_, d)| d.is_finite()) {
            let (row, col) = surface.chart().position(index);
            let chord = source.distance(surface.position(row, col).unwrap());
            prop_assert!(*distance >= chord * (1.0 - ROUNDING), "{row},{col}: {distance} {chord}");
        }
    }

    /// The map scales to the bit: every operation of the update scales with the lengths.
    #[test]
    fn a_power_of_two_scales_the_map(
        surface in prop_oneof![smooth(), holed()],
        a in place(),
        exponent in -20..=20i32,
        wavefront in wavefront(),
    ) {
        let scale = f64::from(exponent).exp2();
        let source = sources(present(&surface, a));
        // Both surfaces are positions, since heights over a grid are rounded differently.
        let solve = |scale: f64| {
            let positions = (0..surface.chart().points()).map(|index| {
                let (row, col) = surface.chart().position(index);
                surface.position(row, col).map_or(DVec3::NAN, |position| scale * position)
            });
            let (rows, cols) = (surface.rows(), surface.cols());
            let scaled = Surface::from_positions(rows, cols, positions.collect()).unwrap();
            rotated::<f32>(&scaled, &source, wavefront, CONVERGED).distances()
        };
        let expected: Vec<f32> = solve(1.0).into_iter().map(|d| d * scale as f32).collect();
        let found = solve(scale);
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn turning_the_grid_turns_the_map(
        surface in prop_oneof![smooth(), rough(), holed()],
        slow in slow(),
        a in place(),
        wavefront in wavefront(),
    ) {
        check_turned(&surface, present(&surface, a), wavefront)?;
        // With a slowness this holds only for the planar front. From a fast into a much slower medium, the circular
        // front assumes a wrong centre and is not monotone, so that its map can depend on the order of updates (once in
        // ten thousand such surfaces).
        check_turned(&slow, present(&slow, a), Wavefront::Planar)?;
    }

    /// The map is exact: from inside a cell, the first update outside already finds the source.
    #[test]
    fn a_source_between_points_of_a_plane_is_exact(
        (rows, cols) in (2..=12usize, 2..=12usize),
        (v, u) in (0.0..1.0, 0.0..1.0),
        (dx, dy) in (0.2..5.0, 0.2..5.0),
    ) {
        let flat = vec![1.0; rows * cols];
        let surface = Surface::from_heights(rows, cols, flat, Spacing { dx, dy }).unwrap();
        let (row, col) = (v * (rows - 1) as f64, u * (cols - 1) as f64);
        let distances = map(&surface, &Sources::point(row, col), Wavefront::Circular);
        for (index, distance) in distances.into_iter().enumerate() {
            let (r, c) = surface.chart().position(index);
            let exact = ((c as f64 - col) * dx).hypot((r as f64 - row) * dy);
            prop_assert!((distance - exact).abs() < 1e-9 * (dx + dy), "{distance} {exact}");
        }
    }

    /// For the planar front, which is monotone, the map is the minimum of the single maps or less. Where two
    /// fronts meet across an edge, the update treats them as one, so that the map is early by up to a third of a
    /// cell.
    #[test]
    fn several_sources_give_the_least_of_their_maps(
        surface in smooth(),
        places in prop::collection::vec(place(), 1..5),
    ) {
        let places: Vec<_> = places.into_iter().map(|place| point(&surface, place)).collect();
        let all = places.iter().fold(Sources::default(), |sources, &(row, col)| {
            sources.and_point(row as f64, col as f64, 0.0)
        });
        for wavefront in [Wavefront::Planar, Wavefront::Circular] {
            let alone: Vec<_> =
                places.iter().map(|&place| map(&surface, &sources(place), wavefront)).collect();
            for (index, together) in map(&surface, &all, wavefront).into_iter().enumerate() {
                let least = alone.iter().map(|map| map[index]).fold(f64::INFINITY, f64::min);
                // Cells are 0.1 to 0.12 wide.
                prop_assert!(together > least - 0.05, "{wavefront}: {together} {least}");
                let late = if wavefront == Wavefront::Planar { ROUNDING } else { 0.02 };
                prop_assert!(together <= least + late, "{wavefront}: {together} {least}");
            }
        }
    }

    /// A source changes nothing if the front of another source passes it before it starts. Starting all sources
    /// later delays the map by the same time.
    #[test]
    fn initial_values_delay(surface in smooth(), a in place(), b in place(), later in 0.0..50.0) {
        let (a, b) = (point(&surface, a), point(&surface, b));
        let map = |sources: &Sources, wavefront| {
            let options =
                Options::default().with_engine(Engine::Cpu).with_wavefront(wavefront);
            distance_map(&surface, sources, &options).unwrap()
        };
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let plain = map(&sources(a), wavefront);
            let delayed = map(&Sources::default().and_point(a.0 as f64, a.1 as f64, later), wavefront);
            for (delayed, plain) in delayed.distances.iter().zip(&plain.distances) {
                let expected = plain + later as f32;
                prop_assert!((delayed - expected).abs() <= 1e-6 * expected, "{delayed} {expected}");
            }
            let passed = plain.distance(b.0, b.1) + 0.01;
            let both = map(&sources(a).and_point(b.0 as f64, b.1 as f64, passed.into()), wavefront);
            // With several sources, fronts other than planar ones are causal. In square cells this makes no
            // difference, but in some of these cells it does.
            let tolerance = if wavefront == Wavefront::Planar { 0.0 } else { 1e-2 };
            let largest = plain.distances.iter().fold(0.0, |most: f32, &here| most.max(here));
            for (both, plain) in both.distances.iter().zip(&plain.distances) {
                prop_assert!((both - plain).abs() <= tolerance * largest, "{both} {plain}");
            }
        }
    }

    /// In single precision, each surface rounds its edge lengths separately.
    #[test]
    fn a_constant_slowness_scales_the_map(
        surface in holed(),
        a in place(),
        slowness in 0.1..10.0,
        wavefront in wavefront(),
    ) {
        let source = sources(present(&surface, a));
        let plain = rotated::<f64>(&surface, &source, wavefront, CONVERGED_F64).distances();
        let count = surface.chart().points();
        let slowed = surface.with_slowness(vec![slowness; count]).unwrap();
        let expected: Vec<f64> = plain.into_iter().map(|distance| slowness * distance).collect();
        prop_assert!(difference(&map(&slowed, &source, wavefront), &expected) < ROUNDING);
        let single = rotated::<f32>(&slowed, &source, wavefront, CONVERGED).distances();
        prop_assert!(difference(&single, &expected) < 1e-5);
    }

    #[test]
    fn a_constant_metric_is_a_plane(
        (rows, cols) in (2..=12usize, 2..=12usize),
        (down, right, shear) in (0.2..5.0, 0.2..5.0, -4.0..4.0),
        a in place(),
        wavefront in wavefront(),
    ) {
        let positions = (0..rows * cols).map(|index| {
            let (row, col) = ((index / cols) as f64, (index % cols) as f64);
            DVec3::new(right * col + shear * row, down * row, 7.0)
        });
        let plane = Surface::from_positions(rows, cols, positions.collect()).unwrap();
        let tensor =
            MetricTensor { rr: down * down + shear * shear, rc: right * shear, cc: right * right };
        let metric = Surface::from_metric(rows, cols, vec![tensor; rows * cols]).unwrap();
        prop_assert!(matches!(metric.geometry(), Geometry::Metric(_)));
        let source = sources(point(&plane, a));
        let (of_plane, of_metric) =
            (map(&plane, &source, wavefront), map(&metric, &source, wavefront));
        prop_assert!(difference(&of_metric, &of_plane) < 1e-11);
    }

    /// Planar fronts that are computed in the order of their times are those of scans.
    #[test]
    fn fast_marching_gives_the_map_of_scans(surface in any_surface(), a in place()) {
        let source = sources(present(&surface, a));
        let marched = marched::<f64>(&surface, &source, Wavefront::Planar);
        let apart = difference(&marched, &map(&surface, &source, Wavefront::Planar));
        prop_assert!(apart < ROUNDING, "{apart:e}");
    }

    #[test]
    fn more_iterations_never_raise_a_distance(
        surface in any_surface(),
        a in place(),
        count in 1..4u32,
        wavefront in wavefront(),
    ) {
        let source = sources(present(&surface, a));
        // With a slowness, curved fronts, which are renewed, take the place of circular ones.
        let wavefront = if surface.slowness().is_some() { Wavefront::Planar } else { wavefront };
        let solve =
            |count| rotated::<f32>(&surface, &source, wavefront, Stop::after(count)).distances();
        let (before, after) = (solve(count), solve(count + 1));
        prop_assert!(before.iter().zip(&after).all(|(before, after)| after <= before));
    }

    /// Which column of a wrapped surface is the first, and which way columns run, changes nothing.
    #[test]
    fn rolling_and_mirroring_changes_nothing(
        wrapped in wrapped(),
        by in any::<prop::sample::Index>(),
        mirrored in any::<bool>(),
        from in place(),
        wavefront in wavefront(),
    ) {
        let wavefront = if wrapped.is_slowed { Wavefront::Planar } else { wavefront };
        let (surface, numbers) = wrapped.surface(|col| col);
        let (row, col) = present(&surface, from);
        // Obtuse triangles beside a seam are split by points beyond it. `distance_map_f64` finds these points, but the
        // solver that it calls does not.
        let options = Options::default().with_engine(Engine::Cpu).with_wavefront(wavefront);
        let map = |surface, source| {
            distance_map_f64(surface, &sources(source), &options).unwrap().distances
        };
        let distances = map(&surface, (row, col));
        // Columns are shifted by up to twice round the surface, after which a Moebius strip is as it was.
        let by = by.index(2 * wrapped.round);
        let (rolled, places) = wrapped.surface(|col| {
            if mirrored { 3 * wrapped.round + by - col } else { col + by }
        });
        let source = places.iter().position(|number| *number == numbers[surface.chart().index(row, col)]);
        let source = rolled.chart().position(source.expect("both surfaces have all points"));
        let found = map(&rolled, source);
        let mut expected = vec![f64::NAN; wrapped.values.len()];
        numbers.iter().zip(&distances).for_each(|(&number, &distance)| expected[number] = distance);
        let expected: Vec<_> = places.iter().map(|&number| expected[number]).collect();
        let apart = difference(&found, &expected);
        // On closed surfaces curved fronts carry their ray, whose direction is rounded to 1.5e-9.
        let most = if wavefront == Wavefront::Curved { 1e-7 } else { ROUNDING };
        prop_assert!(apart < most, "{apart:e}");
    }
}
