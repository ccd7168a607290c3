//! Detects where a grid of positions is a closed surface that was cut open. Fronts do not pass such a cut unless its
//! sides are glued.

use std::fmt::{self, Display, Formatter};

use glam::DVec3;

pub use super::chart::GridSide;
use super::{Geometry, Surface};

/// A part of the grid's border at which the surface continues although the grid ends: at other points of the border, or
/// at a pole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seam {
    /// Two sides of the grid coincide, point by point. Unless the sides are glued, fronts do not pass from one to the
    /// other.
    Sides {
        /// The two sides.
        sides: [GridSide; 2],
        /// Whether the first point of one side coincides with the last point of the other.
        reversed: bool,
    },
    /// Two opposite sides of the grid are neighbours one cell apart, as on a globe that is sampled at the middles of
    /// its cells. Fronts do not pass from one to the other.
    Neighbours {
        /// The two sides.
        sides: [GridSide; 2],
        /// Whether the first point of one side is beside the last point of the other.
        reversed: bool,
    },
    /// The two halves of a side coincide, as in geometry images. Unless the halves are glued, fronts do not pass from
    /// one to the other.
    Fold(GridSide),
    /// A side is a single point, as at the poles of a sphere.
    Pole {
        /// The side.
        side: GridSide,
        /// Whether the side's points are exactly equal. Fronts then pass the pole along edges of length 0. Edges whose
        /// length is mere rounding are rejected.
        exact: bool,
    },
    /// A side surrounds a pole that the grid lacks, as on a globe that is sampled at the middles of its cells.
    /// [`Surface::seams`] does not find it, since a tube that ends there looks the same.
    /// [`CompletedGrid`](super::CompletedGrid) adds the pole.
    Ring(GridSide),
}

impl Display for Seam {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let order = |reversed: bool| if reversed { " in reverse order" } else { "" };
        match self {
            Self::Sides { sides: [a, b], reversed } => {
                write!(f, "its {a} and its {b} coincide{}", order(*reversed))
            }
            Self::Neighbours { sides: [a, b], reversed } => {
                write!(f, "its {a} and its {b} are neighbours one cell apart{}", order(*reversed))
            }
            Self::Fold(side) => write!(f, "the halves of its {side} coincide"),
            Self::Pole { side, exact: true } => write!(f, "its {side} is a single point"),
            Self::Pole { side, exact: false } => write!(f, "its {side} is nearly a single point"),
            Self::Ring(side) => write!(f, "its {side} surrounds a pole"),
        }
    }
}

/// Largest distance of coincident points, relative to the edges there. It is far less than the distance of neighbours,
/// and more than the rounding of half precision, in which geometry images are sometimes stored.
pub(super) const COINCIDENT: f64 = 0.05;

/// Maximum ratio, either way, of the step between two neighbouring sides to the steps of the grid before and behind it.
const MOST_UNEVEN: f64 = 2.0;
/// Length up to which a step counts as zero, as at a pole. It is a part of the longest edge that leads inwards from the
/// side.
const AT_POLE: f64 = 1e-9;
/// Least cosine of the angle between the step from one neighbouring side to the other and the steps of the grid before
/// and behind it: that of 60 degrees.
const LEAST_COSINE: f64 = 0.5;

