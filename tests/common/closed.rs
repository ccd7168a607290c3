//! Closed surfaces, glued where their sides coincide.

use std::f64::consts::{PI, TAU};

use geosweep::glam::{DVec2, DVec3};
use geosweep::surface::Gluing;
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

/// Returns a sphere by latitudes and longitudes.
pub fn globe(rows: usize, cols: usize) -> Surface {
    let sphere = grid(rows, cols, |row, col| {
        let (polar, angle) =
            (PI * row as f64 / (rows - 1) as f64, TAU * col as f64 / (cols - 1) as f64);
        DVec3::new(polar.sin() * angle.cos(), polar.sin() * angle.sin(), polar.cos())
    });
    sphere.with_gluing(Gluing::globe()).unwrap()
}

/// Returns an octahedral map of a sphere, with 2 half + 1 points a side.
pub fn octahedral(half: usize) -> Surface {
    let side = 2 * half + 1;
    let map = grid(side, side, |row, col| {
        let [v, u] = [row, col].map(|k| k as f64 / half as f64 - 1.0);
        let z = 1.0 - u.abs() - v.abs();
        let sign = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
        let folded = DVec3::new((1.0 - v.abs()) * sign(u), (1.0 - u.abs()) * sign(v), z);
        (if z < 0.0 { folded } else { DVec3::new(u, v, z) }).normalize()
    });
    map.with_gluing(Gluing::Octahedral).unwrap()
}

/// Returns the six faces of a cube on the sphere, 2 x 3, with lines of holes between them.
pub fn cube(side: usize) -> Surface {
    let block = side + 1;
    let sphere = grid(2 * block - 1, 3 * block - 1, |row, col| {
        let (face, row, col) = (row / block * 3 + col / block, row % block, col % block);
        if row == side || col == side {
            return DVec3::NAN;
        }
        let [v, u] =
            [row, col].map(|k| (PI / 4.0 * (2.0 * k as f64 / (side - 1) as f64 - 1.0)).tan());
        let place = match face {
            0 => [1.0, u, v],
            1 => [-1.0, -u, v],
            2 => [-u, 1.0, v],
            3 => [u, -1.0, v],
            4 => [u, v, 1.0],
            _ => [u, -v, -1.0],
        };
        DVec3::from_array(place).normalize()
    });
    sphere.with_gluing(Gluing::Charts).unwrap()
}

/// A plane of 41 x 65 points with square cells, of which opposite sides are glued.
#[derive(Clone, Copy, Debug, Default)]
pub struct Flat {
    /// The last column is glued to the first one.
    pub cols: bool,
    /// The rows are reversed beyond the columns.
    pub flipped: bool,
    /// The last row is glued to the first one.
    pub rows: bool,
}

impl Flat {
    /// Returns the shortest way from one place to another, in rows and columns at the first.
    pub fn way(self, from: [f64; 2], to: [f64; 2]) -> DVec2 {
        let [from, to] = [from, to].map(DVec2::from);
        let images = |wraps: bool| if wraps { -1..=1 } else { 0..=0 };
        let image = |down: i32, right: i32| {
            let row = if self.flipped && right != 0 { 40.0 - to.x } else { to.x };
            DVec2::new(row + 40.0 * f64::from(down), to.y + 64.0 * f64::from(right)) - from
        };
        let all =
            images(self.rows).flat_map(|down| images(self.cols).map(move |by| image(down, by)));
        all.min_by(|a, b| a.length().total_cmp(&b.length())).unwrap()
    }

    /// Returns whether the way to `to` is the only shortest one around a place. At the cut locus either way is right.
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
