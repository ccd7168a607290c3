//! Draws a band of rows of the picture, sample by sample.

use geosweep::glam::{Vec2, Vec3};

use super::super::canvas::{Color, mix};
use super::light::lit;
use super::mesh::Seen;

/// The number of samples per pixel along each side.
const SIDE: usize = 4;
/// The depth, in pixels, by which a stroke may lie behind the surface and still be visible. Its vertices are
/// on the surface, and the straight segments between them slightly off it.
const LIFT: f32 = 1.5;
/// The largest slope that counts, in pixels of depth per pixel. A steeper surface hides a part of a stroke,
/// up to half of its width.
const STEEPEST: f32 = 4.0;

/// The contents of the pixels of some rows.
pub struct Band {
    top: usize,
    width: usize,
    rows: usize,
    hits: Vec<Hit>,
    colors: Vec<Color>,
}

/// The nearest triangle at a sample.
#[derive(Clone, Copy)]
struct Hit {
    depth: f32,
    /// The change of depth per pixel in the picture.
    slope: f32,
    triangle: u32,
    /// The weights of the first two corners.
    weights: [f32; 2],
}

const NOTHING: Hit =
    Hit { depth: f32::NEG_INFINITY, slope: 0.0, triangle: u32::MAX, weights: [0.0; 2] };

impl Band {
    pub fn new(top: usize, width: usize, rows: usize) -> Self {
        let samples = rows * width * SIDE * SIDE;
        Self { top, width, rows, hits: vec![NOTHING; samples], colors: Vec::new() }
    }

    /// Converts a position in pixels to a position in samples, counted from the band's first sample.
    fn sample(&self, pixel: Vec2) -> Vec2 {
        (pixel - Vec2::new(0.0, self.top as f32) + 0.5) * SIDE as f32 - 0.5
    }

    /// Returns the ranges of columns and rows of the samples between two places.
    fn within(&self, low: Vec2, high: Vec2) -> [std::ops::Range<usize>; 2] {
        let range = |low: f32, high: f32, count: usize| {
            let end = (high.floor() + 1.0).clamp(0.0, count as f32) as usize;
            (low.ceil().max(0.0) as usize).min(end)..end
        };
        [range(low.x, high.x, self.width * SIDE), range(low.y, high.y, self.rows * SIDE)]
    }

    /// Draws a triangle where it is the nearest so far.
    pub fn cover(&mut self, seen: &Seen, index: usize) {
        let corners = seen.triangles[index].map(|corner| seen.places[corner as usize]);
        let [a, b, c] = corners.map(|corner| self.sample(corner.truncate()));
        let area = (b - a).perp_dot(c - a);
        let [columns, rows] = self.within(a.min(b).min(c), a.max(b).max(c));
        // The triangle is seen edge-on or has a missing corner.
        if area.is_nan() || area.abs() < 1e-9 {
            return;
        }
        let depths = corners.map(|corner| corner.z);
        let slope = slope(corners);
        for y in rows {
            for x in columns.clone() {
                let at = Vec2::new(x as f32, y as f32);
                let first = (c - b).perp_dot(at - b) / area;
                let second = (a - c).perp_dot(at - c) / area;
                let third = 1.0 - first - second;
                // The tolerance extends the triangle slightly, so that rounding leaves no gap between
                // neighbours.
                if first.min(second).min(third) < -1e-5 {
                    continue;
                }
                let depth = first * depths[0] + second * depths[1] + third * depths[2];
                let hit = &mut self.hits[y * self.width * SIDE + x];
                if depth > hit.depth {
                    *hit = Hit { depth, slope, triangle: index as u32, weights: [first, second] };
                }
            }
        }
    }

    /// Colours the samples by the triangles that they hit.
    pub fn shade(&mut self, seen: &Seen, background: Color) {
        let color = |hit: &Hit| {
            if hit.triangle == u32::MAX {
                return background;
            }
            let corners = seen.triangles[hit.triangle as usize].map(|corner| corner as usize);
            let [first, second] = hit.weights;
            let weights = [first, second, 1.0 - first - second];
            let mut normal = Vec3::ZERO;
            let mut color = [0.0; 3];
            for (corner, weight) in corners.into_iter().zip(weights) {
                normal += weight * seen.normals[corner];
                color = std::array::from_fn(|k| color[k] + weight * seen.colors[corner][k]);
            }
            // Both sides are lit in the same way. In the picture y points downwards, hence the sign.
            let [a, b, c] = corners.map(|corner| seen.places[corner].truncate());
            let faces_away = (b - a).perp_dot(c - a) > 0.0;
            lit(color, if faces_away { -normal } else { normal })
        };
        self.colors = self.hits.iter().map(color).collect();
    }

    /// Draws a polyline, given by pixels and depths, over what is behind it.
    pub fn stroke(&mut self, path: &[Vec3], radius: f32, color: Color) {
        let joints = [path.first(), path.last()].map(|end| end.copied());
        let single = joints[0].zip(joints[1]).filter(|_| path.len() == 1);
        let pieces = path.windows(2).map(|ends| (ends[0], ends[1]));
        for (from, to) in pieces.chain(single) {
            self.stroke_piece(from, to, radius, color);
        }
    }

    fn stroke_piece(&mut self, from: Vec3, to: Vec3, radius: f32, color: Color) {
        let (start, end) = (self.sample(from.truncate()), self.sample(to.truncate()));
        let reach = radius * SIDE as f32;
        let [columns, rows] = self.within(start.min(end) - reach, start.max(end) + reach);
        let along = end - start;
        let squared = along.length_squared().max(f32::MIN_POSITIVE);
        for y in rows {
            for x in columns.clone() {
                let at = Vec2::new(x as f32, y as f32);
                let t = ((at - start).dot(along) / squared).clamp(0.0, 1.0);
                if at.distance(start + along * t) > reach {
                    continue;
                }
                let index = y * self.width * SIDE + x;
                let hit = self.hits[index];
                let before = LIFT + radius * hit.slope.min(STEEPEST);
                if from.z + (to.z - from.z) * t + before >= hit.depth {
                    self.colors[index] = color;
                }
            }
        }
    }

    /// Averages the samples of each pixel.
    pub fn resolve(&self, pixels: &mut [Color]) {
        for (index, pixel) in pixels.iter_mut().enumerate() {
            let (x, y) = (index % self.width * SIDE, index / self.width * SIDE);
            let mut sum = [0.0; 3];
            for k in 0..SIDE * SIDE {
                let sample = self.colors[(y + k / SIDE) * self.width * SIDE + x + k % SIDE];
                sum = std::array::from_fn(|channel| sum[channel] + sample[channel]);
            }
            *pixel = mix([0.0; 3], sum, 1.0 / (SIDE * SIDE) as f32);
        }
    }
}

/// Returns the change of depth per pixel of the plane through three places.
fn slope([a, b, c]: [Vec3; 3]) -> f32 {
    let normal = (b - a).cross(c - a);
    (normal.truncate().length() / normal.z.abs().max(f32::MIN_POSITIVE)).min(1e6)
}