impl Surface {
    /// Returns the seams: sides of the grid that coincide or are neighbours, at points that are not holes.
    /// Seams that are glued ([`Self::with_gluing`]) are left out. Only positions show that a surface is closed; other
    /// geometries have no seams.
    ///
    /// ```
    /// use std::f64::consts::TAU;
    /// use geosweep::Surface;
    /// use geosweep::glam::DVec3;
    /// // A tube whose last column repeats its first.
    /// let angle = |index: usize| TAU * (index % 17) as f64 / 16.0;
    /// let point = |index| DVec3::new(angle(index).cos(), angle(index).sin(), (index / 17) as f64);
    /// let tube = Surface::from_positions(9, 17, (0..9 * 17).map(point).collect())?;
    /// assert_eq!(tube.seams()[0].to_string(), "its first column and its last column coincide");
    /// # Ok::<(), geosweep::surface::SurfaceError>(())
    /// ```
    pub fn seams(&self) -> Vec<Seam> {
        use GridSide::{FirstColumn, FirstRow, LastColumn, LastRow};
        if !matches!(self.geometry(), Geometry::Positions(_)) {
            return Vec::new();
        }
        let sides = [FirstRow, LastRow, FirstColumn, LastColumn].map(|side| Rim::new(self, side));
        let is_line = |rim: &&Rim| rim.pole().is_none();
        let lines: Vec<_> = sides.iter().filter(is_line).collect();
        let mut seams: Vec<_> = sides.iter().filter_map(Rim::pole).collect();
        for (index, a) in lines.iter().enumerate() {
            if a.is_folded() {
                seams.push(Seam::Fold(a.side));
            }
            for b in &lines[index + 1..] {
                let reversed = [false, true].into_iter().find(|&reversed| a.is_along(b, reversed));
                let of = |reversed| Seam::Sides { sides: [a.side, b.side], reversed };
                seams.extend(reversed.map(of));
                if reversed.is_none() && a.side.is_opposite(b.side) {
                    // Narrow strips may continue in both orders. The true order has the shorter steps.
                    let ways = [false, true].map(|way| (way, a.gap_to(b, way)));
                    let ways = ways.into_iter().filter_map(|(way, gap)| Some((way, gap?)));
                    let reversed = ways.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(way, _)| way);
                    let of = |reversed| Seam::Neighbours { sides: [a.side, b.side], reversed };
                    seams.extend(reversed.map(of));
                }
            }
        }
        seams.retain(|seam| !self.has_glued(seam));
        seams
    }
}

/// The points of one side of the grid.
pub(super) struct Rim {
    side: GridSide,
    points: Vec<Option<RimPoint>>,
}

struct RimPoint {
    index: usize,
    position: DVec3,
    /// The edge that leads inwards, if there is one.
    inwards: Option<DVec3>,
}

impl RimPoint {
    /// Returns whether two points coincide, or `None` for the same grid point, which two sides share at a
    /// corner. Their distance is compared with the edges that lead inwards and with the size of the seam: a strip may be
    /// narrower than a twentieth of its edges.
    fn coincides(&self, other: &Self, size: f64) -> Option<bool> {
        let apart = self.position.distance(other.position);
        let near = COINCIDENT * self.depth().max(other.depth()).min(size);
        (self.index != other.index).then_some(apart <= near)
    }

    /// Returns the length of the edge that leads inwards, or 0 if there is none.
    fn depth(&self) -> f64 {
        self.inwards.map_or(0.0, DVec3::length)
    }

    /// Returns whether the step from `other` to this point continues the steps of the grid before and behind it. The
    /// result is `None` if one of these steps is missing, and at poles, where all of them are at most `least` long.
    fn follows(&self, other: &Self, least: f64) -> Option<bool> {
        let steps = [self.position - other.position, self.inwards?, other.inwards?];
        if steps.into_iter().all(|step| step.length() <= least) {
            return None;
        }
        let step = self.position - other.position;
        let alike = |edge: DVec3| {
            let (along, product) = (step.dot(edge), step.length() * edge.length());
            let ratio = step.length() / edge.length();
            along >= LEAST_COSINE * product && (1.0 / MOST_UNEVEN..=MOST_UNEVEN).contains(&ratio)
        };
        Some(alike(self.inwards?) && alike(-other.inwards?))
    }
}

impl Rim {
    pub(super) fn new(surface: &Surface, side: GridSide) -> Self {
        let chart = surface.chart();
        let point = |(row, col)| {
            let position = surface.position(row, col)?;
            let behind = chart.neighbour(row, col, side.inwards());
            let behind = behind.and_then(|(row, col)| surface.position(row, col));
            let inwards = behind.map(|behind| behind - position);
            Some(RimPoint { index: chart.index(row, col), position, inwards })
        };
        Self { side, points: side.places(chart).map(point).collect() }
    }

    /// Returns the [`spread`] of the next line inwards.
    pub(super) fn spread_behind(&self) -> f64 {
        let behind = |point: &RimPoint| point.inwards.map(|inwards| point.position + inwards);
        spread(self.points.iter().flatten().filter_map(behind))
    }

    pub(super) fn pole(&self) -> Option<Seam> {
        let mut points = self.points.iter().flatten();
        let (first, size) = (points.next()?, self.spread_behind());
        let (mut others, mut exact) = (0, true);
        for point in points {
            if !first.coincides(point, size)? {
                return None;
            }
            others += 1;
            exact &= point.position == first.position;
        }
        (others >= 2).then_some(Seam::Pole { side: self.side, exact })
    }

