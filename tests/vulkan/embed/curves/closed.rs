//! Paths, regions and directions over seams in the host's frames, compared with the CPU's on the same map.

use geosweep::geometry::{BackDirections, NO_REGION, PathTracer, Voronoi};
use geosweep::surface::{Direction, EdgeLengths, Geometry, Gluing, Run};
use geosweep::vulkan::Schedule;
use geosweep::vulkan::embed::{
    CurveStatus, CurveVertex, PathsInfo, PointSource, SourceInput, StartInput,
};
use geosweep::{Surface, Wavefront};

use super::paths::{new_paths, read};
use super::regions::{Atlas, of_twin, off_places};
use super::{Scene, map_of, vertices};
use crate::common::Random;
use crate::common::closed::*;
use crate::embed::closed::stage_on;
use crate::embed::stage::{Kept, RASTER, on_cpu, sources_at};

/// Iterations after which maps of these surfaces no longer change.
const ITERATIONS: u32 = 12;

/// Returns closed surfaces with their gluings and two sources each, most of which lie on or beside seams.
fn surfaces() -> Vec<(&'static str, Surface, Gluing, Vec<PointSource>)> {
    let at = sources_at;
    let moebius = flat(31, 65).with_gluing(Gluing::flipped_columns()).unwrap();
    let flat_torus = flat(29, 41).with_gluing(Gluing::both()).unwrap();
    let faces = cube(15);
    // Frames have no positions on the host that would tell which charts meet.
    let run = |index: u32| {
        let from = faces.chart().position(index as usize);
        Run { from, to: Direction::East, points: 1 }
    };
    let pairs = faces.copies().unwrap().iter().flat_map(|group| {
        group[1..].iter().map(|&other| [run(group[0]), run(other)]).collect::<Vec<_>>()
    });
    let by_runs = Gluing::Runs(pairs.collect());
    vec![
        ("cube", faces, by_runs, at(&[[0.0, 7.0], [22.0, 20.5]])),
        ("tube", tube(33, 49), Gluing::columns(), at(&[[12.0, 48.0], [25.0, 20.5]])),
        ("torus", torus(33, 50), Gluing::both(), at(&[[0.0, 30.25], [17.5, 1.0]])),
        ("flat torus", flat_torus, Gluing::both(), at(&[[28.0, 0.0], [11.0, 23.0]])),
        ("Moebius strip", moebius, Gluing::flipped_columns(), at(&[[5.0, 62.0], [20.0, 30.0]])),
        ("globe", globe(41, 81), Gluing::globe(), at(&[[12.0, 2.0], [30.0, 50.0]])),
        ("globe from a pole", globe(41, 81), Gluing::globe(), at(&[[0.0, 17.0], [28.5, 80.0]])),
        ("octahedral map", octahedral(24), Gluing::Octahedral, at(&[[0.0, 7.0], [30.0, 20.0]])),
        ("octahedral map, middle", octahedral(24), Gluing::Octahedral, at(&[[0.25, 23.0]])),
    ]
}

fn scene(surface: &Surface, gluing: &Gluing, sources: &[PointSource]) -> Scene {
    let stage = stage_on(surface, gluing, Kept::watched(), &RASTER);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, ITERATIONS).over_seams();
    let map = stage.map(0, SourceInput::Inline(sources), &plan);
    Scene { stage, map: map_of(surface.chart(), map) }
}

/// Returns how often a path continues at a copy of its place, and checks that the copy is the same place.
fn crossings(name: &str, drawn: &[CurveVertex]) -> usize {
    let is_jump = |pair: &&[CurveVertex]| {
        let [a, b] = [pair[0], pair[1]];
        (a.row - b.row).abs().max((a.col - b.col).abs()) > 1.001
    };
    let jumps: Vec<_> = drawn.windows(2).filter(is_jump).collect();
    for pair in &jumps {
        let [a, b] = [pair[0], pair[1]].map(|vertex| geosweep::glam::Vec3::from(vertex.position));
        let apart = a.distance(b) / a.abs().max_element().max(1.0);
        assert!(apart < 1e-5, "{name}: {pair:?}");
    }
    jumps.len()
}

