//! Closed surfaces whose grids do not repeat the samples of a seam, against truth and against grids that repeat them.

use std::f64::consts::{PI, TAU};

use geosweep::accuracy::Errors;
use geosweep::glam::DVec3;
use geosweep::surface::builtin::Closed;
use geosweep::surface::{
    Chart, CompletedGrid, Gluing, GluingError, GridSide, LastLine, Layout, MetricTensor, Seam,
    SurfaceError,
};
use geosweep::{Sources, Spacing, Surface, distance_map_f64};

use crate::common::closed::{angle, flat, grid};
use crate::common::curved;

/// Returns the distances at the given points from a given place.
fn map(lines: &CompletedGrid, surface: &Surface, source: [f64; 2]) -> Vec<f64> {
    let [row, col] = lines.to_completed(source).unwrap();
    let map = distance_map_f64(surface, &Sources::point(row, col), &curved()).unwrap();
    assert!(map.report.converged && map.report.seams.is_empty());
    lines.crop(&map.distances)
}

/// Completes a grid. Asserts that the completed grid has the rows and columns `chart`.
fn completed(given: &Surface, layout: Layout, chart: [usize; 2]) -> (CompletedGrid, Surface) {
    let lines = CompletedGrid::new(given, layout).unwrap();
    let surface = lines.complete(given).unwrap();
    assert_eq!([surface.rows(), surface.cols()], chart);
    assert_eq!((lines.chart(), lines.given()), (surface.chart(), given.chart()));
    assert!(surface.is_glued() && surface.seams().is_empty());
    (lines, surface)
}

/// Returns the mean relative error of distances on the unit sphere, and the largest up to 0.1 radians from the antipode.
fn sphere_errors(name: &str, given: &Surface, from: DVec3, found: &[f64]) -> [f64; 2] {
    let exact = |index| {
        let (row, col) = given.chart().position(index);
        let exact = given.position(row, col).map_or(f64::INFINITY, |at| angle(at, from));
        // Beside the antipode, and at the source, errors do not count.
        if (PI - 0.1..4.0).contains(&exact) || exact < 1e-9 { f64::NAN } else { exact }
    };
    let exact: Vec<_> = (0..found.len()).map(exact).collect();
    let errors = Errors::of(found, &exact);
    println!("{name} from {from}: {errors}");
    assert_eq!(errors.reached_by_one, 0);
    [errors.mean_relative, errors.max_relative]
}

/// Returns a sphere of these latitudes and longitudes in degrees.
fn sphere(latitudes: &[f64], longitudes: &[f64]) -> Surface {
    grid(latitudes.len(), longitudes.len(), |row, col| {
        let [lat, lon] = [latitudes[row], longitudes[col]].map(f64::to_radians);
        DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin())
    })
}

fn lines(count: usize, first: f64, step: f64) -> Vec<f64> {
    (0..count).map(|k| first + step * k as f64).collect()
}

/// Lines at the poles and on both sides of the date line may be there or not. The bounds are those of `Closed::Globe`
/// at this size.
#[test]
fn a_sphere_is_whole_whichever_of_its_lines_are_given() {
    let step = 1.8;
    let around = lines(200, 0.0, step);
    for (name, latitudes, longitudes, source, chart) in [
        ("all lines", lines(101, 90.0, -step), lines(201, 0.0, step), [50.0, 70.0], [101, 201]),
        ("0 to 358", lines(101, 90.0, -step), around.clone(), [40.0, 199.0], [101, 201]),
        ("cells", lines(100, 89.1, -step), lines(200, 0.9, step), [3.0, 0.0], [102, 201]),
        ("a pole of cells", lines(100, 89.1, -step), around.clone(), [-0.5, 7.0], [102, 201]),
        ("no poles", lines(99, 88.2, -step), lines(201, 0.0, step), [60.0, 3.0], [101, 201]),
        ("northwards", lines(100, -89.1, step), around, [70.0, 13.0], [102, 201]),
    ] {
        let given = sphere(&latitudes, &longitudes);
        let (lines, surface) = completed(&given, Layout::Globe, chart);
        let from = match source[0] < 0.0 {
            true => DVec3::Z,
            false => given.position(source[0] as usize, source[1] as usize).unwrap(),
        };
        let [mean, largest] = sphere_errors(name, &given, from, &map(&lines, &surface, source));
        assert!(mean < 2e-5 && largest < 5e-4, "{name}: {mean:e} {largest:e}");
    }
}

