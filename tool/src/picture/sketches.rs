//! Draws the subject of the computation: a grid on a surface, and the update of a point from a triangle.

use geosweep::glam::{DVec2, DVec3, Vec2};

use super::canvas::{Canvas, Color};
use super::colors::{INK, PAPER};
use super::gallery::{Tile, tiled};
use super::text::Pen;

/// The width of a panel, in pixels. `HEIGHT` is its height.
const WIDTH: usize = 640;
const HEIGHT: usize = 520;
/// The number of grid lines in each direction.
const LINES: usize = 8;
/// The row and column of the grid point that is drawn with its triangle.
const POINT: [usize; 2] = [4, 3];
const ACCENT: Color = [0.86, 0.37, 0.2];
const FILL: Color = [0.73, 0.85, 0.92];
const FRONT: Color = [0.2, 0.5, 0.7];
const PALE: Color = [0.72, 0.72, 0.72];

/// Draws the grid, the surface over it, and the update: the subject of the paper's figures 1 and 2.
pub fn update_figure() -> Canvas {
    let tile = |title: &str, picture| Tile { title: title.into(), heading: false, picture };
    tiled(&[vec![
        tile("the grid of parameters", grid(in_domain)),
        tile("the same grid on the surface", grid(on_surface)),
        tile("a straight front comes through a triangle", triangle()),
    ]])
}

/// Returns where a place of the grid lies in the first panel. Places run from 0 to 1, rightwards and
/// downwards.
fn in_domain(at: DVec2) -> Vec2 {
    (DVec2::new(120.0, 60.0) + 400.0 * at).as_vec2()
}

/// Returns where a place lies on a hill in the second panel, seen from above at an angle.
fn on_surface(at: DVec2) -> Vec2 {
    let hill = (-6.0 * (at - DVec2::new(0.5, 0.45)).length_squared()).exp();
    let (right, away) = (at.x - 0.5, 0.5 - at.y);
    let point = DVec3::new(right + 0.45 * away, away, 0.42 * hill - 0.12 * right);
    (DVec2::new(310.0, 300.0) + 400.0 * DVec2::new(point.x, -0.72 * point.y - 0.6 * point.z))
        .as_vec2()
}

/// Draws the lines of a grid, a point with its two directions, and one of its triangles.
fn grid(place: fn(DVec2) -> Vec2) -> Canvas {
    const STEPS: usize = 48;
    let mut canvas = Canvas::new(WIDTH, HEIGHT, PAPER);
    let at = |row: f64, col: f64| place(DVec2::new(col, row) / LINES as f64);
    let [row, col] = POINT.map(|index| index as f64);
    let corners = [at(row, col), at(row, col + 1.0), at(row + 1.0, col + 1.0)];
    canvas.triangle(corners, FILL);
    let along = |step: usize| LINES as f64 * step as f64 / STEPS as f64;
    for line in 0..=LINES {
        let line = line as f64;
        for of_rows in [true, false] {
            let point = |step: usize| {
                if of_rows { at(line, along(step)) } else { at(along(step), line) }
            };
            let points: Vec<_> = (0..=STEPS).map(point).collect();
            canvas.polyline(&points, 0.9, PALE);
        }
    }
    let [x0, x1, x2] = corners;
    canvas.polyline(&[x1, x2, x0], 1.8, INK);
    // Each arrow is as long as two grid steps along the tangent.
    let pen = Pen::bold(28.0);
    let (east, south) = (at(row, col + 0.01) - x0, at(row + 0.01, col) - x0);
    for (way, name) in [(east, "ξ₁"), (south, "ξ₂")] {
        let tip = x0 + 200.0 * way;
        arrow(&mut canvas, x0, tip, ACCENT);
        let beside = tip + 24.0 * way.normalize();
        write_around(&mut canvas, &pen, beside, name, ACCENT);
    }
    for (point, name, color, aside) in [
        (x0, "x₀", ACCENT, Vec2::new(-24.0, -20.0)),
        (x1, "x₁", INK, Vec2::new(14.0, -28.0)),
        (x2, "x₂", INK, Vec2::new(28.0, 18.0)),
    ] {
        canvas.polyline(&[point; 2], 8.0, color);
        write_around(&mut canvas, &pen, point + aside, name, color);
    }
    canvas
}

/// Draws a triangle with a planar wavefront that has reached two of its corners and goes on to the third.
fn triangle() -> Canvas {
    let mut canvas = Canvas::new(WIDTH, HEIGHT, PAPER);
    let [x0, x1, x2] = [[400.0, 80.0], [250.0, 315.0], [480.0, 310.0]].map(Vec2::from);
    canvas.triangle([x0, x1, x2], FILL);
    // The direction of the wavefront, and a point on the line from which it starts at time 0.
    let n = Vec2::new(0.24, -0.97).normalize();
    let source = Vec2::new(330.0, 440.0);
    let time = |point: Vec2| (point - source).dot(n);
    let across = n.perp();
    let line = |middle: Vec2, half: f32| [middle - half * across, middle + half * across];
    for point in [x1, x2, x0] {
        let middle = source + time(point) * n;
        canvas.polyline(&line(middle, 205.0), 1.0, FRONT);
    }
    canvas.polyline(&line(source, 205.0), 2.6, FRONT);
    canvas.polyline(&[x0, x1, x2, x0], 1.8, INK);
    let (pen, plain) = (Pen::bold(28.0), Pen::new(24.0));
    for (point, name, aside) in [
        (x1, "t₁", Vec2::new(-20.0, 4.0)),
        (x2, "t₂", Vec2::new(20.0, 6.0)),
        (x0, "t₀", Vec2::new(-22.0, 4.0)),
    ] {
        // The arrow runs from this line at a right angle up to the wavefront.
        let foot = point - time(point) * n;
        arrow(&mut canvas, foot, point - 11.0 * n, FRONT);
        write_around(&mut canvas, &plain, foot.lerp(point, 0.45) + aside, name, FRONT);
    }
    for (point, name, color, aside) in [
        (x0, "x₀", ACCENT, Vec2::new(26.0, -22.0)),
        (x1, "x₁", INK, Vec2::new(-30.0, 12.0)),
        (x2, "x₂", INK, Vec2::new(32.0, 6.0)),
    ] {
        canvas.polyline(&[point; 2], 8.0, color);
        write_around(&mut canvas, &pen, point + aside, name, color);
    }
    let tail = source + 185.0 * across;
    arrow(&mut canvas, tail, tail + 70.0 * n, ACCENT);
    write_around(&mut canvas, &pen, tail + 70.0 * n + Vec2::new(20.0, -8.0), "n", ACCENT);
    canvas
}

fn arrow(canvas: &mut Canvas, tail: Vec2, tip: Vec2, color: Color) {
    canvas.polyline(&[tail, tip], 1.8, color);
    let back = (tail - tip).normalize();
    for side in [0.45, -0.45] {
        canvas.polyline(&[tip, tip + 15.0 * Vec2::from_angle(side).rotate(back)], 1.8, color);
    }
}

/// Writes a text with its middle at a place.
fn write_around(canvas: &mut Canvas, pen: &Pen, at: Vec2, text: &str, color: Color) {
    pen.write(canvas, at.x - 0.5 * pen.width(text), at.y, text, color);
}
