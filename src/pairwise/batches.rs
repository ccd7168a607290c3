//! Groups sources into batches whose maps are computed side by side.

use std::ops::Range;

use crate::cpu::PairwiseScan;
use crate::surface::Chart;

/// Sources whose maps are computed together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Batch {
    /// The sources, as indices of grid points.
    pub sources: Vec<usize>,
    /// The position of each source in the list of requested sources; `None` if it was not requested.
    pub places: Vec<Option<usize>>,
}

/// Groups the sources of a whole matrix.
///
/// The maps of a batch are updated wherever one of them changes, so their sources should be close together.
/// At 64 x 64 points, blocks of 4 x 4 points cost less than 16 points in a row: a tenth less for planar maps
/// and a sixth less for converged ones. But with blocks, rows of the matrix are completed only band by band.
#[derive(Clone, Copy, Debug)]
pub(super) struct Batches {
    chart: Chart,
    /// The number of grid rows in a block.
    rows: usize,
}

/// The largest size of a band of blocks, in bytes of the matrix. It is small enough that a few bands fit in
/// memory.
const BAND: usize = 16 << 20;

impl Batches {
    const LANES: usize = PairwiseScan::LANES;

    pub fn new(chart: Chart) -> Self {
        let rows = 4;
        let band = rows * chart.cols * chart.points() * size_of::<f32>();
        Self { chart, rows: if band <= BAND { rows } else { 1 } }
    }

    /// Returns the largest number of sources in a group. A group is one batch or several.
    pub fn most(&self) -> usize {
        if self.rows == 1 { Self::LANES } else { self.rows * self.chart.cols }
    }

    /// Splits sources, in order, into groups, each with its batches.
    ///
    /// The other sources of a batch can change the last bits of a map. So consecutive sources are computed in
    /// the same batches as for the whole matrix; these batches are filled up with neighbours that were not
    /// requested. The sources of other lists fill the lanes in order.
    pub fn split(self, sources: &[usize]) -> impl Iterator<Item = (Range<usize>, Vec<Batch>)> {
        let mut begin = 0;
        std::iter::from_fn(move || {
            let rest = &sources[begin..];
            let &first = rest.first()?;
            let follow = following(&rest[..rest.len().min(self.most())]);
            let group = if follow >= Self::LANES || follow == rest.len() {
                let group = self.group(first);
                let wanted = first..group.end.min(first + follow);
                let place = |source| wanted.contains(&source).then(|| begin + source - first);
                let batches = self.blocks(&group).map(|sources| {
                    let places = sources.iter().copied().map(place).collect();
                    Batch { sources, places }
                });
                let wanted_by_some = |batch: &Batch| batch.places.iter().any(Option::is_some);
                (begin..begin + wanted.len(), batches.filter(wanted_by_some).collect())
            } else {
                let most = rest.len().min(Self::LANES);
                let next = |at: usize| &rest[at..rest.len().min(at + Self::LANES)];
                let long = |&at: &usize| following(next(at)) == Self::LANES;
                let count = (1..most).find(long).unwrap_or(most);
                let places = (begin..begin + count).map(Some).collect();
                (begin..begin + count, vec![Batch { sources: rest[..count].to_vec(), places }])
            };
            begin = group.0.end;
            Some(group)
        })
    }

    /// Returns the group of a source: a range of consecutive sources.
    fn group(&self, source: usize) -> Range<usize> {
        let begin = source - source % self.most();
        begin..self.chart.points().min(begin + self.most())
    }

    /// Returns the batches of a group.
    fn blocks(&self, group: &Range<usize>) -> impl Iterator<Item = Vec<usize>> {
        let lines: Vec<Range<usize>> = if self.rows == 1 {
            vec![group.clone()]
        } else {
            group.clone().step_by(self.chart.cols).map(|at| at..at + self.chart.cols).collect()
        };
        let width = Self::LANES / lines.len();
        (0..lines[0].len()).step_by(width).map(move |first| {
            let line = |line: &Range<usize>| line.clone().skip(first).take(width);
            lines.iter().flat_map(line).collect()
        })
    }
}

/// Returns the number of consecutive sources at the start of the list.
fn following(sources: &[usize]) -> usize {
    let breaks = sources.windows(2).position(|pair| pair[1] != pair[0] + 1);
    breaks.map_or(sources.len(), |last| last + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHART: Chart = Chart { rows: 7, cols: 6 };

    /// Returns batches that are parts of rows, and batches that are blocks.
    fn tilings() -> [Batches; 2] {
        [1, 4].map(|rows| Batches { chart: CHART, rows })
    }

    /// Splits the sources. Returns all batches, and the source of each position in the list, in order.
    fn split(batches: Batches, sources: &[usize]) -> (Vec<Batch>, Vec<usize>) {
        let (mut all, mut computed, mut end) = (Vec::new(), vec![usize::MAX; sources.len()], 0);
        for (group, batches) in batches.split(sources) {
            assert_eq!(group.start, end);
            end = group.end;
            for batch in batches {
                assert!(batch.sources.len() <= Batches::LANES);
                for (&source, place) in batch.sources.iter().zip(&batch.places) {
                    if let Some(place) = *place {
                        assert!(group.contains(&place) && computed[place] == usize::MAX);
                        computed[place] = source;
                    }
                }
                all.push(batch);
            }
        }
        assert_eq!(end, sources.len());
        (all, computed)
    }

    #[test]
    fn ranges_are_cut_like_the_whole_matrix() {
        let whole: Vec<usize> = (0..CHART.points()).collect();
        for batches in tilings() {
            let (all, computed) = split(batches, &whole);
            assert_eq!(computed, whole);
            let sizes: Vec<_> = all.iter().map(|batch| batch.sources.len()).collect();
            let expected: &[usize] =
                if batches.rows == 1 { &[16, 16, 10] } else { &[16, 8, 15, 3] };
            assert_eq!(sizes, expected);
            for first in 0..whole.len() {
                for end in first + 1..=whole.len() {
                    let (some, computed) = split(batches, &whole[first..end]);
                    assert_eq!(computed, whole[first..end]);
                    for batch in some {
                        assert!(all.iter().any(|one| one.sources == batch.sources), "{batch:?}");
                    }
                }
            }
        }
    }

    /// Resuming after any group must give the same bytes.
    #[test]
    fn remaining_sources_are_split_as_before() {
        let list: Vec<usize> = (0..40).map(|k| k * 11 % 42).chain(3..30).chain([3, 3, 5]).collect();
        for batches in tilings() {
            let groups: Vec<_> =
                batches.split(&list).map(|(group, all)| (group.end, all)).collect();
            for (k, (end, _)) in groups.iter().enumerate() {
                let rest = batches.split(&list[*end..]).map(|(_, all)| all);
                let sources = |all: &[Batch]| -> Vec<_> {
                    all.iter().map(|batch| batch.sources.clone()).collect()
                };
                let expected = groups[k + 1..].iter().map(|(_, all)| sources(all));
                assert!(rest.map(|all| sources(&all)).eq(expected));
            }
        }
    }

    #[test]
    fn any_list_is_computed_in_its_order() {
        let list: Vec<usize> =
            (0..40).map(|k| k * 11 % 42).chain([3, 3, 15, 16, 17]).chain(5..33).collect();
        for batches in tilings() {
            assert_eq!(split(batches, &list).1, list);
            assert!(split(batches, &[]).0.is_empty());
        }
    }
}
