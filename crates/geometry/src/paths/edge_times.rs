//! Interpolates arrival times along an edge and finds the straight line to the edge that arrives first.

/// The arrival times between two neighbouring grid points.
///
/// They are interpolated from the squared times at four points in a row. Squares are used, since the squared
/// distance from a point is smooth even at that point.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeTimes {
    /// The time that is subtracted before times are squared.
    start: f64,
    /// The squared time at the first end.
    first: f64,
    /// The difference of the squared times, second end minus first end.
    rise: f64,
    /// The second differences of the squared times at both ends.
    bends: [f64; 2],
    /// The times at both ends since the start.
    since: [f64; 2],
    length: f64,
}

/// The ratio of second differences above which there is a kink between them.
const KINK: f64 = geosweep_surface::constants::KINK;

/// Largest ratio of the lengths of two edges in line at which a second difference is taken from them.
const MOST_UNEVEN: f64 = geosweep_surface::constants::MOST_UNEVEN;

/// Largest change of time along an edge beyond the edge's length, as a fraction of the length. It allows for
/// curved edges and for a metric that changes.
const MARGIN: f64 = geosweep_surface::constants::MARGIN;

/// The place where a straight line crosses an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// The place on the edge, from the first end (0) to the second (1).
    pub share: f64,
    /// The arrival time at the place.
    pub time: f64,
    /// The distance from the place to the start of the line.
    pub distance: f64,
}

impl EdgeTimes {
    /// Interpolates between the second and the third of four points in a row, which are the ends of an edge
    /// of the length `length`. The times at the outer two points are infinite if there is no such point. `ratios` are
    /// the lengths on the surface of the edges before and behind this one, as parts of its own.
    ///
    /// Where the map is smooth, the interpolation is a cubic. Where wavefronts meet, one of the two second
    /// differences contains the kink; the other, which is the smaller one, is used for both ends. If both
    /// outer points are missing, the wavefront is taken for a circle around a point of the plane.
    #[inline(always)]
    pub(super) fn new(start: f64, times: [f64; 4], ratios: [f64; 2], length: f64) -> Self {
        let since = times.map(|time| (time - start).max(0.0));
        let [before, first, last, after] = since.map(|since| since * since);
        let length_squared = length * length;
        let rise = last - first;
        let left = second_difference(before - first, rise, ratios[0]);
        let right = second_difference(after - last, -rise, ratios[1]);
        // A missing second difference is infinite, and therefore the larger one.
        let is_left_small = left.abs() < right.abs();
        let small = if is_left_small { left } else { right };
        let large = if is_left_small { right } else { left };
        let is_smooth = (small * large > 0.0) & (large.abs() < KINK * small.abs());
        // If the centre of the circle would lie beside the edge, two wavefronts meet on the edge.
        let is_circle = (rise.abs() >= length_squared) | (first.min(last) >= length_squared);
        let circle = if is_circle { 2.0 * length_squared } else { 0.0 };
        let one = if small.abs() < f64::INFINITY { small } else { circle };
        let at_ends = at_ends([left, right], ratios);
        let bends = at_ends.map(|bend| if is_smooth { bend } else { one });
        let times = Self { start, first, rise, bends, since: [since[1], since[2]], length };
        let is_distance = times.is_distance();
        Self { bends: bends.map(|bend| if is_distance { bend } else { 0.0 }), ..times }
    }

    /// Returns whether the time half-way differs from the times at the ends by no more than the distance to
    /// them.
    #[inline(always)]
    fn is_distance(&self) -> bool {
        let [first, last] = self.since;
        let (way, middle) = ((0.5 + MARGIN) * self.length, self.squared(0.5).0.max(0.0));
        let (earliest, latest) = (first.max(last) - way, first.min(last) + way);
        (middle <= latest * latest) & ((earliest <= 0.0) | (middle >= earliest * earliest))
    }

    /// Returns the squared time since the start, and its first two derivatives by `share`.
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

    /// Returns the arrival time at the fraction `share` of the edge.
    pub(super) fn time(&self, share: f64) -> f64 {
        let time = self.squared(share).0.max(0.0).sqrt();
        self.start + time.max(self.earliest(share))
    }

    /// Returns a lower bound of the time since the start, at the place `share` of the edge. The wavefront
    /// arrives there earlier than at an end of the edge by at most the distance to that end.
    #[inline(always)]
    fn earliest(&self, share: f64) -> f64 {
        let [first, last] = self.since;
        (first - share * self.length).max(last - (1.0 - share) * self.length)
    }

    /// Returns the crossing from which the wavefront arrives first at a given place, along a straight line:
    /// it minimises the sum of arrival time and distance. `ends` are the squared distances of the edge's ends
    /// from the place.
    ///
    /// The method is Newton's, with bracketing. The sum is convex except where wavefronts meet, and there the better
    /// end of the edge is good enough.
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

    /// Returns the line that meets the edge at a right angle, or ends at the nearer end of the edge.
    pub(super) fn foot(&self, ends: [f64; 2]) -> Crossing {
        let share = 0.5 + 0.5 * (ends[0] - ends[1]) / (self.length * self.length);
        self.crossing_at(share.clamp(0.0, 1.0), ends)
    }