    fn is_folded(&self) -> bool {
        let half = self.points.len() / 2;
        coincide(self.points.iter().zip(self.points.iter().rev()).take(half))
    }

    /// Returns the sum of the distances between corresponding points of this side and another one, if the grid
    /// continues from the other side to this one.
    pub(super) fn gap_to(&self, other: &Self, reversed: bool) -> Option<f64> {
        let others: Vec<_> = match reversed {
            false => other.points.iter().collect(),
            true => other.points.iter().rev().collect(),
        };
        let pairs = || self.points.iter().zip(&others);
        let known = || pairs().filter_map(|(a, b)| a.as_ref().zip(b.as_ref()));
        // A pair whose partner in the other order is missing would count in only one of the two sums.
        let has_both = |index: usize| {
            let mirrored = self.points.len() - 1 - index;
            [index, mirrored]
                .into_iter()
                .all(|at| self.points[at].is_some() && others[at].is_some())
        };
        let gaps = pairs().enumerate().filter(|(index, _)| has_both(*index));
        let known_to_both = gaps.filter_map(|(_, (a, b))| a.as_ref().zip(b.as_ref()));
        let gap = known_to_both.map(|(a, b)| a.position.distance(b.position)).sum();
        let longest = self.points.iter().flatten().map(RimPoint::depth).fold(0.0, f64::max);
        all_known(known().map(|(a, b)| a.follows(b, AT_POLE * longest))).then_some(gap)
    }

    pub(super) fn is_along(&self, other: &Self, reversed: bool) -> bool {
        self.points.len() == other.points.len()
            && match reversed {
                false => coincide(self.points.iter().zip(&other.points)),
                true => coincide(self.points.iter().zip(other.points.iter().rev())),
            }
    }
}

/// Returns whether there are at least two pairs of different points that are not holes, and all such pairs coincide.
fn coincide<'a>(pairs: impl Iterator<Item = (&'a Option<RimPoint>, &'a Option<RimPoint>)>) -> bool {
    let known = pairs.filter_map(|(a, b)| Some((a.as_ref()?, b.as_ref()?)));
    let known: Vec<_> = known.collect();
    let size = spread(known.iter().flat_map(|(a, b)| [a.position, b.position]));
    all_known(known.iter().map(|(a, b)| a.coincides(b, size)))
}

/// Returns the distance from the first of some points to the farthest other one, or 0 if there are none.
pub(super) fn spread(points: impl IntoIterator<Item = DVec3>) -> f64 {
    let mut points = points.into_iter();
    let Some(first) = points.next() else { return 0.0 };
    points.map(|point| first.distance(point)).fold(0.0, f64::max)
}

