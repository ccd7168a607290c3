//! Finds the first source to reach each point by straight lines, on surfaces whose cells are all alike.
//!
//! In long or sheared cells, the region of a source may be too narrow to have neighbouring grid points, so that no
//! front can be followed from point to point. Over cells that are alike, a straight line tells the time without points
//! in between.

use glam::DVec2;
use rayon::prelude::*;

use super::holes::Holes;
use super::straight_lines::{StraightLine, StraightLines};
use geosweep_surface::{Block, Chart, Origin, Source, Surface, Tiling};

/// Rows and columns of the tiles for whose points the sources to look at are found together.
const TILE: usize = 16;
/// Relative difference up to which a line explains the time of a map. It is ten times the rounding of single precision.
const SAME_TIME: f64 = 1e-5;
/// Relative difference below which two sources are equally far.
const EQUAL: f64 = 1e-12;

/// The fronts of sources along straight lines.
pub struct StraightFronts {
    chart: Chart,
    lines: StraightLines,
    /// The points and segments of each source.
    sources: Vec<Vec<Origin>>,
    holes: Option<Holes>,
}

/// The front that reaches a point first on a straight line.
#[derive(Clone, Copy, Debug)]
pub struct FirstArrival {
    /// The index of the source.
    pub source: u32,
    /// Arrival time.
    pub time: f64,
    /// Curvature of the front at the point.
    pub curvature: f64,
}

impl StraightFronts {
    /// Returns the fronts of sources that consist of points and segments. The result is `None` if cells differ.
    #[doc(hidden)]
    pub fn new(surface: &Surface, sources: Vec<Vec<Origin>>) -> Option<Self> {
        if !surface.has_even_cells() {
            return None;
        }
        let lines = StraightLines::around(surface, whole_cell(surface)?)?;
        Some(Self { chart: surface.chart(), lines, sources, holes: Holes::of(surface) })
    }

    /// Returns whether any points are missing, so that some points are reached on no straight line.
    #[doc(hidden)]
    pub fn has_holes(&self) -> bool {
        self.holes.is_some()
    }

    /// Returns the first front at each point that no hole hides from all sources, row-major. If points are missing, only
    /// fronts count that explain the times of a map.
    #[doc(hidden)]
    pub fn first_arrivals(&self, map: Option<&[f32]>) -> Vec<Option<FirstArrival>> {
        let tiling = Tiling::new(self.chart, TILE);
        let cols = self.chart.cols;
        let mut arrivals = vec![None; self.chart.points()];
        arrivals.par_chunks_mut(TILE * cols).enumerate().for_each(|(row, arrivals)| {
            for col in 0..tiling.tiles().cols {
                let tile = tiling.points(tiling.tiles().around((row, col), 0));
                let nearby = self.sources_near(&tile, map);
                for at in tile.places() {
                    let time = map.map(|map| f64::from(map[self.chart.index(at.0, at.1)]));
                    let place = DVec2::new(at.0 as f64, at.1 as f64);
                    let first = self.first(place, &nearby);
                    arrivals[(at.0 - tile.rows.start) * cols + at.1] =
                        first.filter(|first| self.is_explained(time, first));
                }
            }
        });
        arrivals
    }

    fn is_explained(&self, time: Option<f64>, first: &FirstArrival) -> bool {
        let is_as_early = |time: f64| first.time <= time + SAME_TIME * time.abs();
        self.holes.is_none() || time.is_some_and(is_as_early)
    }

