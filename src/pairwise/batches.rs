//! Which maps are computed side by side.

use std::ops::Range;

/// Maps to compute together, and which of them are wanted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Batch {
    /// Grid points.
    pub sources: Vec<usize>,
    /// By their place in `sources`.
    pub wanted: Range<usize>,
}

/// Splits sources, in order, into batches of at most `lanes` maps.
///
/// What else is in a batch can change a map's last bits. So wherever sources follow one another,
/// batches are those of the whole matrix, filled up with neighbours that nobody wants: their lanes
/// would be idle anyhow.
pub(super) fn batches(
    sources: &[usize],
    points: usize,
    lanes: usize,
) -> impl Iterator<Item = Batch> {
    let mut rest = sources;
    std::iter::from_fn(move || {
        let (&first, _) = rest.split_first()?;
        let (batch, after) = rest.split_at(batch_length(rest, lanes));
        rest = after;
        let follow = batch.iter().zip(first..).all(|(&source, expected)| source == expected);
        if !follow {
            return Some(Batch { sources: batch.to_vec(), wanted: 0..batch.len() });
        }
        let begin = first - first % lanes;
        let wanted = first - begin..first - begin + batch.len();
        Some(Batch { sources: (begin..points.min(begin + lanes)).collect(), wanted })
    })
}

/// How many of the sources the first batch takes: up to the next batch of the whole matrix, if they
/// follow one another there.
fn batch_length(sources: &[usize], lanes: usize) -> usize {
    let begins = |pair: &[usize]| pair[1] == pair[0] + 1 && pair[1].is_multiple_of(lanes);
    let next = sources.windows(2).position(begins).map_or(sources.len(), |before| before + 1);
    next.min(lanes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(sources: &[usize]) -> Vec<Batch> {
        batches(sources, 42, 16).collect()
    }

    #[test]
    fn ranges_are_cut_like_the_whole_matrix() {
        let whole: Vec<usize> = (0..42).collect();
        let all = split(&whole);
        assert_eq!(all.iter().map(|batch| batch.wanted.len()).collect::<Vec<_>>(), [16, 16, 10]);
        for first in 0..42 {
            for end in first + 1..=42 {
                let mut wanted = Vec::new();
                for batch in split(&whole[first..end]) {
                    let place = all.iter().find(|one| one.sources == batch.sources);
                    assert!(place.is_some(), "{first}..{end}: {batch:?}");
                    wanted.extend_from_slice(&batch.sources[batch.wanted]);
                }
                assert_eq!(wanted, whole[first..end]);
            }
        }
    }

    #[test]
    fn any_list_is_computed_in_its_order() {
        let list: Vec<usize> = (0..40).map(|k| k * 11 % 42).chain([3, 3, 15, 16, 17]).collect();
        let computed: Vec<usize> = split(&list)
            .into_iter()
            .flat_map(|batch| batch.sources[batch.wanted].to_vec())
            .collect();
        assert_eq!(computed, list);
        assert!(split(&[]).is_empty());
    }
}
