//! Regions of the points nearest to each source, compared with the CPU's.

use geosweep::MetricTensor;
use geosweep::cpu::twins;
use geosweep::geometry::{NO_REGION, Voronoi};
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{Chart, Direction, EdgeLengths, Geometry, Seed};
use geosweep::vulkan::Schedule;
use geosweep::vulkan::embed::{
    Access, PointSource, Points, RegionFrame, Regions, SourceBuffer, SourceInput, SurfaceInfo,
};
use geosweep::{Sources, Surface, Wavefront};

use crate::common::closed::flat;
use crate::common::{Lent, Random, rough};
use crate::embed::stage::{
    Kept, RASTER, STOP, Stage, numbers_of, on_cpu, positions_of, sources_at as at,
};
use crate::host::HostBuffer;

/// A surface on the device, with maps of one wavefront.
pub struct Atlas {
    pub stage: Stage,
    pub regions: Regions,
    wavefront: Wavefront,
}

/// Labels, and the map from which they were found.
pub struct Found {
    labels: Vec<u32>,
    map: Vec<f32>,
}

impl Atlas {
    pub fn new(host: impl Into<Lent<Kept>>, surface: &Surface, wavefront: Wavefront) -> Self {
        let numbers = match surface.geometry() {
            Geometry::Metric(_) => numbers_of(surface),
            _ => positions_of(surface),
        };
        Self::of(Stage::on(host, &RASTER, (surface, None), numbers), wavefront)
    }

    /// Creates an atlas of the surface of a stage.
    pub fn of(mut stage: Stage, wavefront: Wavefront) -> Self {
        let device = stage.host.device.clone();
        let Stage { host, solver, surface, .. } = &mut stage;
        let regions = solver.regions(&device, host.allocator(), surface, wavefront).unwrap();
        let stated = solver.bytes_for_regions(&device, surface.chart()).unwrap();
        assert_eq!(regions.bytes(), stated);
        Self { stage, regions, wavefront }
    }

    pub fn find(&mut self, sources: SourceInput) -> Found {
        let plan = self.stage.plan(Schedule::Raster, self.wavefront, 6);
        let map = self.stage.map(0, sources, &plan);
        Found { labels: self.labels(sources), map }
    }

    /// Returns the labels of the current map.
    pub fn labels(&mut self, sources: SourceInput) -> Vec<u32> {
        let Stage { host, solver, surface, .. } = &mut self.stage;
        let (device, bytes) = (host.device.clone(), self.regions.labels().bytes);
        let copy = host.buffer(bytes, true);
        host.run(|commands| {
            let recording = solver.record(&device, commands, surface);
            recording.begin(Access::NONE);
            let frame = RegionFrame::new(sources, Access::TRANSFER_READ);
            let labels = recording.regions(&self.regions, &frame).unwrap();
            assert_eq!(labels, self.regions.labels());
            host.copy_buffer(commands, labels.buffer, &copy, bytes);
        });
        let labels = copy.bytes()[..bytes as usize].chunks_exact(4);
        let labels = labels.map(|label| u32::from_ne_bytes(label.try_into().unwrap())).collect();
        host.free(copy);
        labels
    }

    pub fn end(self) {
        self.end_with([]);
    }

    fn end_with(self, buffers: impl IntoIterator<Item = HostBuffer>) {
        let Self { mut stage, mut regions, .. } = self;
        let device = stage.host.device.clone();
        regions.destroy(&device, stage.host.allocator());
        regions.destroy(&device, stage.host.allocator());
        stage.end(buffers);
    }
}

