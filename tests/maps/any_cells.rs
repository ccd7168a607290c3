//! Properties of maps, paths and regions on planes whose cells are alike and of any shape: axes of a metric up to 1:100
//! at any angle, shears up to 85 degrees, and sides up to 30:1. Gently bent planes have cells that differ.

use geosweep::geometry::{NO_REGION, PathTracer, Voronoi};
use geosweep::glam::{DVec2, DVec3};
use geosweep::surface::{EdgeLengths, MetricTensor};
use geosweep::{Options, Sources, Surface, distance_map, distance_map_f64};
use proptest::prelude::*;

use crate::common::{cases, difference};

/// A plane. A step along columns is `right`, one along rows is `down`.
#[derive(Clone, Debug)]
struct Plane {
    rows: usize,
    cols: usize,
    right: DVec2,
    down: DVec2,
    /// Whether the surface is made from its metric, and not from positions.
    by_metric: bool,
    /// Heights as a fraction of the plane's size.
    bend: f64,
}

impl Plane {
    fn surface(&self) -> Surface {
        let Self { rows, cols, right, down, by_metric, bend } = *self;
        if by_metric && bend == 0.0 {
            let tensor =
                MetricTensor { rr: down.dot(down), rc: down.dot(right), cc: right.dot(right) };
            return Surface::from_metric(rows, cols, vec![tensor; rows * cols]).unwrap();
        }
        let size = right.length() * cols as f64 + down.length() * rows as f64;
        let height = |k: usize| {
            let at = self.place(k) / DVec2::new(rows as f64, cols as f64);
            bend * size * (0.5 + (3.0 * at.x).sin() * (4.0 * at.y).cos())
        };
        let position = |k: usize| -> DVec3 { self.position(self.place(k)).extend(height(k)) };
        Surface::from_positions(rows, cols, (0..rows * cols).map(position).collect()).unwrap()
    }

    fn place(&self, index: usize) -> DVec2 {
        DVec2::new((index / self.cols) as f64, (index % self.cols) as f64)
    }

    fn position(&self, at: DVec2) -> DVec2 {
        at.x * self.down + at.y * self.right
    }

    fn distance(&self, from: DVec2, to: DVec2) -> f64 {
        self.position(from).distance(self.position(to))
    }

    /// Returns the place at shares of the rows and columns; a grid point if `is_point` is set.
    fn at(&self, [row, col]: [f64; 2], is_point: bool) -> DVec2 {
        let at = DVec2::new(row * (self.rows - 1) as f64, col * (self.cols - 1) as f64);
        if is_point { at.round() } else { at }
    }

    /// Returns the plane with rows and columns exchanged.
    fn transposed(&self) -> Self {
        let Self { rows, cols, right, down, .. } = *self;
        Self { rows: cols, cols: rows, right: down, down: right, ..self.clone() }
    }

    /// Returns the plane with its rows in reverse order.
    fn flipped(&self) -> Self {
        Self { down: -self.down, ..self.clone() }
    }

    fn shortest_step(&self) -> f64 {
        self.right.length().min(self.down.length())
    }
}

/// Draws the steps of cells: those of a metric, or sheared and stretched ones.
fn steps() -> impl Strategy<Value = [DVec2; 2]> {
    let metric = (0.0..2.0, 0.0..3.15).prop_map(|(power, angle)| {
        let (axis, ratio) = (DVec2::from_angle(angle), 10f64.powf(power));
        [DVec2::X, DVec2::Y].map(|v| v + axis * (ratio - 1.0) * axis.dot(v))
    });
    let sheared = (-85.0..85.0, -1.477..1.477).prop_map(|(degrees, power): (f64, f64)| {
        [DVec2::X, 10f64.powf(power) * DVec2::new(degrees.to_radians().tan(), 1.0)]
    });
    prop_oneof![metric, sheared]
}

fn planes() -> impl Strategy<Value = Plane> {
    (steps(), 12..36usize, 12..40usize, any::<bool>()).prop_map(
        |([right, down], rows, cols, by_metric)| Plane {
            rows,
            cols,
            right,
            down,
            by_metric,
            bend: 0.0,
        },
    )
}

fn bent_planes() -> impl Strategy<Value = Plane> {
    (planes(), 0.001..0.005).prop_map(|(plane, bend)| Plane { bend, ..plane })
}

/// Draws places, as shares of the rows and columns, and whether they are grid points.
fn places(count: std::ops::RangeInclusive<usize>) -> impl Strategy<Value = Vec<([f64; 2], bool)>> {
    prop::collection::vec((prop::array::uniform2(0.0..1.0), any::<bool>()), count)
}

fn sources(at: &[DVec2]) -> Sources {
    let first = Sources::point(at[0].x, at[0].y);
    at[1..].iter().fold(first, |sources, at| sources.and_point(at.x, at.y, 0.0))
}

fn map(plane: &Plane, at: &[DVec2]) -> Vec<f64> {
    let options = Options::default();
    distance_map_f64(&plane.surface(), &sources(at), &options).unwrap().distances
}

