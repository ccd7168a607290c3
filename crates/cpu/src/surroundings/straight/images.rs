//! Lists the images of a source on a surface that repeats after some steps of the chart.
//!
//! Over a cylinder or a torus whose cells are all alike, a front goes round as if the chart went on and the source lay
//! there again and again. The images that may be the nearest to a point of the chart are few.

use glam::{DMat2, DVec2};

use super::lines::StraightLines;
use geosweep_surface::{Chart, Origin};

/// Returns the steps from an origin to those of its images that may be the nearest to a point of the chart. `periods`
/// are the steps after which the surface repeats, of which there are two at most.
pub(super) fn images(
    lines: &StraightLines,
    chart: Chart,
    periods: &[DVec2],
    origin: &Origin,
) -> Vec<DVec2> {
    let (last_row, last_col) = chart.last();
    let corners = [(0, 0), (0, last_col), (last_row, 0), (last_row, last_col)];
    let steps = corners
        .into_iter()
        .flat_map(|(row, col)| origin.ends.map(|end| DVec2::new(row as f64, col as f64) - end));
    let steps: Vec<DVec2> = steps.collect();
    // Counts of periods are linear in the place, so those of corners are the largest and the smallest.
    let counts = |of: &dyn Fn(DVec2) -> f64| {
        let all = || steps.iter().map(|step| of(*step));
        let (least, most) = (all().fold(f64::MAX, f64::min), all().fold(f64::MIN, f64::max));
        (least - ROUNDING).floor() as i64..=(most + ROUNDING).ceil() as i64
    };
    match *periods {
        [] => vec![DVec2::ZERO],
        [period] => {
            let square = lines.dot(period, period);
            let along = |step| lines.dot(step, period) / square;
            counts(&along).map(|count| count as f64 * period).collect()
        }
        [first, second, ..] => {
            // The nearest image is a corner of the parallelogram of a reduced basis in which the point lies.
            let [a, b] = reduced(lines, first, second);
            let shares = DMat2::from_cols(a, b).inverse();
            let of_a = counts(&|step| (shares * step).x);
            let of_b = counts(&|step| (shares * step).y);
            let along_b = |count: i64| of_b.clone().map(move |other| (count, other));
            let all = of_a.flat_map(along_b);
            all.map(|(count, other)| count as f64 * a + other as f64 * b).collect()
        }
    }
}

/// Count of periods by which rounding may move a place over an image's border.
const ROUNDING: f64 = 1e-9;

/// Returns the shortest basis of the periods (Gauss's reduction).
fn reduced(lines: &StraightLines, mut a: DVec2, mut b: DVec2) -> [DVec2; 2] {
    loop {
        if lines.dot(b, b) < lines.dot(a, a) {
            std::mem::swap(&mut a, &mut b);
        }
        let count = (lines.dot(a, b) / lines.dot(a, a)).round();
        // The second period gets clearly shorter, or both are as short as they can be.
        let shorter = b - count * a;
        if count == 0.0 || lines.dot(shorter, shorter) >= lines.dot(b, b) * (1.0 - ROUNDING) {
            return [a, b];
        }
        b = shorter;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The nearest of many images is among those found, for random metrics and places.
    #[test]
    fn the_nearest_image_is_found() {
        let chart = Chart { rows: 13, cols: 9 };
        let part = |k: u32, by: f64| (f64::from(k + 1) * by).fract();
        for k in 0..200 {
            let (along, across) = (0.2 + 3.0 * part(k, 0.618), 0.2 + 3.0 * part(k, 0.414));
            let shear = 6.0 * part(k, 0.732) - 3.0;
            // Rows are `along` apart and shifted by `shear`, columns are `across` apart.
            let metric = [along * along + shear * shear, shear * across, across * across];
            let lines = StraightLines::of(metric);
            let from = DVec2::new(12.0 * part(k, 0.236), 8.0 * part(k, 0.317));
            let to = from + DVec2::new(2.0 * part(k, 0.55) - 1.0, 1.5 * part(k, 0.83));
            let ends = if k % 3 == 0 {
                [from; 2]
            } else {
                [from, to.clamp(DVec2::ZERO, DVec2::new(12.0, 8.0))]
            };
            let origin = Origin { ends, start: 0.0 };
            let (rows, cols) = (DVec2::new(12.0, 0.0), DVec2::new(0.0, 8.0));
            for periods in [vec![], vec![cols], vec![rows], vec![cols, rows]] {
                let found = images(&lines, chart, &periods, &origin);
                let many = |period: DVec2| {
                    let most = if periods.contains(&period) { 30 } else { 0 };
                    (-most..=most).map(move |count| f64::from(count) * period)
                };
                let all: Vec<DVec2> =
                    many(rows).flat_map(|a| many(cols).map(move |b| a + b)).collect();
                for (row, col) in chart.places().step_by(7) {
                    let at = DVec2::new(row as f64, col as f64);
                    let nearest = |images: &[DVec2]| {
                        let lengths =
                            images.iter().map(|image| lines.from(&origin, at - *image).length);
                        lengths.fold(f64::MAX, f64::min)
                    };
                    let (nearest, truth) = (nearest(&found), nearest(&all));
                    assert!(nearest <= truth * (1.0 + 1e-9) + 1e-12, "{k}: {nearest} {truth}");
                }
                assert!(periods.is_empty() == (found.len() == 1), "{k}");
            }
        }
    }
}