/// Returns the number of labels in `found` that differ from `others`. Also returns the largest distance, in points,
/// from such a label to the nearest equal label in `others`. A border in `others` lies within this distance.
fn off(chart: Chart, found: &[u32], others: &[u32]) -> (usize, usize) {
    let far = |index: usize| {
        let (row, col) = chart.position(index);
        let is_there = |away: &usize| {
            let rows = row.saturating_sub(*away)..=(row + away).min(chart.rows - 1);
            let cols = || col.saturating_sub(*away)..=(col + away).min(chart.cols - 1);
            let mut around = rows.flat_map(|row| cols().map(move |col| chart.index(row, col)));
            around.any(|other| others[other] == found[index])
        };
        (1..chart.rows.max(chart.cols)).find(is_there).unwrap_or(usize::MAX)
    };
    let differ: Vec<usize> = (0..chart.points()).filter(|&i| found[i] != others[i]).collect();
    (differ.len(), differ.into_iter().map(far).max().unwrap_or(0))
}

/// Returns the number of labels in `found` that differ from `others` on a glued surface. Also returns the largest
/// distance from such a label to the nearest equal label in `others`, in steps from point to neighbour. Copies of a
/// point are no step apart.
pub fn off_places(surface: &Surface, found: &[u32], others: &[u32]) -> (usize, usize) {
    let chart = surface.chart();
    let groups: Vec<&[u32]> = surface.copies().unwrap().iter().collect();
    let copies = |index: usize| {
        let group = groups.iter().find(|group| group.contains(&(index as u32)));
        group.map_or_else(|| vec![index], |group| group.iter().map(|&copy| copy as usize).collect())
    };
    let far = |index: usize| {
        let mut around: std::collections::BTreeSet<usize> = copies(index).into_iter().collect();
        for away in 0..chart.rows.max(chart.cols) {
            if around.iter().any(|&other| others[other] == found[index]) {
                return away;
            }
            let beside = around.iter().flat_map(|&index| {
                let (row, col) = chart.position(index);
                Direction::ALL.into_iter().filter_map(move |to| chart.neighbour(row, col, to))
            });
            let beside: Vec<_> = beside.collect();
            around.extend(beside.into_iter().flat_map(|(row, col)| copies(chart.index(row, col))));
        }
        usize::MAX
    };
    let differ: Vec<usize> = (0..chart.points()).filter(|&i| found[i] != others[i]).collect();
    (differ.len(), differ.into_iter().map(far).max().unwrap_or(0))
}

/// Returns the labels that the twin finds on its own map.
pub fn of_twin(surface: &Surface, sources: &[PointSource], wavefront: Wavefront) -> Vec<u32> {
    let seeds = |(source, label): (&PointSource, u32)| {
        let seeds = on_cpu(&[*source]).seeds(surface).unwrap();
        let is_point = seeds.len() == 1;
        let given = if source.curvature == PointSource::STRAIGHT { 0.0 } else { Seed::AT_SOURCE };
        let curvature = |seed: Seed| if is_point { given } else { seed.curvature };
        seeds
            .into_iter()
            .map(move |seed| (Seed { curvature: curvature(seed), ..seed }, label))
            .collect::<Vec<_>>()
    };
    let seeds: Vec<_> = sources.iter().zip(0..).flat_map(seeds).collect();
    twins::regions(&EdgeLengths::new(surface).unwrap(), &seeds, wavefront, STOP)
}

/// Compares labels with those of the twin and of [`Voronoi`] on the same map.
fn compare(
    name: &str,
    atlas: &mut Atlas,
    surface: &Surface,
    sources: &[PointSource],
    within: usize,
) -> Found {
    let chart = surface.chart();
    let found = atlas.find(SourceInput::Inline(sources));
    // A second recording gives the same labels.
    assert_eq!(atlas.labels(SourceInput::Inline(sources)), found.labels, "{name}");
    let twin = off(chart, &found.labels, &of_twin(surface, sources, atlas.wavefront));
    let edges = EdgeLengths::new(surface).unwrap();
    let exact = Voronoi::new(surface, &edges, &on_cpu(sources), &found.map).unwrap();
    for (label, time) in found.labels.iter().zip(&found.map) {
        assert_eq!(*label == NO_REGION, *time == f32::INFINITY, "{name}");
    }
    let exact = off(chart, &found.labels, &exact.labels);
    println!("{name}, {}: {twin:?} off the twin, {exact:?} off the CPU", atlas.wavefront);
    assert!(twin.1 <= 1 && twin.0 <= chart.points() / TWIN_MAY_DIFFER, "{name}: {twin:?}");
    assert!(exact.1 <= within, "{name}: {exact:?}");
    found
}

