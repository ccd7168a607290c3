//! Marks points of a grid, with a bit for each.

use geosweep_surface::Chart;

/// Number of points in a word of marks.
pub(super) const WORD: usize = u64::BITS as usize;

/// Marks of lines of points, a bit for each point. The first point is the lowest bit.
#[derive(Clone, Debug)]
pub(super) struct Marks {
    words: Vec<u64>,
    on_line: usize,
}

impl Marks {
    /// Returns marks for a chart whose rows are the lines, with no point marked.
    pub(super) fn none(lines: Chart) -> Self {
        let words = words(lines);
        Self { words: vec![0; words.points()], on_line: words.cols }
    }

    pub(super) fn bytes(lines: Chart) -> usize {
        words(lines).points() * size_of::<u64>()
    }

    /// Marks all points, or none. With `all`, bits beyond the grid may be set too.
    pub(super) fn fill(&mut self, all: bool) {
        self.words.fill(if all { u64::MAX } else { 0 });
    }

    pub(super) fn mark(&mut self, line: usize, point: usize) {
        self.line_mut(line)[point / WORD] |= 1 << (point % WORD);
    }

    pub(super) fn lines(&self) -> usize {
        self.words.len() / self.on_line
    }

    pub(super) fn line(&self, line: usize) -> &[u64] {
        &self.words[line * self.on_line..][..self.on_line]
    }

    pub(super) fn line_mut(&mut self, line: usize) -> &mut [u64] {
        &mut self.words[line * self.on_line..][..self.on_line]
    }

    /// Marks points on a line that are beside the marked points of an adjacent line.
    pub(super) fn spread(&mut self, line: usize, marked: &[u64]) {
        for (k, word) in self.line_mut(line).iter_mut().enumerate() {
            let at = marked[k];
            let before = k.checked_sub(1).map_or(0, |k| marked[k]);
            let after = marked.get(k + 1).copied().unwrap_or_default();
            *word |= at | at << 1 | before >> (WORD - 1) | at >> 1 | after << (WORD - 1);
        }
    }

    /// Transposes the marks: lines become points and points become lines.
    pub(super) fn transpose_into(&self, to: &mut Self) {
        let (lines, points) = (self.lines(), to.lines());
        let starts = |count| (0..count).step_by(WORD);
        for (line, point) in starts(lines).flat_map(|line| starts(points).map(move |k| (line, k))) {
            let mut block = [0; WORD];
            let words = self.words[line * self.on_line..].chunks(self.on_line);
            for (row, words) in block.iter_mut().zip(words) {
                *row = words[point / WORD];
            }
            transpose(&mut block);
            let words = to.words[point * to.on_line..].chunks_mut(to.on_line);
            for (row, words) in block.iter().zip(words) {
                words[line / WORD] = *row;
            }
        }
    }
}

/// Returns the chart of the words of lines.
fn words(lines: Chart) -> Chart {
    Chart { cols: lines.cols.div_ceil(WORD), ..lines }
}

/// Transposes a block of bits: swaps its two off-diagonal quarters, then the off-diagonal quarters of each quarter,
/// down to single bits.
fn transpose(block: &mut [u64; WORD]) {
    let (mut width, mut low) = (WORD / 2, u64::MAX >> (WORD / 2));
    while width > 0 {
        for row in (0..WORD).filter(|row| row & width == 0) {
            let swapped = (block[row] >> width ^ block[row | width]) & low;
            block[row] ^= swapped << width;
            block[row | width] ^= swapped;
        }
        width /= 2;
        low ^= low << width;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marked(marks: &Marks) -> Vec<(usize, usize)> {
        let is_marked =
            |line: usize, point| marks.line(line)[point / WORD] >> (point % WORD) & 1 > 0;
        let points = marks.on_line * WORD;
        let all = (0..marks.lines()).flat_map(|line| (0..points).map(move |point| (line, point)));
        all.filter(|&(line, point)| is_marked(line, point)).collect()
    }

    #[test]
    fn marks_spread_across_words() {
        for (point, beside) in [(0, 0..2), (63, 62..65), (64, 63..66), (149, 148..151)] {
            let [mut from, mut to] = [1, 2].map(|rows| Marks::none(Chart { rows, cols: 150 }));
            from.mark(0, point);
            to.spread(1, from.line(0));
            assert_eq!(marked(&to), beside.map(|point| (1, point)).collect::<Vec<_>>());
        }
    }

    #[test]
    fn every_mark_is_turned() {
        let chart = Chart { rows: 70, cols: 150 };
        let [mut marks, mut turned] = [chart, chart.transposed()].map(Marks::none);
        let is_marked = |k: &usize| k * k % 7 == 2;
        for (line, point) in (0..chart.points()).filter(is_marked).map(|k| chart.position(k)) {
            marks.mark(line, point);
        }
        marks.transpose_into(&mut turned);
        let mut back: Vec<_> = marked(&turned).into_iter().map(|(c, r)| (r, c)).collect();
        back.sort();
        assert_eq!(back, marked(&marks));
    }
}
