//! Arrival times along an edge, and where a straight line to it arrives first.

/// Arrival times between two neighbouring grid points, from the squares of those at four points
/// in a row: squares, since the square of the distance from a point is smooth even there.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeTimes {
    /// The smallest initial value, which times are taken relative to.
    start: f64,
    /// Square at the first end.
    first: f64,
    /// From there to that at the other end.
    rise: f64,
    /// Second differences at both ends.
    bends: [f64; 2],
    /// Times at both ends since the start.
    since: [f64; 2],
    length: f64,
}

/// Second differences that differ by more than this factor have a kink between them.
const KINK: f64 = crate::constants::KINK;

/// How much faster times may change than the way is long, in shares of an edge: curved edges, and
/// a metric that changes.
const MARGIN: f64 = crate::constants::MARGIN;

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

impl EdgeTimes {
    /// The second and the third of four points in a row are the edge's ends; `length` is
    /// its own. The times at the outer two are infinite where there is no such point.
    ///
    /// A cubic where the surface is smooth. Where fronts meet, one of the second differences sees
    /// the kink and the other one, the smaller, does not. With neither neighbour, the front is
    /// taken for a circular one around a point of the plane.
    #[inline(always)]
    pub(super) fn new(start: f64, times: [f64; 4], length: f64) -> Self {
        let since = times.map(|time| (time - start).max(0.0));
        let [before, first, last, after] = since.map(|since| since * since);
        let length_squared = length * length;
        let rise = last - first;
        let (left, right) = (before + last - 2.0 * first, first + after - 2.0 * last);
        // One that is missing is infinite, and so the larger.
        let is_left_small = left.abs() < right.abs();
        let small = if is_left_small { left } else { right };
        let large = if is_left_small { right } else { left };
        let is_smooth = (small * large > 0.0) & (large.abs() < KINK * small.abs());
        // Not where its centre would lie beside the edge: two fronts meet there.
        let is_circle = (rise.abs() >= length_squared) | (first.min(last) >= length_squared);
        let circle = if is_circle { 2.0 * length_squared } else { 0.0 };
        let one = if small.abs() < f64::INFINITY { small } else { circle };
        let bends = [left, right].map(|bend| if is_smooth { bend } else { one });
        let times = Self { start, first, rise, bends, since: [since[1], since[2]], length };
        let is_distance = times.is_distance();
        Self { bends: bends.map(|bend| if is_distance { bend } else { 0.0 }), ..times }
    }

    /// Whether the time half-way differs from those at the ends by no more than the way is long.
    #[inline(always)]
    fn is_distance(&self) -> bool {
        let [first, last] = self.since;
        let (way, middle) = ((0.5 + MARGIN) * self.length, self.squared(0.5).0.max(0.0));
        let (earliest, latest) = (first.max(last) - way, first.min(last) + way);
        (middle <= latest * latest) & ((earliest <= 0.0) | (middle >= earliest * earliest))
    }

