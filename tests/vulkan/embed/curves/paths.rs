//! Paths in the host's frames.

use geosweep::geometry::PathTracer;
use geosweep::glam::{DVec3, Vec3};
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::vulkan::embed::{
    self, Access, CurveRecord, CurveStatus, CurveVertex, PathFrame, PathsInfo, PointSource,
    SourceInput, StartInput,
};
use geosweep::{Spacing, Surface};

use super::{Scene, lifted_off, vertices};
use crate::common::closed::flat;
use crate::common::{Random, rough};
use crate::embed::stage::{Kept, on_cpu};

pub fn new_paths(scene: &mut Scene, info: PathsInfo) -> embed::Paths {
    let stage = &mut scene.stage;
    let device = stage.host.device.clone();
    stage.solver.paths(&device, stage.host.allocator(), &stage.surface, info).unwrap()
}

/// Returns pseudo-random starts, at grid points and between them.
fn starts(rows: usize, cols: usize, count: usize) -> Vec<[f32; 2]> {
    let mut random = Random::new(1);
    let mut next = || random.next() as f32;
    (0..count)
        .map(|number| {
            let place = [next() * (rows - 1) as f32, next() * (cols - 1) as f32];
            if number % 2 == 0 { place.map(f32::round) } else { place }
        })
        .collect()
}

pub fn read(
    scene: &mut Scene,
    paths: &embed::Paths,
    starts: StartInput,
    sources: SourceInput,
) -> (Vec<CurveRecord>, Vec<CurveVertex>) {
    let reader = Access::TRANSFER_READ;
    let frame = PathFrame::new(starts, sources, reader);
    scene.read(paths.curves(), |recording| {
        recording.paths(paths, &frame).unwrap();
    })
}

fn end(scene: Scene, mut paths: embed::Paths) {
    scene.end_with(|device, allocator| paths.destroy(device, allocator));
}

/// Compares paths. Returns three relative differences of lengths: from the CPU's paths on the same map, for
/// 99 in 100 paths; the largest from the exact ones, for paths from grid points; and the largest from the
/// map. Differences are relative to at least a twentieth of the largest distance, since beside a grid line
/// single precision rounds by up to 3e-4 of a cell.
fn compare(
    name: &str,
    surface: &Surface,
    sources: &[PointSource],
    exact: Option<&[f64]>,
) -> [f64; 3] {
    const PATHS: usize = 300;
    let chart = surface.chart();
    let mut scene = Scene::new(Kept::watched_but_for_shaders(), surface, sources);
    let room = 8 * (chart.rows + chart.cols) as u32;
    let paths = new_paths(&mut scene, PathsInfo::new(PATHS as u32, room));
    let starts = starts(chart.rows, chart.cols, PATHS);
    let (inline, given) = (StartInput::Inline(&starts), SourceInput::Inline(sources));
    let (records, all) = read(&mut scene, &paths, inline, given);

    let edges = EdgeLengths::new(surface).unwrap();
    let exact_tracer = PathTracer::new(surface, &edges, &on_cpu(sources), &scene.map.distances);
    let on_cpu = exact_tracer.unwrap().along_the_map();
    let [mut from_map, mut from_exact, mut off] = [0.0f64; 3];
    let mut from_cpu = Vec::new();
    for (number, (record, start)) in records.iter().zip(&starts).enumerate() {
        let expected = match on_cpu.trace(start.map(f64::from)) {
            Ok(expected) => expected,
            Err(error) => {
                assert_eq!(record.status(), CurveStatus::Unreached, "{name}: {error}");
                assert_eq!((record.vertex_count, record.vertices), (0, 0));
                continue;
            }
        };
        assert_eq!(record.status(), CurveStatus::Complete, "{name} from {start:?}: {record:?}");
        assert_eq!(record.source(), Some(expected.source as u32), "{name} from {start:?}");
        assert_eq!(record.vertex_count, record.vertices);
        let drawn = vertices(record, number, paths.curves(), &all);
        let (first, last) = (&drawn[0], &drawn[drawn.len() - 1]);
        let source = sources[expected.source];
        assert_eq!([first.row, first.col], *start);
        assert_eq!([last.row, last.col, last.time], [source.row, source.col, source.time]);
        assert_eq!(first.time, record.distance);
        let least = 0.05 * scene.map.report.max_distance;
        let apart = |a: f32, b: f64| (f64::from(a) - b).abs() / b.max(least);
        let off_map = apart(record.distance, expected.distance);
        // Between the corners of a cell in which the slowness jumps, both know the value less well.
        let most_off = if surface.slowness().is_some() { 2e-3 } else { 3e-4 };
        assert!(off_map < most_off, "{name} from {start:?}: {off_map}");
        from_cpu.push(apart(record.length, expected.length));
        from_map = from_map.max(apart(record.length, record.distance.into()));
        off = off.max(lifted_off(surface, drawn));
        if let Some(exact) = exact.filter(|_| number % 2 == 0) {
            let exact = exact[chart.index(start[0] as usize, start[1] as usize)];
            from_exact = from_exact.max(apart(record.length, exact));
        }
    }
    from_cpu.sort_by(f64::total_cmp);
    let whole = from_cpu.len();
    let from_cpu = from_cpu[whole * 99 / 100];
    println!(
        "{name}: {whole} paths, lengths {from_cpu:.1e} from the CPU's, {from_exact:.1e} from the \
         exact, {from_map:.1e} from the map, lifted {off:.1e} off"
    );
    assert!(whole > 200 && off < 1e-5, "{name}: {whole} {off}");
    end(scene, paths);
    [from_cpu, from_exact, from_map]
}

