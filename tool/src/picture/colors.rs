//! Maps distances to colours.

use std::collections::BTreeSet;

use colorous::{TABLEAU10, VIRIDIS};

use super::canvas::{Color, mix};

/// The background of text and axes.
pub const PAPER: Color = [1.0, 1.0, 1.0];
/// The colour of text and axes.
pub const INK: Color = [0.2, 0.2, 0.2];
/// The colour of holes in the surface.
pub const HOLE: Color = [0.87, 0.87, 0.87];
/// The colour of points of the surface that no source reaches.
pub const UNREACHED: Color = [0.45, 0.45, 0.47];
/// The hatching over [`UNREACHED`].
pub const HATCHING: Color = [0.56, 0.56, 0.58];

const SHADES: usize = 1024;

/// A perceptually uniform colour scale over the range of a map.
pub struct Scale {
    pub low: f32,
    pub high: f32,
    shades: Vec<Color>,
}

impl Scale {
    /// Returns the scale over the range of some finite values.
    pub fn over(values: impl Iterator<Item = f32>) -> Self {
        let range = (f32::INFINITY, f32::NEG_INFINITY);
        let (low, high) = values.fold(range, |(low, high), v| (low.min(v), high.max(v)));
        let shade = |index| {
            let color = VIRIDIS.eval_rational(index, SHADES);
            [color.r, color.g, color.b].map(|channel| f32::from(channel) / 255.0)
        };
        Self { low, high, shades: (0..SHADES).map(shade).collect() }
    }

    pub fn color(&self, value: f32) -> Color {
        let t = self.fraction(value) * (SHADES - 1) as f32;
        self.shades[t.round() as usize]
    }

    /// Returns the position of a value in the range, from 0 to 1.
    pub fn fraction(&self, value: f32) -> f32 {
        let t = (value - self.low) / (self.high - self.low).max(f32::MIN_POSITIVE);
        t.clamp(0.0, 1.0)
    }
}

/// Returns a colour for each region. Neighbouring regions have different colours, and no colour is rare.
pub fn region_colors(regions: usize, neighbours: &[[u32; 2]]) -> Vec<Color> {
    // Light enough for shading and dark borders.
    const LIGHTENING: f32 = 0.3;
    let palette = TABLEAU10.map(|color| {
        let channels = [color.r, color.g, color.b].map(|channel| f32::from(channel) / 255.0);
        mix(channels, [1.0; 3], LIGHTENING)
    });
    let mut beside = vec![Vec::new(); regions];
    for &[a, b] in neighbours {
        beside[a as usize].push(b as usize);
        beside[b as usize].push(a as usize);
    }
    let mut uses = [0; TABLEAU10.len()];
    let mut chosen = vec![None; regions];
    for region in fewest_first(&beside).into_iter().rev() {
        let taken = |color| beside[region].iter().any(|&other| chosen[other] == Some(color));
        let best = (0..palette.len()).min_by_key(|&color| (taken(color), uses[color]));
        let best = best.unwrap_or_default();
        uses[best] += 1;
        chosen[region] = Some(best);
    }
    chosen.into_iter().flatten().map(|color| palette[color]).collect()
}

/// Returns the regions in an order in which each has few neighbours among the regions after it: at most five
/// if the graph of neighbours is planar. If regions are coloured from last to first, each finds a colour
/// that its neighbours do not have.
fn fewest_first(beside: &[Vec<usize>]) -> Vec<usize> {
    let mut degree: Vec<_> = beside.iter().map(Vec::len).collect();
    let mut left: BTreeSet<_> = degree.iter().copied().zip(0..).collect();
    let mut order = Vec::with_capacity(beside.len());
    while let Some((_, region)) = left.pop_first() {
        order.push(region);
        for &other in &beside[region] {
            if left.remove(&(degree[other], other)) {
                degree[other] -= 1;
                left.insert((degree[other], other));
            }
        }
    }
    order
}

/// Returns the perceived brightness of a colour, from 0 to 1.
pub fn luma([r, g, b]: Color) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Returns the colour of lines over a background: light over dark, and dark over light.
pub fn ink_over(ground: Color) -> Color {
    if luma(ground) < 0.5 { [1.0, 1.0, 1.0] } else { [0.05, 0.05, 0.1] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(regions: usize, neighbours: &[[u32; 2]]) {
        let colors = region_colors(regions, neighbours);
        assert_eq!(colors.len(), regions);
        for &[a, b] in neighbours {
            assert_ne!(colors[a as usize], colors[b as usize], "{a} and {b}");
        }
    }

    /// The hub has more neighbours than there are colours. It is the first, a middle or the last region.
    #[test]
    fn neighbours_differ_around_a_hub() {
        let ring = 24;
        for hub in [0, 7, ring] {
            let name = |k: u32| if k % ring < hub { k % ring } else { k % ring + 1 };
            let neighbours: Vec<_> =
                (0..ring).flat_map(|k| [[name(k), name(k + 1)], [hub, name(k)]]).collect();
            check(ring as usize + 1, &neighbours);
        }
    }

    #[test]
    fn neighbours_differ_in_a_honeycomb_and_no_color_is_rare() {
        let (rows, cols) = (9, 11);
        let name = |row: u32, col: u32| row * cols + col;
        let mut neighbours = Vec::new();
        for row in 0..rows {
            for col in 0..cols {
                let there = [(0, 1), (1, 0), (1, 1)].map(|(down, right)| (row + down, col + right));
                let inside = there.into_iter().filter(|&(row, col)| row < rows && col < cols);
                neighbours.extend(inside.map(|(r, c)| [name(row, col), name(r, c)]));
            }
        }
        check(99, &neighbours);
        let colors = region_colors(99, &neighbours);
        for color in &colors {
            assert!(colors.iter().filter(|other| *other == color).count() >= 5);
        }
    }

    #[test]
    fn regions_without_neighbours_have_a_color() {
        check(3, &[]);
        check(0, &[]);
    }
}
