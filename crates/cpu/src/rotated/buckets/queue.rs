//! A queue of points in buckets of arrival time.

use geosweep_surface::{EdgeLengths, FAR, Real};

/// Points in buckets of arrival time. A bucket holds points in the order in which they came. The same point may be in
/// several buckets; the caller knows which of these entries counts.
#[derive(Clone, Debug)]
pub(super) struct Buckets {
    /// Reciprocal of the time that a bucket spans.
    per_width: f64,
    /// The buckets of the next times, of which half may be in use. Their number is a power of two. Bucket n is at n modulo
    /// this number.
    ring: Vec<Vec<u32>>,
    /// The bucket in work, and the number of its points that have been taken.
    now: u64,
    taken: usize,
    /// Number of points in the ring.
    held: usize,
    /// Points of buckets beyond the ring, and the first of these buckets.
    later: Vec<u32>,
    first_later: u64,
    /// Memory of buckets that were emptied.
    free: Vec<Vec<u32>>,
}

impl Buckets {
    /// Creates an empty queue of buckets that span `width` each. Points of the next `held` buckets are not sorted again.
    pub(super) fn new(width: f64, held: usize) -> Self {
        Self {
            per_width: width.recip(),
            ring: vec![Vec::new(); 2 * held.next_power_of_two()],
            now: 0,
            taken: 0,
            held: 0,
            later: Vec::new(),
            first_later: u64::MAX,
            free: Vec::new(),
        }
    }

    /// Removes all points.
    pub(super) fn clear(&mut self) {
        self.ring.iter_mut().for_each(Vec::clear);
        self.later.clear();
        (self.now, self.taken, self.held, self.first_later) = (0, 0, 0, u64::MAX);
    }

    /// Returns whether there are any points.
    pub(super) fn has_points(&self) -> bool {
        self.held > self.taken || !self.later.is_empty()
    }

    /// Lets points of any time be added again.
    pub(super) fn restart(&mut self, time: impl Fn(u32) -> Option<f64>) {
        let taken = self.taken;
        let waiting: Vec<u32> = match self.has_points() {
            true => (0..self.ring.len())
                .flat_map(|ahead| {
                    let at = self.place(self.now + ahead as u64);
                    let from = if ahead == 0 { taken } else { 0 };
                    self.ring[at][from..].iter().copied()
                })
                .chain(self.later.iter().copied())
                .collect(),
            false => Vec::new(),
        };
        self.clear();
        for point in waiting {
            if let Some(time) = time(point) {
                self.push(point, time);
            }
        }
    }

    /// Returns the bucket of an arrival time. Times before the bucket in work belong to it.
    #[inline(always)]
    fn number(&self, time: f64) -> u64 {
        ((time * self.per_width) as u64).max(self.now)
    }

    /// Returns the place of a bucket in the ring.
    #[inline(always)]
    fn place(&self, number: u64) -> usize {
        number as usize & (self.ring.len() - 1)
    }

    /// Returns whether two arrival times share a bucket.
    #[inline(always)]
    pub(super) fn share(&self, a: f64, b: f64) -> bool {
        self.number(a) == self.number(b)
    }

    /// Returns whether a time comes after the bucket in work.
    #[inline(always)]
    pub(super) fn is_later(&self, time: f64) -> bool {
        self.number(time) > self.now
    }

    /// Returns a time before which all points have been taken.
    pub(super) fn time(&self) -> f64 {
        self.now as f64 / self.per_width
    }

    #[inline(always)]
    pub(super) fn push(&mut self, point: u32, time: f64) {
        self.put(point, self.number(time));
    }

    #[inline(always)]
    fn put(&mut self, point: u32, number: u64) {
        if number - self.now >= self.ring.len() as u64 / 2 {
            self.later.push(point);
            self.first_later = self.first_later.min(number);
            return;
        }
        let place = self.place(number);
        let bucket = &mut self.ring[place];
        if bucket.capacity() == 0
            && let Some(memory) = self.free.pop()
        {
            *bucket = memory;
        }
        bucket.push(point);
        self.held += 1;
    }

    /// Takes the next point of the bucket in work.
    #[inline(always)]
    pub(super) fn take(&mut self) -> Option<u32> {
        let point = self.ring[self.place(self.now)].get(self.taken).copied();
        self.taken += usize::from(point.is_some());
        point
    }

    /// Returns the point of the bucket in work that comes `ahead` points after the next one.
    #[inline(always)]
    pub(super) fn ahead(&self, ahead: usize) -> Option<u32> {
        self.ring[self.place(self.now)].get(self.taken + ahead).copied()
    }

