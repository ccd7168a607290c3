//! The part of a surface whose fronts a queue solves: all of it, or a patch with the points around it.

use crate::lines::window::Window;
use geosweep_surface::{Block, Chart};

/// A window of the surface. Points are entries of its own arrays, and have another index in the arrays of the surface.
#[derive(Clone, Debug)]
pub(super) struct View {
    window: Window,
    patch: Option<Patch>,
}

#[derive(Clone, Debug)]
struct Patch {
    /// The points that are solved here. Those around them belong to other patches.
    block: Block,
    /// The index on the surface of each entry.
    on_surface: Vec<u32>,
}

impl View {
    /// Returns the view of the whole surface.
    pub(super) fn whole(grid: Chart) -> Self {
        Self { window: Window::whole(grid), patch: None }
    }

    /// Returns the view of a block, and of the points at most `reach` rows and columns away.
    pub(super) fn around(grid: Chart, block: &Block, reach: usize) -> Self {
        let [rows, cols] = [&block.rows, &block.cols].map(|span| [span.start, span.end - 1]);
        let window = Window::new(grid, &grid.around_span(rows, cols, [reach; 2]));
        let (own, (row, col)) = (window.own(), window.first());
        let entries = (0..own.bordered_points()).map(|point| {
            let (down, right) = own.entry(point);
            grid.entry_index(row + down, col + right) as u32
        });
        let on_surface = entries.collect();
        Self { window, patch: Some(Patch { block: block.clone(), on_surface }) }
    }

    /// Returns the layout of the arrays.
    pub(super) fn layout(&self) -> Chart {
        self.window.own()
    }

    /// Returns the index of a point of the surface, given by row and column.
    pub(super) fn at(&self, (row, col): (usize, usize)) -> usize {
        self.window.index(row, col)
    }

    /// Returns the index of a point of the surface.
    #[inline(always)]
    pub(super) fn here(&self, on_surface: usize) -> usize {
        match &self.patch {
            None => on_surface,
            Some(_) => self.at(self.window.grid().bordered_position(on_surface)),
        }
    }

    /// Returns the index of a point of the surface, if it is solved here.
    #[inline(always)]
    pub(super) fn own(&self, on_surface: usize) -> Option<usize> {
        let Some(Patch { block, .. }) = &self.patch else { return Some(on_surface) };
        let place = self.window.grid().bordered_position(on_surface);
        block.has(place).then(|| self.at(place))
    }

    /// Returns the index on the surface of a point.
    #[inline(always)]
    pub(super) fn on_surface(&self, point: usize) -> usize {
        match &self.patch {
            None => point,
            Some(Patch { on_surface, .. }) => on_surface[point] as usize,
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.patch.as_ref().map_or(0, |patch| size_of_val(patch.on_surface.as_slice()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_those_of_the_same_points() {
        let grid = Chart { rows: 9, cols: 11 };
        for block in [grid.around((4, 8), 2), grid.around((0, 0), 3)] {
            let view = View::around(grid, &block, 2);
            let mut seen = 0;
            for (row, col) in grid.places().filter(|&(row, col)| {
                row + 2 >= block.rows.start
                    && row < block.rows.end + 2
                    && col + 2 >= block.cols.start
                    && col < block.cols.end + 2
            }) {
                let (point, on_surface) = (view.at((row, col)), grid.bordered(row, col));
                assert_eq!((view.on_surface(point), view.here(on_surface)), (on_surface, point));
                assert_eq!(view.own(on_surface), block.has((row, col)).then_some(point));
                seen += 1;
            }
            assert_eq!(seen, view.layout().points());
        }
        let whole = View::whole(grid);
        assert_eq!((whole.here(17), whole.own(17), whole.on_surface(17)), (17, Some(17), 17));
    }
}
