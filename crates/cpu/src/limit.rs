//! Limits the travel of fronts: by a time, and by the times at which fronts reach given points.

use geosweep_surface::FAR;
use geosweep_surface::Targets;

/// The time after which fronts do not matter.
#[derive(Clone, Debug)]
pub(crate) struct Limit {
    /// Latest arrival time that matters to the map or to the targets.
    time: f64,
    targets: Option<Targets>,
}

/// Margin added to the targets' time, as a fraction of that time. A renewed front may be later than before, but by less
/// than this margin.
const LATER: f64 = 1e-4;

impl Limit {
    /// No limit.
    pub(crate) const NONE: Self = Self { time: f64::INFINITY, targets: None };

    /// Returns a limit by time alone.
    pub(crate) fn at(time: f64) -> Self {
        Self { time, targets: None }
    }

    /// Returns a limit that falls to the targets' arrival time once fronts have reached all targets.
    pub(crate) fn to(targets: &Targets, time: f64) -> Self {
        Self { time, targets: Some(targets.clone()) }
    }

    /// Returns the present limit.
    pub(crate) fn time(&self) -> f64 {
        self.time
    }

    /// Returns the targets whose times lower the limit.
    pub(crate) fn targets(&self) -> &[[usize; 2]] {
        self.targets.as_ref().map_or(&[], Targets::points)
    }

    /// Lowers the limit, given the present times at points. The final times are no later than these, apart from the
    /// margin for renewed fronts.
    pub(crate) fn lower(&mut self, time: impl Fn([usize; 2]) -> f64) {
        let Some(targets) = &self.targets else { return };
        let last = targets.last(time);
        if last < FAR {
            self.time = self.time.min(last * (1.0 + LATER));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_falls_to_the_time_that_targets_need() {
        let points = [[0, 5], [0, 9]];
        let time = |[_, col]: [usize; 2]| if col == 5 { 5.0 } else { 9.0 };
        let lowered = |targets: &Targets, from: f64, time: &dyn Fn([usize; 2]) -> f64| {
            let mut limit = Limit::to(targets, from);
            limit.lower(time);
            limit.time()
        };
        let [all, any] = [Targets::all(points), Targets::any(points)];
        assert!((lowered(&all, f64::INFINITY, &time) - 9.0).abs() < 0.01);
        assert!((lowered(&any, f64::INFINITY, &time) - 5.0).abs() < 0.01);
        assert_eq!(lowered(&all, 3.0, &time), 3.0);
        let none = |_: [usize; 2]| FAR;
        assert_eq!(lowered(&any, 7.0, &none), 7.0);
        assert_eq!(lowered(&all, 7.0, &|[_, col]| if col == 5 { 5.0 } else { FAR }), 7.0);
    }
}