/// The bound is 2e-3. Measured: 6.6e-4 from the exact lengths and 9e-4 from the map (peaks), elsewhere 4e-5.
#[test]
fn lengths_are_the_distances() {
    const POINTS: usize = 257;
    for builtin in Builtin::measurable() {
        let surface = builtin.surface(POINTS, POINTS).unwrap();
        let source = if builtin == Builtin::Maze { [0.0; 2] } else { [77.0, 102.0] };
        let exact = builtin.reference_distances(POINTS, POINTS, source.map(f64::from));
        let sources = [PointSource::at(source[0], source[1])];
        let [from_cpu, from_exact, from_map] =
            compare(&builtin.to_string(), &surface, &sources, Some(&exact));
        assert!(from_cpu < 3e-4, "{builtin}: {from_cpu}");
        assert!(from_exact < 2e-3 && from_map < 2e-3, "{builtin}: {from_exact} {from_map}");
    }
}

/// Patches, a wall and a ridge of slowness, up to 1000:1, on a plane and on peaks. Paths are those of the CPU, whose
/// vertices slide to where a path costs least.
#[test]
fn paths_over_a_slowness_cost_what_the_map_says() {
    let (rows, cols) = (61, 81);
    let mut random = Random::new(5);
    let classes: Vec<f64> =
        (0..100).map(|_| [1.0, 2.0, 5.0, 10.0][(4.0 * random.next()) as usize]).collect();
    let patches = |row: usize, col: usize| classes[row / 9 * 10 + col / 9];
    let wall = |_: usize, col: usize| if col == 40 { 1000.0 } else { 1.0 };
    let ridge = |_: usize, col: usize| 1.0 + 99.0 * (-(col as f64 / 2.0 - 15.0).powi(2)).exp();
    let slowed = |surface: Surface, slowness: &dyn Fn(usize, usize) -> f64| {
        let all = (0..rows * cols).map(|k| slowness(k / cols, k % cols)).collect();
        surface.with_slowness(all).unwrap()
    };
    let heights =
        || Surface::from_heights(rows, cols, vec![0.0; rows * cols], Spacing::square(1.0)).unwrap();
    let peaks = || Builtin::Peaks.surface(rows, cols).unwrap();
    for (name, surface, most) in [
        ("patches", slowed(heights(), &patches), 0.03),
        ("patches on peaks", slowed(peaks(), &patches), 0.08),
        ("wall", slowed(heights(), &wall), 3e-3),
        ("ridge", slowed(heights(), &ridge), 2e-3),
    ] {
        let sources = [PointSource::at(30.0, 11.0)];
        let [from_cpu, _, from_map] = compare(name, &surface, &sources, None);
        assert!(from_cpu < 3e-3 && from_map < most, "{name}: {from_cpu} {from_map}");
    }
}

