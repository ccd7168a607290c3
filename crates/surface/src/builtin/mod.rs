//! Provides built-in surfaces, most of them with exact distances to test a solver against.
//!
//! Every surface maps the unit square to space. Rows run along v and columns along u, both from 0 to 1. Each patch is
//! chosen so that exact distances hold inside it, not only on the whole surface from which it is cut.

mod closed;
mod developable;
mod face;
mod flat_paths;
mod jet;
mod maze;
mod peaks;
mod shooting;
mod sphere;
mod torus;
mod unit_square;

use glam::{DVec2, DVec3};

use super::{Surface, SurfaceError};
use crate::shown::excerpt;
pub use closed::Closed;
#[doc(hidden)]
pub use flat_paths::{FlatPaths, FloorPlan};
use jet::{Jet, Smooth};
use unit_square::unit_square;

/// A surface known by name, which can be sampled at any size. [`Closed`] has surfaces that are glued at their
/// sides.
///
/// ```
/// use geosweep::surface::builtin::Builtin;
/// let sphere = Builtin::parse("sphere")?;
/// let surface = sphere.surface(65, 65)?;
/// // From the middle of a face of the cube to the middle of its side: an eighth of the way round.
/// let distance = sphere.exact_distance(65, 65, [32.0, 32.0], [32.0, 64.0]).unwrap();
/// assert!((distance - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
/// # assert_eq!(surface.points(), 65 * 65);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Builtin {
    /// The unit square, x = (u, v, 0). Exact distances are straight lines.
    Plane,
    /// The unit square sheared, x = (u + v tan(degrees), v, 0). From 45 degrees on, the triangles of a square
    /// grid are obtuse. Exact distances are straight lines, which stay inside the parallelogram.
    ShearedPlane {
        /// Angle of the shear, between -89 and 89 degrees.
        degrees: f64,
    },
    /// One face of a cube, blown up to the unit sphere: x = (tan a, tan b, 1) divided by its length. The
    /// angles a and b run from -45 to 45 degrees, proportional to u and v. Exact distances are along great
    /// circles, atan2(|p x q|, p . q). The central projection to the cube's face turns great circles into
    /// straight lines, so they stay inside the patch.
    Sphere,
    /// Three quarters of a cylinder: x = (cos a, sin a, 3 v), a = 270 u degrees. Exact distances are straight
    /// lines in the unrolled rectangle: the hypotenuse of angle and height.
    Cylinder,
    /// Three quarters of a truncated cone with its apex at the origin: x = s (sin h cos a, sin h sin a, cos
    /// h), with a half-angle h of 30 degrees, a = 270 u degrees and slant heights s = 0.5 + v. Unrolled, it
    /// is a sector of 135 degrees of an annulus. The exact distance is the straight line, or where that would
    /// cross the inner circle, two tangents and an arc of the circle.
    Cone,
    /// A quarter of a torus, x = ((1 + r cos b) cos a, (1 + r cos b) sin a, r sin b) with r = 0.4, a = 180 u
    /// and b = 180 v degrees. Half of it is curved outwards, half is a saddle. There is no closed form of the
    /// distance. Its borders are geodesics, so that shortest paths stay inside.
    Torus,
    /// The sum of Gaussians known as "peaks", over a square of side 6, a quarter as high as usual. There is
    /// no closed form of the distance.
    Peaks,
    /// The unit square with walls that make a spiral corridor (after the paper's figure 6). It has up to
    /// three turns: fewer on small grids, none below 21 rows or columns. The exact distance is the shortest
    /// polygonal path around the walls, by a visibility graph.
    Maze,
    /// A face as a range scanner sees it, in millimetres. Brow, eyes, nose, lips and chin are bumps on a
    /// rounded head 160 wide and 200 high, cut out along an oval, with x rightwards, y downwards and z
    /// towards the scanner. On a grid of 183 x 155 points, about 21 775 points are left, as many as the
    /// surface of the paper's figure 7 has. Distances are not known.
    Face,
}

impl Builtin {
    /// All built-in surfaces, with the default shear.
    pub const ALL: [Self; 9] = [
        Self::Plane,
        Self::ShearedPlane { degrees: Self::DEFAULT_SHEAR },
        Self::Sphere,
        Self::Cylinder,
        Self::Cone,
        Self::Torus,
        Self::Peaks,
        Self::Maze,
        Self::Face,
    ];

