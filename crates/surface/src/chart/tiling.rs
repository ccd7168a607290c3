//! Defines tiles: the squares of points into which a chart is cut.

use std::ops::Range;

use super::{Block, Chart};

/// A chart cut into tiles of `side` x `side` points. The last tiles of rows and columns may be smaller.
#[derive(Clone, Copy, Debug)]
pub struct Tiling {
    chart: Chart,
    side: usize,
}

impl Tiling {
    #[doc(hidden)]
    #[inline]
    pub const fn new(chart: Chart, side: usize) -> Self {
        Self { chart, side }
    }

    /// Returns the chart that is cut.
    #[doc(hidden)]
    #[inline]
    pub const fn chart(self) -> Chart {
        self.chart
    }

    /// Returns a chart whose points are the tiles.
    #[doc(hidden)]
    #[inline]
    pub const fn tiles(self) -> Chart {
        let Chart { rows, cols } = self.chart;
        Chart { rows: rows.div_ceil(self.side), cols: cols.div_ceil(self.side) }
    }

    /// Returns the tile of a point, and the point's position in the tile, both by row and column.
    #[doc(hidden)]
    #[inline]
    pub const fn tile_of(self, (row, col): (usize, usize)) -> ((usize, usize), (usize, usize)) {
        let side = self.side;
        ((row / side, col / side), (row % side, col % side))
    }

    /// Returns the tiles, other than the tile of `point`, that have a point at most `reach` rows and columns
    /// away from it. A tile may occur more than once.
    #[cfg(any(test, feature = "twins"))]
    #[doc(hidden)]
    #[inline]
    pub fn beside(
        self,
        point: (usize, usize),
        reach: usize,
    ) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (own, _) = self.tile_of(point);
        let around = self.chart.around(point, reach).places();
        around.map(move |point| self.tile_of(point).0).filter(move |&tile| tile != own)
    }

    /// Returns the rows of points of some rows of tiles.
    #[doc(hidden)]
    #[inline]
    pub fn rows(self, tiles: Range<usize>) -> Range<usize> {
        self.lines(tiles, self.chart.rows)
    }

    /// Returns the columns of points of some columns of tiles.
    #[doc(hidden)]
    #[inline]
    pub fn cols(self, tiles: Range<usize>) -> Range<usize> {
        self.lines(tiles, self.chart.cols)
    }

    /// Returns the points of some rows and columns of tiles.
    #[doc(hidden)]
    #[inline]
    pub fn points(self, tiles: Block) -> Block {
        Block { rows: self.rows(tiles.rows), cols: self.cols(tiles.cols) }
    }

    fn lines(self, tiles: Range<usize>, count: usize) -> Range<usize> {
        tiles.start * self.side..(tiles.end * self.side).min(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_point_lies_in_one_tile() {
        let chart = Chart { rows: 7, cols: 12 };
        let tiling = Tiling::new(chart, 4);
        assert_eq!(tiling.tiles(), Chart { rows: 2, cols: 3 });
        let mut points = 0;
        for tile in tiling.tiles().places() {
            let block = tiling.points(tiling.tiles().around(tile, 0));
            points += block.chart().points();
            for place in block.places() {
                assert_eq!(tiling.tile_of(place), (tile, block.local(place)));
            }
        }
        assert_eq!(points, chart.points());
        assert!(tiling.beside((2, 4), 1).all(|tile| tile == (0, 0)));
        let corner: std::collections::BTreeSet<_> = tiling.beside((4, 7), 1).collect();
        assert!(corner.into_iter().eq([(0, 1), (0, 2), (1, 2)]));
        assert_eq!(tiling.beside((6, 1), 1).count(), 0);
        assert!(tiling.beside((6, 1), 3).any(|tile| tile == (1, 1)));
        let most = Block { rows: 0..2, cols: 1..3 };
        assert_eq!(tiling.points(most), Block { rows: 0..7, cols: 4..12 });
    }
}
