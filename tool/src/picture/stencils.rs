//! Draws scans: the points from which a scan updates each point, and the order and dependences of the
//! updates.

use geosweep::glam::Vec2;
use geosweep::surface::Direction::{self, *};

use super::canvas::{Canvas, Color, mix};
use super::colors::{INK, PAPER, Scale, ink_over};
use super::gallery::{Tile, tiled};
use super::text::Pen;

/// A scan: its name, the neighbours from which it updates a point (counter-clockwise), and its directions,
/// the fast one last. In a scan with one direction, all points of a line across this direction are updated
/// at once.
struct Scan {
    name: &'static str,
    from: [Direction; 3],
    order: &'static [Direction],
}

/// The first row of figure 3.
const RASTER: [Scan; 4] = [
    Scan { name: "right-down", from: [North, NorthWest, West], order: &[South, East] },
    Scan { name: "left-down", from: [East, NorthEast, North], order: &[South, West] },
    Scan { name: "right-up", from: [West, SouthWest, South], order: &[North, East] },
    Scan { name: "left-up", from: [South, SouthEast, East], order: &[North, West] },
];
/// The second row of figure 3.
const ROTATED: [Scan; 4] = [
    Scan { name: "down", from: [NorthEast, North, NorthWest], order: &[South] },
    Scan { name: "up", from: [SouthWest, South, SouthEast], order: &[North] },
    Scan { name: "right", from: [NorthWest, West, SouthWest], order: &[East] },
    Scan { name: "left", from: [SouthEast, East, NorthEast], order: &[West] },
];

/// The side of a stencil, in pixels. `STEP` is the distance between points.
const STENCIL: usize = 400;
const STEP: f32 = 104.0;
const DISC: f32 = 15.0;
const ACCENT: Color = [0.86, 0.37, 0.2];
const FILLS: [Color; 2] = [[0.56, 0.74, 0.86], [0.73, 0.85, 0.92]];
const PALE: Color = [0.78, 0.78, 0.78];

/// Draws stencils of the eight scans in two rows, above the order of updates of two of them.
pub fn scan_figure() -> Canvas {
    let stencil =
        |scan: &Scan| Tile { title: scan.name.into(), heading: false, picture: stencil(scan) };
    let order = |title: &str, scan: &Scan| Tile {
        title: title.into(),
        heading: false,
        picture: order(scan),
    };
    let stencils =
        tiled(&[RASTER.iter().map(stencil).collect(), ROTATED.iter().map(stencil).collect()]);
    let orders = tiled(&[vec![
        order("order of updates in the right-down scan", &RASTER[0]),
        order("order of updates in the scan to the right", &ROTATED[2]),
    ]]);
    let mut canvas =
        Canvas::new(stencils.width.max(orders.width), stencils.height + orders.height, PAPER);
    canvas.paste((canvas.width - stencils.width) / 2, 0, &stencils);
    canvas.paste((canvas.width - orders.width) / 2, stencils.height, &orders);
    canvas
}

fn step(to: Direction) -> Vec2 {
    let (down, right) = to.step();
    Vec2::new(right as f32, down as f32)
}

/// Draws a point among its neighbours, and the triangles from which it is updated.
fn stencil(scan: &Scan) -> Canvas {
    let mut canvas = Canvas::new(STENCIL, STENCIL, PAPER);
    let middle = Vec2::splat(0.5 * STENCIL as f32);
    let at = |to: Direction| middle + STEP * step(to);
    for (ends, fill) in scan.from.windows(2).zip(FILLS) {
        canvas.triangle([middle, at(ends[0]), at(ends[1])], fill);
    }
    for to in [North, West, South, East] {
        // The grid around the middle: each side of the square, and the lines through the middle.
        let across = STEP * step(to.next().next());
        canvas.polyline(&[at(to) - across, at(to) + across], 1.0, PALE);
        canvas.polyline(&[middle, at(to)], 1.0, PALE);
    }
    for &to in &scan.from {
        canvas.polyline(&[at(to), middle], 1.8, INK);
    }
    canvas.polyline(&scan.from.map(at), 1.8, INK);
    for to in Direction::ALL {
        let color = if scan.from.contains(&to) { INK } else { PALE };
        canvas.polyline(&[at(to); 2], DISC, color);
    }
    canvas.polyline(&[middle; 2], DISC + 4.0, ACCENT);
    arrows(&mut canvas, scan);
    canvas
}

/// Draws the scan's order: a short arrow for the slow direction, and a long one for the fast direction.
fn arrows(canvas: &mut Canvas, scan: &Scan) {
    let middle = Vec2::splat(0.5 * STENCIL as f32);
    let ways = scan.order.iter().rev();
    for (&way, half) in ways.zip([0.95 * STEP, 0.45 * STEP]) {
        // The arrow is on the side that the scan reaches last, where there is no triangle.
        let aside = match way {
            East | West => {
                if scan.order.contains(&North) {
                    North
                } else {
                    South
                }
            }
            _ => {
                if scan.order.contains(&West) {
                    West
                } else {
                    East
                }
            }
        };
        let center = middle + 1.58 * STEP * step(aside);
        let (tail, tip) = (center - half * step(way), center + half * step(way));
        canvas.polyline(&[tail, tip], 2.2, ACCENT);
        for barb in [way.opposite().next(), way.opposite().previous()] {
            canvas.polyline(&[tip, tip + 13.0 * step(barb)], 2.2, ACCENT);
        }
    }
}

/// Draws points of a grid with the step in which each is updated, and the points that each depends on.
fn order(scan: &Scan) -> Canvas {
    const POINTS: usize = 6;
    const SPACE: f32 = 112.0;
    const RADIUS: f32 = 30.0;
    let side = SPACE * POINTS as f32;
    let mut canvas = Canvas::new(side as usize + 60, side as usize, PAPER);
    let at = |row: usize, col: usize| {
        SPACE * (Vec2::new(col as f32, row as f32) + 0.5) + Vec2::new(30.0, 0.0)
    };
    let first = |row: usize, col: usize| {
        // Steps are counted from the corner or side at which the scan starts. These scans go right and down.
        1 + if scan.order.len() == 2 { row + col } else { col }
    };
    let steps = first(POINTS - 1, POINTS - 1) as f32;
    let scale = Scale::over([-1.0, steps + 1.0].into_iter());
    let points = || (0..POINTS).flat_map(|row| (0..POINTS).map(move |col| (row, col)));
    for (row, col) in points() {
        for &to in &scan.from {
            let (down, right) = to.step();
            let there = row.checked_add_signed(down).zip(col.checked_add_signed(right));
            let Some((above, beside)) = there.filter(|&(row, _)| row < POINTS) else { continue };
            let (from, to) = (at(above, beside), at(row, col));
            let way = (to - from).normalize();
            let (tail, tip) = (from + RADIUS * way, to - (RADIUS + 4.0) * way);
            canvas.polyline(&[tail, tip], 1.2, PALE);
            for side in [0.5, -0.5] {
                let barb = Vec2::from_angle(side).rotate(-way);
                canvas.polyline(&[tip, tip + 11.0 * barb], 1.2, mix(PALE, INK, 0.5));
            }
        }
    }
    let pen = Pen::bold(30.0);
    for (row, col) in points() {
        let step = first(row, col);
        let color = scale.color(step as f32);
        canvas.polyline(&[at(row, col); 2], RADIUS, color);
        let text = step.to_string();
        let Vec2 { x, y } = at(row, col);
        pen.write(&mut canvas, x - 0.5 * pen.width(&text), y, &text, ink_over(color));
    }
    canvas
}
