//! Agents that step along the image of directions, as examples/horde.rs does on the device: they arrive, on ways
//! that are nearly the shortest.

use geosweep::Surface;
use geosweep::glam::{DVec2, DVec3};
use geosweep::surface::Geometry;
use geosweep::surface::builtin::Builtin;
use geosweep::vulkan::embed::{PointSource, SourceInput};

use super::Scene;
use super::directions::Field;
use crate::embed::stage::Kept;

/// The length of a step in the grid. Where a way turns at a corner, an agent goes up to a step too far.
const STEP: f64 = 0.1;
/// The distance from the source, in cells, at which agents have arrived. Nearer to the source, texels do not show the
/// way.
const ARRIVED: f64 = 1.0;

/// A surface, its directions, and the source of the map; places are rows and columns.
struct Ground<'a> {
    surface: &'a Surface,
    field: &'a Field,
    source: DVec2,
}

impl Ground<'_> {
    /// Returns the corners of the cell around a place with their weights: bilinear ones, or those of the triangle
    /// that is left if one corner is a hole. A weight below zero means that the place is beyond that triangle.
    fn corners(&self, place: DVec2) -> Vec<([usize; 2], f64)> {
        let low = place.floor().min(self.last() - 1.0);
        let part = place - low;
        let (row, col) = (low.x as usize, low.y as usize);
        let along = |k: usize, part: f64| if k == 0 { 1.0 - part } else { part };
        let corners = [[0, 0], [0, 1], [1, 0], [1, 1]];
        let has = |[i, j]: [usize; 2]| self.surface.has(row + i, col + j);
        let mut holes = corners.into_iter().filter(|&corner| !has(corner));
        let weighed: [_; 4] = match (holes.next(), holes.next()) {
            (Some([i, j]), None) => {
                // Coordinates that count from the hole. At each of the hole's two neighbours, one of them is 0.
                let [u, v] = [along(1 - i, part.x), along(1 - j, part.y)];
                [
                    ([1 - i, j], 1.0 - v),
                    ([i, 1 - j], 1.0 - u),
                    ([1 - i, 1 - j], u + v - 1.0),
                    ([i, j], 0.0),
                ]
            }
            _ => corners.map(|[i, j]| ([i, j], along(i, part.x) * along(j, part.y))),
        };
        weighed.into_iter().map(|([i, j], weight)| ([row + i, col + j], weight)).collect()
    }

    /// Returns the last row and column.
    fn last(&self) -> DVec2 {
        let chart = self.surface.chart();
        DVec2::new(chart.rows as f64 - 1.0, chart.cols as f64 - 1.0)
    }

    /// Returns whether a place is on the surface.
    fn is_open(&self, place: DVec2) -> bool {
        place.cmpge(DVec2::ZERO).all()
            && place.cmple(self.last()).all()
            && self.corners(place).iter().all(|&([row, col], weight)| {
                weight == 0.0 || weight > 0.0 && self.surface.has(row, col)
            })
    }

    /// Returns the position in space.
    fn position(&self, place: DVec2) -> DVec3 {
        let at = |[row, col]: [usize; 2]| {
            let index = self.surface.chart().index(row, col);
            match self.surface.geometry() {
                Geometry::Positions(points) => points[index],
                Geometry::Heights { heights, spacing, .. } => {
                    DVec3::new(col as f64 * spacing.dx, row as f64 * spacing.dy, heights[index])
                }
                Geometry::Metric(_) => panic!("the surface has positions"),
            }
        };
        let weighed = self.corners(place).into_iter().filter(|&(_, weight)| weight > 0.0);
        weighed.map(|(corner, weight)| weight * at(corner)).sum()
    }

    /// Returns the direction at a place: the interpolated one, or the nearest texel's where ways lead apart.
    fn heading(&self, place: DVec2) -> DVec2 {
        let way = |[row, col]: [usize; 2]| {
            let [cols, rows] = self.field.ways[self.surface.chart().index(row, col)];
            DVec2::new(rows.into(), cols.into())
        };
        let corners = self.corners(place);
        let mean: DVec2 = corners.iter().map(|&(at, weight)| weight * way(at)).sum();
        if mean.length() > 0.5 {
            return mean.normalize();
        }
        let nearest = corners.iter().max_by(|(_, a), (_, b)| a.total_cmp(b)).unwrap();
        way(nearest.0)
    }

    /// Returns the place after a step. At a wall, an agent slides along it: along the grid or a diagonal.
    fn step(&self, place: DVec2) -> DVec2 {
        let by = STEP * self.heading(place);
        let mut steps = [DVec2::X, DVec2::Y, DVec2::ONE, DVec2::new(1.0, -1.0)].map(|axis| {
            let axis = axis.normalize();
            by.dot(axis) * axis
        });
        steps.sort_by(|a, b| b.length().total_cmp(&a.length()));
        let open = [by].into_iter().chain(steps).map(|by| place + by).find(|&at| self.is_open(at));
        open.unwrap_or(place)
    }

    /// Returns the length of an agent's way to the source; `None` if it does not arrive.
    fn walk(&self, start: DVec2) -> Option<f64> {
        let (mut place, mut length) = (start, 0.0);
        let chart = self.surface.chart();
        for _ in 0..20 * chart.points() {
            if place.distance(self.source) <= ARRIVED {
                return Some(length + self.position(place).distance(self.position(self.source)));
            }
            let next = self.step(place);
            length += self.position(place).distance(self.position(next));
            place = next;
        }
        None
    }
}

