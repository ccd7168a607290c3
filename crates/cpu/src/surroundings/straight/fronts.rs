//! Finds the first source to reach each point by straight lines, on surfaces whose cells are all alike.
//!
//! Where fronts of several sources meet, or a front and itself, an update does not know which front comes from where.
//! In long or sheared cells, the region of a source may even be too narrow to have neighbouring grid points, so that no
//! front can be followed from point to point. Over cells that are alike, a straight line tells the time without points
//! in between.

use glam::DVec2;

use super::holes::Holes;
use super::images::images;
use super::lines::{StraightLine, StraightLines};
use geosweep_surface::{Block, Chart, Origin, Real, Seed, Surface};

/// Number of parts of sources that are looked at for each point of a block. Where there are more, the block is divided.
const FEW: usize = 6;
/// Number of points of a block that is not divided any further.
const SMALL: usize = 4;
/// Number of points of a block of which a thread of its own takes one half.
const LARGE: usize = 1 << 14;
/// Maximum number of parts of sources, images included.
const MOST: usize = 1 << 22;
/// Relative difference up to which a line explains the time of a map. It is ten times the rounding of single precision.
const SAME_TIME: f64 = 1e-5;
/// Relative difference below which two sources are equally far.
const EQUAL: f64 = 1e-12;

/// The fronts of sources along straight lines.
pub struct StraightFronts {
    chart: Chart,
    lines: StraightLines,
    /// The parts of all sources, in the order of the sources.
    parts: Vec<Part>,
    /// The number of parts before those of each source, and of all parts.
    before: Vec<usize>,
    holes: Option<Holes>,
}

/// A point or segment of a source, or an image of it.
#[derive(Clone, Copy, Debug)]
struct Part {
    source: u32,
    origin: Origin,
    /// The step to this image.
    image: DVec2,
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
    /// The point or segment from which the front comes, or its image beyond a seam.
    pub origin: Origin,
    /// The place of the origin from which the front comes.
    pub foot: DVec2,
}

impl StraightFronts {
    /// Returns the fronts of sources that consist of points and segments. The result is `None` if cells differ, and if
    /// holes may hide the images of a source over a seam.
    #[doc(hidden)]
    pub fn new(surface: &Surface, sources: &[Vec<Origin>]) -> Option<Self> {
        let lines = StraightLines::of(surface.even_metric()?);
        let (chart, periods, holes) = (surface.chart(), surface.periods()?, Holes::of(surface));
        if holes.is_some() && !periods.is_empty() {
            return None;
        }
        let (mut parts, mut before) = (Vec::new(), vec![0]);
        for (source, origins) in (0..).zip(sources) {
            for origin in origins {
                let images = images(&lines, chart, &periods, origin).into_iter();
                let part = |image| Part { source, origin: origin.moved(image), image };
                parts.extend(images.map(part).take(MOST));
            }
            before.push(parts.len());
            if parts.len() >= MOST {
                return None;
            }
        }
        Some(Self { chart, lines, parts, before, holes })
    }

    /// Returns whether any points are missing, so that some points are reached on no straight line.
    #[doc(hidden)]
    pub fn has_holes(&self) -> bool {
        self.holes.is_some()
    }

    /// Returns the arrival time at each point, row-major. It is +infinity where a hole hides the nearest source.
    #[doc(hidden)]
    pub fn times<R: Real>(&self) -> Vec<R> {
        self.arrivals(None, R::infinity(), |first| R::of(first.time))
    }

    /// Returns exact seeds at all points whose nearest source no hole hides, in row-major order.
    #[doc(hidden)]
    pub fn seeds(&self) -> Vec<Seed> {
        let arrivals = self.first_arrivals(None).into_iter();
        let seed = |((row, col), first): ((usize, usize), Option<FirstArrival>)| {
            let FirstArrival { time, curvature, origin, .. } = first?;
            let curvature = curvature.min(Seed::AT_SOURCE);
            let from = (origin.is_point() && time > origin.start).then_some(origin.ends[0]);
            Some(Seed { curvature, from, exact: true, ..Seed::at_source(row, col, time) })
        };
        self.chart.places().zip(arrivals).filter_map(seed).collect()
    }

