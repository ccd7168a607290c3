//! Contours compared with circles in the plane, on the unrolled cylinder and on the sphere.

use geosweep::geometry::{LevelError, Levels, contours};
use geosweep::surface::builtin::Builtin;
use geosweep::{Engine, Options, Sources, Spacing, Surface, Wavefront, distance_map};
use proptest::prelude::*;

use crate::common::closed::flat;
use crate::common::{cases, cells_from_zero, cpu_map};

/// Contours lie within a tenth of a cell of the exact curve, also in the middle of each of their segments.
/// Sources are at grid points, between them, and beside the border.
#[test]
fn contours_lie_within_a_tenth_of_a_cell_of_the_exact_curve() {
    const POINTS: usize = 129;
    for builtin in [Builtin::Plane, Builtin::Cylinder, Builtin::Sphere] {
        let surface = builtin.surface(POINTS, POINTS).unwrap();
        for source in [[40.0, 70.0], [40.3, 70.6], [0.0, 0.0], [2.5, 127.0]] {
            let sources = Sources::point(source[0], source[1]);
            let map = cpu_map(&surface, &sources);
            let levels = Levels::Count(40).on(&map, &sources).unwrap();
            let exact = |at| builtin.exact_distance(POINTS, POINTS, source, at).unwrap();
            let (mut worst, mut vertices) = (0.0f64, 0);
            for contour in contours(&map, &sources, &levels) {
                for curve in &contour.curves {
                    let points: Vec<_> = curve.points().collect();
                    for ends in points.windows(2) {
                        let middle = [0, 1].map(|k| 0.5 * (ends[0][k] + ends[1][k]));
                        for at in [ends[0], middle] {
                            let later = |at| exact(at) - contour.level;
                            worst = worst.max(cells_from_zero(POINTS, later, at));
                            vertices += 1;
                        }
                    }
                }
            }
            println!("{builtin} {source:?}: {worst:.4} cells, {vertices} places");
            assert!(vertices > 5000 && worst < 0.1, "{builtin} {source:?}: {worst} cells");
        }
    }
}

proptest! {
    #![proptest_config(cases(100))]

    /// If a whole border, or the line midway between two sources, has the largest distance, this border or line
    /// is found as a contour at three levels: the exact distance, the map's largest distance, and the last
    /// multiple of a spacing.
    #[test]
    fn the_largest_distance_has_a_curve_where_points_side_by_side_have_it(
        (rows, cols) in (2usize..40, 2usize..40),
        // Multiples of these spacings are exact in single precision. In much longer cells, straight fronts have
        // larger rounding errors.
        spacing in (1u16..400, prop::sample::select(vec![0.5, 1.0, 2.0]))
            .prop_map(|(dx, long)| (0.25 * f64::from(dx), 0.25 * f64::from(dx) * long)),
        start in prop::sample::select(vec![0.0, 3.0]),
        from_last: bool,
        along_rows: bool,
        both: bool,
    ) {
        let (dx, dy) = spacing;
        let cols = if both { 2 * (cols / 2) + 1 } else { cols };
        let heights = vec![0.0; rows * cols];
        let surface = match along_rows {
            true => Surface::from_heights(cols, rows, heights, Spacing { dx: dy, dy: dx }),
            false => Surface::from_heights(rows, cols, heights, Spacing { dx, dy }),
        };
        let surface = surface.unwrap();
        let (last_row, last_col) = ((rows - 1) as f64, (cols - 1) as f64);
        let place = |row: f64, col: f64| if along_rows { [col, row] } else { [row, col] };
        let line = |col: f64| [place(0.0, col), place(last_row, col)];
        let near = if from_last { last_col } else { 0.0 };
        let mut sources = Sources::default().and_curve(line(near), start);
        if both {
            sources = sources.and_curve(line(last_col - near), start);
        }
        // Straight fronts are exact here.
        let wavefront = Some(Wavefront::Planar);
        let options = Options::default().with_engine(Engine::Cpu).with_wavefront(wavefront);
        let map = distance_map(&surface, &sources, &options).unwrap();
        let far = if both { 0.5 * last_col } else { last_col - near };
        let exact = start + (far - near).abs() * dx;
        let every = Levels::Spacing(exact / 4.0).on(&map, &sources).unwrap();
        let levels = [exact, map.report.max_distance, every[every.len() - 1]];
        for contour in contours(&map, &sources, &levels) {
            let [curve] = &contour.curves[..] else { panic!("{contour:?}") };
            prop_assert!(!curve.closed);
            let length = curve.length(&surface).unwrap();
            prop_assert!((length - last_row * dy).abs() < 1e-9 * length, "{length}");
            prop_assert!(curve.vertices.iter().all(|&[row, col]| [row, col][usize::from(!along_rows)] == far));
            if !both {
                // The nearer side lies to the left of the curve. Since rows count downwards, the step to the left
                // of a step (down, right) is (-right, down).
                let (a, b) = (curve.vertices[0], curve.vertices[1]);
                let left = [a[1] - b[1], b[0] - a[0]];
                let inwards = left[usize::from(!along_rows)];
                prop_assert!(inwards * (near - far) > 0.0, "{curve:?}");
            }
        }
    }

    /// If only a corner has the largest distance, the contour of this distance has no curve.
    #[test]
    fn a_single_farthest_point_has_no_curve((rows, cols) in (2usize..30, 2usize..30), last: bool) {
        let source = if last { [rows - 1, cols - 1] } else { [0, 0] };
        let sources = Sources::point(source[0] as f64, source[1] as f64);
        let map = cpu_map(&flat(rows, cols), &sources);
        let found = contours(&map, &sources, &[map.report.max_distance]);
        prop_assert!(found[0].curves.is_empty(), "{found:?}");
    }
}

