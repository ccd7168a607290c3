//! Accesses the neighbours of a point and the triangles between them, in bordered arrays.

use glam::{DMat2, DVec2};

use geosweep_surface::{Chart, Direction, EdgeLengths, EdgeSlot, Offset, Real, ring};

/// One neighbour: its index offset, the edge to it, and the edge from it to the next neighbour.
#[derive(Clone, Copy, Debug)]
struct Neighbour {
    offset: Offset,
    edge: EdgeSlot,
    base: EdgeSlot,
}

/// The eight neighbours of a point, in the order of [`Direction::ALL`].
#[derive(Clone, Debug)]
pub(super) struct Neighbourhood<'a> {
    edges: &'a EdgeLengths<f32>,
    neighbourhood: [Neighbour; 8],
}

impl<'a> Neighbourhood<'a> {
    pub(super) fn new(edges: &'a EdgeLengths<f32>) -> Self {
        let chart = edges.chart();
        let neighbourhood = Direction::ALL.map(|to| {
            let offset = chart.offset(to);
            let base = EdgeSlot::new(chart, offset, to.base());
            Neighbour { offset, edge: EdgeSlot::of(chart, to), base }
        });
        Self { edges, neighbourhood }
    }

    pub(super) fn chart(&self) -> Chart {
        self.edges.chart()
    }

    /// Returns the index of the neighbour in direction `to`.
    #[inline]
    pub(super) fn neighbour(&self, point: usize, to: usize) -> usize {
        self.neighbourhood[to].offset.from(point)
    }

    /// Returns the indices of all eight neighbours.
    #[inline]
    pub(super) fn neighbours(&self, point: usize) -> impl Iterator<Item = usize> {
        self.neighbourhood.iter().map(move |neighbour| neighbour.offset.from(point))
    }

    /// Returns the length of the edge to a neighbour, or [`Real::FAR`] if there is no such edge.
    #[inline]
    pub(super) fn length(&self, point: usize, to: usize) -> f64 {
        wide(self.edges.at(point, self.neighbourhood[to].edge))
    }

    /// Returns the length of the edge between two neighbouring points, or 0 if the points are not neighbours.
    pub(super) fn length_between(&self, from: usize, to: usize) -> f64 {
        let towards = (0..8).find(|&direction| self.neighbour(from, direction) == to);
        towards.map_or(0.0, |direction| self.length(from, direction))
    }

    /// Returns the length of the edge from a neighbour to the next neighbour.
    #[inline]
    pub(super) fn base(&self, point: usize, to: usize) -> f64 {
        wide(self.edges.at(point, self.neighbourhood[to].base))
    }

    /// Returns the arrival time at a point of the ray of a circular wavefront across the base between a neighbour and
    /// the next one, and the position on the base where it crosses, from 0 to 1.
    ///
    /// `since` holds the times since the start at both neighbours, infinite where they are not known. Returns
    /// `None` unless at least one of the neighbours has both a known time and an edge to the point.
    pub(super) fn ray(&self, point: usize, to: usize, since: [f64; 2]) -> Option<(f64, f64)> {
        let next = ring::next(to);
        let [a, b] = [to, next].map(|to| self.length(point, to));
        let there = [since[0] < f64::FAR && a < f64::FAR, since[1] < f64::FAR && b < f64::FAR];
        let along = [(since[0] + a, 0.0), (since[1] + b, 1.0)];
        match there {
            [false, false] => return None,
            [true, false] => return Some(along[0]),
            [false, true] => return Some(along[1]),
            [true, true] => {}
        }
        let edge = if along[0].0 <= along[1].0 { along[0] } else { along[1] };
        let base = self.base(point, to);
        if !(base > 0.0 && base < f64::FAR) {
            return Some(edge);
        }
        // Positions of the wavefront's centre and of the point, with the base from (0, 0) to (base, 0).
        let place = |to_first: f64, to_last: f64| {
            let along = 0.5 * (base + (to_first - to_last) * (to_first + to_last) / base);
            DVec2::new(along, (to_first * to_first - along * along).max(0.0).sqrt())
        };
        let (centre, here) = (place(since[0], since[1]), place(a, b));
        let share = (centre.x * here.y + here.x * centre.y) / ((centre.y + here.y) * base);
        if !(share > 0.0 && share < 1.0) {
            return Some(edge);
        }
        Some((centre.distance(DVec2::new(here.x, -here.y)), share))
    }

    /// Returns the first ray that arrives at a point: its time, its base, and where it crosses the base.
    /// `since` holds the times since the start at the neighbours.
    pub(super) fn first_ray(&self, point: usize, since: &[f64; 8]) -> Option<(f64, usize, f64)> {
        let ray = |to: usize| {
            let (time, share) = self.ray(point, to, [since[to], since[ring::next(to)]])?;
            Some((time, to, share))
        };
        let earlier = |a: &(f64, usize, f64), b: &(f64, usize, f64)| a.0.total_cmp(&b.0);
        // The ray nearly always crosses a base next to the neighbour with the shortest path along an edge.
        // The other bases are tried only if it does not.
        let (mut shortest, mut nearest) = (f64::FAR, None);
        for (to, &since) in since.iter().enumerate().filter(|&(_, &since)| since < f64::FAR) {
            let along = since + self.length(point, to);
            if along < shortest {
                (shortest, nearest) = (along, Some(to));
            }
        }
        let nearest = nearest?;
        let beside =
            [ring::previous(nearest), nearest].into_iter().filter_map(ray).min_by(earlier)?;
        if beside.2 > 0.0 && beside.2 < 1.0 {
            return Some(beside);
        }
        (0..8).filter_map(ray).min_by(earlier)
    }

    /// Returns the metric at a point in steps of rows and columns, estimated from the edges that exist.
    pub(super) fn metric(&self, point: usize) -> DMat2 {
        let mean_square = |directions: [Direction; 2]| {
            let lengths = directions.map(|to| self.length(point, to as usize));
            let there = lengths.into_iter().filter(|&length| length < f64::FAR);
            let (sum, count) = there.fold((0.0, 0), |(sum, count), l| (sum + l * l, count + 1));
            (count > 0).then(|| sum / f64::from(count))
        };
        let rr = mean_square([Direction::North, Direction::South]);
        let cc = mean_square([Direction::East, Direction::West]);
        let falling = mean_square([Direction::NorthWest, Direction::SouthEast]);
        let rising = mean_square([Direction::NorthEast, Direction::SouthWest]);
        let (rr, cc) = (rr.or(cc).unwrap_or(1.0), cc.or(rr).unwrap_or(1.0));
        let rc = match (falling, rising) {
            (Some(falling), Some(rising)) => 0.25 * (falling - rising),
            (Some(falling), None) => 0.5 * (falling - rr - cc),
            (None, Some(rising)) => 0.5 * (rr + cc - rising),
            (None, None) => 0.0,
        };
        let metric = DMat2::from_cols_array(&[rr, rc, rc, cc]);
        if metric.determinant() > 0.0 { metric } else { DMat2::IDENTITY }
    }

    /// Returns the length of the longest edge of a point.
    #[inline]
    pub(super) fn longest(&self, point: usize) -> f32 {
        let lengths =
            self.neighbourhood.iter().map(|neighbour| self.edges.at(point, neighbour.edge));
        lengths.filter(|&length| length < f32::FAR).fold(0.0, f32::max)
    }
}

/// Converts a length to double precision, in which the value for a missing edge differs.
#[inline]
fn wide(length: f32) -> f64 {
    if length < f32::FAR { f64::from(length) } else { f64::FAR }
}
