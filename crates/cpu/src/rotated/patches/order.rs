//! Decides which patches are visited next: those that no neighbour is about to change.

use geosweep_surface::{Chart, Real};

/// Times at which patches are due.
#[derive(Clone, Debug)]
pub(super) struct Dues<R> {
    /// The chart of the patches.
    chart: Chart,
    /// For each patch, the time of the earliest front that it has not seen yet.
    due: Vec<Option<R>>,
    /// A patch waits if it is due later than the first one by more than `band`, or later than a neighbour by
    /// more than `lag`.
    band: R,
    lag: R,
}

impl<R: Real> Dues<R> {
    pub(super) fn new(chart: Chart, band: R, lag: R) -> Self {
        Self { chart, due: vec![None; chart.points()], band, lag }
    }

    pub(super) fn clear(&mut self) {
        self.due.fill(None);
    }

    /// Notes that a patch has to see a front of this time.
    pub(super) fn enlist(&mut self, patch: usize, time: R) {
        let due = &mut self.due[patch];
        *due = Some(due.map_or(time, |due| due.min(time)));
    }

    /// Removes and returns the patches of the next round: the earliest patches that do not wait, at most `most`, in
    /// ascending order of their numbers. Patches that are due later than `limit` are never visited.
    pub(super) fn next_round(&mut self, most: usize, limit: R) -> Vec<usize> {
        let Some(first) = self.due.iter().flatten().copied().reduce(R::min) else {
            return Vec::new();
        };
        let last = (first + self.band).min(limit);
        let is_next = |patch: usize, time: R| time <= last && !self.waits(patch, time);
        let due = self.due.iter().enumerate().filter_map(|(patch, due)| Some((patch, (*due)?)));
        let mut round: Vec<_> = due.filter(|&(patch, time)| is_next(patch, time)).collect();
        if round.len() > most {
            round.sort_by(|(_, a), (_, b)| a.partial_cmp(b).expect("times are numbers"));
            round.truncate(most);
            round.sort_by_key(|&(patch, _)| patch);
        }
        round.into_iter().map(|(patch, _)| patch).inspect(|&patch| self.due[patch] = None).collect()
    }

    /// Returns whether a neighbour is due earlier by more than the lag.
    fn waits(&self, patch: usize, time: R) -> bool {
        let around = self.chart.around(self.chart.position(patch), 1);
        let mut due = around.places().filter_map(|(row, col)| self.due[self.chart.index(row, col)]);
        due.any(|due| due + self.lag < time)
    }

    /// Returns the time at which a patch is due.
    #[cfg(test)]
    fn of(&self, patch: usize) -> Option<R> {
        self.due[patch]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dues(times: &[(usize, f32)]) -> Dues<f32> {
        let mut dues = Dues::new(Chart { rows: 3, cols: 4 }, 10.0, 1.0);
        times.iter().for_each(|&(patch, time)| dues.enlist(patch, time));
        dues
    }

    #[test]
    fn a_patch_waits_for_a_neighbour_that_is_due_before_it() {
        // Patches 0, 1 and 5 touch one another, and patch 3 lies apart.
        let mut dues = dues(&[(0, 2.0), (1, 4.0), (5, 2.5), (3, 7.0), (3, 6.0)]);
        assert_eq!(dues.next_round(9, f32::INFINITY), [0, 3, 5]);
        assert_eq!((dues.of(1), dues.of(3)), (Some(4.0), None));
        assert_eq!(dues.next_round(9, f32::INFINITY), [1]);
        assert!(dues.next_round(9, f32::INFINITY).is_empty());
    }

    #[test]
    fn patches_far_from_the_first_front_wait() {
        let mut dues = dues(&[(0, 1.0), (11, 11.5), (3, 11.0)]);
        assert_eq!(dues.next_round(9, f32::INFINITY), [0, 3]);
        assert_eq!(dues.next_round(9, f32::INFINITY), [11]);
    }

    #[test]
    fn patches_that_are_due_after_the_limit_are_not_visited() {
        let mut dues = dues(&[(0, 1.0), (3, 4.0), (11, 4.5)]);
        assert_eq!(dues.next_round(9, 4.0), [0, 3]);
        assert!(dues.next_round(9, 4.0).is_empty());
        assert_eq!(dues.next_round(9, 5.0), [11]);
    }

    #[test]
    fn rounds_take_the_earliest_patches_if_there_are_too_many() {
        let mut dues = dues(&[(0, 3.0), (2, 1.0), (8, 2.0), (10, 2.0)]);
        assert_eq!(dues.next_round(2, f32::INFINITY), [2, 8]);
        assert_eq!(dues.next_round(2, f32::INFINITY), [0, 10]);
    }
}
