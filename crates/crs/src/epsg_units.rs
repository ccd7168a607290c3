//! Looks up the coordinate reference systems of the EPSG register (v12.029) whose unit of length is not the metre.
//! GeoTIFF 1.1 lets the system's number determine the unit.

/// Runs of systems, a line each: their kind, the numbers of the first and the last one, and the number of their unit.
/// All systems within a run have that unit.
const RUNS: &str = include_str!("epsg_units.csv");

/// Returns the unit of a projected system, if it is not the metre.
pub fn projected(system: u16) -> Option<u16> {
    find("projected", system)
}

/// Returns the unit of a vertical system, if it is not the metre.
pub fn vertical(system: u16) -> Option<u16> {
    find("vertical", system)
}

fn find(kind: &str, system: u16) -> Option<u16> {
    RUNS.lines().filter_map(|line| line.strip_prefix(kind)?.strip_prefix(',')).find_map(|run| {
        let mut numbers = run.split(',').map(|number| number.parse::<u16>());
        let [first, last, unit] = [(); 3].map(|()| numbers.next().and_then(Result::ok));
        (first?..=last?).contains(&system).then_some(unit?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_a_run() {
        assert_eq!(RUNS.lines().skip(1).count(), 490);
        for line in RUNS.lines().skip(1) {
            let [kind, first, last, unit] = line.split(',').collect::<Vec<_>>()[..] else {
                panic!("{line}")
            };
            for end in [first, last] {
                assert_eq!(find(kind, end.parse().unwrap()), unit.parse().ok(), "{line}");
            }
        }
        assert_eq!([projected(32616), vertical(5773)], [None; 2]);
    }
}
