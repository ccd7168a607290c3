//! Provides the common parts of figures that reproduce the paper's tables.

/// The rows of one of the paper's tables: the number of points per side, and the paper's values for such a
/// grid.
pub struct Paper<const ROWS: usize, const N: usize>(pub [(usize, [f64; N]); ROWS]);

impl<const ROWS: usize, const N: usize> Paper<ROWS, N> {
    /// Returns the numbers of points per side.
    pub fn sides(&self) -> [usize; ROWS] {
        self.0.map(|(side, _)| side)
    }

    /// Returns the cells for a grid. They are empty if the paper has no grid of this size.
    pub fn cells<const M: usize>(
        &self,
        side: usize,
        cells: impl Fn([f64; N]) -> [String; M],
    ) -> [String; M] {
        let row = self.0.iter().find(|(other, _)| *other == side);
        row.map_or([(); M].map(|()| String::new()), |&(_, numbers)| cells(numbers))
    }
}

/// Returns " on a MACHINE", or nothing if the machine is not known.
pub fn on_a(machine: Option<&String>) -> String {
    machine.map_or(String::new(), |machine| format!(" on a {machine}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_empty_for_sizes_that_the_paper_does_not_have() {
        let paper = Paper([(32, [0.5, 2.0]), (64, [1.0, 3.0])]);
        let cells = |side| paper.cells(side, |[a, b]| [(b / a).to_string()]);
        assert_eq!((paper.sides(), cells(64), cells(33)), ([32, 64], ["3".into()], ["".into()]));
    }
}