    /// Returns the sources that may be the first at some point of a tile, in ascending order.
    fn sources_near(&self, tile: &Block, map: Option<&[f32]>) -> Vec<u32> {
        let last = DVec2::new(tile.rows.end as f64 - 1.0, tile.cols.end as f64 - 1.0);
        let half = 0.5 * (last - tile.origin());
        let centre = tile.origin() + half;
        let reach = self.lines.length(half).max(self.lines.length(DVec2::new(half.x, -half.y)));
        let times: Vec<f64> =
            (0..self.sources.len()).map(|source| self.line(source, centre).0).collect();
        let of_tile = map.into_iter().flat_map(|map| {
            tile.places().map(|(row, col)| f64::from(map[self.chart.index(row, col)]))
        });
        let latest = of_tile.filter(|time| time.is_finite()).fold(f64::MIN, f64::max);
        let first = times.iter().copied().fold(f64::INFINITY, f64::min);
        let most = latest.max(first + reach) + reach;
        let is_near = |source: &u32| times[*source as usize] <= most + SAME_TIME * most.abs();
        (0..times.len() as u32).filter(is_near).collect()
    }

    /// Returns the source from which a front reaches a place first. Of sources that are equally far, the first is
    /// returned.
    fn first(&self, at: DVec2, sources: &[u32]) -> Option<FirstArrival> {
        let mut found: Option<FirstArrival> = None;
        for &source in sources {
            let (time, line) = self.line(source as usize, at);
            let is_first = found.is_none_or(|first| time < first.time - EQUAL * first.time.abs());
            if is_first && self.is_free(line.foot, at) {
                let is_straight = line.is_beside && line.length > 0.0;
                let curvature = if is_straight { 0.0 } else { line.length.recip() };
                found = Some(FirstArrival { source, time, curvature });
            }
        }
        found
    }

    /// Returns the arrival time of a source's front at a grid point, if no hole is in the way.
    #[doc(hidden)]
    pub fn time(&self, index: usize, source: u32) -> Option<f64> {
        let (row, col) = self.chart.position(index);
        let at = DVec2::new(row as f64, col as f64);
        let (time, line) = self.line(source as usize, at);
        self.is_free(line.foot, at).then_some(time)
    }

    /// Returns the point of a source from which its front arrives at a grid point, if no hole is in the way.
    #[doc(hidden)]
    pub fn foot(&self, index: usize, source: u32) -> Option<DVec2> {
        let (row, col) = self.chart.position(index);
        let at = DVec2::new(row as f64, col as f64);
        let (_, line) = self.line(source as usize, at);
        self.is_free(line.foot, at).then_some(line.foot)
    }

    /// Returns the arrival time of a source's front at a place, and the line on which it arrives first.
    fn line(&self, source: usize, at: DVec2) -> (f64, StraightLine) {
        let lines = self.sources[source].iter().map(|origin| {
            let line = self.lines.from(origin, at);
            (origin.start + line.length, line)
        });
        let none =
            (f64::INFINITY, StraightLine { foot: at, length: f64::INFINITY, is_beside: false });
        lines.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or(none)
    }

    fn is_free(&self, from: DVec2, to: DVec2) -> bool {
        self.holes.as_ref().is_none_or(|holes| !holes.are_between(from, to))
    }
}

/// Returns the points and segments of a source.
#[doc(hidden)]
pub fn straight_parts(source: &Source) -> Vec<Origin> {
    match source {
        Source::Point { at, initial } => vec![Origin::point(*at, *initial)],
        Source::Curve { vertices, initial } if vertices.len() < 2 => {
            vertices.iter().map(|at| Origin::point(*at, *initial)).collect()
        }
        Source::Curve { vertices, initial } => vertices
            .windows(2)
            .map(|ends| Origin { ends: [ends[0], ends[1]], start: *initial })
            .collect(),
    }
}

