//! Labels points by the nearest source. The twin of `glsl/passes/region_*.comp`, and of `glsl/passes/share_starts.comp`.

use super::scan::scan;
use crate::behind::TriangleSlots;
use crate::fronts::{TriangleFronts, TriangleKind, for_triangle_kind};
use crate::points::PointFronts;
use geosweep_surface::Stop;
use geosweep_surface::constants::{FLOW_JUMPS, NEAR_PLACES, PARENT_JUMPS};
use geosweep_surface::update::{Setting, StoredFront, Wavefront, base_crossing};
use geosweep_surface::{Chart, Direction, EdgeLengths, Groups, Real, Seed};

/// A column and a row.
type Place = [f32; 2];

/// Arrival time of a seed's own front, and its label, at a point that has a seed.
type Start = Option<(f32, u32)>;

/// Current knowledge of a point's region.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Link {
    Label(u32),
    /// Index of an earlier point, whose label applies if the path ends without a label.
    Parent(usize),
    /// No front arrives.
    Nothing,
}

/// Returns for each grid point, in row-major order, the label of the seed from which its front has come. The
/// label is [`u32::MAX`] where no front arrives.
pub fn regions(
    edges: &EdgeLengths<f32>,
    seeds: &[(Seed, u32)],
    wavefront: Wavefront,
    stop: Stop,
) -> Vec<u32> {
    let wavefront = wavefront.or_curved(Setting::of_device(false));
    for_triangle_kind!(edges, wavefront, kind => solve(edges, kind, seeds, wavefront, stop))
}

fn solve<K: TriangleKind<f32>>(
    edges: &EdgeLengths<f32>,
    kind: K,
    seeds: &[(Seed, u32)],
    wavefront: Wavefront,
    stop: Stop,
) -> Vec<u32> {
    let chart = edges.chart();
    let all: Vec<Seed> = seeds.iter().map(|(seed, _)| *seed).collect();
    let mut fronts = PointFronts::start(edges, kind, &all);
    scan(&mut fronts, &all, stop, false);
    let copies = copies(edges);
    let mut starts = starts(chart, seeds);
    share_starts(&copies, &mut starts);
    let mut first_copies: Vec<usize> = (0..chart.points()).collect();
    for group in &copies {
        group.iter().for_each(|&copy| first_copies[copy] = group[0]);
    }
    let triangles = Direction::ALL.map(|to| TriangleSlots::new(chart, to, to.next()));
    let begin =
        |index| begin(chart, &fronts, &triangles, wavefront, (&starts, &first_copies), index);
    let mut ways: Vec<(f32, Link, Place)> = (0..chart.points()).map(begin).collect();
    share_ways(&copies, &mut ways);
    let (mut links, mut places): (Vec<Link>, Vec<Place>) =
        ways.into_iter().map(|(_, link, place)| (link, place)).unzip();
    for _ in 0..rounds(chart, FLOW_JUMPS) {
        let flow = |index| flow(chart, &links, &places, index);
        (links, places) = (0..chart.points()).map(flow).unzip();
    }
    for _ in 0..rounds(chart, PARENT_JUMPS) {
        links = (0..chart.points()).map(|index| jump(&links, index)).collect();
    }
    let label = |link| if let Link::Label(label) = link { label } else { u32::MAX };
    links.into_iter().map(label).collect()
}

/// Returns the number of passes after which paths extend over as many points as the grid has. Each pass lengthens a
/// path by a factor of `jumps` + 1.
fn rounds(chart: Chart, jumps: u32) -> u32 {
    let (mut rounds, mut reach) = (1, u64::from(jumps) + 1);
    while reach < chart.points() as u64 {
        (rounds, reach) = (rounds + 1, reach * (u64::from(jumps) + 1));
    }
    rounds
}

/// Returns the earliest seed of each point, and the smallest label among equally early ones.
fn starts(chart: Chart, seeds: &[(Seed, u32)]) -> Vec<Start> {
    let mut starts: Vec<Start> = vec![None; chart.points()];
    for (seed, label) in seeds {
        let start = (seed.time as f32, *label);
        let first = starts[chart.index(seed.row, seed.col)].get_or_insert(start);
        if start.0 < first.0 || (start.0 == first.0 && start.1 < first.1) {
            *first = start;
        }
    }
    starts
}

/// Returns the row-major indices of the copies of each point that has copies.
fn copies(edges: &EdgeLengths<f32>) -> Vec<Vec<usize>> {
    let chart = edges.chart();
    let index = |&point: &u32| chart.index_of(point as usize);
    let groups = edges.copies().into_iter().flat_map(Groups::iter);
    groups.map(|group| group.iter().map(index).collect()).collect()
}

/// Gives all copies of a point the earliest of their starts.
fn share_starts(copies: &[Vec<usize>], starts: &mut [Start]) {
    for group in copies {
        let of_group = group.iter().filter_map(|&copy| starts[copy]);
        let first = of_group.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        group.iter().for_each(|&copy| starts[copy] = first);
    }
}

/// Gives all copies of a point the path of the copy that a front reaches first.
fn share_ways(copies: &[Vec<usize>], ways: &mut [(f32, Link, Place)]) {
    for group in copies {
        let of_group = group.iter().map(|&copy| ways[copy]);
        let first = of_group.min_by(|a, b| a.0.total_cmp(&b.0)).expect("groups have members");
        group.iter().for_each(|&copy| ways[copy] = first);
    }
}

