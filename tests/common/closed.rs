//! Closed surfaces, glued where their sides coincide.

use std::f64::consts::TAU;

use geosweep::glam::{DVec2, DVec3};
use geosweep::surface::Gluing;
use geosweep::surface::builtin::Closed;
use geosweep::{Spacing, Surface};

/// Returns the surface with these positions at rows and columns.
pub fn grid(rows: usize, cols: usize, at: impl Fn(usize, usize) -> DVec3) -> Surface {
    let points = (0..rows * cols).map(|index| at(index / cols, index % cols)).collect();
    Surface::from_positions(rows, cols, points).unwrap()
}

/// Returns a plane with square cells.
pub fn flat(rows: usize, cols: usize) -> Surface {
    Surface::from_heights(rows, cols, vec![0.0; rows * cols], Spacing::square(1.0)).unwrap()
}

/// Returns a cylinder of radius 1 with square cells.
pub fn tube(rows: usize, cols: usize) -> Surface {
    let step = TAU / (cols - 1) as f64;
    let cylinder = grid(rows, cols, |row, col| {
        let angle = step * (col % (cols - 1)) as f64;
        DVec3::new(angle.cos(), angle.sin(), step * row as f64)
    });
    cylinder.with_gluing(Gluing::columns()).unwrap()
}

/// Returns a torus in space with uneven cells, closed both ways.
pub fn torus(rows: usize, cols: usize) -> Surface {
    rolled_torus(rows, cols, 0, 0.0)
}

/// Returns a torus whose grid begins at another column, with three waves of this height around it.
pub fn rolled_torus(rows: usize, cols: usize, by: usize, waves: f64) -> Surface {
    let torus = grid(rows, cols, |row, col| {
        let [v, u] = [(row, rows), (col + by, cols)]
            .map(|(k, n)| TAU * (k % (n - 1)) as f64 / (n - 1) as f64);
        let radius = 2.0 + v.cos();
        DVec3::new(radius * u.cos(), radius * u.sin(), v.sin() + waves * (3.0 * u).sin())
    });
    torus.with_gluing(Gluing::both()).unwrap()
}

/// Returns the angle between two directions: their distance on the unit sphere.
pub fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// Returns the distances on the unit sphere from a grid point, which are infinite in holes.
pub fn on_sphere(surface: &Surface, [row, col]: [usize; 2]) -> Vec<f64> {
    let (chart, from) = (surface.chart(), surface.position(row, col).unwrap());
    let exact = |(row, col)| surface.position(row, col).map_or(f64::INFINITY, |at| angle(at, from));
    (0..chart.points()).map(|index| exact(chart.position(index))).collect()
}

/// Returns a sphere as a grid of latitudes and longitudes.
pub fn globe(rows: usize, cols: usize) -> Surface {
    Closed::Globe.surface(rows, cols).unwrap()
}

/// Returns an octahedral map of a sphere, with 2 half + 1 points a side.
pub fn octahedral(half: usize) -> Surface {
    Closed::OctahedralSphere.surface(2 * half + 1, 2 * half + 1).unwrap()
}

/// Returns an octahedral map of a sphere whose cells have equal areas, with 2 half + 1 points a side.
pub fn equal_area(half: usize) -> Surface {
    Closed::EqualAreaSphere.surface(2 * half + 1, 2 * half + 1).unwrap()
}

/// Returns the six faces of a cube projected onto the sphere, in two rows of three, with lines of holes between
/// them.
pub fn cube(side: usize) -> Surface {
    Closed::CubeSphere.surface(2 * side + 1, 3 * side + 2).unwrap()
}

/// A plane of 41 x 65 points with square cells. One or both pairs of its opposite sides are glued.
#[derive(Clone, Copy, Debug, Default)]
pub struct Flat {
    /// The last column is glued to the first one.
    pub cols: bool,
    /// The columns are glued in reverse order: row r of the last column meets row 40 - r of the first one.
    pub flipped: bool,
    /// The last row is glued to the first one.
    pub rows: bool,
}

impl Flat {
    /// Returns the vectors from a place to all images of another one near the grid, in the rows and columns of the
    /// first place.
    pub fn ways(self, from: [f64; 2], to: [f64; 2]) -> impl Iterator<Item = DVec2> {
        let [from, to] = [from, to].map(DVec2::from);
        let turns = |wraps: bool| if wraps { -2..=2 } else { 0..=0 };
        let image = move |down: i32, right: i32| {
            let row = if self.flipped && right % 2 != 0 { 40.0 - to.x } else { to.x };
            DVec2::new(row + 40.0 * f64::from(down), to.y + 64.0 * f64::from(right)) - from
        };
        let right = turns(self.cols);
        turns(self.rows).flat_map(move |down| right.clone().map(move |right| image(down, right)))
    }

    /// Returns the shortest of these vectors.
    pub fn way(self, from: [f64; 2], to: [f64; 2]) -> DVec2 {
        self.ways(from, to).min_by(|a, b| a.length().total_cmp(&b.length())).unwrap()
    }

    /// Returns whether the shortest vector to `to` is unique at a place and around it. At the cut locus either of two
    /// is right.
    pub fn is_smooth(self, at: [f64; 2], to: [f64; 2]) -> bool {
        let way = self.way(at, to);
        [[0.0, 1.5], [0.0, -1.5], [1.5, 0.0], [-1.5, 0.0]].into_iter().all(|by| {
            let moved = self.way([at[0] + by[0], at[1] + by[1]], to);
            (moved + DVec2::from(by)).distance(way) < 1e-6
        })
    }
}

/// Returns the names, gluings and shapes of a cylinder, a torus and a Moebius strip.
pub fn shapes() -> [(&'static str, Gluing, Flat); 3] {
    let cylinder = Flat { cols: true, flipped: false, rows: false };
    [
        ("cylinder", Gluing::columns(), cylinder),
        ("torus", Gluing::both(), Flat { rows: true, ..cylinder }),
        ("Moebius strip", Gluing::flipped_columns(), Flat { flipped: true, ..cylinder }),
    ]
}