/// Number of points among which one label may differ from the twin's. The point of such a label lies beside a
/// border, where rounding decides.
const TWIN_MAY_DIFFER: usize = 500;

#[test]
fn labels_are_those_of_the_cpu_but_beside_borders() {
    let random = |count: usize, chart: Chart, seed: u64| {
        let mut random = Random::new(seed);
        let mut up_to = |last: usize| (random.next() * last as f64) as f32;
        let place = |_| [up_to(chart.rows - 1), up_to(chart.cols - 1)];
        at(&(0..count).map(place).collect::<Vec<_>>())
    };
    let surfaces = [
        ("plane", flat(65, 81)),
        ("sphere", Builtin::Sphere.surface(65, 65).unwrap()),
        ("peaks", Builtin::Peaks.surface(77, 65).unwrap()),
        ("sheared plane", Builtin::ShearedPlane { degrees: 50.0 }.surface(65, 49).unwrap()),
    ];
    for (name, surface) in &surfaces {
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let host = Kept::watched_but_for_shaders();
            let mut atlas = Atlas::new(host, surface, wavefront);
            // Straight fronts from points bend paths near the sources.
            let within = if wavefront == Wavefront::Planar { 4 } else { 2 };
            let two = at(&[[15.0, 17.0], [47.0, 37.0]]);
            compare(&format!("{name}, two"), &mut atlas, surface, &two, within);
            let close = at(&[[30.0, 30.0], [32.0, 34.0]]);
            compare(&format!("{name}, four apart"), &mut atlas, surface, &close, within + 1);
            let mut later = at(&[[10.5, 12.25], [40.0, 30.75]]);
            later[0].time = 0.1 * surface_extent(surface);
            compare(&format!("{name}, one later"), &mut atlas, surface, &later, within);
            let many = random(24, surface.chart(), 7);
            compare(&format!("{name}, many"), &mut atlas, surface, &many, within);
            atlas.end();
        }
    }
}

fn surface_extent(surface: &Surface) -> f32 {
    (positions_of(surface).1)
        .into_iter()
        .filter(|x| x.is_finite())
        .fold(0.0, |a: f32, x| a.max(x.abs()))
}

/// The layers check the shaders too.
#[test]
fn walls_holes_and_narrow_grids_have_regions() {
    let cut = {
        let mask: Vec<_> = (0..31 * 41).map(|i| i % 41 != 30).collect();
        flat(31, 41).with_mask(&mask).unwrap()
    };
    let cases = [
        ("maze", Builtin::Maze.surface(61, 61).unwrap(), at(&[[0.0, 0.0], [30.0, 30.0]])),
        ("rough, with holes", rough(61, 83, 11), at(&[[30.0, 41.0], [5.0, 70.0], [50.5, 9.5]])),
        ("cut in two", cut, at(&[[10.0, 12.0], [20.0, 20.0]])),
    ];
    for (name, surface, sources) in cases {
        let mut atlas = Atlas::new(Kept::watched(), &surface, Wavefront::Curved);
        let found = compare(name, &mut atlas, &surface, &sources, 2);
        for label in (0..sources.len() as u32).chain([NO_REGION]) {
            assert!(found.labels.contains(&label), "{name}");
        }
        atlas.end();
    }
    for (rows, cols) in [(1, 9), (9, 1), (2, 2), (2, 19), (19, 2), (3, 130), (35, 66)] {
        let surface = flat(rows, cols);
        let last = [rows - 1, cols - 1].map(|last| last as f32);
        let mut atlas = Atlas::new(Kept::watched(), &surface, Wavefront::Curved);
        let sources = at(&[[0.0, 0.0], last]);
        compare(&format!("{rows} x {cols}"), &mut atlas, &surface, &sources, 1);
        atlas.end();
    }
}

