//! Contours in the host's frames.

use std::collections::HashMap;

use geosweep::geometry::contours;
use geosweep::surface::builtin::Builtin;
use geosweep::vulkan::embed::{
    Access, ContourFrame, Contours, CurveRecord, CurveStatus, CurveVertex, LevelInput, PointSource,
};
use geosweep::{DistanceMap, Sources, Surface};

use super::{Scene, lifted_off, vertices};
use crate::common::closed::flat;
use crate::common::rough;
use crate::embed::stage::Kept;

/// Length in cells below which pieces are not compared: the CPU leaves out pieces without length.
const SHORT: f64 = 0.01;

type Piece = [[f64; 2]; 2];

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Returns the pieces of all levels, by level.
fn on_cpu(map: &DistanceMap, sources: &Sources, levels: &[f32]) -> Vec<Vec<Piece>> {
    let levels: Vec<f64> = levels.iter().map(|&level| level.into()).collect();
    let pieces = |contour: &geosweep::geometry::Contour| {
        let curves = contour.curves.iter().map(|curve| curve.points().collect::<Vec<_>>());
        curves
            .flat_map(|points| points.windows(2).map(|p| [p[0], p[1]]).collect::<Vec<_>>())
            .collect()
    };
    contours(map, sources, &levels).iter().map(pieces).collect()
}

fn on_device(levels: &[f32], vertices: &[CurveVertex]) -> Vec<Vec<Piece>> {
    let mut pieces = vec![Vec::new(); levels.len()];
    for ends in vertices.chunks_exact(2) {
        assert_eq!(ends[0].time, ends[1].time);
        let level = levels.iter().position(|&level| level == ends[0].time).unwrap();
        pieces[level].push([0, 1].map(|k| [ends[k].row.into(), ends[k].col.into()]));
    }
    pieces
}

/// Returns the largest distance from a piece to the nearest of `others` that runs in the same direction. It
/// is infinite if there is none in a neighbouring cell.
fn apart(pieces: &[Piece], others: &[Piece]) -> f64 {
    let cell = |piece: &Piece| [0, 1].map(|k| (0.5 * (piece[0][k] + piece[1][k])).floor() as i64);
    let mut by_cell: HashMap<[i64; 2], Vec<&Piece>> = HashMap::new();
    others.iter().for_each(|piece| by_cell.entry(cell(piece)).or_default().push(piece));
    let long = pieces.iter().filter(|piece| distance(piece[0], piece[1]) > SHORT);
    let nearest = |piece: &Piece| {
        let [row, col] = cell(piece);
        let around = (row - 1..=row + 1).flat_map(|r| (col - 1..=col + 1).map(move |c| [r, c]));
        let found = around.filter_map(|cell| by_cell.get(&cell)).flatten();
        let far = |other: &&Piece| distance(piece[0], other[0]).max(distance(piece[1], other[1]));
        found.map(far).fold(f64::INFINITY, |near, far| far.min(near))
    };
    long.map(nearest).fold(0.0, f64::max)
}

/// Returns the largest distance in cells between the device's contours and the CPU's on the same map.
pub fn difference(
    map: &DistanceMap,
    sources: &Sources,
    levels: &[f32],
    vertices: &[CurveVertex],
) -> f64 {
    let (found, expected) = (on_device(levels, vertices), on_cpu(map, sources, levels));
    assert!(expected.iter().any(|pieces| !pieces.is_empty()), "no contours to compare");
    let both = found.iter().zip(&expected);
    both.map(|(a, b)| apart(a, b).max(apart(b, a))).fold(0.0, f64::max)
}

fn record(
    scene: &mut Scene,
    contours: &Contours,
    levels: LevelInput,
    start: f32,
) -> (CurveRecord, Vec<CurveVertex>) {
    let frame = ContourFrame::new(levels, Access::TRANSFER_READ).with_start(start);
    let (records, vertices) = scene.read(contours.curves(), |recording| {
        recording.contours(contours, &frame).unwrap();
    });
    (records[0], vertices)
}

pub fn new_contours(scene: &mut Scene, room: u32) -> Contours {
    let stage = &mut scene.stage;
    let device = stage.host.device.clone();
    stage.solver.contours(&device, stage.host.allocator(), &stage.surface, room).unwrap()
}

/// Compares contours with the CPU's on the device's own map, as sets of pieces.
fn compare(name: &str, surface: &Surface, source: [f32; 3], levels: &[f32], tolerance: f64) {
    let [row, col, time] = source;
    let sources = [PointSource { time, ..PointSource::at(row, col) }];
    let mut scene = Scene::new(Kept::watched_but_for_shaders(), surface, &sources);
    let mut contours = new_contours(&mut scene, 1 << 16);
    let (record, all) = record(&mut scene, &contours, LevelInput::List(levels), time);
    assert_eq!(record.status(), CurveStatus::Complete, "{name}: {record:?}");
    assert_eq!(record.vertices, record.vertex_count);
    let drawn = vertices(&record, 0, contours.curves(), &all);
    let sources = Sources::default().and_point(row.into(), col.into(), time.into());
    let worst = difference(&scene.map, &sources, levels, drawn);
    let off = lifted_off(surface, drawn);
    println!("{name}: {worst:.1e} cells apart, lifted {off:.1e} off");
    assert!(worst < tolerance, "{name}: {worst}");
    assert!(off < 1e-5, "{name}: {off}");
    scene.end_with(|device, allocator| contours.destroy(device, allocator));
}