/// Returns the largest ratio of an agent's way to the distance. An agent starts at every seventh point, unless that is
/// nearer to the source than ten cells.
fn longest_way(name: &str, builtin: Builtin, [rows, cols]: [usize; 2], at: [f32; 2]) -> f64 {
    let surface = builtin.surface(rows, cols).unwrap();
    let sources = [PointSource::at(at[0], at[1])];
    let mut scene = Scene::new(Kept::watched_but_for_shaders(), &surface, &sources);
    let directions = scene.new_directions();
    let field = scene.directions(&directions, SourceInput::Inline(&sources));
    let source = DVec2::new(at[0].into(), at[1].into());
    let ground = Ground { surface: &surface, field: &field, source };
    let exact = builtin.exact_distances(rows, cols, at.map(f64::from));
    let (mut longest, mut worst) = (0.0f64, DVec2::ZERO);
    for index in (0..rows * cols).step_by(7) {
        let distance = f64::from(scene.map.distances[index]);
        let (row, col) = surface.chart().position(index);
        let start = DVec2::new(row as f64, col as f64);
        if distance.is_infinite() || start.distance(source) < 10.0 {
            continue;
        }
        let walked = ground.walk(start);
        let walked = walked.unwrap_or_else(|| panic!("{name}: the agent at {start} is lost"));
        let ratio = walked / exact.as_ref().map_or(distance, |exact| exact[index]);
        if ratio > longest {
            (longest, worst) = (ratio, start);
        }
    }
    println!("{name}: ways are at most {longest:.5} times as long, from {worst}");
    scene.end_with(directions);
    longest
}

#[test]
fn agents_arrive_on_ways_that_are_nearly_the_shortest() {
    let cases = [
        ("plane", Builtin::Plane, [65, 81], [20.0, 30.0]),
        ("plane, between points", Builtin::Plane, [65, 81], [20.25, 30.75]),
        ("sheared", Builtin::ShearedPlane { degrees: 50.0 }, [65, 49], [20.0, 30.5]),
        ("sphere", Builtin::Sphere, [97, 97], [30.0, 40.0]),
        ("peaks", Builtin::Peaks, [129, 129], [64.0, 64.0]),
        ("maze", Builtin::Maze, [101, 101], [50.0, 50.0]),
    ];
    for (name, builtin, size, source) in cases {
        let longest = longest_way(name, builtin, size, source);
        let most = match builtin {
            // Ways meet at small angles. A direction interpolated between two ways is neither of them, and a few
            // agents follow such directions for some steps.
            Builtin::Peaks => 1e-2,
            // Agents go up to a step too far at a corner, which counts on short ways.
            Builtin::Maze => 4e-3,
            _ => 1e-3,
        };
        assert!(longest < 1.0 + most, "{name}: {longest}");
    }
}