    /// Returns the surfaces that have [distances to test a solver against](Self::reference_distances).
    pub fn measurable() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|&builtin| builtin != Self::Face)
    }

    /// Shear of `sheared-plane` without `@degrees`, in degrees.
    pub const DEFAULT_SHEAR: f64 = 60.0;

    /// Returns the name that [`Self::parse`] accepts, without the angle of the shear.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plane => "plane",
            Self::ShearedPlane { .. } => "sheared-plane",
            Self::Sphere => "sphere",
            Self::Cylinder => "cylinder",
            Self::Cone => "cone",
            Self::Torus => "torus",
            Self::Peaks => "peaks",
            Self::Maze => "maze",
            Self::Face => "face",
        }
    }

    /// Returns all names, separated by commas, for help texts and messages.
    pub fn names() -> String {
        Self::ALL.map(Self::name).join(", ")
    }

    /// Finds a surface by its name. A text such as `sheared-plane@72` gives the angle of the shear too.
    ///
    /// # Errors
    /// A message that lists the names, or the range of angles.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (name, angle) = match text.split_once('@') {
            Some((name, angle)) => (name, Some(angle)),
            None => (text, None),
        };
        let found = Self::ALL.into_iter().find(|builtin| builtin.name() == name);
        match (found, angle) {
            (Some(builtin), None) => Ok(builtin),
            (Some(Self::ShearedPlane { .. }), Some(angle)) => match angle.parse::<f64>() {
                Ok(degrees) if degrees.abs() <= 89.0 => Ok(Self::ShearedPlane { degrees }),
                _ => {
                    let angle = excerpt(angle);
                    Err(format!("shear \"{angle}\" is not an angle from -89 to 89 degrees"))
                }
            },
            (Some(_), Some(_)) => Err(format!("{name} takes no angle; only sheared-plane does")),
            (None, _) => Err(format!(
                "no built-in surface is called \"{}\"; there are {}",
                excerpt(text),
                Self::names()
            )),
        }
    }

    /// Returns the surface, sampled at `rows` x `cols` points. A single row or column lies at v = 0 or u = 0.
    ///
    /// # Errors
    /// [`SurfaceError::Empty`] without rows or columns.
    pub fn surface(self, rows: usize, cols: usize) -> Result<Surface, SurfaceError> {
        let points = (0..rows).flat_map(|row| (0..cols).map(move |col| [row as f64, col as f64]));
        let position = |at| self.position(unit_square(rows, cols, at).to_array());
        let positions = points.map(|at| DVec3::from_array(position(at))).collect();
        let surface = Surface::from_positions(rows, cols, positions)?;
        match self {
            Self::Maze => surface.with_mask(&maze::floor(rows, cols)),
            Self::Face => surface.with_mask(&face::oval(rows, cols)),
            _ => Ok(surface),
        }
    }

    /// Returns the exact geodesic distance between two places, given as fractional row and column, of the
    /// surface sampled at `rows` x `cols` points. The result is `None` where no closed form exists, and
    /// infinite from or to a place in a wall.
    pub fn exact_distance(
        self,
        rows: usize,
        cols: usize,
        from: [f64; 2],
        to: [f64; 2],
    ) -> Option<f64> {
        if self == Self::Maze {
            return Some(FlatPaths::new(maze::floor_plan(rows, cols), from).distance_to(to));
        }
        self.distance(unit_square(rows, cols, from), unit_square(rows, cols, to))
    }

    /// Returns the exact geodesic distances from a place, given as fractional row and column, to all points
    /// of the surface sampled at `rows` x `cols` points, row-major. The result is `None` where no closed form
    /// exists. Distances are infinite at points in walls.
    pub fn exact_distances(self, rows: usize, cols: usize, from: [f64; 2]) -> Option<Vec<f64>> {
        if self == Self::Maze {
            return Some(FlatPaths::new(maze::floor_plan(rows, cols), from).distances());
        }
        let from = unit_square(rows, cols, from);
        (0..rows)
            .flat_map(|row| (0..cols).map(move |col| [row as f64, col as f64]))
            .map(|to| self.distance(from, unit_square(rows, cols, to)))
            .collect()
    }

    /// Returns geodesic distances from a place, given as fractional row and column, to all points of the
    /// surface sampled at `rows` x `cols` points, row-major. They are [exact](Self::exact_distances), or else
    /// computed by shooting geodesics, with a relative error below 1e-9. Distances are infinite at points in
    /// walls. They are NaN where the distance is not known: where the shortest path would leave the patch,
    /// and on all of the face.
    pub fn reference_distances(self, rows: usize, cols: usize, from: [f64; 2]) -> Vec<f64> {
        if self == Self::Face {
            return vec![f64::NAN; rows * cols];
        }
        self.exact_distances(rows, cols, from).unwrap_or_else(|| {
            let position = |uv: [Jet; 2]| self.position(uv);
            shooting::distances(position, rows, cols, unit_square(rows, cols, from))
        })
    }

    /// Returns the position of (u, v) in space.
    fn position<T: Smooth>(self, [u, v]: [T; 2]) -> [T; 3] {
        match self {
            Self::Plane | Self::Maze => [u, v, T::from(0.0)],
            Self::ShearedPlane { degrees } => developable::shear(degrees, [u, v]),
            Self::Sphere => sphere::position([u, v]),
            Self::Cylinder => developable::cylinder([u, v]),
            Self::Cone => developable::cone([u, v]),
            Self::Torus => torus::position([u, v]),
            Self::Peaks => peaks::position([u, v]),
            Self::Face => face::position([u, v]),
        }
    }

    /// Returns the exact distance between two places (u, v) of a surface without holes.
    fn distance(self, a: DVec2, b: DVec2) -> Option<f64> {
        match self {
            Self::Plane => Some(a.distance(b)),
            Self::ShearedPlane { degrees } => Some(developable::shear_distance(degrees, a, b)),
            Self::Sphere => Some(sphere::distance(a, b)),
            Self::Cylinder => Some(developable::cylinder_distance(a, b)),
            Self::Cone => Some(developable::cone_distance(a, b)),
            Self::Torus | Self::Peaks | Self::Maze | Self::Face => None,
        }
    }
}

