//! Finds the borders between Voronoi regions by marching triangles.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::fronts::Fronts;
use super::known::NO_REGION;
use crate::Curve;
use crate::chains::{Segment, join};
use geosweep_surface::{Cell, Edge, triangles};

/// A border between two regions.
#[derive(Clone, Debug, PartialEq)]
pub struct Border {
    /// The regions on the left and on the right of the border, as seen in a picture of the grid with rows
    /// downwards. The smaller number comes first.
    pub regions: [u32; 2],
    /// The curve of the border.
    pub curve: Curve,
}

/// A triangle that several regions share, and the fraction of its area that each region has.
#[derive(Clone, Debug)]
pub(super) struct Split {
    pub points: [usize; 3],
    /// The labels and their fractions. A region may appear twice.
    pub parts: [(u32, f64); 3],
}

/// The largest number of edges between a triangle and the place where its three regions meet.
const FARTHEST: usize = 4;

/// The place where the three regions of a triangle meet.
#[derive(Clone, Copy)]
struct Junction {
    place: DVec2,
    /// The edge of the triangle beyond which the place lies. Its ends are in two of the regions; the third
    /// region extends across this edge.
    beyond: Option<[usize; 2]>,
}

/// A triangle whose corners have several labels.
struct Mixed<'a, 'b> {
    fronts: &'a Fronts<'b>,
    points: [usize; 3],
    labels: [u32; 3],
    /// The node number of the triangle's junction, if it has one.
    junction: u64,
}

/// Returns the borders and the triangles that several regions share.
pub(super) fn march(fronts: &Fronts, labels: &[u32]) -> (Vec<Border>, Vec<Split>) {
    let chart = fronts.chart();
    // Junctions are numbered after all edges, two for each cell.
    let junctions = Edge::end(chart);
    let of_cell = |cell: Cell| {
        let corners = cell.indices(chart);
        let found = corners.map(|index| labels[index]);
        let of_triangle = move |(number, triangle): (usize, &[usize; 3])| Mixed {
            fronts,
            points: triangle.map(|corner| corners[corner]),
            labels: triangle.map(|corner| found[corner]),
            junction: junctions + 2 * corners[0] as u64 + number as u64,
        };
        let triangles = triangles(found.map(|label| label != NO_REGION), true);
        triangles.iter().enumerate().map(of_triangle)
    };
    let of_row = |row: usize| {
        let mut mixed = Vec::new();
        for cell in chart.cells_of_row(row) {
            let found = cell.indices(chart).map(|index| labels[index]);
            if found != [found[0]; 4] {
                mixed.extend(of_cell(cell).filter(Mixed::is_mixed));
            }
        }
        mixed
    };
    let rows = chart.rows_of_cells().into_par_iter();
    let mixed: Vec<Mixed> = rows.flat_map_iter(of_row).collect();
    let segments = mixed.par_iter().flat_map_iter(Mixed::segments).collect();
    // Returns the triangle on the other side of an edge of a triangle.
    let across = |points: [usize; 3], edge: [usize; 2]| {
        let [a, b] = edge.map(|point| chart.position(point));
        let is_across = |other: &Mixed| {
            edge.iter().all(|point| other.points.contains(point)) && other.points != points
        };
        chart.cells_between(a, b).flat_map(of_cell).find(is_across)
    };
    // Returns the edges between a triangle and the place where its regions meet. Returns `None` if that place
    // is not on the course of the border between two of the regions.
    let passed = |triangle: &Mixed, Junction { place, beyond }: Junction| {
        let (mut points, mut edge, mut passed) = (triangle.points, beyond?, Vec::new());
        for _ in 0..FARTHEST {
            let other = across(points, edge).filter(|other| !other.has_junction())?;
            passed.push(Edge::between(chart, edge[0], edge[1]).number());
            if other.contains(place) {
                return Some(passed);
            }
            (points, edge) = (other.points, other.exit(edge)?);
        }
        None
    };
    // The nodes that lie at places where three regions meet.
    let mut places: HashMap<u64, DVec2> = HashMap::new();
    for triangle in mixed.iter().filter(|triangle| triangle.has_junction()) {
        let junction = triangle.junction();
        let (place, passed) = match passed(triangle, junction) {
            Some(passed) => (junction.place, passed),
            None => (triangle.junction_place(), Vec::new()),
        };
        places.extend(passed.into_iter().chain([triangle.junction]).map(|node| (node, place)));
    }
    let curves = join(segments, |regions, node| {
        if let Some(place) = places.get(&node) {
            return place.to_array();
        }
        edge_place(fronts, labels, Edge::from_number(node), regions).to_array()
    });
    let borders = curves.into_iter().map(|(regions, curve)| Border { regions, curve });
    (borders.collect(), mixed.par_iter().map(Mixed::split).collect())
}

/// Returns the place where a border crosses an edge.
fn edge_place(fronts: &Fronts, labels: &[u32], edge: Edge, regions: [u32; 2]) -> DVec2 {
    let chart = fronts.chart();
    let ((row, col), to) = edge.ends(chart);
    let points = edge.points(chart);
    let [a, b] = regions;
    let regions = if labels[points[0]] == a { [a, b] } else { [b, a] };
    DVec2::new(row as f64, col as f64) + fronts.meeting(points, regions) * to.vector()
}

impl Mixed<'_, '_> {
    fn is_mixed(&self) -> bool {
        let [a, b, c] = self.labels;
        a != b || b != c
    }

    fn has_junction(&self) -> bool {
        let [a, b, c] = self.labels;
        a != b && b != c && c != a
    }