#[test]
fn curves_are_closed_around_the_source_and_run_counter_clockwise() {
    let sources = Sources::point(20.0, 22.0);
    let map = cpu_map(&flat(41, 45), &sources);
    for contour in contours(&map, &sources, &[0.4, 5.0, 17.5]) {
        let [curve] = &contour.curves[..] else { panic!("{contour:?}") };
        assert!(curve.closed);
        let points: Vec<_> = curve.points().collect();
        // Twice the area. Since rows count downwards, it is positive if the curve is counter-clockwise in a
        // picture.
        let twice = |ends: &[[f64; 2]]| ends[0][0] * ends[1][1] - ends[1][0] * ends[0][1];
        let area = 0.5 * points.windows(2).map(twice).sum::<f64>();
        // Inscribed polygons are smaller than the circle, octagons by a tenth.
        let exact = std::f64::consts::PI * contour.level.powi(2);
        assert!((0.85 * exact..exact * 1.0001).contains(&area), "{area} {exact}");
    }
}

#[test]
fn levels_outside_the_map_give_no_curve() {
    let sources = Sources::point(4.0, 4.0);
    let map = cpu_map(&flat(9, 9), &sources);
    for contour in contours(&map, &sources, &[-3.0, 0.0, 5.7, 1e9]) {
        assert!(contour.curves.is_empty(), "{contour:?}");
    }
    assert!(contours(&map, &sources, &[]).is_empty());
}

#[test]
fn levels_are_listed_counted_or_spaced() {
    let sources = Sources::default().and_point(0.0, 0.0, 10.0);
    let map = cpu_map(&flat(2, 11), &Sources::default().and_point(0.0, 0.0, 10.0));
    let on = |levels: Levels| levels.on(&map, &sources);
    assert_eq!(on(Levels::List(vec![12.0, 11.0, 12.0])), Ok(vec![11.0, 12.0]));
    assert_eq!(on(Levels::Spacing(4.0)), Ok(vec![12.0, 16.0, 20.0]));
    assert_eq!(on(Levels::Count(3)).unwrap().len(), 3);
    assert_eq!(on(Levels::Count(0)), Ok(vec![]));
    for levels in [Levels::Spacing(0.0), Levels::Spacing(f64::NAN)] {
        assert!(matches!(on(levels), Err(LevelError::Spacing(_))));
    }
    assert!(matches!(on(Levels::List(vec![f64::NAN])), Err(LevelError::NotFinite(_))));
    assert!(matches!(on(Levels::Spacing(1e-9)), Err(LevelError::TooMany(_))));
}

#[test]
fn contours_end_at_holes_and_stay_on_reached_points() {
    // A wall with a gap at its northern end, and a column that is cut off.
    let (rows, cols) = (15, 21);
    let kept = |i: usize| !(i % cols == 8 && i / cols > 0) && i % cols != 18;
    let mask: Vec<bool> = (0..rows * cols).map(kept).collect();
    let surface = flat(rows, cols).with_mask(&mask).unwrap();
    let sources = Sources::point(10.0, 3.0);
    let map = cpu_map(&surface, &sources);
    let levels = Levels::Spacing(1.0).on(&map, &sources).unwrap();
    let mut curves = 0;
    for contour in contours(&map, &sources, &levels) {
        for curve in &contour.curves {
            curves += 1;
            // Only a curve on the surface has a length.
            curve.length(&surface).unwrap();
            assert!(curve.vertices.iter().all(|at| at[1] <= 17.0), "{curve:?}");
        }
    }
    assert!(curves > levels.len(), "some levels lie on both sides of the wall");
}

#[test]
fn two_rows_a_plateau_and_a_single_row() {
    let sources = Sources::point(0.0, 0.0);
    let found = contours(&cpu_map(&flat(2, 9), &sources), &sources, &[3.5]);
    assert_eq!(found[0].curves[0].vertices.len(), 3);
    // All points are at the same place: the whole map is a plateau.
    let points = vec![geosweep::glam::DVec3::ONE; 12];
    let plateau = Surface::from_positions(3, 4, points).unwrap();
    let map = cpu_map(&plateau, &sources);
    assert!(contours(&map, &sources, &[-1.0, 0.0, 1.0]).iter().all(|c| c.curves.is_empty()));
    let line = cpu_map(&flat(1, 9), &sources);
    assert!(contours(&line, &sources, &[3.5])[0].curves.is_empty());
}
