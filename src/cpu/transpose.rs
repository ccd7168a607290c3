//! Transposition of a block of an array into another.

use super::Instructions;
use crate::surface::Real;

/// Where a block lies in both arrays: entry (r, c) goes from `from + r * from_stride + c` to
/// `to + c * to_stride + r`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub from: usize,
    pub from_stride: usize,
    pub to: usize,
    pub to_stride: usize,
    pub rows: usize,
    pub cols: usize,
}

/// Copies a block, transposed.
pub(super) fn transpose<R: Real>(
    from: &[R],
    to: &mut [R],
    block: Block,
    instructions: Instructions,
) {
    #[cfg(target_arch = "x86_64")]
    if instructions != Instructions::Baseline && size_of::<R>() == size_of::<f32>() {
        use bytemuck::{try_cast_slice, try_cast_slice_mut};
        if let (Ok(from), Ok(to)) = (try_cast_slice(from), try_cast_slice_mut(to)) {
            // SAFETY: both sets have AVX2, and `Instructions::available` lists only sets that
            // this machine has.
            return unsafe { avx2::transpose(from, to, block) };
        }
    }
    let _ = instructions;
    one_by_one(from, to, block);
}

fn one_by_one<R: Copy>(from: &[R], to: &mut [R], block: Block) {
    for r in 0..block.rows {
        let line = &from[block.from + r * block.from_stride..][..block.cols];
        for (c, &value) in line.iter().enumerate() {
            to[block.to + c * block.to_stride + r] = value;
        }
    }
}

impl Block {
    /// The part that starts at some row and column.
    fn part(self, row: usize, col: usize, rows: usize, cols: usize) -> Self {
        Self {
            from: self.from + row * self.from_stride + col,
            to: self.to + col * self.to_stride + row,
            rows,
            cols,
            ..self
        }
    }
}

/// Blocks of 8 x 8 in registers, since compilers do not find these shuffles.
#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;

    use super::{Block, one_by_one};

    #[target_feature(enable = "avx2")]
    pub(super) fn transpose(from: &[f32], to: &mut [f32], block: Block) {
        let (rows, cols) = (block.rows & !7, block.cols & !7);
        for col in (0..cols).step_by(8) {
            for row in (0..rows).step_by(8) {
                eight(from, to, block.part(row, col, 8, 8));
            }
        }
        one_by_one(from, to, block.part(0, cols, block.rows, block.cols - cols));
        one_by_one(from, to, block.part(rows, 0, block.rows - rows, cols));
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn eight(from: &[f32], to: &mut [f32], block: Block) {
        let from = &from[block.from..];
        let line = |r: usize| -> __m256 {
            let line: [f32; 8] = from[r * block.from_stride..][..8].try_into().expect("eight");
            bytemuck::cast(line)
        };
        let [a, b, c, d, e, f, g, h] =
            [line(0), line(1), line(2), line(3), line(4), line(5), line(6), line(7)];
        // Pairs of lines, then fours, then all eight interleaved.
        let (ab0, ab1) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
        let (cd0, cd1) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
        let (ef0, ef1) = (_mm256_unpacklo_ps(e, f), _mm256_unpackhi_ps(e, f));
        let (gh0, gh1) = (_mm256_unpacklo_ps(g, h), _mm256_unpackhi_ps(g, h));
        let low = [
            _mm256_shuffle_ps::<0x44>(ab0, cd0),
            _mm256_shuffle_ps::<0xee>(ab0, cd0),
            _mm256_shuffle_ps::<0x44>(ab1, cd1),
            _mm256_shuffle_ps::<0xee>(ab1, cd1),
        ];
        let high = [
            _mm256_shuffle_ps::<0x44>(ef0, gh0),
            _mm256_shuffle_ps::<0xee>(ef0, gh0),
            _mm256_shuffle_ps::<0x44>(ef1, gh1),
            _mm256_shuffle_ps::<0xee>(ef1, gh1),
        ];
        let to = &mut to[block.to..];
        for k in 0..4 {
            let near: [f32; 8] = bytemuck::cast(_mm256_permute2f128_ps::<0x20>(low[k], high[k]));
            let far: [f32; 8] = bytemuck::cast(_mm256_permute2f128_ps::<0x31>(low[k], high[k]));
            to[k * block.to_stride..][..8].copy_from_slice(&near);
            to[(k + 4) * block.to_stride..][..8].copy_from_slice(&far);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_goes_to_its_place_and_nothing_else_is_touched() {
        let from: Vec<f32> = (0..40 * 30).map(|k| k as f32).collect();
        for instructions in Instructions::available() {
            for (rows, cols) in [(1, 1), (8, 8), (17, 16), (16, 17), (23, 9), (5, 20)] {
                let mut to = vec![-1.0f32; 40 * 30];
                let block = Block { from: 63, from_stride: 30, to: 81, to_stride: 40, rows, cols };
                transpose(&from, &mut to, block, instructions);
                let copied = to.iter().filter(|&&value| value >= 0.0).count();
                assert_eq!(copied, rows * cols);
                for (r, c) in (0..rows).flat_map(|r| (0..cols).map(move |c| (r, c))) {
                    assert_eq!(
                        to[81 + c * 40 + r],
                        from[63 + r * 30 + c],
                        "{instructions} {r} {c}"
                    );
                }
            }
        }
    }
}