    /// Returns the first front at each point, row-major. If points are missing, these are the fronts that explain the
    /// times of a map; without a map, those of nearest sources that no hole hides.
    #[doc(hidden)]
    pub fn first_arrivals(&self, map: Option<&[f32]>) -> Vec<Option<FirstArrival>> {
        self.arrivals(map, None, Some)
    }

    /// Returns `value` of the first front at each point, or `none`.
    fn arrivals<T: Copy + Send>(
        &self,
        map: Option<&[f32]>,
        none: T,
        value: impl Fn(FirstArrival) -> T + Sync,
    ) -> Vec<T> {
        let mut values = vec![none; self.chart.points()];
        let block = Block { rows: 0..self.chart.rows, cols: 0..self.chart.cols };
        let all: Vec<u32> = (0..self.parts.len() as u32).collect();
        let map = map.filter(|_| self.holes.is_some());
        self.fill(block, &all, map, &value, &mut values);
        values
    }

    /// Writes the values of a block's points. `parts` may be the first at some of them, in ascending order; `rows` holds
    /// the rows of the block.
    fn fill<T: Copy + Send>(
        &self,
        block: Block,
        parts: &[u32],
        map: Option<&[f32]>,
        value: &(impl Fn(FirstArrival) -> T + Sync),
        rows: &mut [T],
    ) {
        let near = self.near(&block, parts, map);
        let Chart { cols, .. } = self.chart;
        let (points, [down, right]) = (block.chart().points(), self.sides(&block));
        if near.len() <= FEW || points <= SMALL {
            for (row, col) in block.places() {
                if let Some(first) = self.first((row, col), &near, map) {
                    rows[(row - block.rows.start) * cols + col] = value(first);
                }
            }
        } else if block.rows.len() > 1 && (down >= right || points > LARGE) {
            let middle = block.rows.start + block.rows.len() / 2;
            let (above, below) = rows.split_at_mut((middle - block.rows.start) * cols);
            let halves = [block.rows.start..middle, middle..block.rows.end];
            let [first, second] = halves.map(|rows| Block { rows, ..block.clone() });
            let above = || self.fill(first, &near, map, value, above);
            let below = || self.fill(second, &near, map, value, below);
            if points > LARGE {
                rayon::join(above, below);
            } else {
                above();
                below();
            }
        } else {
            let middle = block.cols.start + block.cols.len() / 2;
            for cols in [block.cols.start..middle, middle..block.cols.end] {
                self.fill(Block { cols, ..block.clone() }, &near, map, value, rows);
            }
        }
    }

    /// Returns the parts of sources that may be the first at some point of a block, in ascending order.
    fn near(&self, block: &Block, parts: &[u32], map: Option<&[f32]>) -> Vec<u32> {
        let last = DVec2::new(block.rows.end as f64 - 1.0, block.cols.end as f64 - 1.0);
        let half = 0.5 * (last - block.origin());
        let centre = block.origin() + half;
        let reach = self.lines.length(half).max(self.lines.length(DVec2::new(half.x, -half.y)));
        let time = |part: &u32| self.arrival(&self.parts[*part as usize], centre).0;
        let times: Vec<f64> = parts.iter().map(time).collect();
        let of_block = map.into_iter().flat_map(|map| {
            block.places().map(|(row, col)| f64::from(map[self.chart.index(row, col)]))
        });
        let latest = of_block.filter(|time| time.is_finite()).fold(f64::MIN, f64::max);
        let first = times.iter().copied().fold(f64::INFINITY, f64::min);
        let most = latest.max(first + reach) + reach;
        let is_near = |(_, time): &(&u32, f64)| *time <= most + SAME_TIME * most.abs();
        parts.iter().zip(times).filter(is_near).map(|(part, _)| *part).collect()
    }

    /// Returns the lengths of a block's sides, along columns and along rows.
    fn sides(&self, block: &Block) -> [f64; 2] {
        let [down, right] = [block.rows.len(), block.cols.len()].map(|points| points as f64 - 1.0);
        [DVec2::new(down, 0.0), DVec2::new(0.0, right)].map(|side| self.lines.length(side))
    }

