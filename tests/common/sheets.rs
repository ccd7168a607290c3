//! Sheets that unroll into a plane, and neighbouring sources on them, with their exact distances.

use geosweep::glam::{DVec2, DVec3};
use geosweep::{Sources, Surface};

use super::Random;

/// An even grid in the plane, or rolled into a part of a cylinder, and its sources.
pub struct Sheet {
    pub name: String,
    pub surface: Surface,
    pub sources: Sources,
    /// Length of the longer side of a cell.
    pub cell: f64,
    /// Exact distances, row by row.
    pub exact: Vec<f64>,
}

/// Kind of sources on a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Two sources at neighbouring grid points.
    Pair,
    /// Up to six sources at grid points, within some cells.
    Cluster,
    /// All grid points of a row.
    Row,
    /// A straight line from one border to the other.
    Across,
    /// A polyline of up to four segments.
    Polyline,
}

impl Kind {
    pub const ALL: [Self; 5] = [Self::Pair, Self::Cluster, Self::Row, Self::Across, Self::Polyline];
}

impl Sheet {
    /// Returns a sheet of 5 to 27 points per side. Cells are up to four times as long as wide and sheared by
    /// up to one and a half cells. `rolled` sheets are up to 20 degrees of a cylinder.
    pub fn new(number: u64, kind: Kind, rolled: bool) -> Self {
        let mut random = Random::new(number);
        let mut between = |low: f64, high: f64| low + (high - low) * random.next();
        let (rows, cols) = (between(5.0, 28.0) as usize, between(5.0, 28.0) as usize);
        let long = if between(0.0, 1.0) < 0.5 { between(1.0, 4.0) } else { 1.0 };
        let shear = if between(0.0, 1.0) < 0.5 { between(-1.5, 1.5) } else { 0.0 };
        let [down, right] = if between(0.0, 1.0) < 0.5 {
            [DVec2::new(shear * long, 1.0), DVec2::new(long, 0.0)]
        } else {
            [DVec2::new(0.0, long), DVec2::new(1.0, shear)]
        };
        let unrolled = |at: DVec2| at.x * down + at.y * right;
        let turn = DVec2::from_angle(between(0.0, 6.3));
        let last = DVec2::new(rows as f64 - 1.0, cols as f64 - 1.0);
        let extent =
            unrolled(DVec2::new(last.x, 0.0)).length() + unrolled(DVec2::new(0.0, last.y)).length();
        let radius = extent / 20f64.to_radians();
        let place = |at: DVec2| {
            let flat = turn.rotate(unrolled(at));
            let (across, along) = (flat.x / radius, flat.y);
            match rolled {
                true => DVec3::new(radius * across.sin(), along, radius * (1.0 - across.cos())),
                false => DVec3::new(flat.x, along, 0.0),
            }
        };
        let places = |rows: usize, cols: usize| {
            (0..rows * cols)
                .map(move |index| DVec2::new((index / cols) as f64, (index % cols) as f64))
        };
        let positions = places(rows, cols).map(place).collect();
        let surface = Surface::from_positions(rows, cols, positions).unwrap();

        let mut at_point = || DVec2::new(between(0.0, last.x), between(0.0, last.y)).round();
        let mut segments: Vec<[DVec2; 2]> = Vec::new();
        let mut sources = Sources::default();
        match kind {
            Kind::Pair | Kind::Cluster => {
                let first = at_point();
                segments.push([first; 2]);
                let count = if kind == Kind::Pair { 1 } else { 1 + (number % 5) as usize };
                let reach = if kind == Kind::Pair { 1.0 } else { 2.0 };
                while segments.len() <= count {
                    let apart =
                        (at_point() - at_point()).clamp(DVec2::splat(-reach), DVec2::splat(reach));
                    let other = (first + apart).clamp(DVec2::ZERO, last);
                    if segments.iter().all(|segment| segment[0] != other) {
                        segments.push([other; 2]);
                    }
                }
            }
            Kind::Row => {
                let row = at_point().x;
                segments.extend((0..cols).map(|col| [DVec2::new(row, col as f64); 2]));
            }
            Kind::Across => {
                let row = between(0.0, last.x);
                segments.push([DVec2::new(row, 0.0), DVec2::new(row, last.y)]);
            }
            Kind::Polyline => {
                let mut vertex = || DVec2::new(between(0.0, last.x), between(0.0, last.y));
                let mut vertices = vec![vertex(), vertex()];
                while vertices.len() < 2 + (number % 4) as usize {
                    // A polyline that turns little beside a short segment would count as part of a smooth
                    // curve.
                    let [.., a, b] = vertices[..] else { unreachable!() };
                    let next = vertex();
                    let [into, out] = [unrolled(b - a), unrolled(next - b)];
                    if into.angle_to(out).abs() > 0.6 {
                        vertices.push(next);
                    }
                }
                segments.extend(vertices.windows(2).map(|ends| [ends[0], ends[1]]));
            }
        }
        if matches!(kind, Kind::Across | Kind::Polyline) {
            let vertices =
                segments.iter().map(|ends| ends[0]).chain(segments.last().map(|ends| ends[1]));
            sources = sources.and_curve(vertices.map(|at| at.to_array()), 0.0);
        } else {
            for [at, _] in &segments {
                sources = sources.and_point(at.x, at.y, 0.0);
            }
        }
        let segments: Vec<_> = segments.iter().map(|ends| ends.map(unrolled)).collect();
        let exact = places(rows, cols)
            .map(|at| {
                segments.iter().map(|ends| distance(unrolled(at), *ends)).fold(f64::MAX, f64::min)
            })
            .collect();
        let name =
            format!("sheet {number}, {kind:?}, {rows} x {cols}, rolled: {rolled}, {down} {right}");
        Self { name, surface, sources, cell: down.length().max(right.length()), exact }
    }
}

/// Returns the distance from a place to a straight segment.
fn distance(at: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    let along = b - a;
    let square = along.length_squared();
    let foot = if square > 0.0 { ((at - a).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    at.distance(a + foot * along)
}