/// The surface has no positions, and lengths are longer along the diagonals of one direction.
#[test]
fn a_metric_has_regions() {
    let chart = Chart { rows: 41, cols: 53 };
    let tensor = |index: usize| {
        let (row, col) = chart.position(index);
        let wave = (0.2 * row as f64).sin() * (0.15 * col as f64).cos();
        MetricTensor { rr: 1.5 + 0.3 * wave, rc: 0.4, cc: 1.0 }
    };
    let metric = (0..chart.points()).map(tensor).collect();
    let surface = Surface::from_metric(chart.rows, chart.cols, metric).unwrap();
    let mut atlas = Atlas::new(Kept::watched(), &surface, Wavefront::Curved);
    let sources = at(&[[10.0, 12.0], [33.25, 40.5], [5.0, 45.0]]);
    compare("metric", &mut atlas, &surface, &sources, 2);
    atlas.end();
}

#[test]
fn labels_are_places_in_the_list() {
    let mut mask = vec![true; 33 * 41];
    mask[5 * 41 + 7] = false;
    let surface = flat(33, 41).with_mask(&mask).unwrap();
    let late = PointSource { time: 100.0, ..PointSource::at(16.0, 16.0) };
    let [first, second] = [PointSource::at(16.0, 10.25), PointSource::at(20.0, 30.0)];
    let nowhere = PointSource { row: f32::NAN, ..first };
    // A source in the hole, one at no place, one that is too late, and one that is listed twice.
    let list = [PointSource::at(5.0, 7.0), second, nowhere, first, late, second, first];
    let mut host = Kept::watched();
    let points = host.buffer_of(&positions_of(&surface).1);
    let listed = host.buffer_of(bytemuck::cast_slice(&list));
    let inputs = [Points::positions(points.handle, 12)];
    let count = list.len() as u32;
    let sources = [SourceBuffer { buffer: listed.handle, offset: 0, count }];
    let info = SurfaceInfo::new(surface.chart()).with_points(&inputs).with_sources(&sources);
    let mut atlas = Atlas::of(Stage::new(host, &RASTER, &info), Wavefront::Curved);
    let found = atlas.find(SourceInput::Buffer(0));
    let edges = EdgeLengths::new(&surface).unwrap();
    let of_two = Voronoi::new(&surface, &edges, &on_cpu(&[second, first]), &found.map).unwrap();
    let number = |&label: &u32| if label == NO_REGION { label } else { 2 * label + 1 };
    let expected: Vec<u32> = of_two.labels.iter().map(number).collect();
    let (count, away) = off(surface.chart(), &found.labels, &expected);
    assert!(away <= 1, "{count} up to {away} away");

    let pair = at(&[[16.0, 30.0], [16.0, 11.0]]);
    let found = atlas.find(SourceInput::Inline(&pair));
    // Without sources, there is no map and no region.
    let nothing = atlas.find(SourceInput::Inline(&[]));
    assert!(nothing.labels.iter().all(|&label| label == NO_REGION));

    // A source that is added gets its region.
    let plan = atlas.stage.plan(Schedule::Raster, Wavefront::Curved, 6);
    atlas.stage.map(0, SourceInput::Inline(&pair[..1]), &plan);
    atlas.stage.add(SourceInput::Inline(&pair[1..]), &plan);
    let added = atlas.labels(SourceInput::Inline(&pair));
    assert_eq!(off(surface.chart(), &added, &found.labels), (0, 0));
    atlas.end_with([points, listed]);
}

