//! Fronts over random floor plans, against exact polygons and against one another.

use glam::DVec2;

use super::{Solution, Stop, raster_scan, rotated_scan};
use crate::Sources;
use crate::accuracy::Errors;
use crate::surface::builtin::{FlatPaths, FloorPlan};
use crate::surface::{EdgeLengths, Real, Seed, Spacing, Surface};
use crate::update::Wavefront;

const ROWS: usize = 97;
const COLS: usize = 73;
/// Plans of each kind.
const PLANS: u64 = 12;

/// Pseudo-random numbers (xorshift) below 1.
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        (0..10).for_each(|_| _ = random.next());
        random
    }

    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn place(&mut self) -> DVec2 {
        DVec2::new(self.between(2.0, ROWS as f64 - 3.0), self.between(2.0, COLS as f64 - 3.0))
    }
}

/// What stands on the floor.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Nine boxes along the grid.
    Boxes,
    /// Twelve walls along the grid, one point thick.
    Walls,
    /// Twelve rooms with doors of three to six points.
    Rooms,
    /// Nine boxes at all angles, with steps for sides.
    TurnedBoxes,
    /// Nine columns.
    Columns,
}

impl Kind {
    const ALL: [Self; 5] =
        [Self::Boxes, Self::Walls, Self::Rooms, Self::TurnedBoxes, Self::Columns];

    fn floor(self, random: &mut Random) -> Vec<bool> {
        let mut floor = vec![true; ROWS * COLS];
        let mut clear = |inside: &dyn Fn(DVec2) -> bool| {
            for (index, free) in floor.iter_mut().enumerate() {
                *free &= !inside(DVec2::new((index / COLS) as f64, (index % COLS) as f64));
            }
        };
        let is_in_box = |to: DVec2, half: DVec2, ahead: DVec2| {
            to.dot(ahead).abs() <= half.x && to.perp_dot(ahead).abs() <= half.y
        };
        match self {
            Self::Boxes | Self::TurnedBoxes => (0..9).for_each(|_| {
                let middle = random.place();
                let half = DVec2::new(random.between(1.0, 10.0), random.between(1.0, 10.0));
                let turned = matches!(self, Self::TurnedBoxes);
                let ahead = DVec2::from_angle(if turned { random.between(0.0, 3.2) } else { 0.0 });
                clear(&|place| is_in_box(place - middle, half, ahead));
            }),
            Self::Walls => (0..12).for_each(|_| {
                let (middle, length) = (random.place(), random.between(4.0, 20.0));
                let ahead = if random.next() < 0.5 { DVec2::X } else { DVec2::Y };
                clear(&|place| is_in_box(place - middle, DVec2::new(length, 0.6), ahead));
            }),
            Self::Rooms => {
                let mut wall = |across: f64, along: f64, by_rows: bool| {
                    let door = along + random.between(2.0, 16.0).floor();
                    let end = door + random.between(3.0, 7.0).floor();
                    clear(&|place| {
                        let [at, to] =
                            if by_rows { [place.x, place.y] } else { [place.y, place.x] };
                        at == across
                            && (along..along + 24.0).contains(&to)
                            && !(door..end).contains(&to)
                    });
                };
                for (row, col) in (1..4).flat_map(|row| (0..3).map(move |col| (row, col))) {
                    wall(24.0 * f64::from(row), 24.0 * f64::from(col), true);
                }
                for (row, col) in (0..4).flat_map(|row| (1..3).map(move |col| (row, col))) {
                    wall(24.0 * f64::from(col), 24.0 * f64::from(row), false);
                }
            }
            Self::Columns => (0..9).for_each(|_| {
                let (middle, radius) = (random.place(), random.between(2.0, 10.0));
                clear(&|place| place.distance(middle) < radius);
            }),
        }
        floor
    }
}

/// A floor, its source and exact distances.
struct Case {
    surface: Surface,
    seeds: Vec<Seed>,
    exact: Vec<f64>,
}