    fn crossing_at(&self, share: f64, ends: [f64; 2]) -> Crossing {
        let (square, ..) = self.away(share, ends);
        Crossing { share, time: self.time(share), distance: square.max(0.0).sqrt() }
    }

    /// Computes [`Self::crossing`] at lower cost from a good estimate `share`. Also returns whether at most
    /// two steps of Newton's method converge to a place strictly between the ends.
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

    /// Performs a step of Newton's method. Returns its result, whether that result is a minimum strictly
    /// between the ends, and whether it is accurate enough.
    #[inline(always)]
    fn newton(&self, share: f64, ends: [f64; 2]) -> (Crossing, [bool; 2]) {
        let [p, q] = self.squares(share, ends);
        let [p_root, q_root] = [p, q].map(|square| square.value.sqrt());
        // The derivatives of the sum up to a common factor, which avoids a division.
        let slope = 2.0 * p.value * q.value * (p.slope * q_root + q.slope * p_root);
        let bend = p.bend_of_root() * q.value * q_root + q.bend_of_root() * p.value * p_root;
        let change = -slope / bend;
        let share = share + change;
        let half = 0.5 / (p_root * q_root);
        let [time, distance] =
            [p.root(p_root, half * q_root), q.root(q_root, half * p_root)].map(|t| t.after(change));
        let is_inside = (bend > 0.0) & (share > 0.0) & (share < 1.0);
        // The remaining error is of the order of the squared change, divided by the distance to the edge in
        // lengths of the edge.
        let is_exact = change * change * self.length < 1e-5 * distance;
        let time = self.start + time.max(self.earliest(share));
        (Crossing { share, time, distance }, [is_inside, is_exact])
    }

    /// Returns the sum of the arrival time since the start and the distance, at a fraction of the edge.
    fn sum(&self, share: f64, ends: [f64; 2]) -> Sum {
        let root = |square: Term| {
            let root = square.value.sqrt();
            square.root(root, 0.5 / root)
        };
        Sum { terms: self.squares(share, ends).map(root) }
    }

    /// Returns the squares of arrival time and distance, bounded away from zero.
    #[inline(always)]
    fn squares(&self, share: f64, ends: [f64; 2]) -> [Term; 2] {
        let floor = 1e-16 * self.length * self.length;
        [self.squared(share), self.away(share, ends)].map(|(value, slope, bend)| Term {
            value: value.max(floor),
            slope,
            bend,
        })
    }

    /// Returns the squared distance of a place from the fraction `share` of the edge, and its first two
    /// derivatives.
    #[inline(always)]
    fn away(&self, share: f64, ends: [f64; 2]) -> (f64, f64, f64) {
        let (length_squared, rise) = (self.length * self.length, ends[1] - ends[0]);
        let square = ends[0] + share * (rise - (1.0 - share) * length_squared);
        let slope = rise - (1.0 - 2.0 * share) * length_squared;
        (square, slope, 2.0 * length_squared)
    }
}

/// Returns the second derivative by the fraction of an edge of a value that rises by `rise` along the edge, and by
/// `beyond` from one end to the next point, whose distance is `ratio` lengths of the edge. Both are counted from that
/// end. The result is infinite if the next point is missing, or much nearer or farther than the edge is long.
#[inline(always)]
fn second_difference(beyond: f64, rise: f64, ratio: f64) -> f64 {
    let second = 2.0 * (beyond / ratio + rise) / (1.0 + ratio);
    if (1.0 / MOST_UNEVEN..=MOST_UNEVEN).contains(&ratio) { second } else { f64::INFINITY }
}

/// Returns the second derivatives at the ends of an edge. Each second difference is that at the mean of its three
/// points, which is an end if the points are evenly spaced.
#[inline(always)]
fn at_ends([left, right]: [f64; 2], [before, behind]: [f64; 2]) -> [f64; 2] {
    let slope = (right - left) * 3.0 / (1.0 + before + behind);
    let third = 1.0 / 3.0;
    [left - third * (1.0 - before) * slope, right + third * (1.0 - behind) * slope]
}

/// A function of the fraction of an edge: its value and its first two derivatives.
#[derive(Clone, Copy)]
struct Term {
    value: f64,
    slope: f64,
    bend: f64,
}

impl Term {
    /// Returns the square root of the function. `value` is the value of the root, and `half` is 0.5 /
    /// `value`.
    #[inline(always)]
    fn root(self, value: f64, half: f64) -> Self {
        let slope = self.slope * half;
        Self { value, slope, bend: (self.bend - 2.0 * slope * slope) * half }
    }

    /// Returns the second derivative of the square root, times four times the third power of the root.
    #[inline(always)]
    fn bend_of_root(self) -> f64 {
        2.0 * self.bend * self.value - self.slope * self.slope
    }

    /// Returns the value after a small change of the fraction.
    #[inline(always)]
    fn after(self, change: f64) -> f64 {
        self.value + change * (self.slope + 0.5 * change * self.bend)
    }
}

/// The sum of two functions.
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
