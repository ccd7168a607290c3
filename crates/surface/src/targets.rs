//! Defines targets: grid points whose distances are needed. Once these are known, the map may end.

/// Grid points that let the computation of a map end once their distances are known.
///
/// A map with targets ends when no front can lower the distances of the needed targets any more. Points farther than
/// the last of these, including other targets, are unreached: their distance is +infinity.
///
/// ```
/// use geosweep::{Options, Sources, Spacing, Surface, Targets, distance_map};
///
/// let surface = Surface::from_heights(40, 50, vec![0.0; 2000], Spacing::square(1.0))?;
/// let options = Options::default().with_targets(Targets::any([[20, 26], [20, 40]]));
/// let map = distance_map(&surface, &Sources::point(20.0, 20.0), &options)?;
/// // The nearest target is 6 steps away, and nothing farther is reached.
/// assert_eq!(map.report.max_distance, 6.0);
/// assert!(map.distance(20, 40).is_infinite());
/// # Ok::<(), geosweep::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Targets {
    points: Vec<[usize; 2]>,
    /// Number of points whose distances are needed.
    needed: usize,
}

impl Targets {
    /// Returns targets with which the map ends when all of these points, given by row and column, have their
    /// distances. If one of the points cannot be reached, the whole map is computed.
    pub fn all(points: impl IntoIterator<Item = [usize; 2]>) -> Self {
        Self::nearest(usize::MAX, points)
    }

    /// Returns targets with which the map ends when the nearest of these points, given by row and column, has
    /// its distance.
    pub fn any(points: impl IntoIterator<Item = [usize; 2]>) -> Self {
        Self::nearest(1, points)
    }

    /// Returns targets with which the map ends when the `count` nearest of these points, given by row and
    /// column, have their distances.
    pub fn nearest(count: usize, points: impl IntoIterator<Item = [usize; 2]>) -> Self {
        let points: Vec<_> = points.into_iter().collect();
        let needed = count.clamp(1, points.len().max(1));
        Self { points, needed }
    }

    /// Returns the points, by row and column.
    pub fn points(&self) -> &[[usize; 2]] {
        &self.points
    }

    /// Returns the number of nearest points whose distances are needed.
    pub fn needed(&self) -> usize {
        self.needed
    }

    /// Returns these targets with `by` added to their rows and columns, for a grid that has `by` more rows and columns
    /// at its beginning.
    pub(crate) fn moved(mut self, by: [usize; 2]) -> Self {
        let points = self.points.iter_mut();
        points.for_each(|[row, col]| (*row, *col) = (*row + by[0], *col + by[1]));
        self
    }

    /// Returns the time by which as many targets as needed are reached, given the times at points. Later fronts do
    /// not matter to the targets. The time is +infinity if there is no target.
    #[doc(hidden)]
    pub fn last(&self, time: impl Fn([usize; 2]) -> f64) -> f64 {
        let mut times: Vec<_> = self.points.iter().map(|&point| time(point)).collect();
        if times.is_empty() {
            return f64::INFINITY;
        }
        *times.select_nth_unstable_by(self.needed - 1, f64::total_cmp).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_time_is_that_of_the_last_target_needed() {
        let points = [[0, 3], [0, 9], [0, 5]];
        let last = |targets: Targets| targets.last(|[_, col]| col as f64);
        assert_eq!(last(Targets::all(points)), 9.0);
        assert_eq!(last(Targets::any(points)), 3.0);
        assert_eq!(last(Targets::nearest(2, points)), 5.0);
        assert_eq!(last(Targets::nearest(7, points)), 9.0);
        assert_eq!(last(Targets::all([])), f64::INFINITY);
    }
}
