//! Numbers the origins of curved fronts for shaders. The twin of `glsl/update/anchors.glsl`.

use std::collections::HashMap;

use super::seeds::curvatures;
use crate::constants::{SOURCES_INSIDE, WHOLE};
use crate::surface::{Origin, Seed, Tagged};
use crate::update::{Curvature, SEED};
use crate::vulkan::TexelChart;

/// Largest number of origins in shaders. Fronts of further origins carry their curvature.
const MOST: usize = SOURCES_INSIDE as usize / 2;

/// Origin as shaders read it: column and row of one end, the step from there to the other end, then the time.
type Words = [[f32; 4]; 2];

/// Origins of a map, numbered in the order in which they come.
#[derive(Debug, Default)]
pub(in crate::vulkan) struct NumberedOrigins {
    numbers: HashMap<[u64; 5], u32>,
    words: Vec<Words>,
}

impl NumberedOrigins {
    pub(in crate::vulkan) fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    /// Forgets the origins of the last map.
    pub(in crate::vulkan) fn forget(&mut self) {
        self.numbers.clear();
        self.words.clear();
    }

    /// Returns what the fronts at seeds carry: the numbers of their origins, or their curvatures if the
    /// origin is unknown.
    pub(in crate::vulkan) fn carried(&mut self, seeds: &[Seed]) -> Vec<f32> {
        let mut carried = curvatures(seeds);
        for (carried, seed) in carried.iter_mut().zip(seeds) {
            if let Some(number) = seed.origin.and_then(|origin| self.number(&origin)) {
                *carried = Curvature::<f32>::of_origin(number).with_tag(SEED | WHOLE as u8);
            }
        }
        carried
    }

    fn number(&mut self, origin: &Origin) -> Option<u32> {
        if let Some(&number) = self.numbers.get(&origin.key()) {
            return Some(number);
        }
        let number = self.words.len();
        (number < MOST).then(|| {
            let before = f64::from(TexelChart::POINTS_BEFORE);
            let [a, b] = origin.ends;
            let ([row, col], [rows, cols]) = ((a + before).to_array(), (b - a).to_array());
            let ends = [col, row, cols, rows].map(|at| at as f32);
            self.words.push([ends, [origin.start as f32, 0.0, 0.0, 0.0]]);
            self.numbers.insert(origin.key(), number as u32);
            number as u32
        })
    }

    /// Writes the origins to where shaders find them.
    pub(in crate::vulkan) fn write(&self, bytes: &mut [u8]) {
        let words: &[u8] = bytemuck::cast_slice(&self.words);
        bytes[..words.len()].copy_from_slice(words);
    }
}