    /// Returns the edge between the two regions of the triangle that is not the edge `entry`.
    fn exit(&self, entry: [usize; 2]) -> Option<[usize; 2]> {
        let edge = |k: usize| [k, (k + 1) % 3];
        let is_exit = |[a, b]: &[usize; 2]| {
            let is_entry = [a, b].iter().all(|end| entry.contains(&self.points[**end]));
            self.labels[*a] != self.labels[*b] && !is_entry
        };
        let exit = (0..3).map(edge).find(is_exit)?;
        Some(exit.map(|corner| self.points[corner]))
    }

    /// Returns the edges of the triangle between two regions, counter-clockwise, with the labels at their
    /// start and end.
    fn crossed(&self) -> impl Iterator<Item = (Edge, [u32; 2])> {
        (0..3).filter_map(|k| {
            let (first, last) = (k, (k + 1) % 3);
            let labels = [self.labels[first], self.labels[last]];
            let edge = Edge::between(self.fronts.chart(), self.points[first], self.points[last]);
            (labels[0] != labels[1]).then_some((edge, labels))
        })
    }

    /// Returns the border segments in the triangle. Each has the region with the smaller number on its left:
    /// it begins where the boundary of the triangle leaves that region.
    fn segments(&self) -> Vec<Segment<[u32; 2]>> {
        let crossed: Vec<_> =
            self.crossed().map(|(edge, labels)| (edge.number(), labels)).collect();
        if self.has_junction() {
            let to_junction = |&(edge, [a, b]): &(u64, [u32; 2])| {
                let (from, to) = if a < b { (edge, self.junction) } else { (self.junction, edge) };
                Segment { key: [a.min(b), a.max(b)], from, to }
            };
            return crossed.iter().map(to_junction).collect();
        }
        let [(first, [a, b]), (second, _)] = crossed[..] else { return Vec::new() };
        let (from, to) = if a < b { (first, second) } else { (second, first) };
        vec![Segment { key: [a.min(b), a.max(b)], from, to }]
    }

    /// Returns the place where three wavefronts arrive at once. The differences of their squared times are interpolated
    /// linearly between the corners, and extrapolated beyond them.
    fn junction(&self) -> Junction {
        let weights = self.junction_weights();
        let outside: Vec<usize> = (0..3).filter(|&k| weights[k] < 0.0).collect();
        let beyond = match outside[..] {
            [k] => Some([self.points[(k + 1) % 3], self.points[(k + 2) % 3]]),
            _ => None,
        };
        Junction { place: (0..3).map(|k| weights[k] * self.place(k)).sum(), beyond }
    }

    /// Returns the junction if it lies in the triangle, and otherwise a place on the triangle's boundary near
    /// it.
    fn junction_place(&self) -> DVec2 {
        // The junction lies outside if one region extends between the corners of the other two.
        let weights = self.junction_weights().max(DVec3::ZERO);
        let weights = weights / weights.element_sum();
        (0..3).map(|k| weights[k] * self.place(k)).sum()
    }

    /// Returns the barycentric coordinates of the junction. They are equal where the wavefronts are not
    /// known.
    fn junction_weights(&self) -> DVec3 {
        let squares = self.labels.map(|label| {
            let at = |k: usize| self.fronts.squared(self.points[k], label);
            Some(DVec3::new(at(0)?, at(1)?, at(2)?))
        });
        let weights = match squares {
            [Some(a), Some(b), Some(c)] => (b - a).cross(c - a),
            _ => DVec3::ONE,
        };
        let weights = weights / weights.element_sum();
        if weights.is_finite() { weights } else { DVec3::splat(1.0 / 3.0) }
    }

    fn contains(&self, place: DVec2) -> bool {
        let corners = [0, 1, 2].map(|k| self.place(k));
        let sign = signed_area(&corners);
        (0..3).all(|k| sign * signed_area(&[corners[k], corners[(k + 1) % 3], place]) >= 0.0)
    }

    fn place(&self, k: usize) -> DVec2 {
        let (row, col) = self.fronts.chart().position(self.points[k]);
        DVec2::new(row as f64, col as f64)
    }

    fn split(&self) -> Split {
        let cut = |j: usize, k: usize| {
            let (points, labels) = ([j, k].map(|k| self.points[k]), [j, k].map(|k| self.labels[k]));
            let share = self.fronts.meeting(points, labels);
            self.place(j).lerp(self.place(k), share)
        };
        let whole = signed_area(&[0, 1, 2].map(|k| self.place(k)));
        let part = |polygon: &[DVec2]| signed_area(polygon) / whole;
        let parts = if self.has_junction() {
            let junction = self.junction_place();
            let of_corner = |k: usize| {
                let [next, previous] = [(k + 1) % 3, (k + 2) % 3];
                let polygon = [self.place(k), cut(k, next), junction, cut(k, previous)];
                (self.labels[k], part(&polygon))
            };
            [0, 1, 2].map(of_corner)
        } else {
            // The corner whose label differs from the two others.
            let alone = (0..3).find(|k| self.labels[(k + 1) % 3] == self.labels[(k + 2) % 3]);
            let k = alone.unwrap_or(0);
            let [next, previous] = [(k + 1) % 3, (k + 2) % 3];
            let part = part(&[self.place(k), cut(k, next), cut(k, previous)]);
            [(self.labels[k], part), (self.labels[next], 1.0 - part), (self.labels[previous], 0.0)]
        };
        Split { points: self.points, parts }
    }
}

/// Returns twice the signed area of a polygon, by the shoelace formula.
fn signed_area(places: &[DVec2]) -> f64 {
    let next = places.iter().cycle().skip(1);
    places.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum()
}