/// Returns the middles of the texels of a cube map of the sphere. `faces` has rows of faces, each with its number and
/// its quarter turns, or `None` for holes. Lines of holes lie between faces if `gap` is 1.
fn cube(texels: usize, gap: usize, faces: &[&[Option<(usize, usize)>]]) -> Surface {
    let pitch = texels + gap;
    let (rows, cols) = (faces.len() * pitch - gap, faces[0].len() * pitch - gap);
    grid(rows, cols, |row, col| {
        let [(down, row), (right, col)] = [row, col].map(|at| (at / pitch, at % pitch));
        let Some((face, turns)) = faces[down][right].filter(|_| row.max(col) < texels) else {
            return DVec3::NAN;
        };
        let at = |k: usize| (2 * k + 1) as f64 / texels as f64 - 1.0;
        // The angles between texels are equal.
        let [mut u, mut v] = [at(col), at(row)].map(|at| (at * PI / 4.0).tan());
        (0..turns).for_each(|_| (u, v) = (-v, u));
        let sign = if face % 2 == 0 { 1.0 } else { -1.0 };
        let (u, v) = (sign * u, v);
        match face / 2 {
            0 => DVec3::new(sign, u, v),
            1 => DVec3::new(u, v, sign),
            _ => DVec3::new(v, sign, u),
        }
        .normalize()
    })
}

/// The bounds are those of `Closed::CubeSphere` with 51 points a side.
#[test]
fn a_cube_map_at_the_middles_of_texels_is_a_whole_sphere() {
    let face = |face: usize, turns: usize| Some((face, turns));
    let strip: Vec<_> = (0..6).map(|k| face(k, 0)).collect();
    let turned: Vec<Vec<_>> = (0..6).map(|k| vec![face((k * 5 + 2) % 6, k % 4)]).collect();
    let column: Vec<&[_]> = turned.iter().map(|row| &row[..]).collect();
    let (top, bottom) =
        ([face(0, 1), face(2, 0), face(4, 3)], [face(3, 2), face(1, 0), face(5, 1)]);
    let cross: [[Option<_>; 4]; 3] = [
        [None, face(4, 0), None, None],
        [face(0, 2), face(2, 1), face(1, 0), face(3, 3)],
        [None, face(5, 1), None, None],
    ];
    let n = 50;
    for (name, given, chart) in [
        ("2 x 3", cube(n, 1, &[&top, &bottom]), [105, 158]),
        ("strip", cube(n, 0, &[&strip]), [52, 317]),
        ("column", cube(n, 0, &column), [317, 52]),
        ("cross", cube(n, 1, &cross.each_ref().map(|row| &row[..])), [158, 211]),
    ] {
        let (lines, surface) = completed(&given, Layout::Cube, chart);
        assert_eq!(surface.points(), 6 * 52 * 52, "{name}");
        // Added points lie on the sphere up to the third order of the distance between texels.
        let off = (0..surface.chart().points()).filter_map(|index| {
            let (row, col) = surface.chart().position(index);
            Some((surface.position(row, col)?.length() - 1.0).abs())
        });
        assert!(off.fold(0.0, f64::max) < 4e-5, "{name}");
        let first = (0..given.chart().points()).find(|&index| {
            let (row, col) = given.chart().position(index);
            given.has(row, col)
        });
        let (row, col) = given.chart().position(first.unwrap());
        for [down, right] in [[0, 0], [25, 25], [10, 49]] {
            let (row, col) = (row + down, col + right);
            let from = given.position(row, col).unwrap();
            let found = map(&lines, &surface, [row as f64, col as f64]);
            let [mean, largest] = sphere_errors(name, &given, from, &found);
            assert!(mean < 3e-5 && largest < 1e-3, "{name}: {mean:e} {largest:e}");
        }
    }
}

