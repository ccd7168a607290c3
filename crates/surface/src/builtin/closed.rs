//! Defines closed surfaces, glued where their sides coincide.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use glam::{DVec2, DVec3};

use super::unit_square::unit_square;
use super::{developable, sphere, torus};
use crate::{Gluing, Surface, SurfaceError};

/// A built-in closed surface, glued where its sides coincide. Rows and columns include both sides of each seam.
///
/// ```
/// use geosweep::surface::builtin::Closed;
/// use geosweep::{Options, Sources, distance_map};
/// let globe = Closed::Globe.surface(91, 181)?;
/// let map = distance_map(&globe, &Sources::point(30.0, 0.0), &Options::default())?;
/// // From 60 degrees north over the pole to the other side.
/// let exact = Closed::Globe.distances(91, 181, [30.0, 0.0])[30 * 181 + 90];
/// assert!((exact - std::f64::consts::FRAC_PI_3 * 2.0).abs() < 1e-12);
/// assert!((map.distance(30, 90) as f64 - exact).abs() < 1e-4);
/// # Ok::<(), geosweep::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Closed {
    /// A whole cylinder of radius 1 and height 3. Each row is a circle around it. Exact distances are straight lines in
    /// the unrolled surface.
    Cylinder,
    /// A whole truncated cone, of which [`Builtin::Cone`](super::Builtin::Cone) is three quarters. Unrolled, it is
    /// half of an annulus.
    Cone,
    /// A whole torus: its centre line has radius 1, its tube 0.4. Distances are computed by shooting geodesics.
    Torus,
    /// A strip 0.8 wide that makes half a turn on its way round a circle of radius 1. Rows run along the strip, columns
    /// across it. Distances are not known.
    MoebiusStrip,
    /// The unit sphere by latitudes (rows) and longitudes (columns), with a row at each pole. Distances on this surface
    /// and the following ones are lengths of great circles.
    Globe,
    /// An octahedral map of the unit sphere: an octahedron unfolded to a square and blown up. The square needs an
    /// odd number of points a side.
    OctahedralSphere,
    /// An octahedral map of the unit sphere whose cells have equal areas (Clarberg, "Fast Equal-Area Mapping of
    /// the (Hemi)Sphere using SIMD", 2008).
    EqualAreaSphere,
    /// The six faces of a cube, blown up to the unit sphere, in two rows of three with a line of holes between
    /// them. Faces of s x s points make 2 s + 1 rows and 3 s + 2 columns; further lines are holes.
    CubeSphere,
}

impl Closed {
    /// All closed surfaces.
    pub const ALL: [Self; 8] = [
        Self::Cylinder,
        Self::Cone,
        Self::Torus,
        Self::MoebiusStrip,
        Self::Globe,
        Self::OctahedralSphere,
        Self::EqualAreaSphere,
        Self::CubeSphere,
    ];