/// Single precision rounds by up to 3e-4 of a cell beside grid lines, as on open surfaces.
#[test]
fn paths_pass_seams() {
    const PATHS: usize = 250;
    for (name, surface, gluing, sources) in surfaces() {
        let mut scene = scene(&surface, &gluing, &sources);
        let chart = surface.chart();
        let is_flat = !matches!(surface.geometry(), Geometry::Positions(_));
        let room = PathsInfo::new(PATHS as u32, 4 * (chart.rows + chart.cols) as u32);
        let mut paths = new_paths(&mut scene, room);
        let mut random = Random::new(5);
        let mut place = || {
            let mut up_to = |count: usize| (random.next() * (count - 1) as f64) as f32;
            [up_to(chart.rows), up_to(chart.cols)]
        };
        let starts: Vec<[f32; 2]> = (0..PATHS)
            .map(|number| if number % 2 == 0 { place().map(f32::round) } else { place() })
            .collect();
        let given = SourceInput::Inline(&sources);
        let (records, all) = read(&mut scene, &paths, StartInput::Inline(&starts), given);
        let edges = EdgeLengths::new(&surface).unwrap();
        let exact = PathTracer::new(&surface, &edges, &on_cpu(&sources), &scene.map.distances);
        let on_cpu = exact.unwrap().along_the_map();
        let least = 0.05 * scene.map.report.max_distance;
        // Over coarse grids, paths are shorter than arcs, on the CPU by as much as on the device.
        let (mut from_cpu, mut seams, mut from_map) = (Vec::new(), 0, [0.0f64; 2]);
        for (number, (record, start)) in records.iter().zip(&starts).enumerate() {
            let Ok(expected) = on_cpu.trace(start.map(f64::from)) else {
                // The start is among the holes between faces.
                assert_eq!(record.status(), CurveStatus::Unreached, "{name} from {start:?}");
                continue;
            };
            let drawn = vertices(record, number, paths.curves(), &all);
            assert_eq!(record.status(), CurveStatus::Complete, "{name} from {start:?}");
            let (first, last) = (&drawn[0], &drawn[drawn.len() - 1]);
            let source = sources[record.source().unwrap() as usize];
            assert_eq!([first.row, first.col], *start);
            assert_eq!([last.row, last.col, last.time], [source.row, source.col, source.time]);
            // Heights in a frame have rows and columns as positions, which jump at seams.
            seams += if is_flat { 0 } else { crossings(name, drawn) };
            let length = f64::from(record.length);
            from_cpu.push((length - expected.length).abs() / expected.length.max(least));
            let distance = f64::from(record.distance);
            for (most, length) in from_map.iter_mut().zip([length, expected.length]) {
                *most = most.max((length - distance).abs() / distance.max(least));
            }
        }
        from_cpu.sort_by(f64::total_cmp);
        let count = from_cpu.len();
        assert!(count > PATHS * 2 / 3, "{name}: {count}");
        let [most, whole] = [count * 98 / 100, count - 1].map(|rank| from_cpu[rank]);
        println!(
            "{name}: {most:.1e} {whole:.1e} from the CPU's, {from_map:.4?} from the map; {seams} crossings"
        );
        // Cells beside a corner of the octahedron are far from parallelograms, and precisions differ there.
        let [usual, longer] = if name.contains("middle") { [1e-3, 2e-2] } else { [3e-4, 1e-3] };
        let is_short = from_map[0] < from_map[1] + longer;
        assert!(most < usual && is_short, "{name}: {most:e} {from_map:?}");
        assert!(is_flat || seams > 20, "{name}: {seams}");
        scene.end_with(|device, allocator| paths.destroy(device, allocator));
    }
}

