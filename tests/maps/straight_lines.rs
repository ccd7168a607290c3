//! Maps of several sources and maps over seams, on planes, cylinders and tori whose cells are all alike. The truth is the
//! distance to the nearest of many images of each source.

use geosweep::geometry::{BackDirections, NO_REGION, Voronoi};
use geosweep::glam::{DMat2, DVec2};
use geosweep::surface::{EdgeLengths, Gluing, MetricTensor};
use geosweep::{
    MapSolver, Options, Source, Sources, Spacing, Surface, Targets, distance_map, distance_map_f64,
};
use proptest::prelude::*;

use crate::common::cases;

/// Number of images to each side over a seam.
const IMAGES: i32 = 24;

/// A plane whose sides may be glued. A step along rows is `down`, one along columns is `right`.
#[derive(Clone, Debug)]
struct Flat {
    rows: usize,
    cols: usize,
    down: DVec2,
    right: DVec2,
    /// Whether the first and the last row, and the first and the last column, are one.
    glued: [bool; 2],
}

impl Flat {
    fn surface(&self) -> Surface {
        let Self { rows, cols, down, right, glued } = *self;
        let tensor = MetricTensor { rr: down.dot(down), rc: down.dot(right), cc: right.dot(right) };
        let open = Surface::from_metric(rows, cols, vec![tensor; rows * cols]).unwrap();
        let gluing = match glued {
            [false, false] => return open,
            [true, false] => Gluing::rows(),
            [false, true] => Gluing::columns(),
            [true, true] => Gluing::both(),
        };
        open.with_gluing(gluing).unwrap()
    }

    fn place(&self, index: usize) -> DVec2 {
        DVec2::new((index / self.cols) as f64, (index % self.cols) as f64)
    }

    fn last(&self) -> DVec2 {
        DVec2::new(self.rows as f64 - 1.0, self.cols as f64 - 1.0)
    }

    /// Returns the steps to all images over a seam that lie near enough.
    fn images(&self) -> Vec<DVec2> {
        let counts = self.glued.map(|glued| if glued { -IMAGES..=IMAGES } else { 0..=0 });
        let [rows, cols] = counts;
        let along =
            |down: i32| cols.clone().map(move |right| DVec2::from([down, right].map(f64::from)));
        rows.flat_map(along).map(|count| count * self.last()).collect()
    }

