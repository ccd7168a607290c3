//! Finds the copies of points of closed surfaces, in bordered arrays.

use super::MapError;
use super::order::{bordered, rank};
use geosweep_surface::{EdgeLengths, Groups, Real};

/// Groups of points that are copies of one point of the surface. Open surfaces have no groups.
#[derive(Clone, Debug, Default)]
pub(super) struct Copies {
    groups: Option<Groups>,
}

impl Copies {
    pub(super) fn new(edges: &EdgeLengths<f32>) -> Self {
        Self { groups: edges.copies().cloned() }
    }

    /// Returns the copies and a map in a bordered array ([`bordered`]). All copies of a point have the earliest of their
    /// times, which may differ by rounding in the given map.
    pub(super) fn with_times(
        edges: &EdgeLengths<f32>,
        distances: &[f32],
    ) -> Result<(Self, Vec<f32>), MapError> {
        let (copies, mut times) = (Self::new(edges), bordered(edges.chart(), distances)?);
        for group in copies.groups() {
            let time = group.iter().fold(f32::FAR, |time, &copy| time.min(times[copy as usize]));
            group.iter().for_each(|&copy| times[copy as usize] = time);
        }
        Ok((copies, times))
    }

    /// Returns whether the surface has no copies.
    pub(super) fn is_none(&self) -> bool {
        self.groups.is_none()
    }

    /// Returns the copies of a point in ascending order, the point itself included. Returns `None` if it has
    /// no other copy.
    fn group(&self, point: usize) -> Option<&[u32]> {
        self.groups.as_ref()?.around(point)
    }

    /// Returns the groups of copies.
    pub(super) fn groups(&self) -> impl Iterator<Item = &[u32]> {
        self.groups.iter().flat_map(Groups::iter)
    }

    /// Returns whether a point has other copies.
    pub(super) fn has(&self, point: usize) -> bool {
        self.group(point).is_some()
    }

    /// Returns all copies of a point, the point itself included. The result is empty if it has no other copy.
    pub(super) fn copies(&self, point: usize) -> impl Iterator<Item = usize> + Clone {
        self.group(point).into_iter().flatten().map(|&copy| copy as usize)
    }

    /// Returns a point and its other copies.
    pub(super) fn all(&self, point: usize) -> impl Iterator<Item = usize> + Clone {
        std::iter::once(point).chain(self.copies(point).filter(move |&copy| copy != point))
    }

    /// Returns the copy of a point with the given number, from 0. A point without copies counts as its own
    /// first copy.
    pub(super) fn nth(&self, point: usize, number: usize) -> Option<usize> {
        match self.group(point) {
            Some(group) => group.get(number).map(|&copy| copy as usize),
            None => (number == 0).then_some(point),
        }
    }

    /// Returns the first copy of a point, which stands for all of them.
    #[inline]
    pub(super) fn first(&self, point: usize) -> usize {
        self.group(point).map_or(point, |group| group[0] as usize)
    }

    /// Returns the rank of a point in the order of arrival, which all its copies share.
    #[inline]
    pub(super) fn rank(&self, times: &[f32], point: usize) -> u64 {
        let first = self.first(point);
        rank(times[first], first)
    }
}