    /// Returns the front that reaches a point first. Of sources that are equally far, the first is returned.
    fn first(
        &self,
        (row, col): (usize, usize),
        parts: &[u32],
        map: Option<&[f32]>,
    ) -> Option<FirstArrival> {
        let at = DVec2::new(row as f64, col as f64);
        let mut found: Option<(f64, &Part, StraightLine)> = None;
        for &part in parts {
            let part = &self.parts[part as usize];
            let (time, line) = self.arrival(part, at);
            let is_first = found.is_none_or(|(first, ..)| time < first - EQUAL * first.abs());
            if is_first && (map.is_none() || self.is_free(line.foot, at)) {
                found = Some((time, part, line));
            }
        }
        let (time, part, line) = found?;
        let is_explained = match map {
            Some(map) => {
                let of_map = f64::from(map[self.chart.index(row, col)]);
                time <= of_map + SAME_TIME * of_map.abs()
            }
            None => self.is_free(line.foot, at),
        };
        let is_straight = line.is_beside && line.length > 0.0;
        let curvature = if is_straight { 0.0 } else { line.length.recip() };
        let Part { source, origin, .. } = *part;
        is_explained.then_some(FirstArrival { source, time, curvature, origin, foot: line.foot })
    }

    /// Returns the arrival time of a source's front at a grid point, if no hole is in the way.
    #[doc(hidden)]
    pub fn time(&self, index: usize, source: u32) -> Option<f64> {
        Some(self.free_line(index, source)?.0)
    }

    /// Returns the point of a source from which its front arrives at a grid point, if no hole is in the way.
    #[doc(hidden)]
    pub fn foot(&self, index: usize, source: u32) -> Option<DVec2> {
        let (_, part, line) = self.free_line(index, source)?;
        Some(line.foot - part.image)
    }

    /// Returns the line of a source's front to a grid point with its time, if no hole is in the way.
    fn free_line(&self, index: usize, source: u32) -> Option<(f64, &Part, StraightLine)> {
        let (row, col) = self.chart.position(index);
        let at = DVec2::new(row as f64, col as f64);
        let source = source as usize;
        let lines = self.parts[self.before[source]..self.before[source + 1]].iter().map(|part| {
            let (time, line) = self.arrival(part, at);
            (time, part, line)
        });
        let first = lines.min_by(|a, b| a.0.total_cmp(&b.0));
        first.filter(|(.., line)| self.is_free(line.foot, at))
    }

    /// Returns the arrival time of a part's front at a place, and the line on which it arrives.
    #[inline]
    fn arrival(&self, part: &Part, at: DVec2) -> (f64, StraightLine) {
        let line = self.lines.from(&part.origin, at);
        (part.origin.start + line.length, line)
    }

    fn is_free(&self, from: DVec2, to: DVec2) -> bool {
        self.holes.as_ref().is_none_or(|holes| !holes.are_between(from, to))
    }
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

    /// Blocks look at all sources that may be the first at one of their points.
    #[test]
    fn first_arrivals_are_those_of_all_sources() {
        let surface = plane(50, 41);
        let line = |a: [f64; 2], b: [f64; 2]| Origin { ends: [a.into(), b.into()], start: 0.5 };
        let mut sources: Vec<_> = (0..30)
            .map(|k| (f64::from(k * 37 % 49), f64::from(k * 23 % 40), 0.1 * f64::from(k % 5)))
            .map(|(row, col, start)| point(row + 0.3, col + 0.6, start))
            .collect();
        sources.push(vec![line([3.0, 5.0], [9.5, 30.0]), line([9.5, 30.0], [40.0, 31.0])]);
        let fronts = StraightFronts::new(&surface, &sources).unwrap();
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
        let fronts = StraightFronts::new(&plane(21, 21), &sources).unwrap();
        let arrivals = fronts.first_arrivals(None);
        let at = |row: usize, col: usize| arrivals[row * 21 + col].unwrap().source;
        assert_eq!([at(10, 4), at(3, 10), at(20, 11)], [0, 0, 1]);
    }

    #[test]
    fn holes_hide_points() {
        let mask: Vec<_> =
            (0..21 * 31).map(|k| k / 31 != 10 || !(9..20).contains(&(k % 31))).collect();
        let surface = plane(21, 31).with_mask(&mask).unwrap();
        let fronts = StraightFronts::new(&surface, &[point(5.0, 15.0, 0.0)]).unwrap();
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
        assert!(StraightFronts::new(&bent, &[point(5.0, 5.0, 0.0)]).is_none());
    }
}