    /// Returns the name that [`Self::parse`] accepts.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cylinder => "closed-cylinder",
            Self::Cone => "closed-cone",
            Self::Torus => "closed-torus",
            Self::MoebiusStrip => "moebius-strip",
            Self::Globe => "globe",
            Self::OctahedralSphere => "octahedral-sphere",
            Self::EqualAreaSphere => "equal-area-sphere",
            Self::CubeSphere => "cube-sphere",
        }
    }

    /// Returns all names, separated by commas, for help texts and messages.
    pub fn names() -> String {
        Self::ALL.map(Self::name).join(", ")
    }

    /// Finds a surface by its name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|closed| closed.name() == name)
    }

    fn gluing(self) -> Gluing {
        match self {
            Self::Cylinder | Self::Cone => Gluing::columns(),
            Self::Torus => Gluing::both(),
            Self::MoebiusStrip => Gluing::flipped_columns(),
            Self::Globe => Gluing::globe(),
            Self::OctahedralSphere | Self::EqualAreaSphere => Gluing::Octahedral,
            Self::CubeSphere => Gluing::Charts,
        }
    }

    /// Returns the surface, sampled at `rows` x `cols` points and glued.
    ///
    /// # Errors
    /// [`SurfaceError::Empty`] without rows or columns. [`SurfaceError::Gluing`] if there are too few.
    pub fn surface(self, rows: usize, cols: usize) -> Result<Surface, SurfaceError> {
        let positions = places(rows, cols).map(|at| self.position(rows, cols, at)).collect();
        Surface::from_positions(rows, cols, positions)?.with_gluing(self.gluing())
    }

    /// Returns geodesic distances from a position, given as fractional row and column, to all points of the surface
    /// sampled at `rows` x `cols` points, row-major. On the torus they have a relative error below 1e-9; all others are
    /// exact. They are infinite in the lines between faces of the cube, and NaN on the Moebius strip.
    pub fn distances(self, rows: usize, cols: usize, from: [f64; 2]) -> Vec<f64> {
        let on_sphere = |to| {
            let [from, to] = [from, to].map(|at| self.position(rows, cols, at));
            let distance = sphere::great_circle(from, to);
            if distance.is_nan() { f64::INFINITY } else { distance }
        };
        let unrolled = |distance: fn(DVec2, DVec2) -> f64, to| {
            let [mut from, to] = [from, to].map(|at| unit_square(rows, cols, at));
            // Takes the shorter path around.
            from.x -= (from.x - to.x).round();
            let [from, to] = [from, to].map(|uv| DVec2::new(uv.x / OPEN_SHARE, uv.y));
            distance(from, to)
        };
        let places = places(rows, cols);
        match self {
            Self::Cylinder => {
                places.map(|to| unrolled(developable::cylinder_distance, to)).collect()
            }
            Self::Cone => places.map(|to| unrolled(developable::cone_distance, to)).collect(),
            Self::Torus => torus::whole_distances(rows, cols, from),
            Self::MoebiusStrip => vec![f64::NAN; rows * cols],
            Self::Globe | Self::OctahedralSphere | Self::EqualAreaSphere | Self::CubeSphere => {
                places.map(on_sphere).collect()
            }
        }
    }

    /// Returns the position in space of a fractional row and column. It is NaN between faces of the cube.
    fn position(self, rows: usize, cols: usize, at: [f64; 2]) -> DVec3 {
        let uv = unit_square(rows, cols, at);
        let open = [uv.x / OPEN_SHARE, uv.y];
        // Octahedral maps have their origin in the middle.
        let square = 2.0 * uv - 1.0;
        match self {
            Self::Cylinder => DVec3::from_array(developable::cylinder(open)),
            Self::Cone => DVec3::from_array(developable::cone(open)),
            Self::Torus => DVec3::from_array(torus::whole(uv.to_array())),
            Self::MoebiusStrip => moebius_strip(uv),
            Self::Globe => globe(uv),
            Self::OctahedralSphere => octahedral(square),
            Self::EqualAreaSphere => equal_area(square),
            Self::CubeSphere => cube(rows, cols, at),
        }
    }
}

/// The share of a turn that the open cylinder and cone cover.
const OPEN_SHARE: f64 = 0.75;

/// Half of the width of the Moebius strip.
const HALF_WIDTH: f64 = 0.4;

/// Returns all rows and columns of a grid, row-major.
fn places(rows: usize, cols: usize) -> impl Iterator<Item = [f64; 2]> {
    (0..rows).flat_map(move |row| (0..cols).map(move |col| [row as f64, col as f64]))
}

/// Returns the position of (u, v): u from 0 to 1 runs once around the circle of radius 1, v from 0 to 1 across the
/// strip, which makes half a turn on the way.
fn moebius_strip(uv: DVec2) -> DVec3 {
    let (angle, beside) = (TAU * uv.x, HALF_WIDTH * (2.0 * uv.y - 1.0));
    let ((sin, cos), (rise, along)) = (angle.sin_cos(), (0.5 * angle).sin_cos());
    let radius = 1.0 + beside * along;
    DVec3::new(radius * cos, radius * sin, beside * rise)
}

fn globe(uv: DVec2) -> DVec3 {
    let ((sin, cos), (out, up)) = ((TAU * uv.x).sin_cos(), (PI * uv.y).sin_cos());
    DVec3::new(out * cos, out * sin, up)
}

/// Returns -1 below zero, else 1.
fn sign(x: f64) -> f64 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

/// Returns the position of a place in the square from -1 to 1. The square's corners are the lower pole.
fn octahedral(at: DVec2) -> DVec3 {
    let DVec2 { x, y } = at;
    let z = 1.0 - x.abs() - y.abs();
    let folded = DVec2::new((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y));
    (if z < 0.0 { folded } else { at }).extend(z).normalize()
}

/// Returns the position of a place in the square from -1 to 1. The square's corners are the lower pole.
fn equal_area(at: DVec2) -> DVec3 {
    let DVec2 { x, y } = at.abs();
    let height = 1.0 - (x + y);
    let radius = 1.0 - height.abs();
    let turn = if radius > 0.0 { (y - x) / radius + 1.0 } else { 0.0 };
    let (sin, cos) = (turn * FRAC_PI_4).sin_cos();
    let out = radius * (2.0 - radius * radius).sqrt();
    DVec3::new(
        sign(at.x) * cos * out,
        sign(at.y) * sin * out,
        sign(height) * (1.0 - radius * radius),
    )
}