#[test]
fn unrolled_surfaces_are_exact_up_to_rounding() {
    let (rows, cols) = (60, 96);
    let (row, col) = (20.0, 93.0);
    let round = |a: f64, b: f64, n: f64| (a - b).abs().min(n - (a - b).abs());
    let tube = |r: f64, c: f64| round(c, col, 96.0).hypot(r - row);
    let torus = |r: f64, c: f64| round(c, col, 96.0).hypot(round(r, row, 60.0));
    let moebius = |r: f64, c: f64| {
        let images = [(r, 0.0), (59.0 - r, 96.0), (59.0 - r, -96.0)];
        let images = images.map(|(r, by)| (c + by - col).hypot(r - row));
        images.into_iter().fold(f64::INFINITY, f64::min)
    };
    let on_side = |r: f64, c: f64| round(r, row, 60.0).hypot(c - col);
    type Exact<'a> = &'a dyn Fn(f64, f64) -> f64;
    let columns = [GridSide::FirstColumn, GridSide::LastColumn];
    let around = [GridSide::FirstRow, GridSide::LastRow];
    let seam = |sides, reversed| Seam::Neighbours { sides, reversed };
    let cases: [(&str, Vec<Seam>, [usize; 2], Exact); 4] = [
        ("tube", vec![seam(columns, false)], [60, 97], &tube),
        ("torus", vec![seam(columns, false), seam(around, false)], [61, 97], &torus),
        ("Moebius strip", vec![seam(columns, true)], [60, 97], &moebius),
        ("rows", vec![seam(around, false)], [61, 96], &on_side),
    ];
    let metric = vec![MetricTensor { rr: 1.0, rc: 0.0, cc: 1.0 }; rows * cols];
    let metric = Surface::from_metric(rows, cols, metric).unwrap();
    for (name, seams, [down, right], exact) in cases {
        for given in [flat(rows, cols), metric.clone()] {
            let lines = CompletedGrid::with_seams(given.chart(), &seams).unwrap();
            assert_eq!(lines.chart(), Chart { rows: down, cols: right });
            let surface = lines.complete(&given);
            if name == "Moebius strip" && !given.geometry().has_positions() {
                let error = surface.unwrap_err();
                assert_eq!(error, GluingError::ReversedMetric.into());
                continue;
            }
            let found = map(&lines, &surface.unwrap(), [row, col]);
            let error = |(index, found): (usize, &f64)| {
                let (r, c) = given.chart().position(index);
                let exact = exact(r as f64, c as f64);
                (found - exact).abs() / exact.max(1.0)
            };
            let largest = found.iter().enumerate().map(error).fold(0.0, f64::max);
            println!("{name}: {largest:.1e}");
            assert!(largest < 3e-6, "{name}: {largest:e}");
        }
    }
}

/// Returns a torus in space that closes after `rows` rows and `cols` columns. `lines` are those of its grid.
fn torus(lines: [usize; 2], [rows, cols]: [usize; 2]) -> Surface {
    let turn = |k: usize, n: usize| TAU * (k % n) as f64 / n as f64;
    grid(lines[0], lines[1], |row, col| {
        let [v, u] = [turn(row, rows), turn(col, cols)];
        let radius = 2.0 + v.cos();
        DVec3::new(radius * u.cos(), radius * u.sin(), v.sin())
    })
}

/// Holes and slowness are completed like positions: the torus equals a torus whose grid repeats the lines.
#[test]
fn holes_and_slowness_are_completed() {
    let turns @ [rows, cols] = [40, 60];
    let whole = [rows + 1, cols + 1];
    let made = |lines: [usize; 2]| {
        let surface = torus(lines, turns);
        let places = (0..lines[0] * lines[1]).map(|index| {
            let (row, col) = surface.chart().position(index);
            [row % rows, col % cols]
        });
        let slowness = places.clone().map(|[row, col]| {
            2.0 + (TAU * row as f64 / 40.0).sin() + 0.5 * (TAU * col as f64 / 30.0).cos()
        });
        let mask: Vec<_> = places.map(|[row, col]| row != 0 || col % 30 > 7).collect();
        let slowness = slowness.collect();
        surface.with_slowness(slowness).unwrap().with_mask(&mask).unwrap()
    };
    let given = made(turns);
    let (lines, surface) = completed(&given, Layout::Both, whole);
    let repeated = made(whole).with_gluing(Gluing::both()).unwrap();
    let found = map(&lines, &surface, [38.0, 2.0]);
    let wanted = map(&lines, &repeated, [38.0, 2.0]);
    assert!(wanted.iter().any(|distance| distance.is_infinite()));
    assert_eq!(found, wanted);
    assert_eq!(surface.slowness(), repeated.slowness());
}

/// A strip in space that turns over, with and without its last column.
#[test]
fn a_moebius_strip_is_that_of_repeated_columns() {
    let (rows, cols) = (31, 121);
    let whole = Closed::MoebiusStrip.surface(rows, cols).unwrap();
    let position = |row, col| whole.position(row, col).unwrap();
    let given = grid(rows, cols - 1, position);
    let (lines, surface) = completed(&given, Layout::FlippedColumns, [rows, cols]);
    let expected = distance_map_f64(&whole, &Sources::point(12.5, 119.5), &curved()).unwrap();
    let found = map(&lines, &surface, [12.5, 119.5]);
    for (index, found) in found.iter().enumerate() {
        let (row, col) = given.chart().position(index);
        let wanted = expected.distance(row, col);
        assert!((found - wanted).abs() <= 1e-9 * wanted, "{row},{col}: {found} {wanted}");
    }
    // With its last column, it needs no other.
    let with_both = grid(rows, cols, position);
    let (lines, _) = completed(&with_both, Layout::FlippedColumns, [rows, cols]);
    assert!(!lines.is_extended());
}

