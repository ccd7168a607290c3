//! A built-in face as a range scanner sees it, made of smooth bumps.

use super::jet::Smooth;

/// Half of the width and height of the scan, in millimetres.
const HALF_WIDTH: f64 = 80.0;
const HALF_HEIGHT: f64 = 100.0;
/// Minimum number of rows and columns of a scan that is cut out along the face's oval.
const SMALLEST_OVAL: usize = 8;

/// A bump, `height e^(-((x - centre) / width)^2)`, with both coordinates in the exponent. A bump beside the
/// middle has a mirror image on the other side. All lengths are in millimetres.
struct Bump {
    height: f64,
    centre: [f64; 2],
    width: [f64; 2],
}

const fn bump(height: f64, centre: [f64; 2], width: [f64; 2]) -> Bump {
    Bump { height, centre, width }
}

/// The features of the face that are added to the bare head. x runs rightwards from the middle of the face, y
/// runs downwards.
const FEATURES: [Bump; 14] = [
    // Nose: tip, ridge, wing and the step below.
    bump(17.0, [0.0, 14.0], [9.0, 9.0]),
    bump(14.0, [0.0, -5.0], [8.0, 19.0]),
    bump(6.0, [11.0, 18.0], [6.0, 6.0]),
    bump(-4.0, [0.0, 29.0], [15.0, 6.0]),
    // Eye: brow, socket and lid.
    bump(7.5, [25.0, -42.0], [20.0, 8.0]),
    bump(-14.0, [30.0, -24.0], [16.0, 11.0]),
    bump(9.0, [31.0, -23.0], [10.5, 5.5]),
    // Cheekbone.
    bump(6.0, [42.0, 6.0], [17.0, 15.0]),
    // Lips, the gap between them, and the hollow below.
    bump(5.5, [0.0, 40.0], [19.0, 4.5]),
    bump(-4.0, [0.0, 46.0], [22.0, 2.6]),
    bump(6.0, [0.0, 52.0], [17.0, 5.0]),
    bump(-4.0, [0.0, 63.0], [18.0, 6.0]),
    // Chin.
    bump(10.0, [0.0, 78.0], [17.0, 11.0]),
    // Hollow of the cheek.
    bump(-4.0, [40.0, 40.0], [14.0, 18.0]),
];

/// Position of the tip of the nose, as fractions of columns and rows.
#[cfg(test)]
const NOSE: [f64; 2] = [0.5, 0.565];

/// Returns the position of (u, v) in millimetres: x rightwards, y downwards and z towards the scanner.
pub(super) fn position<T: Smooth>([u, v]: [T; 2]) -> [T; 3] {
    let x = (u * 2.0 - 1.0) * HALF_WIDTH;
    let y = (v * 2.0 - 1.0) * HALF_HEIGHT;
    let bell = |[a, b]: [f64; 2], [across, along]: [f64; 2]| {
        (((x - a) * across.recip()).squared() + ((y - b) * along.recip()).squared()) * -1.0
    };
    let round = bell([0.0; 2], [92.0, 118.0]);
    let mut z = (round * 0.5 - round.squared() * 0.25).exp() * 90.0;
    for Bump { height, centre, width } in FEATURES {
        z = z + bell(centre, width).exp() * height;
        if centre[0] != 0.0 {
            z = z + bell([-centre[0], centre[1]], width).exp() * height;
        }
    }
    [x, y, z]
}

/// Returns for each point, row-major, whether it lies within the face's oval, which is narrower at the chin. The result
/// is true everywhere on grids of fewer than [`SMALLEST_OVAL`] rows or columns.
pub(super) fn oval(rows: usize, cols: usize) -> Vec<bool> {
    let whole = rows.min(cols) < SMALLEST_OVAL;
    let along = |at: usize, points: usize| 2.0 * at as f64 / (points - 1) as f64 - 1.0;
    let inside = |row: usize, col: usize| {
        let (x, y) = (along(col, cols), along(row, rows));
        (x / (0.99 * (1.0 - 0.13 * y))).powi(2) + y * y <= 1.0
    };
    (0..rows).flat_map(|row| (0..cols).map(move |col| whole || inside(row, col))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tip_of_the_nose_is_nearest() {
        let [.., tip] = position(NOSE);
        for index in 0..100 * 100 {
            let uv = [f64::from(index % 100) / 99.0, f64::from(index / 100) / 99.0];
            let [_, y, z] = position(uv);
            assert!(z <= tip + 0.05, "{uv:?}: {z} mm, {y} mm down; the tip {tip} mm");
        }
    }

    #[test]
    fn a_scan_like_the_papers_has_as_many_points() {
        let points = oval(183, 155).into_iter().filter(|&inside| inside).count();
        assert!(points.abs_diff(21_775) < 20, "{points}");
    }
}