fn cube(rows: usize, cols: usize, [row, col]: [f64; 2]) -> DVec3 {
    let side = (rows.saturating_sub(1) / 2).min(cols.saturating_sub(2) / 3);
    let block = (side + 1) as f64;
    let [(down, row), (right, col)] = [row, col].map(|at| ((at / block).floor(), at % block));
    let last = side as f64 - 1.0;
    if down > 1.0 || right > 2.0 || row > last || col > last {
        return DVec3::NAN;
    }
    let [x, y, z] = sphere::position([col, row].map(|at| at / last));
    let axes = match (down as u8, right as u8) {
        (0, 0) => [z, x, y],
        (0, 1) => [-z, -x, y],
        (0, _) => [-x, z, y],
        (_, 0) => [x, -z, y],
        (_, 1) => [x, y, z],
        _ => [x, -y, -z],
    };
    DVec3::from_array(axes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Size of the grids of all surfaces. The faces of the cube then have 23 x 23 points.
    const SIZE: (usize, usize) = (47, 71);

    #[test]
    fn copies_have_one_position_and_one_distance() {
        for closed in Closed::ALL {
            let (rows, cols) = SIZE;
            let surface = closed.surface(rows, cols).unwrap();
            assert!(surface.is_glued() && surface.seams().is_empty(), "{}", closed.name());
            let from = [14.0, 9.0];
            let distances = closed.distances(rows, cols, from);
            for group in surface.copies().unwrap().iter() {
                let place = |index: u32| {
                    let (row, col) = surface.chart().position(index as usize);
                    closed.position(rows, cols, [row as f64, col as f64])
                };
                for &copy in &group[1..] {
                    assert!(place(group[0]).distance(place(copy)) < 1e-14, "{}", closed.name());
                    let [a, b] = [group[0], copy].map(|index| distances[index as usize]);
                    assert!(a.is_nan() || (a - b).abs() < 1e-9 * a, "{}: {a} {b}", closed.name());
                }
            }
        }
    }

    /// Checks, beside seams too, that the distances of neighbours differ by no more than the arc over their chord, and
    /// that the distances of the source's neighbours are about their chords.
    #[test]
    fn distances_grow_by_the_lengths_of_edges() {
        for closed in Closed::ALL.into_iter().filter(|&closed| closed != Closed::MoebiusStrip) {
            let (rows, cols) = SIZE;
            let surface = closed.surface(rows, cols).unwrap();
            let from = [14.0, 1.0];
            let distances = closed.distances(rows, cols, from);
            for (row, col) in surface.chart().places().filter(|&(row, col)| surface.has(row, col)) {
                let own = distances[row * cols + col];
                let here = surface.position(row, col).unwrap();
                for (r, c) in [(row + 1, col), (row, col + 1)] {
                    if r == rows || c == cols || !surface.has(r, c) {
                        continue;
                    }
                    let chord = here.distance(surface.position(r, c).unwrap());
                    let other = distances[r * cols + c];
                    // An arc of 0.2 radians is longer than its chord by 2e-3.
                    assert!(
                        (own - other).abs() <= 1.002 * chord + 1e-12,
                        "{} {row},{col}",
                        closed.name()
                    );
                    if from == [row as f64, col as f64] {
                        assert!((other - chord).abs() < 2e-3 * chord, "{}", closed.name());
                    }
                }
            }
        }
    }

    #[test]
    fn cells_of_the_equal_area_sphere_have_equal_areas() {
        const CELLS: usize = 16;
        /// Number of flat pieces on a side of a cell. At the poles each piece lacks a tenth of its area.
        const PIECES: usize = 16;
        let place = |row: usize, col: usize| {
            let at = DVec2::new(col as f64, row as f64) / (CELLS * PIECES) as f64;
            equal_area(2.0 * at - 1.0)
        };
        let piece = |row: usize, col: usize| {
            let [a, b, c, d] =
                [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(r, c)| place(row + r, col + c));
            0.5 * (c - a).cross(d - b).length()
        };
        let expected = 2.0 * TAU / (CELLS * CELLS) as f64;
        for cell in 0..CELLS * CELLS {
            let (row, col) = (cell / CELLS * PIECES, cell % CELLS * PIECES);
            let pieces = (0..PIECES * PIECES).map(|k| piece(row + k / PIECES, col + k % PIECES));
            let area: f64 = pieces.sum();
            assert!((area / expected - 1.0).abs() < 2e-3, "{row},{col}: {area} {expected}");
        }
    }
}
