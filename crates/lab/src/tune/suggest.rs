//! Suggests the best portions.

use geosweep::vulkan::{Schedule, Tuning};

use super::results::{Knob, Row, Swept};

/// The ratio of times below which a change of value is worthwhile.
const WORTH: f64 = 0.97;

/// Returns `untuned` with each knob set to its best value, if this is worthwhile and leaves the maps the
/// same.
pub fn suggested(untuned: Tuning, rows: &[Row]) -> Tuning {
    let mut tuning = untuned;
    for knob in [Knob::Lines, Knob::Width, Knob::Tile, Knob::Inner] {
        let of_knob = rows.iter().filter(|row| row.knob == knob && !row.differs());
        let best = of_knob
            .filter_map(|row| Some((row.ratio?, row.value)))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .filter(|&(ratio, _)| ratio < WORTH);
        if let Some((_, value)) = best {
            tuning = knob.set(tuning, value);
        }
    }
    // A group must be wide enough for its lines. Values that are best separately may not fit together.
    let room = |tuning: &Tuning| tuning.scan_width > 2 * (tuning.scan_lines - 1);
    if !room(&tuning) {
        tuning = Tuning { scan_width: untuned.scan_width, ..tuning };
        if !room(&tuning) {
            tuning = Tuning { scan_lines: untuned.scan_lines, ..tuning };
        }
    }
    tuning
}

/// Returns the best number of iterations or rounds per submission for a schedule, and the ratio of its
/// times, if the change is worthwhile. This number is not a part of the suggested tuning, since its
/// default depends on the grid's size and its meaning on the schedule.
pub fn together(rows: &[Row], schedule: Schedule) -> Option<(u32, f64)> {
    let of_knob = |row: &&Row| row.schedule == schedule && row.knob == Knob::Together;
    rows.iter()
        .filter(of_knob)
        .filter(|row| !row.differs())
        .filter_map(|row| Some((row.value, row.ratio?)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|&(_, ratio)| ratio < WORTH)
}

/// The faster schedule on a task.
pub struct Choice {
    pub task: usize,
    /// The best times with the suggested or the untuned portions, in seconds.
    pub raster: Option<f64>,
    pub tiles: Option<f64>,
}

impl Choice {
    pub fn of(swept: &Swept) -> Vec<Self> {
        let best = |task: usize, schedule: Schedule| {
            let is_final = |row: &&Row| {
                row.schedule == schedule
                    && !row.differs()
                    && [Knob::Untuned, Knob::Suggested].contains(&row.knob)
            };
            let rows = swept.rows.iter().filter(is_final);
            let maps = rows.flat_map(|row| &row.maps).filter(|map| map.task == task);
            maps.map(|map| map.best.as_secs_f64()).reduce(f64::min)
        };
        let choice = |task| Self {
            task,
            raster: best(task, Schedule::Raster),
            tiles: best(task, Schedule::Tiles),
        };
        (0..swept.tasks.len()).map(choice).collect()
    }

    pub fn winner(&self) -> Option<Schedule> {
        match (self.raster, self.tiles) {
            (Some(raster), Some(tiles)) if tiles < raster => Some(Schedule::Tiles),
            (Some(_), _) => Some(Schedule::Raster),
            (None, Some(_)) => Some(Schedule::Tiles),
            (None, None) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::super::results::Map;
    use super::*;

    const UNTUNED: Tuning = Tuning { scan_width: 128, scan_lines: 8, ..Tuning::ON_CPU };

    fn row(knob: Knob, value: u32, ratio: f64, difference: f64) -> Row {
        let [best, untuned] = [Duration::from_millis(1); 2];
        let maps = vec![Map { task: 0, best, untuned, iterations: 3, difference }];
        let ratio = Some(ratio);
        Row { schedule: Schedule::Raster, knob, value, maps, refused: None, ratio }
    }

    #[test]
    fn the_best_value_that_is_worth_it_and_right_is_suggested() {
        let rows = [
            row(Knob::Lines, 4, 0.9, 0.0),
            row(Knob::Lines, 16, 0.8, 1e-3), // wrong
            row(Knob::Lines, 2, 0.95, 0.0),
            row(Knob::Width, 64, 0.98, 0.0), // not worth it
            row(Knob::Together, 8, 0.5, 0.0),
        ];
        assert_eq!(suggested(UNTUNED, &rows), Tuning { scan_lines: 4, ..UNTUNED });
        assert_eq!(together(&rows, Schedule::Raster), Some((8, 0.5)));
        assert_eq!(together(&rows, Schedule::Tiles), None);
    }

    #[test]
    fn values_that_do_not_fit_together_are_not_suggested() {
        let rows = [row(Knob::Lines, 32, 0.9, 0.0), row(Knob::Width, 32, 0.9, 0.0)];
        assert_eq!(suggested(UNTUNED, &rows), Tuning { scan_lines: 32, ..UNTUNED });
    }
}