/// A curve is a list of points on the grid, and a table names the curve of each point.
#[test]
fn curves_of_many_sources_have_the_regions_of_curves() {
    let surface = Builtin::Peaks.surface(65, 73).unwrap();
    let lines =
        [[[10.0, 8.0], [10.0, 40.0]], [[30.0, 55.0], [58.0, 55.0]], [[50.0, 9.0], [50.0, 30.0]]];
    let mut sources = Vec::new();
    let mut whose = Vec::new();
    for (number, [from, to]) in (0..).zip(lines) {
        let steps = (to[0] - from[0] + to[1] - from[1]) as usize;
        for step in 0..=steps {
            let share = step as f32 / steps as f32;
            let [row, col] = [0, 1].map(|k: usize| from[k] + share * (to[k] - from[k]));
            let is_end = step == 0 || step == steps;
            let curvature = if is_end { 0.0 } else { PointSource::STRAIGHT };
            sources.push(PointSource { curvature, ..PointSource::at(row.round(), col.round()) });
            whose.push(number);
        }
    }
    let curves = lines.iter().fold(Sources::default(), |all, line| {
        all.and_curve(line.map(|place| place.map(f64::from)), 0.0)
    });
    let edges = EdgeLengths::new(&surface).unwrap();
    for wavefront in [Wavefront::Planar, Wavefront::Curved] {
        let host = Kept::watched_but_for_shaders();
        let mut atlas = Atlas::new(host, &surface, wavefront);
        let found = atlas.find(SourceInput::Inline(&sources));
        let labels: Vec<u32> = found.labels.iter().map(|&label| whose[label as usize]).collect();
        let exact = Voronoi::new(&surface, &edges, &curves, &found.map).unwrap();
        let (count, away) = off(surface.chart(), &labels, &exact.labels);
        println!("curves, {wavefront}: {count} points, up to {away} away");
        assert!(away <= 2, "{wavefront}: {count} up to {away} away");
        atlas.end();
    }
}

/// A few points around a close pair of sources decide all labels behind it. A border there is turned about the
/// pair, and all wrong labels are between the border and its exact place. Measured: angles of 17.5 and 4.8
/// degrees, and no wrong label more than a cell from the border if both sources are grid points.
#[test]
fn borders_behind_close_pairs_turn_by_a_bounded_angle() {
    let chart = Chart { rows: 97, cols: 97 };
    let surface = flat(chart.rows, chart.cols);
    let edges = EdgeLengths::new(&surface).unwrap();
    let host = Kept::watched_but_for_shaders();
    let mut atlas = Atlas::new(host, &surface, Wavefront::Curved);
    // A pair, and the largest angle in degrees.
    for ([a, b], most) in [
        ([[48.2, 48.3], [48.7, 48.8]], 20.0),
        ([[48.25, 48.5], [49.5, 49.25]], 6.0),
        ([[48.0, 48.0], [48.0, 49.0]], 1.0),
        ([[48.0, 48.0], [49.0, 50.0]], 1.0),
        ([[48.0, 48.0], [49.0, 51.0]], 1.0),
    ] {
        let sources = at(&[a, b]);
        let found = atlas.find(SourceInput::Inline(&sources));
        let exact = Voronoi::new(&surface, &edges, &on_cpu(&sources), &found.map).unwrap();
        let middle = [0, 1].map(|k| 0.5 * (a[k] + b[k]));
        let across = [b[0] - a[0], b[1] - a[1]];
        let mut largest = 0.0f32;
        for index in (0..chart.points()).filter(|&i| found.labels[i] != exact.labels[i]) {
            let (row, col) = chart.position(index);
            let to = [row as f32 - middle[0], col as f32 - middle[1]];
            // Angles do not matter for a point within a cell of the border.
            let off = (to[0] * across[0] + to[1] * across[1]) / across[0].hypot(across[1]);
            if off.abs() > 1.0 {
                largest = largest.max((off.abs() / to[0].hypot(to[1])).asin().to_degrees());
            }
        }
        println!("{a:?} and {b:?}: {largest:.1} degrees");
        assert!(largest <= most, "{a:?} and {b:?}: {largest} degrees");
        assert!(found.labels.contains(&0) && found.labels.contains(&1));
    }
    atlas.end();
}