/// Asserts that each reached point has the label of a source from which it is at most `excess` farther than from the
/// nearest one, in `own` maps of each source. Both distances are in steps to the nearest neighbour beyond two thousandths
/// of the distance.
fn assert_labels(
    surface: &Surface,
    (sources, map): (&Sources, &[f32]),
    own: &[Vec<f64>],
    (step, excess): (f64, f64),
) -> Result<(), TestCaseError> {
    let edges = EdgeLengths::new(surface).unwrap();
    let labels = Voronoi::new(surface, &edges, sources, map).unwrap().labels;
    for (index, &label) in labels.iter().enumerate() {
        prop_assert_eq!(label == NO_REGION, map[index].is_infinite(), "{}", index);
        if label != NO_REGION {
            let nearest = own.iter().map(|own| own[index]).fold(f64::INFINITY, f64::min);
            let found = own[label as usize][index];
            let most = nearest * 1.002 + excess * step;
            prop_assert!(found <= most, "{index}: {label} is {found} away, not {nearest}");
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(300))]

    /// Points belong to their nearest source, also where a region is narrower than a cell, and around holes.
    #[test]
    fn regions_are_those_of_the_nearest_source(
        plane in planes(),
        at in places(2..=5),
        hole in prop::option::of((0.2..0.8, 0.2..0.8, 1..5usize)),
    ) {
        let at: Vec<DVec2> = at.iter().map(|&(shares, is_point)| plane.at(shares, is_point)).collect();
        let mut surface = plane.surface();
        if let Some((row, col, wide)) = hole {
            let middle = plane.at([row, col], true);
            let is_far = |k| (plane.place(k) - middle).abs().max_element() > wide as f64;
            prop_assume!(at.iter().all(|at| (at - middle).abs().max_element() > wide as f64 + 1.0));
            let mask: Vec<bool> = (0..plane.rows * plane.cols).map(is_far).collect();
            surface = surface.with_mask(&mask).unwrap();
        }
        let map = distance_map(&surface, &sources(&at), &Options::default()).unwrap();
        let alone = |at: &DVec2| {
            distance_map_f64(&surface, &sources(&[*at]), &Options::default()).unwrap().distances
        };
        let own: Vec<_> = at.iter().map(alone).collect();
        let step = (plane.shortest_step(), 1e-3);
        assert_labels(&surface, (&sources(&at), &map.distances), &own, step)?;
    }

    /// A map of several sources is nowhere later or earlier than the maps of each of them.
    #[test]
    fn sources_together_reach_as_soon_as_alone(plane in bent_planes(), at in places(2..=5)) {
        let at: Vec<DVec2> = at.iter().map(|&(shares, is_point)| plane.at(shares, is_point)).collect();
        let surface = plane.surface();
        prop_assume!(surface.has_skewed_cells(2) && surface.unresolved().is_none());
        let together = map(&plane, &at);
        let own: Vec<_> = at.iter().map(|at| map(&plane, &[*at])).collect();
        for (index, found) in together.iter().enumerate() {
            let nearest = own.iter().map(|own| own[index]).fold(f64::INFINITY, f64::min);
            let error = (found - nearest).abs() / nearest.max(1e-3 * plane.shortest_step());
            prop_assert!(error < 1e-6, "{}: {found} {nearest}", plane.place(index));
        }
        let single = distance_map(&surface, &sources(&at), &Options::default()).unwrap();
        let step = (plane.shortest_step(), 1e-3);
        assert_labels(&surface, (&sources(&at), &single.distances), &own, step)?;
    }

    /// Maps of one source are straight lines, from grid points and from inside cells.
    #[test]
    fn a_lone_source_is_exact(plane in planes(), at in places(1..=1)) {
        let from = plane.at(at[0].0, at[0].1);
        for (index, found) in map(&plane, &[from]).into_iter().enumerate() {
            let exact = plane.distance(from, plane.place(index));
            let error = (found - exact).abs() / exact.max(1e-3 * plane.shortest_step());
            prop_assert!(error < 1e-6, "{from} {}: {found} {exact}", plane.place(index));
        }
    }

    /// Paths are as long as the map says.
    #[test]
    fn paths_are_straight(plane in planes(), at in places(2..=2)) {
        let [from, to] = [0, 1].map(|k| plane.at(at[k].0, at[k].1));
        let exact = plane.distance(from, to);
        prop_assume!(exact > plane.shortest_step());
        let (surface, sources) = (plane.surface(), sources(&[from]));
        let map = distance_map(&surface, &sources, &Options::default()).unwrap();
        let edges = EdgeLengths::new(&surface).unwrap();
        let tracer = PathTracer::new(&surface, &edges, &sources, &map.distances).unwrap();
        let path = tracer.trace(to.to_array()).unwrap();
        prop_assert!((path.length / exact - 1.0).abs() < 5e-3, "{} {exact}", path.length);
    }

    /// Scans visit the points of a turned grid in another order.
    #[test]
    fn turned_grids_have_the_same_map(plane in planes(), at in places(1..=3)) {
        let at: Vec<DVec2> = at.iter().map(|&(shares, is_point)| plane.at(shares, is_point)).collect();
        let (rows, cols) = (plane.rows, plane.cols);
        let own = map(&plane, &at);
        let turned: Vec<_> = at.iter().map(|at| DVec2::new(at.y, at.x)).collect();
        let turned = map(&plane.transposed(), &turned);
        let back: Vec<f64> = (0..rows * cols).map(|i| turned[i % cols * rows + i / cols]).collect();
        prop_assert!(difference(&back, &own) < 1e-5, "{}", difference(&back, &own));
        let turned: Vec<_> = at.iter().map(|at| DVec2::new((rows - 1) as f64 - at.x, at.y)).collect();
        let turned = map(&plane.flipped(), &turned);
        let back: Vec<f64> = turned.chunks(cols).rev().flatten().copied().collect();
        prop_assert!(difference(&back, &own) < 1e-5, "{}", difference(&back, &own));
    }
}