/// Labels differ from those of the CPU only at points that are within two cells of a border, or within four cells with
/// planar fronts.
#[test]
fn regions_pass_seams() {
    for (name, surface, gluing, sources) in surfaces() {
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let passes = [(Schedule::Raster, wavefront)];
            let stage = stage_on(&surface, &gluing, Kept::watched(), &passes);
            let mut atlas = Atlas::of(stage, wavefront);
            let plan = atlas.stage.plan(Schedule::Raster, wavefront, ITERATIONS).over_seams();
            let map = atlas.stage.map(0, SourceInput::Inline(&sources), &plan);
            let labels = atlas.labels(SourceInput::Inline(&sources));
            assert_eq!(atlas.labels(SourceInput::Inline(&sources)), labels, "{name}");
            for group in surface.copies().unwrap().iter() {
                let first = labels[group[0] as usize];
                assert!(group.iter().all(|&copy| labels[copy as usize] == first), "{name}");
            }
            for (label, time) in labels.iter().zip(&map) {
                assert_eq!(*label == NO_REGION, *time == f32::INFINITY, "{name}");
            }
            let edges = EdgeLengths::new(&surface).unwrap();
            let exact = Voronoi::new(&surface, &edges, &on_cpu(&sources), &map).unwrap();
            let exact = off_places(&surface, &labels, &exact.labels);
            let twin = of_twin(&surface, &sources, wavefront);
            let twin = off_places(&surface, &labels, &twin);
            println!("{name}, {wavefront}: {twin:?} off the twin, {exact:?} off the CPU");
            let within = if wavefront == Wavefront::Planar { 4 } else { 2 };
            assert!(exact.1 <= within, "{name}, {wavefront}: {exact:?}");
            assert!(
                twin.1 <= 1 && twin.0 <= surface.chart().points() / 300,
                "{name}, {wavefront}: {twin:?}"
            );
            atlas.end();
        }
    }
}

/// Directions are those of the CPU except at poles, where shaders look only at the cells around the copy itself.
#[test]
fn directions_pass_seams() {
    for (name, surface, gluing, sources) in surfaces() {
        let mut scene = scene(&surface, &gluing, &sources);
        let mut directions = scene.new_directions();
        let field = scene.directions(&directions, SourceInput::Inline(&sources));
        let edges = EdgeLengths::new(&surface).unwrap();
        let exact = BackDirections::new(&surface, &edges, &on_cpu(&sources), &scene.map.distances);
        let exact = exact.unwrap().in_chart();
        let groups: Vec<&[u32]> = surface.copies().unwrap().iter().collect();
        // Sum, number and largest of the angles, at points of seams and at other points.
        let mut found = [[0.0f64; 3]; 2];
        for (index, (way, exact)) in field.ways.iter().zip(&exact).enumerate() {
            let group = groups.iter().find(|group| group.contains(&(index as u32)));
            let is_pole = group.is_some_and(|group| group.len() > 8);
            if is_pole || *exact == [0.0; 2] || exact[0].is_nan() {
                continue;
            }
            let [row, col] = exact.map(f64::from);
            let [x, y] = way.map(f64::from);
            let angle = (x * row - y * col).atan2(x * col + y * row).abs();
            let of = &mut found[usize::from(group.is_none())];
            *of = [of[0] + angle, of[1] + 1.0, of[2].max(angle)];
        }
        let [seams, others] = found.map(|[sum, count, most]| (sum / count.max(1.0), most));
        println!("{name}: {seams:.4?} on seams, {others:.4?} elsewhere");
        // At folds and at edges of a cube, a direction is that of the path's first line, which is accurate to first
        // order in the size of the cells.
        assert!(seams.0 < 3.0 * others.0 + 0.04, "{name}: {seams:?} {others:?}");
        scene.end_with(|device, allocator| directions.destroy(device, allocator));
    }
}