impl Case {
    fn new(kind: Kind, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let floor = kind.floor(&mut random);
        let source = std::iter::repeat_with(|| random.place().floor().to_array())
            .find(|[row, col]| floor[*row as usize * COLS + *col as usize])
            .expect("some floor is free");
        let plane = Surface::from_heights(ROWS, COLS, vec![0.0; ROWS * COLS], Spacing::square(1.0));
        let surface = plane.unwrap().with_mask(&floor).unwrap();
        let seeds = Sources::point(source[0], source[1]).seeds(&surface).unwrap();
        let plan = FloorPlan::new(ROWS, COLS, floor, DVec2::ONE);
        Self { surface, seeds, exact: FlatPaths::new(plan, source).distances() }
    }

    fn solve<R: Real>(
        &self,
        wavefront: Wavefront,
        tolerance: f64,
        scan: fn(&EdgeLengths<R>, &[Seed], Wavefront, Stop) -> Solution<R>,
    ) -> Vec<f64> {
        let edges = EdgeLengths::new(&self.surface).unwrap();
        let stop = Stop { tolerance, iterations: 1000 };
        let map = scan(&edges, &self.seeds, wavefront, stop).distances();
        map.into_iter().map(Real::wide).collect()
    }
}

/// Of single precision: what is left of exact distances, and how far two orders of updates are apart,
/// and two precisions, of the largest distance.
#[derive(Default)]
struct Found {
    errors: Vec<f64>,
    orders: Vec<f64>,
    precisions: Vec<f64>,
}

impl Found {
    fn of(kind: Kind, wavefront: Wavefront) -> Self {
        let mut found = Self::default();
        for seed in 1..=PLANS {
            let case = Case::new(kind, seed);
            let rotated = case.solve::<f32>(wavefront, 1e-6, rotated_scan);
            let directed = case.solve::<f32>(wavefront, 1e-6, raster_scan);
            let double = case.solve::<f64>(wavefront, 1e-13, rotated_scan);
            let errors = Errors::of(&rotated, &case.exact);
            assert_eq!(errors.reached_by_one, 0, "{kind:?} {seed}");
            found.errors.push(errors.mean_relative);
            found.orders.push(Errors::of(&rotated, &directed).max_of_largest);
            found.precisions.push(Errors::of(&rotated, &double).max_of_largest);
        }
        found
    }

    /// The mean error, and of orders and precisions how many plans differ by more than 2e-5 and the
    /// largest difference.
    fn figures(&self) -> (f64, [(usize, f64); 2]) {
        let mean = self.errors.iter().sum::<f64>() / self.errors.len() as f64;
        let apart = [&self.orders, &self.precisions].map(|differences| {
            let many = differences.iter().filter(|&&difference| difference > 2e-5).count();
            (many, differences.iter().fold(0.0, |a: f64, &b| a.max(b)))
        });
        (mean, apart)
    }
}

/// The mean of two arcs is off behind every corner, but does not depend on rounding.
#[test]
fn curved_fronts_over_floor_plans_agree() {
    for kind in Kind::ALL {
        let (mean, apart) = Found::of(kind, Wavefront::Curved).figures();
        println!("{kind:?}, curved: mean error {mean:.1e}, orders and precisions apart {apart:?}");
        assert!(mean < 1e-3, "{kind:?}: {mean:e}");
        // As much as where there are no holes.
        assert!(apart.iter().all(|&(_, most)| most < 5e-6), "{kind:?}: {apart:?}");
    }
}

/// Arcs leave a tenth of that or less, nearly all where fronts meet; but where many borders of shadows
/// lie within a cell of one another, rounding decides at some points what is an arc.
#[test]
fn arcs_over_floor_plans_are_better_and_nearly_agree() {
    for kind in Kind::ALL {
        let (mean, apart) = Found::of(kind, Wavefront::Arcs).figures();
        println!("{kind:?}, arcs: mean error {mean:.1e}, orders and precisions apart {apart:?}");
        assert!(mean < 4e-5, "{kind:?}: {mean:e}");
        assert!(apart.iter().all(|&(_, most)| most < 1e-3), "{kind:?}: {apart:?}");
    }
}