/// Returns the arrival time of the front at a point, the link of the point, and the position at which its path crosses
/// the base of its triangle.
fn begin<K: TriangleKind<f32>>(
    chart: Chart,
    fronts: &PointFronts<f32, K>,
    triangles: &[TriangleSlots; 8],
    wavefront: Wavefront,
    (starts, first_copies): (&[Start], &[usize]),
    index: usize,
) -> (f32, Link, Place) {
    let (row, col) = chart.position(index);
    let own = [col as f32, row as f32];
    let point = chart.bordered(row, col);
    let here = fronts.time(point);
    if here >= f32::FAR {
        return (f32::FAR, Link::Nothing, own);
    }
    let first_copy = |point: usize| first_copies[chart.index_of(point)];
    // Paths lead only to earlier points, so there are no cycles. Copies of a point count as one point, although their
    // times may differ by rounding.
    let own_copy = first_copies[index];
    let earlier = |other: usize| {
        let time = fronts.time(other);
        let is_before = time < here || (time == here && first_copy(other) < own_copy);
        let is_before = is_before && first_copy(other) != own_copy;
        StoredFront { time: if is_before { time } else { f32::FAR }, ..fronts.at(other) }
    };
    let mut first = (f32::FAR, 0);
    for (number, triangle) in triangles.iter().enumerate() {
        let time = K::Carried::time(fronts.kind.through(&fronts.edges, point, triangle, earlier));
        if time < first.0 {
            first = (time, number);
        }
    }
    if let Some((time, label)) = starts[index]
        && time <= first.0
    {
        return (time, Link::Label(label), own);
    }
    if first.0 >= f32::FAR {
        return (f32::FAR, Link::Nothing, own);
    }
    let to = Direction::ALL[first.1];
    let ends = triangles[first.1].corners(point).map(earlier);
    let times = ends.map(|front| front.time);
    let triangle = triangles[first.1].triangle(&fronts.edges, point, times);
    let share = base_crossing(wavefront, triangle, ends.map(K::Carried::curvature));
    let step = |to: Direction| [to.step().1 as f32, to.step().0 as f32];
    let (a, b) = (step(to), step(to.next()));
    let place = [0, 1].map(|k| own[k] + (a[k] + share * (b[k] - a[k])));
    let nearer = if share > 0.5 { to.next() } else { to };
    let (row, col) = chart.neighbour(row, col, nearer).expect("fronts come from the grid");
    (first.0, Link::Parent(chart.index(row, col)), place)
}

/// Extends a path by the paths of other points.
fn flow(chart: Chart, links: &[Link], places: &[Place], index: usize) -> (Link, Place) {
    let (mut link, mut place) = (links[index], places[index]);
    for _ in 0..FLOW_JUMPS {
        if !matches!(link, Link::Parent(_)) {
            break;
        }
        match step(chart, links, places, place) {
            Some(Ok(on)) => place = on,
            Some(Err(label)) => link = Link::Label(label),
            None => break,
        }
    }
    (link, place)
}

/// Returns the next position of a path, or the label there, or `None` if the path ends without a label.
fn step(
    chart: Chart,
    links: &[Link],
    places: &[Place],
    place: Place,
) -> Option<Result<Place, u32>> {
    let first = place.map(f32::floor);
    let [u, v] = [place[0] - first[0], place[1] - first[1]];
    let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
    let corner = |k: usize| {
        let index = chart.index(first[1] as usize + k / 2, first[0] as usize + k % 2);
        (weights[k], index)
    };
    let corners = (0..4).filter(|&k| weights[k] > 0.0).map(corner);
    let corners: Vec<_> = corners.filter(|&(_, index)| links[index] != Link::Nothing).collect();
    let mut heaviest = (0.0, 0);
    for &(weight, index) in &corners {
        if weight > heaviest.0 {
            heaviest = (weight, index);
        }
    }
    if heaviest.0 == 0.0 {
        return None;
    }
    if let Link::Label(label) = links[heaviest.1] {
        return Some(Err(label));
    }
    let on = places[heaviest.1];
    let (mut off, mut sum) = ([0.0; 2], 0.0);
    for &(weight, index) in &corners {
        if !matches!(links[index], Link::Parent(_)) {
            continue;
        }
        let apart = [places[index][0] - on[0], places[index][1] - on[1]];
        if apart[0].abs().max(apart[1].abs()) <= NEAR_PLACES as f32 {
            sum += weight;
            off = [off[0] + weight * apart[0], off[1] + weight * apart[1]];
        }
    }
    let last = [chart.last().1, chart.last().0];
    Some(Ok([0, 1].map(|k| (on[k] + off[k] / sum).clamp(0.0, last[k] as f32))))
}

/// Returns the label of a point's first ancestor that has one, for points whose paths end without a label.
fn jump(links: &[Link], index: usize) -> Link {
    let mut link = links[index];
    for _ in 0..PARENT_JUMPS {
        match link {
            Link::Parent(parent) => link = links[parent],
            _ => break,
        }
    }
    link
}
