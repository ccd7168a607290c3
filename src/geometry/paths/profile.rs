//! Arrival times along an edge, and where a straight line to it arrives first.

/// Arrival times between two neighbouring grid points, from the squares of those at four points
/// in a row: squares, since the square of the distance from a point is smooth even there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    /// The smallest initial value, which times are taken relative to.
    start: f64,
    /// Square at the first end.
    first: f64,
    /// From there to that at the other end.
    rise: f64,
    /// Second differences at both ends.
    bends: [f64; 2],
    length: f64,
}

/// Second differences that differ by more than this factor have a kink between them.
const KINK: f64 = 3.0;

/// How much faster times may change than the way is long, in shares of an edge: curved edges, and
/// a metric that changes.
const MARGIN: f64 = 0.05;

/// Where a straight line crosses an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// From the first end (0) to the other (1).
    pub share: f64,
    /// Arrival time there.
    pub time: f64,
    /// From there to where the line starts.
    pub distance: f64,
}

impl Profile {
    /// The second and the third of four points in a row are the edge's ends; `length_squared` is
    /// its own. The times at the outer two are infinite where there is no such point.
    ///
    /// A cubic where the surface is smooth. Where fronts meet, one of the second differences sees
    /// the kink and the other one, the smaller, does not. With neither neighbour, the front is
    /// taken for a circular one around a point of the plane.
    pub(super) fn new(start: f64, times: [f64; 4], length_squared: f64) -> Self {
        let [before, first, last, after] = times.map(|time| {
            let since = (time - start).max(0.0);
            since * since
        });
        let rise = last - first;
        let (left, right) = (before + last - 2.0 * first, first + after - 2.0 * last);
        let bends = match (left < f64::INFINITY, right < f64::INFINITY) {
            (true, true) => {
                let (small, large) =
                    if left.abs() < right.abs() { (left, right) } else { (right, left) };
                if small * large > 0.0 && large.abs() < KINK * small.abs() {
                    [left, right]
                } else {
                    [small; 2]
                }
            }
            (true, false) => [left; 2],
            (false, true) => [right; 2],
            // Not where its centre would lie beside the edge: two fronts meet there.
            (false, false) if rise.abs() >= length_squared || first.min(last) >= length_squared => {
                [2.0 * length_squared; 2]
            }
            (false, false) => [0.0; 2],
        };
        let profile = Self { start, first, rise, bends, length: length_squared.sqrt() };
        if profile.is_distance() { profile } else { Self { bends: [0.0; 2], ..profile } }
    }

    /// Whether the time half-way differs from those at the ends by no more than the way is long.
    fn is_distance(&self) -> bool {
        let ends = [self.first, self.first + self.rise].map(f64::sqrt);
        let middle = self.squared(0.5).0.max(0.0).sqrt();
        ends.iter().all(|time| (time - middle).abs() <= (0.5 + MARGIN) * self.length)
    }

    /// The square of the time since the start, and its two derivatives.
    fn squared(&self, share: f64) -> (f64, f64, f64) {
        let Self { first, rise, bends: [left, right], .. } = *self;
        let rest = 1.0 - share;
        let bend = (1.0 + rest) * left + (1.0 + share) * right;
        let sixth = 1.0 / 6.0;
        let value = first + share * (rise - rest * sixth * bend);
        let slope = rise - sixth * ((rest - share) * bend + share * rest * (right - left));
        (value, slope, rest * left + share * right)
    }

    /// Arrival time at a share of the edge.
    pub(super) fn time(&self, share: f64) -> f64 {
        let time = self.squared(share).0.max(0.0).sqrt();
        let ends = [self.first, self.first + self.rise].map(f64::sqrt);
        let earliest = (ends[0] - share * self.length).max(ends[1] - (1.0 - share) * self.length);
        self.start + time.max(earliest)
    }

    /// Where the straight line to a place crosses the edge that arrives there first: the smallest
    /// sum of arrival time and distance. `ends` are the squared distances of the edge's ends from
    /// the place, `length_squared` its own.
    ///
    /// Newton's method between brackets: the sum is convex but where fronts meet, and then the
    /// better end will do.
    pub(super) fn crossing(&self, ends: [f64; 2], length_squared: f64) -> Crossing {
        let floor = 1e-16 * length_squared;
        let away = |share: f64| {
            let square = ends[0] + share * (ends[1] - ends[0] - (1.0 - share) * length_squared);
            let slope = ends[1] - ends[0] - (1.0 - 2.0 * share) * length_squared;
            (square, slope, 2.0 * length_squared)
        };
        let root = |(square, slope, bend): (f64, f64, f64)| {
            let square = square.max(floor);
            let root = square.sqrt();
            let half = 0.5 / root;
            (root, slope * half, (bend - 0.5 * slope * slope / square) * half)
        };
        let sum = |share: f64| {
            let (time, to, bend) = root(self.squared(share));
            let (distance, by, bow) = root(away(share));
            (time + distance, to + by, bend + bow)
        };
        let (low, high) = (sum(0.0), sum(1.0));
        let share = if low.1 < 0.0 && high.1 > 0.0 {
            let (mut left, mut right) = (0.0, 1.0);
            let mut share = low.1 / (low.1 - high.1);
            for _ in 0..12 {
                let (_, slope, bend) = sum(share);
                if slope < 0.0 {
                    left = share
                } else {
                    right = share
                };
                let newton = share - slope / bend;
                let next =
                    if newton > left && newton < right { newton } else { 0.5 * (left + right) };
                let change = (next - share).abs();
                share = next;
                if change < 1e-5 {
                    break;
                }
            }
            share
        } else if low.0 <= high.0 {
            0.0
        } else {
            1.0
        };
        Crossing { share, time: self.time(share), distance: away(share).0.max(0.0).sqrt() }
    }
}
