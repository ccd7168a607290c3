//! Surfaces unlike those of `Case::new`: points that are moved aside, spacings that grow or fold back, shears
//! of up to forty cells, spirals and ridges, walls with gaps, and slownesses that vary smoothly.

use geosweep::glam::DVec3;
use geosweep::{EdgeRule, Sources, Surface};

use super::Random;
use super::bounds::{Case, on};

/// Arrangement of the points of a grid.
#[derive(Clone, Copy, Debug)]
enum Shape {
    Hills,
    Flat,
    Spiral,
    GrowingSpacing,
    Ridges,
}

impl Shape {
    const ALL: [Self; 5] =
        [Self::Hills, Self::Flat, Self::Spiral, Self::GrowingSpacing, Self::Ridges];
}

impl Case {
    /// Returns an irregular surface with up to eight sources, which may lie inside cells and have later start
    /// values.
    pub fn irregular(number: u64) -> Self {
        let mut random = Random::new(number + 77_000_003);
        let mut between = |low: f64, high: f64| low + (high - low) * random.next();
        let (rows, cols) = (between(2.0, 45.0) as usize, between(2.0, 45.0) as usize);
        let shape = Shape::ALL[between(0.0, 5.0) as usize];
        let waves = [(); 8].map(|()| {
            [between(-1.0, 1.0), between(-1.5, 1.5), between(-1.5, 1.5), between(0.0, 6.3)]
        });
        let size = 10f64.powf(between(-2.0, 1.3));
        let jitter = if between(0.0, 1.0) < 0.4 { between(0.0, 0.45) } else { 0.0 };
        let growth: f64 = if between(0.0, 1.0) < 0.3 { between(0.9, 1.12) } else { 1.0 };
        let shear = if between(0.0, 1.0) < 0.5 { between(-4.0, 4.0) } else { 0.0 };
        let aspect = 10f64.powf(between(-1.0, 1.0));
        let points = rows * cols;
        let place = |index: usize| ((index / cols) as f64, (index % cols) as f64);
        let positions = (0..points).map(|index| {
            let (row, col) = place(index);
            let (row, col) = (row + jitter * between(-1.0, 1.0), col + jitter * between(-1.0, 1.0));
            let wave = |k: usize| {
                let [height, by_row, by_col, phase] = waves[k];
                height * (by_row * row + by_col * col + phase).sin()
            };
            let sheared = aspect * col + shear * row;
            match shape {
                Shape::Hills => DVec3::new(sheared, row, size * (wave(0) + wave(1) + wave(2))),
                Shape::Flat => DVec3::new(sheared, row, 0.0),
                Shape::Spiral => {
                    let turn = 6.0 * col / cols as f64;
                    let radius = 0.2 * cols as f64 * (1.2 + 0.2 * wave(3));
                    DVec3::new(
                        radius * turn.cos(),
                        radius * turn.sin(),
                        aspect * row + shear * turn,
                    )
                }
                Shape::GrowingSpacing => {
                    let [across, along] = [aspect * col * growth.powf(col), row * growth.powf(row)];
                    DVec3::new(across, along, 0.0) + size * DVec3::new(wave(4), wave(5), wave(6))
                }
                Shape::Ridges => {
                    let is_ridge = (col + row * shear / 4.0) as i64 % 5 == 0;
                    let height = if is_ridge { 3.0 } else { between(0.0, 0.3) };
                    DVec3::new(aspect * col, row, size * height)
                }
            }
        });
        let surface = Surface::from_positions(rows, cols, positions.collect()).unwrap();
        let chords = between(0.0, 1.0) < 0.5;
        let surface = surface.with_edge_rule(if chords { EdgeRule::Chord } else { EdgeRule::Arc });
        let (walled, wall) = (between(0.0, 1.0) < 0.3, between(0.0, cols as f64) as usize);
        let is_open =
            |index: usize| !(walled && cols > 1 && index % cols == wall && (index / cols) % 7 != 3);
        let mask: Vec<bool> = (0..points).map(is_open).collect();
        let surface = surface.with_mask(&mask).unwrap();
        let slow = between(0.0, 1.0) < 0.25;
        let slowness = |index: usize| {
            let (row, col) = place(index);
            (0.8 * (0.7 * col + waves[7][1] * row).sin()).exp()
        };
        let surface = match slow {
            true => surface.with_slowness((0..points).map(slowness).collect()).unwrap(),
            false => surface,
        };
        let count = 1 + (between(0.0, 1.0).powi(2) * 8.0) as usize;
        let (inside, later) = (between(0.0, 1.0) < 0.4, between(0.0, 1.0) < 0.3);
        let there: Vec<usize> = (0..points).filter(|&index| surface.present()[index]).collect();
        let mut sources = Sources::default();
        for _ in 0..count {
            let (row, col) = place(there[(between(0.0, 1.0) * there.len() as f64) as usize]);
            let aside =
                [between(0.0, 1.0), between(0.0, 1.0)].map(|by| if inside { by } else { 0.0 });
            let start = if later { between(0.0, 5.0) } else { 0.0 };
            // Some places inside cells are not on the surface.
            let wanted = sources.clone().and_point(row + aside[0], col + aside[1], start);
            let beside = || sources.clone().and_point(row, col, start);
            sources = on(&surface, wanted).unwrap_or_else(beside);
        }
        let name = format!(
            "irregular case {number}: {shape:?}, {rows} x {cols}, size {size:.2}, jitter {jitter:.2}, growth \
             {growth:.2}, shear {shear:.2}, aspect {aspect:.2}, {count} sources{}{}{}{}",
            if walled { ", a wall" } else { "" },
            if slow { ", slowness" } else { "" },
            if inside { ", inside cells" } else { "" },
            if chords { ", chords" } else { "" },
        );
        Self { name, surface, sources, has_positions: !slow && !inside, has_origins: false }
    }
}