    /// Returns the shortest of the steps in the plane from a place to a source.
    fn step(&self, at: DVec2, source: &Source, images: &[DVec2]) -> DVec2 {
        let plane = DMat2::from_cols(self.down, self.right);
        let (vertices, single) = match source {
            Source::Point { at, .. } => (vec![*at; 2], true),
            Source::Curve { vertices, .. } => (vertices.clone(), false),
        };
        assert!(vertices.len() > 1 || single);
        let to = |ends: &[DVec2], image: DVec2| {
            let [a, b] = [ends[0], ends[1]].map(|end| plane * (end + image - at));
            let along = b - a;
            let square = along.length_squared();
            let share = if square > 0.0 { (-a.dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
            a + share * along
        };
        let steps =
            vertices.windows(2).flat_map(|ends| images.iter().map(|image| to(ends, *image)));
        steps.min_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap()
    }
}

fn flats() -> impl Strategy<Value = Flat> {
    let sizes = (6usize..18, 6usize..18);
    let shapes = (0.4..2.5f64, -2.0..2.0f64, 0.4..2.5f64);
    (sizes, shapes, any::<[bool; 2]>()).prop_map(|((rows, cols), (down, shear, right), glued)| {
        Flat { rows, cols, down: DVec2::new(shear, down), right: DVec2::new(right, 0.0), glued }
    })
}

/// Draws sources as shares of rows and columns: points, some of them grid points, and polylines.
fn sources() -> impl Strategy<Value = Vec<(Vec<[f64; 2]>, bool, f64)>> {
    let place = || [0.0..=1.0f64, 0.0..=1.0];
    let vertices = prop::collection::vec(place(), 1..4);
    prop::collection::vec((vertices, any::<bool>(), 0.0..2.0f64), 1..5)
}

fn placed(flat: &Flat, drawn: &[(Vec<[f64; 2]>, bool, f64)]) -> Sources {
    let source = |(vertices, is_point, initial): &(Vec<[f64; 2]>, bool, f64)| {
        let place = |share: &[f64; 2]| {
            let at = DVec2::from(*share) * flat.last();
            if *is_point { at.round() } else { at }
        };
        let mut vertices: Vec<_> = vertices.iter().map(place).collect();
        // A curve that runs from a place to its copy would jump over the seam.
        vertices.dedup_by(|a, b| {
            let apart = (*a - *b).abs();
            let is_copy = |axis: usize| flat.glued[axis] && apart[axis] == flat.last()[axis];
            (0..2).all(|axis| apart[axis] == 0.0 || is_copy(axis))
        });
        match vertices[..] {
            [at] => Source::Point { at, initial: *initial },
            _ => Source::Curve { vertices, initial: *initial },
        }
    };
    drawn.iter().map(source).collect()
}

proptest! {
    #![proptest_config(cases(60))]

    /// Maps are exact in both precisions, labels are those of a nearest source, and ways back lead to it.
    #[test]
    fn the_nearest_image_gives_time_label_and_way(flat in flats(), drawn in sources()) {
        let (surface, sources) = (flat.surface(), placed(&flat, &drawn));
        let all: Vec<_> = sources.iter().collect();
        let images = flat.images();
        let steps = |index: usize| -> Vec<(f64, DVec2)> {
            let step = |source: &&Source| {
                let step = flat.step(flat.place(index), source, &images);
                (source.initial() + step.length(), step)
            };
            all.iter().map(step).collect()
        };
        let options = Options::default();
        let double = distance_map_f64(&surface, &sources, &options).unwrap();
        let single = distance_map(&surface, &sources, &options).unwrap();
        let edges = EdgeLengths::new(&surface).unwrap();
        let labels = Voronoi::new(&surface, &edges, &sources, &single.distances).unwrap().labels;
        let ways = BackDirections::new(&surface, &edges, &sources, &single.distances).unwrap();
        let ways = ways.in_chart();
        let is_lone_point = matches!(all[..], [Source::Point { .. }]) && flat.glued == [false; 2];
        let plane = DMat2::from_cols(flat.down, flat.right);
        for index in 0..flat.rows * flat.cols {
            let steps = steps(index);
            let (exact, step) =
                *steps.iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            let late = (double.distances[index] - exact).abs();
            // A lone source on an open plane is solved by scans.
            let most = if is_lone_point { 1e-7 } else { 1e-12 };
            prop_assert!(late <= most * (1.0 + exact), "{index}: {exact}, {late}");
            let late = (f64::from(single.distances[index]) - exact).abs();
            prop_assert!(late <= 2e-6 * (1.0 + exact), "{index}: {exact}, {late}");
            prop_assert!(labels[index] != NO_REGION);
            let (of_label, _) = steps[labels[index] as usize];
            prop_assert!(of_label <= exact * (1.0 + 1e-6) + 1e-9, "{index}: {of_label} {exact}");
            // Of two equally long ways, either is right.
            let way = plane * DVec2::from(ways[index].map(f64::from));
            if step.length() > 1e-3 && !is_lone_point {
                let ahead = 1e-3 * way.normalize();
                let moved = flat.place(index) + plane.inverse() * ahead;
                let nearer = all.iter().map(|source| {
                    source.initial() + flat.step(moved, source, &images).length()
                });
                let nearer = nearer.fold(f64::MAX, f64::min);
                prop_assert!((exact - nearer - 1e-3).abs() < 1e-5, "{index}: {exact} {nearer}");
            }
        }
    }
}

#[test]
fn radius_targets_and_kept_solvers_hold_for_straight_lines() {
    let spacing = Spacing { dx: 1.0, dy: 3.0 };
    let surface = Surface::from_heights(31, 41, vec![0.0; 31 * 41], spacing).unwrap();
    let sources = Sources::point(3.5, 4.25).and_point(4.0, 30.0, 1.0).and_point(20.0, 30.5, 2.0);
    let all = distance_map(&surface, &sources, &Options::default()).unwrap();
    assert_eq!((all.report.schedule, all.report.iterations), ("straight-lines", 0));
    assert!(all.report.converged && all.report.reached == 31 * 41);
    let near = distance_map(&surface, &sources, &Options::default().with_radius(9.0)).unwrap();
    for (near, all) in near.distances.iter().zip(&all.distances) {
        assert_eq!(*near, if *all <= 9.0 { *all } else { f32::INFINITY });
    }
    assert_eq!(near.report.reached, near.distances.iter().filter(|d| d.is_finite()).count());
    let targets = Targets::any([[10, 10], [25, 35]]);
    let some = Options::default().with_targets(targets);
    let some = distance_map(&surface, &sources, &some).unwrap();
    let last = all.distance(10, 10).min(all.distance(25, 35));
    assert!(
        some.distances
            .iter()
            .zip(&all.distances)
            .all(|(some, all)| { *some == if *all <= last { *all } else { f32::INFINITY } })
    );
    let kept = MapSolver::new(surface);
    for _ in 0..2 {
        let again = kept.distance_map(&sources, &Options::default()).unwrap();
        assert_eq!(again.distances, all.distances);
    }
}

/// Behind holes, fronts of sources on a sheared plane are those of each source's own map.
#[test]
fn points_in_sight_are_exact_beside_holes() {
    let sheared = |row: usize, col: usize| {
        geosweep::glam::DVec3::new(col as f64 + 0.7 * row as f64, row as f64, 0.0)
    };
    let positions = (0..40 * 50).map(|k| sheared(k / 50, k % 50)).collect();
    let mask: Vec<_> = (0..40 * 50)
        .map(|k| !((15..20).contains(&(k / 50)) && (10..30).contains(&(k % 50))))
        .collect();
    let surface = Surface::from_positions(40, 50, positions).unwrap().with_mask(&mask).unwrap();
    let sources = Sources::point(10.3, 20.6).and_point(11.0, 22.0, 0.0).and_point(30.5, 5.0, 1.0);
    let seen = |row: usize, col: usize| row < 10 || col > 40;
    let map = distance_map_f64(&surface, &sources, &Options::default()).unwrap();
    let curved = Options::default().with_wavefront(geosweep::Wavefront::Curved);
    let seeds = sources.seeds_with_origins(&surface).unwrap();
    let seeds = geosweep::cpu::seeds_for(geosweep::Wavefront::Curved, &surface, seeds);
    let exact: Vec<_> = seeds.iter().filter(|seed| seed.exact).collect();
    assert!(exact.len() > 1000, "{}", exact.len());
    for seed in exact.into_iter().filter(|seed| seen(seed.row, seed.col)) {
        let apart = (seed.time - map.distance(seed.row, seed.col)).abs();
        assert!(apart < 2e-3 * seed.time.max(1.0), "{seed:?}: {apart}");
    }
    let map_of = |sources: &Sources| distance_map_f64(&surface, sources, &curved).unwrap();
    let alone = sources.iter().map(|source| map_of(&std::iter::once(source.clone()).collect()));
    let alone: Vec<_> = alone.collect();
    for index in (0..40 * 50).filter(|&index| mask[index]) {
        let least = alone.iter().map(|map| map.distances[index]).fold(f64::MAX, f64::min);
        let late = map.distances[index] - least;
        assert!(late.abs() < 7e-3 * least.max(1.0), "{index}: {late} of {least}");
    }
}