/// Returns whether a condition is known at two points or more, and holds at all of them.
fn all_known(found: impl Iterator<Item = Option<bool>>) -> bool {
    let mut count = 0;
    found.flatten().inspect(|_| count += 1).all(|holds| holds) && count >= 2
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use proptest::prelude::*;

    use super::*;
    use crate::builtin::Builtin;
    use crate::{Chart, Gluing, Spacing};

    fn surface(rows: usize, cols: usize, at: impl Fn(f64, f64) -> DVec3) -> Surface {
        let point = |index| {
            let (row, col) = Chart { rows, cols }.position(index);
            at(row as f64 / (rows - 1) as f64, col as f64 / (cols - 1) as f64)
        };
        Surface::from_positions(rows, cols, (0..rows * cols).map(point).collect()).unwrap()
    }

    fn names(surface: &Surface) -> Vec<String> {
        surface.seams().iter().map(Seam::to_string).collect()
    }

    fn tube(turns: f64) -> Surface {
        surface(9, 33, |v, u| DVec3::new((turns * TAU * u).cos(), (turns * TAU * u).sin(), 3.0 * v))
    }

    #[test]
    fn a_tube_is_closed_where_its_columns_coincide() {
        assert_eq!(names(&tube(1.0)), ["its first column and its last column coincide"]);
        // With a gap of one step, the last column is beside the first one. With a gap of three and a half steps, or an
        // overlap of one, the tube is open.
        let beside = "its first column and its last column are neighbours one cell apart";
        assert_eq!(names(&tube(32.0 / 33.0)), [beside]);
        assert!(tube(32.0 / 35.5).seams().is_empty());
        assert!(tube(33.0 / 32.0).seams().is_empty());
        // Rounded to half precision, the tube is still closed.
        let half = |x: f64| (1024.0 * x).round() / 1024.0;
        let rough = surface(9, 33, |v, u| {
            DVec3::new(half((TAU * u + 2e-4).cos()), half((TAU * u - 2e-4).sin()), 3.0 * v)
        });
        assert_eq!(rough.seams().len(), 1);
        // Without one of the two columns, the tube is open.
        let mask: Vec<_> = (0..9 * 33).map(|index| index % 33 != 32).collect();
        assert!(tube(1.0).with_mask(&mask).unwrap().seams().is_empty());
    }

    #[test]
    fn a_moebius_strip_and_a_torus_are_closed() {
        let moebius = surface(9, 65, |v, u| {
            let (half_turn, across) = (PI * u, v - 0.5);
            let radius = 2.0 + across * half_turn.cos();
            DVec3::new(radius * (TAU * u).cos(), radius * (TAU * u).sin(), across * half_turn.sin())
        });
        assert_eq!(
            names(&moebius),
            ["its first column and its last column coincide in reverse order"]
        );
        let torus = surface(17, 33, |v, u| {
            let radius = 2.0 + (TAU * v).cos();
            DVec3::new(radius * (TAU * u).cos(), radius * (TAU * u).sin(), (TAU * v).sin())
        });
        let closed = [
            "its first row and its last row coincide",
            "its first column and its last column coincide",
        ];
        assert_eq!(names(&torus), closed);
    }

    #[test]
    fn a_ball_has_poles() {
        // In double precision the sine of a half turn is not 0.
        let ball = |sin: fn(f64) -> f64| {
            surface(17, 33, move |v, u| {
                let (radius, around) = (sin(PI * v), TAU * u);
                DVec3::new(radius * around.cos(), radius * around.sin(), (PI * v).cos())
            })
        };
        let seam = "its first column and its last column coincide";
        let [north, south] = ["its first row is a single point", "its last row is a single point"];
        let nearly = "its last row is nearly a single point";
        assert_eq!(names(&ball(f64::sin)), [north, nearly, seam]);
        let exact = |x: f64| if x == PI { 0.0 } else { x.sin() };
        assert_eq!(names(&ball(exact)), [north, south, seam]);
    }

    proptest! {
        /// Closed surfaces that are sampled at the middles of their cells: balls, tori and Moebius strips. A
        /// part of the seam may be missing. Without the last two columns they are open.
        #[test]
        fn sides_one_cell_apart_are_neighbours(
            // Enough points, so that holes leave some whose partners in both orders are known.
            rows in 9usize..30,
            cols in 9usize..40,
            kind in 0usize..3,
            span in prop_oneof![0.003..0.3, 0.3..3.0f64],
            hole in 0usize..4,
        ) {
            // A ball or torus that is much flatter covers a disc twice, so that its halves coincide.
            let span = if kind == 2 { span } else { f64::max(span, 0.3) };
            let at = |v: f64, u: f64| {
                let (sin, cos) = (TAU * u).sin_cos();
                match kind {
                    0 => DVec3::new((PI * v).sin() * cos, (PI * v).sin() * sin, span * (PI * v).cos()),
                    1 => {
                        let radius = 2.0 + span * 0.5 * (TAU * v).cos();
                        DVec3::new(radius * cos, radius * sin, (TAU * v).sin())
                    }
                    _ => {
                        let (across, half) = (span * (v - 0.5), PI * u);
                        let radius = 4.0 + across * half.cos();
                        DVec3::new(radius * cos, radius * sin, across * half.sin())
                    }
                }
            };
            let middles = |kept: usize| {
                let chart = Chart { rows, cols: kept };
                let point = |(row, col)| at((row as f64 + 0.5) / rows as f64, (col as f64 + 0.5) / cols as f64);
                let mut positions: Vec<_> = chart.places().map(point).collect();
                (0..hole).for_each(|row| positions[chart.index(row, 0)] = DVec3::NAN);
                Surface::from_positions(rows, kept, positions).unwrap()
            };
            let (columns, rows_too) = ([GridSide::FirstColumn, GridSide::LastColumn], [GridSide::FirstRow, GridSide::LastRow]);
            let seam = Seam::Neighbours { sides: columns, reversed: kind == 2 };
            let found = middles(cols).seams();
            prop_assert!(found.contains(&seam), "{found:?}");
            // The rows of a torus turn too sharply if they are few or uneven.
            let around = Seam::Neighbours { sides: rows_too, reversed: false };
            prop_assert!(found.iter().all(|found| *found == seam || kind == 1 && *found == around), "{found:?}");
            prop_assert!(!middles(cols - 2).seams().contains(&seam));
        }
    }

    /// Strips that are narrower than a twentieth of their cells' length. Their ends are neither poles nor folded, and
    /// they close in the order of their points.
    #[test]
    fn the_ends_of_narrow_strips_do_not_coincide() {
        for width in [0.3, 0.1, 1e-3] {
            let band = |twist: f64, end: f64| {
                surface(10, 9, move |v, u| {
                    let (angle, across) = (end * TAU * u, width * (v - 0.5));
                    let (radius, half) = (4.0 + across * (twist * angle).cos(), twist * angle);
                    DVec3::new(radius * angle.cos(), radius * angle.sin(), across * half.sin())
                })
            };
            assert_eq!(names(&band(0.0, 0.5)), [""; 0], "width {width}");
            let repeated = "its first column and its last column coincide";
            assert_eq!(names(&band(0.0, 1.0)), [repeated], "width {width}");
            let twisted = "its first column and its last column coincide in reverse order";
            assert_eq!(names(&band(0.5, 1.0)), [twisted], "width {width}");
            let beside = "its first column and its last column are neighbours one cell apart";
            assert_eq!(names(&band(0.0, 8.0 / 9.0)), [beside], "width {width}");
            let opposite = format!("{beside} in reverse order");
            assert_eq!(names(&band(0.5, 8.0 / 9.0)), [opposite], "width {width}");
            for (strip, gluing) in [
                (band(0.5, 1.0), Gluing::columns()),
                (band(0.0, 1.0), Gluing::flipped_columns()),
                (band(0.0, 0.5), Gluing::Seams(vec![Seam::Fold(GridSide::FirstColumn)])),
                (
                    band(0.0, 0.5),
                    Gluing::Seams(vec![Seam::Pole { side: GridSide::FirstColumn, exact: false }]),
                ),
            ] {
                let refused = strip.with_gluing(gluing.clone());
                assert!(refused.is_err(), "width {width}: {gluing:?}");
            }
        }
    }

    /// The rows of a tube may lie closer to each other than the rounding of its positions reaches.
    #[test]
    fn a_tube_of_close_rows_is_closed_although_its_sides_are_rounded() {
        let half = |x: f64| (1024.0 * x).round() / 1024.0;
        let rough = surface(301, 17, |v, u| {
            DVec3::new(half((TAU * u + 2e-4).cos()), half((TAU * u - 2e-4).sin()), 0.1 * v)
        });
        assert_eq!(names(&rough), ["its first column and its last column coincide"]);
        assert!(rough.with_gluing(Gluing::columns()).is_ok());
    }

    /// A square folded to a bag: a geometry image of a closed surface has such sides.
    #[test]
    fn the_halves_of_a_folded_side_coincide() {
        let bag =
            surface(9, 17, |v, u| DVec3::new((TAU * u).cos() * (1.0 - v), v, (TAU * u).sin() * v));
        // Along rows: at v = 0 the two halves of a line run there and back.
        assert_eq!(bag.seams()[0], Seam::Fold(GridSide::FirstRow));
    }

    #[test]
    fn open_surfaces_have_no_seams() {
        for builtin in Builtin::ALL {
            let surface = builtin.surface(33, 33).unwrap();
            assert!(surface.seams().is_empty(), "{builtin}: {:?}", names(&surface));
        }
        let flat = Surface::from_heights(5, 5, vec![0.0; 25], Spacing::square(1.0)).unwrap();
        assert!(flat.seams().is_empty());
        for (rows, cols) in [(1, 1), (1, 9), (9, 1), (2, 2), (2, 9)] {
            let strip = surface_of(rows, cols);
            assert!(strip.seams().is_empty(), "{rows} x {cols}: {:?}", names(&strip));
        }
    }

    fn surface_of(rows: usize, cols: usize) -> Surface {
        let point = |index| {
            let (row, col) = Chart { rows, cols }.position(index);
            DVec3::new(col as f64, row as f64, 0.0)
        };
        Surface::from_positions(rows, cols, (0..rows * cols).map(point).collect()).unwrap()
    }
}
