//! Groups of grid points that are copies of one surface point.

use std::collections::HashMap;

/// Groups of indices of one glued surface point, in compressed rows: the members of group g are
/// `members[starts[g]..starts[g + 1]]`, in ascending order. Each group has two members or more. No index is in two
/// groups.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Groups {
    starts: Vec<u32>,
    members: Vec<u32>,
    /// The number of each member's group.
    numbers: HashMap<u32, u32>,
}

impl Groups {
    fn new(starts: Vec<u32>, members: Vec<u32>) -> Self {
        let of_group = |(number, range): (u32, &[u32])| {
            members[range[0] as usize..range[1] as usize].iter().map(move |&index| (index, number))
        };
        let numbers = (0..).zip(starts.windows(2)).flat_map(of_group).collect();
        Self { starts, members, numbers }
    }

    /// Joins pairs of indices to groups.
    pub(in super::super) fn of(pairs: impl IntoIterator<Item = [usize; 2]>) -> Self {
        let mut parents: HashMap<u32, u32> = HashMap::new();
        for [a, b] in pairs {
            let [a, b] = [a, b].map(|index| root(&mut parents, index as u32));
            // The smallest index is the root.
            parents.insert(a.max(b), a.min(b));
        }
        let all: Vec<u32> = parents.keys().copied().collect();
        let mut rooted: Vec<_> =
            all.into_iter().map(|index| (root(&mut parents, index), index)).collect();
        rooted.sort_unstable();
        let (mut starts, mut members) = (vec![0], Vec::with_capacity(rooted.len()));
        for group in rooted.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() > 1) {
            members.extend(group.iter().map(|&(_, index)| index));
            starts.push(members.len() as u32);
        }
        Self::new(starts, members)
    }

    /// Returns these groups with indices converted by `to`, which must keep the order of the indices.
    #[inline]
    pub(crate) fn mapped(&self, to: impl Fn(usize) -> usize) -> Self {
        let members = self.members.iter().map(|&index| to(index as usize) as u32).collect();
        Self::new(self.starts.clone(), members)
    }

    /// Returns the members of each group.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> + Clone {
        self.starts.windows(2).map(|range| &self.members[range[0] as usize..range[1] as usize])
    }

    /// Returns the number of the group that an index belongs to.
    pub(crate) fn number(&self, index: usize) -> Option<u32> {
        self.numbers.get(&(index as u32)).copied()
    }

    /// Returns the members of the group that an index belongs to.
    #[doc(hidden)]
    pub fn around(&self, index: usize) -> Option<&[u32]> {
        let number = self.number(index)? as usize;
        Some(&self.members[self.starts[number] as usize..self.starts[number + 1] as usize])
    }

    /// Returns whether any group is a pole: more grid points than the four copies of a corner are one point.
    pub(crate) fn have_poles(&self) -> bool {
        self.starts.windows(2).any(|ends| ends[1] - ends[0] > 8)
    }

    /// Returns the start of each group in [`Self::members`], followed by the number of members.
    #[inline]
    pub fn starts(&self) -> &[u32] {
        &self.starts
    }

    /// Returns the members of all groups.
    #[inline]
    pub fn members(&self) -> &[u32] {
        &self.members
    }

    /// Returns, for each group, the pairs of its first member with each other member.
    pub(super) fn pairs(&self) -> impl Iterator<Item = [usize; 2]> {
        self.iter().flat_map(|group| {
            let first = group[0] as usize;
            group[1..].iter().map(move |&other| [first, other as usize])
        })
    }

    /// Returns the number of bytes held.
    #[inline]
    pub(crate) fn bytes(&self) -> usize {
        (self.starts.len() + 3 * self.members.len()) * size_of::<u32>()
    }
}

/// Returns the root of an index, and compresses the path to it.
fn root(parents: &mut HashMap<u32, u32>, index: u32) -> u32 {
    let mut top = index;
    while let Some(&parent) = parents.get(&top).filter(|&&parent| parent != top) {
        top = parent;
    }
    let mut at = index;
    while let Some(parent) = parents.insert(at, top).filter(|&parent| parent != at) {
        at = parent;
    }
    top
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_join_to_groups() {
        let groups = Groups::of([[7, 3], [1, 2], [9, 7], [2, 1], [3, 9], [5, 5]]);
        assert!(groups.iter().eq([&[1, 2][..], &[3, 7, 9][..]]));
        assert_eq!(groups.starts(), [0, 2, 5]);
        assert!(groups.pairs().eq([[1, 2], [3, 7], [3, 9]]));
        assert_eq!(groups.number(9), Some(1));
        assert_eq!(groups.mapped(|index| index + 1).members(), [2, 3, 4, 8, 10]);
    }
}