impl std::fmt::Display for Builtin {
    /// Writes the text that [`Self::parse`] reads back.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::ShearedPlane { degrees } => write!(f, "{}@{degrees}", self.name()),
            _ => f.write_str(self.name()),
        }
    }
}

impl std::str::FromStr for Builtin {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::parse(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for builtin in Builtin::ALL {
            assert_eq!(Builtin::parse(builtin.name()), Ok(builtin));
            assert_eq!(builtin.to_string().parse(), Ok(builtin));
        }
        let sheared = Builtin::parse("sheared-plane@-72.5");
        assert_eq!(sheared, Ok(Builtin::ShearedPlane { degrees: -72.5 }));
    }

    #[test]
    fn wrong_names_and_angles_say_what_is_right() {
        let message = Builtin::parse("shpere").unwrap_err();
        assert!(Builtin::ALL.iter().all(|builtin| message.contains(builtin.name())), "{message}");
        for text in ["sheared-plane@90", "sheared-plane@", "sheared-plane@nan", "plane@3"] {
            assert!(Builtin::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn every_size_makes_a_surface() {
        for builtin in Builtin::ALL {
            for (rows, cols) in [(1, 1), (1, 7), (6, 1), (2, 2), (21, 30), (90, 23)] {
                let surface = builtin.surface(rows, cols).unwrap();
                let middle = surface.has(rows / 2, cols / 2);
                assert!(middle || builtin == Builtin::Maze && surface.has(0, 0), "{builtin}");
                let to = [(rows - 1) as f64, (cols - 1) as f64];
                if let Some(distance) = builtin.exact_distance(rows, cols, [0.0, 0.0], to) {
                    let chord = surface.position(0, 0).unwrap().distance(
                        surface.position(rows - 1, cols - 1).expect("a corner is not a wall"),
                    );
                    assert!(distance.is_finite() && distance >= chord - 1e-15, "{builtin}");
                }
            }
            let empty = builtin.surface(0, 3).unwrap_err();
            assert_eq!(empty, SurfaceError::Empty { rows: 0, cols: 3 });
        }
    }

    #[test]
    fn short_steps_are_as_long_as_their_chords() {
        // Compares each closed form with its parametrisation, all over the patch.
        let points = 40;
        for builtin in Builtin::ALL {
            let surface = builtin.surface(points, points).unwrap();
            for (row, col) in (0..points - 1).flat_map(|row| (1..points).map(move |col| (row, col)))
            {
                for (r, c) in [(row + 1, col), (row, col - 1), (row + 1, col - 1)] {
                    let ends = surface.position(row, col).zip(surface.position(r, c));
                    let from = [row as f64, col as f64];
                    let to = [r as f64, c as f64];
                    let exact = builtin.exact_distance(points, points, from, to);
                    let Some(((a, b), exact)) = ends.zip(exact) else { continue };
                    // The chord of an arc of d radians is shorter by the fraction d^2 / 24; here d <= 0.13.
                    approx::assert_relative_eq!(exact, a.distance(b), max_relative = 1e-3);
                }
            }
        }
    }

    #[test]
    fn all_distances_are_the_single_ones() {
        for builtin in Builtin::ALL {
            let (rows, cols, from) = (23, 31, [3.25, 20.0]);
            let Some(all) = builtin.exact_distances(rows, cols, from) else { continue };
            for (row, col) in [(0, 0), (22, 30), (11, 4), (3, 20)] {
                let one = builtin.exact_distance(rows, cols, from, [row as f64, col as f64]);
                assert_eq!(Some(all[row * cols + col]), one, "{builtin} {row},{col}");
            }
        }
    }
}