fn spaced(step: f32, count: usize) -> Vec<f32> {
    (1..=count).map(|k| step * k as f32).collect()
}

/// Largest difference in cells. On lavapipe 7e-6 was measured, the resolution of rows and columns in single
/// precision. If divisions and roots are a unit off in the last place, as on GPUs, it is 3.3e-5.
pub const SAME: f64 = 1e-4;

#[test]
fn contours_are_those_of_the_cpu() {
    let plane = flat(65, 49);
    compare("plane", &plane, [20.25, 31.5, 0.0], &spaced(2.5, 40), SAME);
    compare("plane from 10 on", &plane, [20.0, 31.0, 10.0], &spaced(2.5, 40), SAME);
    let sphere = Builtin::Sphere.surface(65, 65).unwrap();
    compare("sphere", &sphere, [20.0, 31.0, 0.0], &spaced(0.05, 60), SAME);
    let maze = Builtin::Maze.surface(101, 101).unwrap();
    compare("maze", &maze, [0.0, 0.0, 0.0], &spaced(0.1, 300), SAME);
    compare("rough, with holes", &rough(61, 83, 11), [30.0, 41.0, 0.0], &spaced(1.0, 120), SAME);
    // A column that no front crosses.
    let mask: Vec<_> = (0..31 * 41).map(|i| i % 41 != 30).collect();
    let cut = flat(31, 41).with_mask(&mask).unwrap();
    compare("cut in two", &cut, [10.0, 12.0, 0.0], &spaced(1.0, 60), SAME);
    // Levels that are the map's own values along the source's row and column.
    compare("levels on grid points", &flat(21, 34), [7.0, 11.0, 0.0], &spaced(1.0, 30), SAME);
    for (rows, cols) in [(2, 2), (2, 19), (19, 2), (3, 130), (33, 64), (34, 65), (35, 66)] {
        let name = format!("{rows} x {cols}");
        compare(&name, &flat(rows, cols), [0.0, 0.0, 0.0], &spaced(0.7, 200), SAME);
    }
}

/// The layers check the shaders too.
#[test]
fn contours_that_do_not_fit_are_counted_and_the_first_are_kept() {
    let surface = rough(23, 21, 13);
    let mut scene = Scene::new(Kept::watched(), &surface, &[PointSource::at(11.0, 10.0)]);
    let levels = LevelInput::Spacing { step: 0.5, count: 200 };
    let mut roomy = new_contours(&mut scene, 40_000);
    let (all, mut vertices) = record(&mut scene, &roomy, levels, 0.0);
    assert_eq!(all.status(), CurveStatus::Complete);
    let needed = all.vertices as usize;
    // Nothing is written beyond the needed vertices.
    vertices.truncate(needed);
    // A second recording gives the same contours, vertex by vertex.
    let (again, found) = record(&mut scene, &roomy, levels, 0.0);
    assert_eq!((again, &found[..needed]), (all, &vertices[..]));
    for room in [needed, needed - 1, needed / 2 + 1, 2] {
        let mut contours = new_contours(&mut scene, room as u32);
        let stated = scene.stage.solver.bytes_for_contours(
            &scene.stage.host.device,
            surface.chart(),
            room as u32,
        );
        assert_eq!(stated.unwrap(), contours.bytes());
        let (record, kept) = record(&mut scene, &contours, levels, 0.0);
        let drawn = room / 2 * 2;
        assert_eq!((record.vertices, record.vertex_count), (needed as u32, drawn as u32));
        let fits = if room == needed { CurveStatus::Complete } else { CurveStatus::OutOfRoom };
        assert_eq!(record.status(), fits);
        assert_eq!(kept, vertices[..drawn]);
        let device = scene.stage.host.device.clone();
        contours.destroy(&device, scene.stage.host.allocator());
    }
    // No level; one level below and one above the map.
    for levels in [&[][..], &[-1.0, 1e9]] {
        let (none, _) = record(&mut scene, &roomy, LevelInput::List(levels), 0.0);
        assert_eq!((none.vertices, none.status()), (0, CurveStatus::Complete));
    }
    scene.end_with(|device, allocator| roomy.destroy(device, allocator));
}

#[test]
fn grids_without_cells_have_no_contours() {
    for (rows, cols) in [(1, 9), (9, 1), (1, 1)] {
        let surface = flat(rows, cols);
        let mut scene = Scene::new(Kept::watched(), &surface, &[PointSource::at(0.0, 0.0)]);
        let mut contours = new_contours(&mut scene, 100);
        let (record, _) = record(&mut scene, &contours, LevelInput::List(&[0.5, 1.5]), 0.0);
        assert_eq!((record.vertices, record.status()), (0, CurveStatus::Complete));
        scene.end_with(|device, allocator| contours.destroy(device, allocator));
    }
}