    /// Goes back to the bucket of an earlier time, but by half of the ring at most. All points of the bucket in work were
    /// taken.
    pub(super) fn go_back(&mut self, time: f64) {
        let most = self.ring.len() as u64 / 2;
        let earlier = ((time * self.per_width) as u64).max(self.now.saturating_sub(most));
        self.now = self.now.min(earlier);
    }

    /// Goes on to the next bucket that has points, after all points of the bucket in work were taken, but not beyond the
    /// time `until`. `time` returns the arrival time of a point, or `None` if its entry does not count. Returns whether
    /// there is such a bucket.
    pub(super) fn advance(&mut self, until: f64, time: impl Fn(u32) -> Option<f64>) -> bool {
        let place = self.place(self.now);
        let bucket = &mut self.ring[place];
        self.held -= bucket.len();
        bucket.clear();
        self.taken = 0;
        self.free.push(std::mem::take(bucket));
        let last = self.number(until);
        let mut next = self.first_held();
        if self.first_later <= next.unwrap_or(u64::MAX).min(last) && !self.later.is_empty() {
            // Points beyond the ring are sorted in again.
            let points = std::mem::take(&mut self.later);
            let numbered = |point: u32| time(point).map(|time| (point, self.number(time)));
            let points: Vec<_> = points.into_iter().filter_map(numbered).collect();
            next = points.iter().map(|&(_, number)| number).chain(next).min();
            self.now = next.map_or(self.now, |next| next.min(last));
            self.first_later = u64::MAX;
            points.into_iter().for_each(|(point, number)| self.put(point, number));
        }
        let Some(next) = next.or((!self.later.is_empty()).then_some(u64::MAX)) else {
            return false;
        };
        self.now = next.min(last);
        next <= last
    }

    /// Returns the first bucket of the ring that has points.
    fn first_held(&self) -> Option<u64> {
        let filled = |&number: &u64| !self.ring[self.place(number)].is_empty();
        (self.held > 0).then(|| (self.now..).find(filled).expect("the ring has points"))
    }

    /// Returns a time before which no point waits, or `None` if none waits.
    pub(super) fn next(&self) -> Option<f64> {
        let later = (!self.later.is_empty()).then_some(self.first_later);
        let next = self.first_held().into_iter().chain(later).min();
        next.map(|next| next as f64 / self.per_width)
    }
}

/// Returns the time that a bucket spans: half the harmonic mean of the costs of edges along rows and columns. Wider
/// buckets bring points out of order, narrower ones cost more than they save.
pub(super) fn width<R: Real>(edges: &EdgeLengths<R>) -> f64 {
    let [east, north, ..] = edges.planes();
    let (mut sum, mut total, mut count) = (0.0, 0.0, 0u64);
    for length in east.iter().chain(north).map(|length| length.wide()) {
        if length < FAR {
            sum += length.recip();
            total += length;
            count += 1;
        }
    }
    if count == 0 {
        return 1.0;
    }
    let (harmonic, mean) = (count as f64 / sum, total / count as f64);
    (0.5 * harmonic).max(mean * LEAST_WIDTH)
}

/// Least width of a bucket, as a part of the mean cost of edges. Where travel is free on a part of the surface, the
/// harmonic mean is close to zero.
const LEAST_WIDTH: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_come_in_the_order_of_their_buckets() {
        // Times far apart, which fill the ring many times.
        let times: Vec<f64> = (0..4000u32).map(|k| f64::from(k * 7919 % 4001).powi(2)).collect();
        for width in [0.1, 3.0, 1e5, 1e9] {
            let mut queue = Buckets::new(width, 1 << 11);
            let held =
                |point: u32| Some(times[point as usize]).filter(|_| !point.is_multiple_of(5));
            (0..2000).for_each(|point| queue.push(point, times[point as usize]));
            let (mut found, mut last, mut next) = (vec![0; times.len()], 0.0, 2000);
            loop {
                while let Some(point) = queue.take() {
                    let time = times[point as usize];
                    assert!(
                        time.max(last) + width >= last
                            && (time / width).floor() * width >= last - width
                    );
                    found[point as usize] += 1;
                    last = f64::max(last, (time / width).floor() * width);
                    // Points that are added later, not before the bucket in work.
                    if next < times.len() && times[next] >= last {
                        queue.push(next as u32, times[next]);
                    } else if next < times.len() {
                        found[next] += 1;
                    }
                    next += 1;
                }
                if !queue.advance(f64::INFINITY, held) {
                    break;
                }
                assert!(queue.time() >= last);
            }
            // Entries that do not count may be left out.
            assert!(
                found.iter().enumerate().all(|(k, &n)| n == 1 || (n == 0 && k % 5 == 0)),
                "{width}"
            );
        }
    }
}
