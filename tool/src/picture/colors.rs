//! From distances to colours.

use colorous::{TABLEAU10, VIRIDIS};

use super::canvas::{Color, mix};

/// What text and axes are drawn on...
pub const PAPER: Color = [1.0, 1.0, 1.0];
/// ... and in.
pub const INK: Color = [0.2, 0.2, 0.2];
/// The surface is not there.
pub const HOLE: Color = [0.87, 0.87, 0.87];
/// The surface is there and no source reaches it.
pub const UNREACHED: Color = [0.45, 0.45, 0.47];
/// Hatching over it.
pub const HATCHING: Color = [0.56, 0.56, 0.58];

const SHADES: usize = 1024;

/// Maps the range of a map to a perceptually uniform scale.
pub struct Scale {
    pub low: f32,
    pub high: f32,
    shades: Vec<Color>,
}

impl Scale {
    /// The scale over some finite values.
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

    /// Where in the range a value lies, from 0 to 1.
    pub fn fraction(&self, value: f32) -> f32 {
        let t = (value - self.low) / (self.high - self.low).max(f32::MIN_POSITIVE);
        t.clamp(0.0, 1.0)
    }
}

/// A colour for each of some regions, such that neighbours differ and no colour is rare.
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
    let mut chosen: Vec<usize> = Vec::with_capacity(regions);
    for others in &beside {
        let taken =
            |color| others.iter().any(|&other| chosen.get(other).is_some_and(|&of| of == color));
        let best = (0..palette.len()).min_by_key(|&color| (taken(color), uses[color]));
        let best = best.unwrap_or_default();
        uses[best] += 1;
        chosen.push(best);
    }
    chosen.into_iter().map(|color| palette[color]).collect()
}

/// How bright a colour looks, from 0 to 1.
pub fn luma([r, g, b]: Color) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// What lines are drawn in over a ground: light over dark, dark over light.
pub fn ink_over(ground: Color) -> Color {
    if luma(ground) < 0.5 { [1.0, 1.0, 1.0] } else { [0.05, 0.05, 0.1] }
}