#[test]
fn values_are_extended_and_cropped() {
    let given = sphere(&lines(6, 75.0, -30.0), &lines(8, 0.0, 45.0));
    let (lines, globe) = completed(&given, Layout::Globe, [8, 9]);
    let values: Vec<_> = (0..48).map(f64::from).collect();
    let all = lines.extend(&values);
    assert_eq!(lines.crop(&all), values);
    assert_eq!((&all[..9], all[9], all[17], all[71]), (&[3.5; 9][..], 0.0, 0.0, 43.5));
    assert_eq!(lines.margins(), [[0.5, 0.5], [0.0, 1.0]]);
    for (place, completed) in [([-0.5, 2.0], [0.0, 2.0]), ([5.5, 8.0], [7.0, 8.0])] {
        assert_eq!(lines.to_completed(place), Some(completed));
        assert_eq!(lines.to_given(completed), place);
    }
    assert_eq!([[-0.6, 0.0], [0.0, -0.1], [0.0, 8.1]].map(|at| lines.to_completed(at)), [None; 3]);
    assert!(globe.position(0, 0).unwrap().distance(DVec3::Z) < 0.03);
    // A pole beside holes is computed from points whose opposite points are present. If there are none, it is a hole.
    let holed = |cols: std::ops::Range<usize>| {
        let mask: Vec<_> = (0..48).map(|index| index > 7 || !cols.contains(&index)).collect();
        let surface = lines.complete(&given.clone().with_mask(&mask).unwrap()).unwrap();
        surface.position(0, 3)
    };
    assert!(holed(0..2).unwrap().distance(DVec3::Z) < 0.03);
    assert_eq!(holed(0..4), None);
}

#[test]
fn grids_that_do_not_fit_are_refused() {
    let refused = |surface: &Surface, layout| match CompletedGrid::new(surface, layout) {
        Err(SurfaceError::Gluing(error)) => error,
        other => panic!("{other:?}"),
    };
    let plane = grid(9, 9, |row, col| DVec3::new(col as f64, row as f64, 0.0));
    let apart = refused(&plane, Layout::Columns);
    let sides = [GridSide::FirstColumn, GridSide::LastColumn];
    assert_eq!(apart, GluingError::NotNeighbours { sides, apart: 8.0, step: 1.0 });
    assert!(apart.to_string().contains("the first column and the last column"), "{apart}");
    let tube = grid(9, 16, |row, col| {
        let angle = TAU * col as f64 / 16.0;
        DVec3::new(angle.cos(), angle.sin(), row as f64)
    });
    let ring = refused(&tube, Layout::Globe);
    assert!(matches!(ring, GluingError::NoRing { side: GridSide::FirstRow, .. }), "{ring}");
    assert!(matches!(refused(&tube, Layout::Rows), GluingError::NotNeighbours { .. }));
    assert!(matches!(refused(&tube, Layout::FlippedColumns), GluingError::NotNeighbours { .. }));
    assert_eq!(refused(&tube, Layout::Cube), GluingError::NotCube { rows: 9, cols: 16 });
    let strip = grid(8, 48, |row, col| DVec3::new(col as f64, row as f64, 0.0));
    let alone = refused(&strip, Layout::Cube);
    assert!(matches!(alone, GluingError::FaceSide { row: 0, col: 0, .. }), "{alone}");
    assert!(matches!(refused(&flat(9, 9), Layout::Globe), GluingError::NoPositions { .. }));
    assert!(matches!(refused(&flat(12, 18), Layout::Cube), GluingError::NoPositions { .. }));
    let narrow = grid(9, 3, |row, col| {
        let angle = TAU * col as f64 / 3.0;
        DVec3::new(angle.cos(), angle.sin(), row as f64)
    });
    assert!(matches!(refused(&narrow, Layout::Columns), GluingError::NotNeighbours { .. }));
    let (lines, whole) = completed(&tube, Layout::Columns, [9, 17]);
    assert!(matches!(refused(&whole, Layout::Columns), GluingError::Unsupported { .. }));
    let other = lines.complete(&plane).unwrap_err();
    assert!(matches!(other, SurfaceError::Shape { rows: 9, cols: 16, .. }), "{other}");
    let chart = Chart { rows: 9, cols: 9 };
    let seams = |seams: &[Seam]| CompletedGrid::with_seams(chart, seams).unwrap_err();
    let rows = [GridSide::FirstRow, GridSide::LastRow];
    let around = |sides, reversed| Seam::Neighbours { sides, reversed };
    for refused in [
        seams(&[around(sides, true), around(rows, false)]),
        seams(&[Seam::Fold(GridSide::FirstRow)]),
        seams(&[Seam::Ring(GridSide::FirstColumn)]),
        seams(&[around(rows, false), Seam::Ring(GridSide::FirstRow)]),
    ] {
        assert!(matches!(refused, GluingError::Unsupported { .. }), "{refused}");
    }
    let few = Chart { rows: 9, cols: 3 };
    for seams in [vec![around(sides, false)], vec![around(sides, false), around(rows, false)]] {
        let small = CompletedGrid::with_seams(few, &seams);
        assert!(matches!(small, Err(GluingError::TooSmall { .. })), "{seams:?}");
    }
    let few = Chart { rows: 3, cols: 9 };
    for seam in [around(rows, false), Seam::Ring(GridSide::FirstRow)] {
        let small = CompletedGrid::with_seams(few, &[seam]);
        assert!(matches!(small, Err(GluingError::TooSmall { .. })), "{seam:?}");
    }
    // Gluing alone adds no line.
    for seam in [around(sides, false), Seam::Ring(GridSide::FirstRow)] {
        let error = tube.clone().with_gluing(Gluing::Seams(vec![seam])).unwrap_err();
        assert!(error.to_string().contains("CompletedGrid"), "{error}");
    }
}