/// Returns the middle of the cell nearest to the middle of the chart of which no corner is missing.
fn whole_cell(surface: &Surface) -> Option<DVec2> {
    let chart = surface.chart();
    let middle = 0.5 * DVec2::new(chart.rows as f64, chart.cols as f64);
    let is_whole = |&(row, col): &(usize, usize)| {
        (row..row + 2).all(|row| (col..col + 2).all(|col| surface.has(row, col)))
    };
    let cells = chart.places().filter(is_whole);
    let centres = cells.map(|(row, col)| DVec2::new(row as f64 + 0.5, col as f64 + 0.5));
    let from_middle = |at: &DVec2| at.distance_squared(middle);
    centres.min_by(|a, b| from_middle(a).total_cmp(&from_middle(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geosweep_surface::Spacing;

    fn plane(rows: usize, cols: usize) -> Surface {
        let spacing = Spacing { dx: 1.0, dy: 7.0 };
        Surface::from_heights(rows, cols, vec![0.0; rows * cols], spacing).unwrap()
    }

    fn point(row: f64, col: f64, start: f64) -> Vec<Origin> {
        vec![Origin::point(DVec2::new(row, col), start)]
    }

    /// Tiles look at all sources that may be the first at one of their points.
    #[test]
    fn first_arrivals_are_those_of_all_sources() {
        let surface = plane(50, 41);
        let line = |a: [f64; 2], b: [f64; 2]| Origin { ends: [a.into(), b.into()], start: 0.5 };
        let mut sources: Vec<_> = (0..30)
            .map(|k| (f64::from(k * 37 % 49), f64::from(k * 23 % 40), 0.1 * f64::from(k % 5)))
            .map(|(row, col, start)| point(row + 0.3, col + 0.6, start))
            .collect();
        sources.push(vec![line([3.0, 5.0], [9.5, 30.0]), line([9.5, 30.0], [40.0, 31.0])]);
        let fronts = StraightFronts::new(&surface, sources).unwrap();
        let arrivals = fronts.first_arrivals(None);
        for (index, first) in arrivals.into_iter().enumerate() {
            let first = first.unwrap();
            let times = (0..31).map(|source| fronts.time(index, source).unwrap());
            assert_eq!(first.time, times.fold(f64::INFINITY, f64::min), "{index}");
            assert_eq!(fronts.time(index, first.source), Some(first.time));
        }
    }

    #[test]
    fn equally_far_points_belong_to_the_first_source() {
        let sources = vec![point(10.0, 4.0, 0.0), point(10.0, 16.0, 0.0), point(10.0, 4.0, 0.0)];
        let fronts = StraightFronts::new(&plane(21, 21), sources).unwrap();
        let arrivals = fronts.first_arrivals(None);
        let at = |row: usize, col: usize| arrivals[row * 21 + col].unwrap().source;
        assert_eq!([at(10, 4), at(3, 10), at(20, 11)], [0, 0, 1]);
    }

    #[test]
    fn holes_hide_points() {
        let mask: Vec<_> =
            (0..21 * 31).map(|k| k / 31 != 10 || !(9..20).contains(&(k % 31))).collect();
        let surface = plane(21, 31).with_mask(&mask).unwrap();
        let fronts = StraightFronts::new(&surface, vec![point(5.0, 15.0, 0.0)]).unwrap();
        assert!(fronts.has_holes());
        let late = vec![1e9; 21 * 31];
        let arrivals = fronts.first_arrivals(Some(&late));
        let is_seen = |row: usize, col: usize| arrivals[row * 31 + col].is_some();
        assert!(is_seen(0, 0) && is_seen(9, 15) && is_seen(20, 0) == is_seen(20, 30));
        assert!(!is_seen(15, 15) && fronts.time(15 * 31 + 15, 0).is_none());
        // A time before that of the straight line is another source's.
        let early = vec![0.1; 21 * 31];
        assert_eq!(fronts.first_arrivals(Some(&early)).iter().flatten().count(), 1);
    }

    #[test]
    fn cells_that_differ_have_none() {
        let mut heights = vec![0.0; 21 * 21];
        heights[200] = 1.0;
        let bent = Surface::from_heights(21, 21, heights, Spacing::square(1.0)).unwrap();
        assert!(StraightFronts::new(&bent, vec![point(5.0, 5.0, 0.0)]).is_none());
    }
}
