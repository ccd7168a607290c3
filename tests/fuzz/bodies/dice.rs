//! Numbers from a fuzzer's bytes.

use std::ops::Range;

/// Reads bytes as numbers. After the last byte come pseudo-random ones that depend on all bytes, so that
/// short inputs give whole cases too.
pub struct Dice<'a> {
    bytes: std::slice::Iter<'a, u8>,
    state: u64,
}

impl<'a> Dice<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        let mix = |hash: u64, &byte: &u8| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        Self { bytes: bytes.iter(), state: bytes.iter().fold(0xcbf2_9ce4_8422_2325, mix) | 1 }
    }

    pub fn byte(&mut self) -> u8 {
        self.bytes.next().copied().unwrap_or_else(|| {
            self.state ^= self.state << 13;
            self.state ^= self.state >> 7;
            self.state ^= self.state << 17;
            (self.state >> 40) as u8
        })
    }

    pub fn below(&mut self, end: usize) -> usize {
        usize::from(u16::from_le_bytes([self.byte(), self.byte()])) % end
    }

    pub fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[usize::from(self.byte()) % choices.len()]
    }

    /// Returns true once in `times` calls on average.
    pub fn once_in(&mut self, times: u8) -> bool {
        self.byte().is_multiple_of(times)
    }

    /// Returns a number within a range, ends included.
    pub fn within(&mut self, range: Range<f64>) -> f64 {
        let part = f64::from(u16::from_le_bytes([self.byte(), self.byte()])) / f64::from(u16::MAX);
        range.start + part * (range.end - range.start)
    }

    /// Returns a number within a range, with equal probability in each decade.
    pub fn magnitude(&mut self, range: Range<f64>) -> f64 {
        self.within(range.start.ln()..range.end.ln()).exp()
    }
}
