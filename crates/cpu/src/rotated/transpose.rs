//! Transposes a block of an array into another array.

use bytemuck::Pod;

use crate::Instructions;

/// A block of an array that is transposed into another array, and its position in both. Entry (r, c) goes
/// from `from + r * from_stride + c` to `to + c * to_stride + r`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turned {
    pub from: usize,
    pub from_stride: usize,
    pub to: usize,
    pub to_stride: usize,
    pub rows: usize,
    pub cols: usize,
}

/// Copies a block, transposed.
pub(crate) fn transpose<T: Pod>(
    from: &[T],
    to: &mut [T],
    block: Turned,
    instructions: Instructions,
) {
    if size_of::<T>() == 0 {
        return;
    }
    #[cfg(target_arch = "x86_64")]
    if instructions != Instructions::Baseline && size_of::<T>() == size_of::<f32>() {
        use bytemuck::{try_cast_slice, try_cast_slice_mut};
        if let (Ok(from), Ok(to)) = (try_cast_slice(from), try_cast_slice_mut(to)) {
            // SAFETY: all instruction sets above the baseline have AVX2, and `Instructions::available` lists only sets
            // that this machine has.
            return unsafe { avx2::transpose(from, to, block) };
        }
    }
    let _ = instructions;
    one_by_one(from, to, block);
}

fn one_by_one<R: Copy>(from: &[R], to: &mut [R], block: Turned) {
    for r in 0..block.rows {
        let line = &from[block.from + r * block.from_stride..][..block.cols];
        for (c, &value) in line.iter().enumerate() {
            to[block.to + c * block.to_stride + r] = value;
        }
    }
}

/// Transposes blocks of 8 x 8 in registers, since compilers do not find these shuffles.
#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;

    use super::{Turned, one_by_one};
    use geosweep_surface::lanes::prefetch;

    /// Number of lines by which prefetches are ahead of reads. The lines lie pages apart, so the hardware prefetcher
    /// does not find them.
    const AHEAD: usize = 16;

    impl Turned {
        /// Returns the part that starts at `row` and `col` of the block.
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

    #[target_feature(enable = "avx2")]
    pub(crate) fn transpose(from: &[f32], to: &mut [f32], block: Turned) {
        let (rows, cols) = (block.rows & !7, block.cols & !7);
        for row in (0..rows).step_by(8) {
            for line in row + AHEAD..row + AHEAD + 8 {
                let start = (block.from + line * block.from_stride) as isize;
                prefetch(from, start);
                prefetch(from, start + block.cols as isize);
            }
            for col in (0..cols).step_by(8) {
                let part = block.part(row, col, 8, 8);
                let last = |first: usize, stride: usize| first + 7 * stride + 8;
                assert!(last(part.from, part.from_stride) <= from.len());
                assert!(last(part.to, part.to_stride) <= to.len());
                // SAFETY: the last of eight lines of eight lies within each array, so all do.
                unsafe {
                    let from = from.as_ptr().add(part.from);
                    eight(from, part.from_stride, to.as_mut_ptr().add(part.to), part.to_stride);
                }
            }
            one_by_one(from, to, block.part(row, cols, 8, block.cols - cols));
        }
        one_by_one(from, to, block.part(rows, 0, block.rows - rows, block.cols));
    }

    /// # Safety
    /// Eight lines of eight numbers must lie a stride apart, from each pointer on.
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn eight(from: *const f32, from_stride: usize, to: *mut f32, to_stride: usize) {
        // Loads half of a line into the lower half of a register, and the same half of the fourth line after it into
        // the upper half. This costs no extra instruction.
        // SAFETY: the caller's.
        let halves = |line: usize, half: usize| unsafe {
            let near = from.add(line * from_stride + 4 * half);
            let (near, far) = (_mm_loadu_ps(near), _mm_loadu_ps(near.add(4 * from_stride)));
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(near), far)
        };
        for half in 0..2 {
            let [a, b, c, d] = [halves(0, half), halves(1, half), halves(2, half), halves(3, half)];
            // Interleaves pairs of lines, then groups of four.
            let (ab0, ab1) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
            let (cd0, cd1) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
            let lines = [
                _mm256_shuffle_ps::<0x44>(ab0, cd0),
                _mm256_shuffle_ps::<0xee>(ab0, cd0),
                _mm256_shuffle_ps::<0x44>(ab1, cd1),
                _mm256_shuffle_ps::<0xee>(ab1, cd1),
            ];
            for (line, numbers) in lines.into_iter().enumerate() {
                let to = to.wrapping_add((4 * half + line) * to_stride);
                // SAFETY: the caller's.
                unsafe { _mm256_storeu_ps(to, numbers) };
            }
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
                let block = Turned { from: 63, from_stride: 30, to: 81, to_stride: 40, rows, cols };
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
