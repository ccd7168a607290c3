//! Divides lines at the antimeridian, as RFC 7946 (section 3.1.9) asks: no part passes from 180 degrees to -180.

/// A turn round the Earth, half of it, and the latitude of a pole, in degrees.
const TURN: f64 = 360.0;
const HALF: f64 = 180.0;
const POLE: f64 = 90.0;

/// A longitude and a latitude in degrees, and a height, which may be NaN.
pub(super) type Place = [f64; 3];

/// Returns the parts of a line, with longitudes from -180 to 180. Neighbouring vertices are less than half a turn
/// apart, except at a pole, where a new part begins.
pub(super) fn divided(line: &[Place]) -> Vec<Vec<Place>> {
    let line: Vec<_> = line.iter().map(with_pole).collect();
    let Some((&[first, latitude, height], rest)) = line.split_first() else { return Vec::new() };
    // Number of full turns by which the current part lies away from longitude 0. The antimeridian, at half a turn,
    // belongs to two parts.
    let mut turn = (first / TURN).round();
    let mut parts = vec![vec![[first - TURN * turn, latitude, height]]];
    let mut longitude = first;
    for (before, next) in line.iter().zip(rest) {
        let step = next[0] - longitude - TURN * ((next[0] - longitude) / TURN).round();
        let start = longitude - TURN * turn;
        longitude += step;
        let end = longitude - TURN * turn;
        if step.abs() > ROUNDING && before[1].abs() == POLE && next[1].abs() == POLE {
            turn = (longitude / TURN).round();
            parts.push(Vec::new());
        } else if end.abs() > HALF + ROUNDING {
            let side = HALF.copysign(end);
            let part = (side - start) / (end - start);
            let [latitude, height] = [1, 2].map(|k| before[k] + part * (next[k] - before[k]));
            push(&mut parts, [side, latitude, height]);
            parts.push(vec![[-side, latitude, height]]);
            turn += end.signum();
        }
        push(&mut parts, [(longitude - TURN * turn).clamp(-HALF, HALF), next[1], next[2]]);
    }
    let is_line = |part: &Vec<Place>| part.len() > 1;
    if parts.iter().any(is_line) {
        parts.retain(is_line);
    } else {
        parts.truncate(1);
    }
    parts
}

/// Largest rounding error of longitudes and latitudes in degrees. It is a tenth of a millimetre on the Earth.
const ROUNDING: f64 = 1e-9;

/// Returns whether two places have the same longitude and latitude.
pub(super) fn is_same(a: &Place, b: &Place) -> bool {
    (0..2).all(|k| (a[k] - b[k]).abs() <= ROUNDING)
}

/// Returns a place whose latitude is exact at a pole.
fn with_pole(&[longitude, latitude, height]: &Place) -> Place {
    let is_pole = (latitude.abs() - POLE).abs() <= ROUNDING;
    [longitude, if is_pole { POLE.copysign(latitude) } else { latitude }, height]
}

/// Appends a vertex to the last part, unless it is there already.
fn push(parts: &mut [Vec<Place>], vertex: Place) {
    let is_last = |part: &Vec<Place>| part.last().is_some_and(|last| is_same(last, &vertex));
    if let Some(part) = parts.last_mut().filter(|part| !is_last(part)) {
        part.push(vertex);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Divides a line of longitudes and latitudes. The height of each vertex equals its latitude.
    fn parts_of(line: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
        let line: Vec<_> = line.iter().map(|&[east, north]| [east, north, north]).collect();
        let place = |[east, north, height]: Place| {
            assert_eq!(north, height);
            [east, north]
        };
        divided(&line).into_iter().map(|part| part.into_iter().map(place).collect()).collect()
    }

    #[test]
    fn lines_end_at_the_antimeridian_and_go_on_beyond() {
        let line = [[170.0, 0.0], [190.0, 10.0], [200.0, 10.0]];
        let parts =
            [vec![[170.0, 0.0], [180.0, 5.0]], vec![[-180.0, 5.0], [-170.0, 10.0], [-160.0, 10.0]]];
        assert_eq!(parts_of(&line), parts);
        // A westward line, on a grid whose longitudes jump there.
        let back = [[-160.0, 10.0], [-170.0, 10.0], [170.0, 0.0]];
        let reversed: Vec<Vec<_>> =
            parts.iter().rev().map(|part| part.iter().rev().copied().collect()).collect();
        assert_eq!(parts_of(&back), reversed);
        // A vertex on the antimeridian, which the grid has twice.
        let jump = [[179.0, 1.0], [180.0, 1.0], [-180.0, 1.0], [-179.0, 2.0]];
        let parts = [vec![[179.0, 1.0], [180.0, 1.0]], vec![[-180.0, 1.0], [-179.0, 2.0]]];
        assert_eq!(parts_of(&jump), parts);
    }

    #[test]
    fn lines_elsewhere_are_whole() {
        let seam = [[359.0, 3.0], [360.0, 3.0], [0.0, 3.0], [1.0, 3.0]];
        assert_eq!(parts_of(&seam), [vec![[-1.0, 3.0], [0.0, 3.0], [1.0, 3.0]]]);
        let along = [[180.0, 0.0], [180.0, 10.0]];
        assert_eq!(parts_of(&along).len(), 1);
        let turned = [[530.0, 0.0], [535.0, 0.0]];
        assert_eq!(parts_of(&turned), [vec![[170.0, 0.0], [175.0, 0.0]]]);
        assert_eq!(parts_of(&[[200.0, 4.0]]), [vec![[-160.0, 4.0]]]);
    }

    #[test]
    fn a_line_over_a_pole_has_two_parts() {
        let line = [[20.0, 80.0], [20.0, 90.0], [200.0, 90.0], [200.0, 80.0]];
        let parts = [vec![[20.0, 80.0], [20.0, 90.0]], vec![[-160.0, 90.0], [-160.0, 80.0]]];
        assert_eq!(parts_of(&line), parts);
        // The latitude of a pole has a rounding error if it is a sum of steps.
        for pole in [-90.00000000000001, -89.99999999999997, -90.0] {
            let line = [[-170.5, -80.0], [-170.5, pole], [9.5, pole], [9.5, -80.0]];
            let parts = [vec![[-170.5, -80.0], [-170.5, -90.0]], vec![[9.5, -90.0], [9.5, -80.0]]];
            let line = line.map(|[east, north]| [east, north, 0.0]);
            let found = divided(&line);
            let found: Vec<Vec<_>> =
                found.iter().map(|part| part.iter().map(|at| [at[0], at[1]]).collect()).collect();
            assert_eq!(found, parts, "{pole}");
        }
        // Near a pole, but not at it, a line is not divided.
        let near = [[20.0, 80.0], [20.0, 89.9999], [150.0, 89.9999], [150.0, 80.0]];
        assert_eq!(parts_of(&near).len(), 1);
    }

    #[test]
    fn a_ring_around_a_pole_is_cut_once() {
        let ring: Vec<_> = (0..=36).map(|k| [5.0 + 10.0 * f64::from(k), 70.0]).collect();
        let parts = parts_of(&ring);
        assert_eq!(parts.len(), 2);
        assert_eq!((parts[0][0], parts[1][0]), ([5.0, 70.0], [-180.0, 70.0]));
        assert_eq!(parts[1].last(), Some(&[5.0, 70.0]));
    }
}
