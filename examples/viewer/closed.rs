//! Closed surfaces of the viewer: built-in ones, which float and can be seen from all sides.

use std::f32::consts::FRAC_PI_2;
use std::str::FromStr;

use geosweep::Surface;
use geosweep::glam::{Vec3, Vec4};
use geosweep::io::checked_points;
use geosweep::surface::builtin::Closed;
use geosweep::surface::{Chart, Direction, Gluing, Groups, Run};

use crate::Result;
use crate::camera::Camera;
use crate::mesh;
use crate::surfaces::{Look, Model};

/// A closed built-in surface of some size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClosedSurface {
    pub closed: Closed,
    chart: Chart,
}

/// Distance between lines, in radii of the surface.
const SPACING: f32 = 0.1;
/// First source, in fractions of the grid's height and width. It lies beside the seam that the camera shows.
const SOURCE: [f32; 2] = [0.35, 0.06];

impl ClosedSurface {
    /// Returns all closed surfaces in usual sizes.
    pub fn all() -> impl Iterator<Item = Self> {
        Closed::ALL.into_iter().map(|closed| {
            let (rows, cols) = match closed {
                Closed::MoebiusStrip => (49, 361),
                Closed::OctahedralSphere | Closed::EqualAreaSphere => (257, 257),
                Closed::CubeSphere => (201, 302),
                _ => (181, 361),
            };
            Self { closed, chart: Chart { rows, cols } }
        })
    }

    /// Samples the surface. Its middle is at the origin of the world, and its z axis is the vertical.
    pub fn load(self) -> Result<Model> {
        let Self { closed, chart } = self;
        let surface = closed.surface(chart.rows, chart.cols)?;
        let copies = surface.copies().ok_or("a closed surface has copies of points")?;
        let positions = positions(&surface);
        let triangles = mesh::triangles(chart, |index| !positions[index as usize].is_nan());
        let normals = mesh::normals(&positions, &triangles, copies);
        let away = positions.iter().map(|position| position.truncate().length());
        let radius = away.fold(0.0, f32::max);
        let [row, col] = SOURCE;
        let look = Look {
            name: closed.name(),
            chart,
            ground: None,
            spacing: SPACING * radius,
            deforms: false,
            source: [
                (row * (chart.rows - 1) as f32).round(),
                (col * (chart.cols - 1) as f32).round(),
            ],
            camera: Camera {
                turn: -1.2,
                pitch: 0.4,
                lowest: 0.01 - FRAC_PI_2,
                ..Camera::around(radius)
            },
        };
        // A point of a closed surface sees all of the sky.
        let normals = normals.into_iter().map(|normal| normal.extend(1.0)).collect();
        let gluing = Some(gluing(chart, &positions, copies)?);
        Ok(Model { look, positions, normals, triangles, gluing })
    }
}

impl FromStr for ClosedSurface {
    type Err = String;

    /// Parses `NAME:ROWSxCOLS`.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let form =
            || format!("\"{text}\" is not of the form NAME:ROWSxCOLS, such as globe:181x361");
        let (name, size) = text.rsplit_once(':').ok_or_else(form)?;
        let (rows, cols) = size.split_once('x').ok_or_else(form)?;
        let number = |text: &str| text.parse().map_err(|_| form());
        let (rows, cols) = (number(rows)?, number(cols)?);
        let closed = Closed::parse(name).ok_or_else(|| {
            format!("no closed surface is called \"{name}\"; there are {}", Closed::names())
        })?;
        checked_points(rows, cols)?;
        Ok(Self { closed, chart: Chart { rows, cols } })
    }
}

/// Returns the points around the origin, with y upwards. The seam between the last column and the first one is in the
/// west.
fn positions(surface: &Surface) -> Vec<Vec4> {
    let chart = surface.chart();
    let points: Vec<Vec3> = (0..chart.points())
        .map(|index| {
            let (row, col) = chart.position(index);
            let place = surface.position(row, col).filter(|_| surface.has(row, col));
            place.map_or(Vec3::NAN, |at| at.as_vec3())
        })
        .map(|at| Vec3::new(-at.x, at.z, at.y))
        .collect();
    let there = || points.iter().filter(|point| !point.is_nan());
    let low = there().copied().fold(Vec3::MAX, Vec3::min);
    let high = there().copied().fold(Vec3::MIN, Vec3::max);
    points.iter().map(|&point| (point - 0.5 * (low + high)).extend(1.0)).collect()
}

/// Returns the gluing with the given copies: the grid's seams if they are enough, otherwise pairs of points. A surface
/// in frames is created before its positions are known, so it cannot find by itself which points coincide.
fn gluing(chart: Chart, positions: &[Vec4], copies: &Groups) -> Result<Gluing> {
    let points = positions.iter().map(|point| point.truncate().as_dvec3()).collect();
    let open = Surface::from_positions(chart.rows, chart.cols, points)?;
    let seams = Gluing::Seams(open.seams());
    if open.with_gluing(seams.clone()).is_ok_and(|glued| glued.copies() == Some(copies)) {
        return Ok(seams);
    }
    let point =
        |index: u32| Run { from: chart.position(index as usize), to: Direction::East, points: 1 };
    let pairs = copies
        .iter()
        .flat_map(|group| group[1..].iter().map(|&other| [point(group[0]), point(other)]));
    Ok(Gluing::Runs(pairs.collect()))
}