/// The rows of a plane have steps of two lengths in turn, grow, or begin with half a step, as beside a pole at the
/// middle of a cell. The bounds are those of even grids.
#[test]
fn paths_over_uneven_rows_are_straight() {
    let (rows, cols) = (40, 60);
    for name in ["alternating", "growing", "half a step first"] {
        let step = |row: usize| match name {
            "alternating" => [1.0, 2.0][row % 2],
            "growing" => 1.05f64.powi(row as i32),
            _ if row == 0 => 0.5,
            _ => 1.0,
        };
        let y: Vec<f64> = (0..rows).map(|row| (0..row).map(step).sum()).collect();
        let place = |index: usize| DVec3::new((index % cols) as f64 * 0.4, y[index / cols], 0.0);
        let places: Vec<_> = (0..rows * cols).map(place).collect();
        let surface = Surface::from_positions(rows, cols, places.clone()).unwrap();
        let source = [7, 23];
        let from = places[source[0] * cols + source[1]];
        let exact: Vec<_> = places.iter().map(|at| at.distance(from)).collect();
        let sources = [PointSource::at(source[0] as f32, source[1] as f32)];
        let [from_cpu, from_exact, from_map] = compare(name, &surface, &sources, Some(&exact));
        assert!(from_cpu < 3e-4, "{name}: {from_cpu}");
        assert!(from_exact < 2e-3 && from_map < 2e-3, "{name}: {from_exact} {from_map}");
    }
}

/// One of the surfaces has holes, and some sources are between grid points and have different start values. The
/// bound is half of the bound for lengths. Measured: 5e-4 with holes, 1e-5 without. At ridges of the map, the
/// device and the CPU may choose different sides, and the map's distances differ by up to 5 % from the lengths
/// of the CPU's paths too.
#[test]
fn paths_on_rough_surfaces_are_those_of_the_cpu() {
    for (name, one_hole_in) in [("rough, with holes", 11), ("rough", 0)] {
        let surface = rough(61, 83, one_hole_in);
        let one = [PointSource::at(30.0, 41.0)];
        let several = [
            PointSource { time: 3.0, ..PointSource::at(30.0, 41.0) },
            PointSource { time: 5.0, ..PointSource::at(10.25, 70.5) },
            PointSource { time: 4.0, ..PointSource::at(55.0, 12.0) },
        ];
        for sources in [&one[..], &several] {
            let [from_cpu, ..] = compare(name, &surface, sources, None);
            assert!(from_cpu < 1e-3, "{name}: {from_cpu}");
        }
    }
}

/// Paths are within a tenth of a cell of great circles, as the CPU's paths are.
#[test]
fn paths_on_the_sphere_are_great_circles() {
    let surface = Builtin::Sphere.surface(129, 129).unwrap();
    let source = PointSource::at(38.0, 51.0);
    let mut scene = Scene::new(Kept::watched_but_for_shaders(), &surface, &[source]);
    let paths = new_paths(&mut scene, PathsInfo::new(200, 300));
    let starts = starts(129, 129, 200);
    let sources = SourceInput::Inline(&[source]);
    let (records, all) = read(&mut scene, &paths, StartInput::Inline(&starts), sources);
    let cell = 0.5 * std::f32::consts::PI / 128.0;
    for (number, record) in records.iter().enumerate() {
        let drawn = vertices(record, number, paths.curves(), &all);
        let ends = [drawn[0], drawn[drawn.len() - 1]].map(|v| Vec3::from(v.position).normalize());
        let axis = ends[0].cross(ends[1]).normalize();
        for vertex in drawn {
            let off = axis.dot(Vec3::from(vertex.position).normalize()).abs() / cell;
            assert!(off < 0.1, "{off} cells at {vertex:?}");
        }
    }
    end(scene, paths);
}