    /// The square of the time since the start, and its two derivatives.
    #[inline(always)]
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
        self.start + time.max(self.earliest(share))
    }

    /// As late as the way from either end allows, since the start.
    #[inline(always)]
    fn earliest(&self, share: f64) -> f64 {
        let [first, last] = self.since;
        (first - share * self.length).max(last - (1.0 - share) * self.length)
    }

    /// Where the straight line to a place crosses the edge that arrives there first: the smallest
    /// sum of arrival time and distance. `ends` are the squared distances of the edge's ends from
    /// the place.
    ///
    /// Newton's method between brackets: the sum is convex but where fronts meet, and then the
    /// better end will do.
    pub(super) fn crossing(&self, ends: [f64; 2]) -> Crossing {
        let (low, high) = (self.sum(0.0, ends), self.sum(1.0, ends));
        let share = if low.slope() < 0.0 && high.slope() > 0.0 {
            let (mut left, mut right) = (0.0, 1.0);
            let mut share = low.slope() / (low.slope() - high.slope());
            for _ in 0..30 {
                let sum = self.sum(share, ends);
                if sum.slope() < 0.0 {
                    left = share
                } else {
                    right = share
                };
                let newton = share - sum.slope() / sum.bend();
                let next =
                    if newton > left && newton < right { newton } else { 0.5 * (left + right) };
                let change = (next - share).abs();
                share = next;
                if change < 1e-5 {
                    break;
                }
            }
            share
        } else if low.value() <= high.value() {
            0.0
        } else {
            1.0
        };
        self.crossing_at(share, ends)
    }

    /// The line that meets the edge at a right angle, or ends at its nearer end.
    pub(super) fn foot(&self, ends: [f64; 2]) -> Crossing {
        let share = 0.5 + 0.5 * (ends[0] - ends[1]) / (self.length * self.length);
        self.crossing_at(share.clamp(0.0, 1.0), ends)
    }

    fn crossing_at(&self, share: f64, ends: [f64; 2]) -> Crossing {
        let (square, ..) = self.away(share, ends);
        Crossing { share, time: self.time(share), distance: square.max(0.0).sqrt() }
    }

    /// The same near a share that is known well, for less, and whether two steps of Newton's method
    /// settle strictly between the ends.
    #[inline(always)]
    pub(super) fn crossing_near(&self, share: f64, ends: [f64; 2]) -> (Crossing, bool) {
        let (first, [is_one, first_settled]) = self.newton(share, ends);
        let (second, [is_other, second_settled]) = self.newton(first.share, ends);
        let crossing = Crossing {
            share: if first_settled { first.share } else { second.share },
            time: if first_settled { first.time } else { second.time },
            distance: if first_settled { first.distance } else { second.distance },
        };
        (crossing, is_one & (first_settled | (is_other & second_settled)))
    }

    /// A step of Newton's method: what it leads to, whether that is a smallest sum strictly between
    /// the ends, and whether it is exact enough.
    #[inline(always)]
    fn newton(&self, share: f64, ends: [f64; 2]) -> (Crossing, [bool; 2]) {
        let [p, q] = self.squares(share, ends);
        let [p_root, q_root] = [p, q].map(|square| square.value.sqrt());
        // The sum's derivatives but for common factors, without a division.
        let slope = 2.0 * p.value * q.value * (p.slope * q_root + q.slope * p_root);
        let bend = p.bend_of_root() * q.value * q_root + q.bend_of_root() * p.value * p_root;
        let change = -slope / bend;
        let share = share + change;
        let half = 0.5 / (p_root * q_root);
        let [time, distance] =
            [p.root(p_root, half * q_root), q.root(q_root, half * p_root)].map(|t| t.after(change));
        let is_inside = (bend > 0.0) & (share > 0.0) & (share < 1.0);
        // What is left is of the order of the square, over the way to the edge in its lengths.
        let is_exact = change * change * self.length < 1e-5 * distance;
        let time = self.start + time.max(self.earliest(share));
        (Crossing { share, time, distance }, [is_inside, is_exact])
    }

    /// Arrival time since the start and distance together at a share of the edge.
    fn sum(&self, share: f64, ends: [f64; 2]) -> Sum {
        let root = |square: Term| {
            let root = square.value.sqrt();
            square.root(root, 0.5 / root)
        };
        Sum { terms: self.squares(share, ends).map(root) }
    }

    /// The squares of both, not quite zero.
    #[inline(always)]
    fn squares(&self, share: f64, ends: [f64; 2]) -> [Term; 2] {
        let floor = 1e-16 * self.length * self.length;
        [self.squared(share), self.away(share, ends)].map(|(value, slope, bend)| Term {
            value: value.max(floor),
            slope,
            bend,
        })
    }

    /// The squared distance of a place from a share of the edge, and its first two derivatives.
    #[inline(always)]
    fn away(&self, share: f64, ends: [f64; 2]) -> (f64, f64, f64) {
        let (length_squared, rise) = (self.length * self.length, ends[1] - ends[0]);
        let square = ends[0] + share * (rise - (1.0 - share) * length_squared);
        let slope = rise - (1.0 - 2.0 * share) * length_squared;
        (square, slope, 2.0 * length_squared)
    }
}

/// A function at a share of an edge, and its first two derivatives.
#[derive(Clone, Copy)]
struct Term {
    value: f64,
    slope: f64,
    bend: f64,
}

impl Term {
    /// Its root, given the value of that and a half over it.
    #[inline(always)]
    fn root(self, value: f64, half: f64) -> Self {
        let slope = self.slope * half;
        Self { value, slope, bend: (self.bend - 2.0 * slope * slope) * half }
    }

    /// The second derivative of its root, times four and the root's third power.
    #[inline(always)]
    fn bend_of_root(self) -> f64 {
        2.0 * self.bend * self.value - self.slope * self.slope
    }

    /// Its value a small change of the share further.
    #[inline(always)]
    fn after(self, change: f64) -> f64 {
        self.value + change * (self.slope + 0.5 * change * self.bend)
    }
}

/// A sum of two.
#[derive(Clone, Copy)]
struct Sum {
    terms: [Term; 2],
}

impl Sum {
    fn value(&self) -> f64 {
        self.terms[0].value + self.terms[1].value
    }

    fn slope(&self) -> f64 {
        self.terms[0].slope + self.terms[1].slope
    }

    fn bend(&self) -> f64 {
        self.terms[0].bend + self.terms[1].bend
    }
}