/// If heights are equal on both sides, the sides may be one line or neighbouring ones. Otherwise they are neighbours.
#[test]
fn whether_a_line_of_heights_is_repeated_is_said() {
    let heights = |cols: usize| {
        let height = move |index: usize| (TAU * (index % cols % 24) as f64 / 24.0).sin();
        let heights = (0..9 * cols).map(height).collect();
        Surface::from_heights(9, cols, heights, Spacing::square(1.0)).unwrap()
    };
    let unclear = CompletedGrid::new(&heights(25), Layout::Columns).unwrap_err();
    assert!(matches!(unclear, SurfaceError::Gluing(GluingError::Unclear { .. })), "{unclear}");
    let (added, without) = completed(&heights(24), Layout::Columns, [9, 25]);
    let said = |last| CompletedGrid::with_last_line(&heights(25), Layout::Columns, last).unwrap();
    assert_eq!(said(LastLine::IsApart).chart(), Chart { rows: 9, cols: 26 });
    let repeated = said(LastLine::Repeats);
    let with_both = repeated.complete(&heights(25)).unwrap();
    assert!(!repeated.is_extended() && added.is_extended());
    let [expected, found] = [(&repeated, &with_both), (&added, &without)]
        .map(|(lines, surface)| map(lines, surface, [4.0, 1.0]));
    for (index, found) in found.iter().enumerate() {
        let wanted = expected[index / 24 * 25 + index % 24];
        assert!((found - wanted).abs() <= 1e-12 * wanted, "{index}: {found} {wanted}");
    }
}

/// Tubes of two and three rows: only the columns need four lines. The last column is one step from the first.
#[test]
fn tubes_of_few_rows_are_completed() {
    for (rows, cols) in [(2, 16), (3, 13), (16, 2), (13, 3)] {
        let is_wide = rows < cols;
        let angle = TAU / rows.max(cols) as f64;
        let place = |index: usize| {
            let (row, col) = (index / cols, index % cols);
            let [at, up] = if is_wide { [col, row] } else { [row, col] };
            let (sin, cos) = (angle * at as f64).sin_cos();
            DVec3::new(cos, sin, 0.4 * up as f64)
        };
        let positions = (0..rows * cols).map(place).collect();
        let given = Surface::from_positions(rows, cols, positions).unwrap();
        let (layout, whole) = match is_wide {
            true => (Layout::Columns, [rows, cols + 1]),
            false => (Layout::Rows, [rows + 1, cols]),
        };
        let (lines, surface) = completed(&given, layout, whole);
        let distances = map(&lines, &surface, [0.0, 0.0]);
        let last = if is_wide { cols - 1 } else { (rows - 1) * cols };
        assert!((distances[last] - angle).abs() < 1e-3 * angle, "{rows} x {cols}: {distances:?}");
    }
}