/// The layers check the shaders too.
#[test]
fn impossible_paths_give_a_reason() {
    // A column of holes cuts the surface in two.
    let mask: Vec<_> = (0..9 * 11).map(|i| i % 11 != 6).collect();
    let surface = flat(9, 11).with_mask(&mask).unwrap();
    let source = PointSource::at(2.0, 1.5);
    let mut scene = Scene::new(Kept::watched(), &surface, &[source]);
    let paths = new_paths(&mut scene, PathsInfo::new(12, 9));
    let stated =
        scene.stage.solver.bytes_for_paths(&scene.stage.host.device, PathsInfo::new(12, 9));
    assert_eq!(stated.unwrap(), paths.bytes());
    use CurveStatus::*;
    let expected = [
        ([2.0, 5.0], Complete),
        ([2.0, 1.5], Complete), // at the source
        ([8.0, 5.0], OutOfRoom),
        ([4.0, 9.0], Unreached),
        ([4.0, 6.0], Unreached), // in a hole
        ([4.5, 5.5], Unreached), // between a hole and the surface
        ([-0.1, 3.0], Outside),
        ([8.5, 3.0], Outside),
        ([f32::NAN, 3.0], Outside),
        ([0.0, f32::INFINITY], Outside),
    ];
    let starts = expected.map(|(start, _)| start);
    let sources = [source];
    let inline = SourceInput::Inline(&sources);
    let (records, all) = read(&mut scene, &paths, StartInput::Inline(&starts), inline);
    for (record, (start, status)) in records.iter().zip(expected) {
        assert_eq!(record.status(), status, "{start:?}: {record:?}");
        assert_eq!(record.vertex_count > 0, status == Complete);
    }
    // Two paths have no start.
    assert!(records[10..].iter().all(|record| record.status() == Outside));
    assert_eq!((records[1].vertices, records[1].length, records[1].source()), (1, 0.0, Some(0)));
    // The path that is out of room is there up to its last vertex, and leads towards the source.
    let way = vertices(&records[2], 2, paths.curves(), &all);
    assert_eq!((records[2].vertices, way.len()), (9, 9));
    assert!(way.windows(2).all(|pair| pair[1].time < pair[0].time), "{way:?}");

    // No path has a start.
    let (records, _) = read(&mut scene, &paths, StartInput::Inline(&[]), inline);
    assert!(records.iter().all(|record| record.status() == Outside));
    end(scene, paths);
}

/// The surfaces have steep random steps, holes, and cells up to 25 times as long as wide.
#[test]
fn every_path_falls_to_a_source() {
    let mut random = Random::new(5);
    let mut traced = 0;
    for _ in 0..8 {
        let [rows, cols] = [0; 2].map(|_| 2 + (20.0 * random.next()) as usize);
        let heights = (0..rows * cols).map(|_| 3.0 * random.next()).collect();
        let [dx, dy] = [0; 2].map(|_| 0.2 + 4.8 * random.next());
        let filled = 0.5 + 0.5 * random.next();
        let mask: Vec<_> = (0..rows * cols).map(|i| i == 0 || random.next() < filled).collect();
        let surface = Surface::from_heights(rows, cols, heights, Spacing { dx, dy }).unwrap();
        let surface = surface.with_mask(&mask).unwrap();
        let sources = [PointSource::at(0.0, 0.0)];
        let mut scene = Scene::new(Kept::unwatched(), &surface, &sources);
        let chart = surface.chart();
        let starts: Vec<_> = (0..chart.points())
            .map(|index| chart.position(index))
            .map(|(row, col)| [row as f32, col as f32])
            .collect();
        let info = PathsInfo::new(starts.len() as u32, 300);
        let paths = new_paths(&mut scene, info);
        let inline = SourceInput::Inline(&sources);
        let (records, _) = read(&mut scene, &paths, StartInput::Inline(&starts), inline);
        for (record, distance) in records.iter().zip(&scene.map.distances) {
            let reached = distance.is_finite();
            let expected = if reached { CurveStatus::Complete } else { CurveStatus::Unreached };
            assert_eq!(record.status(), expected, "{record:?}");
            if reached {
                assert_eq!(record.distance, *distance);
                traced += 1;
            }
        }
        end(scene, paths);
    }
    println!("{traced} paths");
    assert!(traced > 300, "{traced}");
}

/// All points of the first row coincide, so that no time falls along it. The CPU's path is 10 % too long.
/// The device's path tests all of the pole's points to find the one from which to leave.
#[test]
fn paths_cross_a_pole() {
    let (rows, cols) = (9, 24);
    let points = (0..rows * cols).map(|i| {
        let (polar, angle) = (0.1 * (i / cols) as f64, 0.25 * (i % cols) as f64);
        DVec3::new(polar * angle.cos(), polar * angle.sin(), 0.0)
    });
    let surface = Surface::from_positions(rows, cols, points.collect()).unwrap();
    let sources = [PointSource::at(6.0, 0.0)];
    let mut scene = Scene::new(Kept::watched(), &surface, &sources);
    let paths = new_paths(&mut scene, PathsInfo::new(2, 60));
    let starts = StartInput::Inline(&[[7.0, 13.0], [7.5, 10.25]]);
    let (records, _) = read(&mut scene, &paths, starts, SourceInput::Inline(&sources));
    for (record, exact) in records.iter().zip([1.3, 1.35]) {
        println!("{} of {exact}", record.length);
        assert_eq!(record.status(), CurveStatus::Complete, "{record:?}");
        assert!((record.length - exact).abs() < 0.1 * exact, "{record:?}");
    }
    end(scene, paths);
}
