//! Solves by points that pass their fronts on in the order of their arrival times.
//!
//! Over a rough slowness rays turn in every cell, and scans in four directions have to be repeated many times. Here a
//! point passes its front on to its neighbours when its time has come, mostly once. The queue has buckets of time
//! instead of a total order. A point that becomes earlier after that by more than rounding returns to the queue, so the
//! map is the converged one. A batch of points updates its neighbours in SIMD lanes (`fronts/pushed.rs`).

mod neighbours;
mod parts;
mod queue;

use std::sync::Arc;

use self::neighbours::{Lengths, Neighbours, lengths_of};
use self::parts::PartsAround;
use self::queue::Buckets;
use super::prepared::Settings;
use super::scans::Scans;
use crate::Instructions;
use crate::fronts::{BATCH, Fronts, MOST, Pushed, TriangleFronts, TriangleKind};
use crate::limit::Limit;
use geosweep_surface::lanes::Loop;
use geosweep_surface::update::{StoredFront, Triangle};
use geosweep_surface::{Block, Convergence, EdgeLengths, Monitor, Real, Seed, Stop};

/// A solver for one kind of front; see [`crate::RotatedScan`].
#[derive(Clone, Debug)]
pub(crate) struct BucketScanner<R: Real, K: TriangleKind<R>> {
    edges: EdgeLengths<R>,
    kind: K,
    settings: Settings,
    neighbours: Neighbours,
    lengths: Arc<Lengths<R>>,
    parts: Option<PartsAround<R>>,
    fronts: StoredFronts<R, K::Carried>,
    queue: Buckets,
    /// Whether a point waits in the queue.
    waits: Vec<bool>,
    /// The points that have been reached.
    reached: Vec<u32>,
    /// Numbers of points that have passed on their fronts, and of triangles through which they have done so.
    taken: u64,
    triangles: u64,
}

/// Fronts at all points, as bordered arrays.
#[derive(Clone, Debug)]
struct StoredFronts<R, C> {
    times: Vec<R>,
    carried: Vec<C>,
}

impl<R: Real, C: Copy> StoredFronts<R, C> {
    #[inline(always)]
    fn at(&self, point: usize) -> StoredFront<R, C> {
        StoredFront { time: self.times[point], carried: self.carried[point] }
    }
}

/// Scan number of fronts that points pass on. No scan renews them.
const PUSHED: u8 = 1;

/// Least change of a front after which a point returns to the queue, in units of the rounding of its time.
const CHANGE: u32 = 2;

/// Largest number of targets whose times are read after each bucket. More targets are read after [`SELDOM`] buckets.
const FEW_TARGETS: usize = 16;
const SELDOM: u64 = 16;

impl<R: Real, K: TriangleKind<R>> BucketScanner<R, K> {
    pub(crate) fn new(edges: &EdgeLengths<R>, kind: K) -> Self {
        let chart = edges.chart();
        let points = chart.bordered_points();
        let settings = Settings {
            limit: Limit::NONE,
            instructions: Instructions::best(),
            monitor: Monitor::default(),
        };
        Self {
            edges: edges.clone(),
            parts: PartsAround::of(edges),
            kind,
            settings,
            neighbours: Neighbours::new(chart),
            lengths: Arc::new(lengths_of(edges)),
            fronts: StoredFronts {
                times: vec![R::FAR; points],
                carried: vec![K::Carried::default(); points],
            },
            queue: Buckets::new(width(edges)),
            waits: vec![false; points],
            reached: Vec::new(),
            taken: 0,
            triangles: 0,
        }
    }

    /// Resets all points to unreached.
    fn forget(&mut self) {
        self.kind.forget();
        for &point in &self.reached {
            let point = point as usize;
            self.fronts.times[point] = R::FAR;
            self.fronts.carried[point] = K::Carried::default();
            self.waits[point] = false;
        }
        self.reached.clear();
        self.queue.clear();
        (self.taken, self.triangles) = (0, 0);
    }

    fn seed(&mut self, seeds: &[Seed]) {
        let (queue, waits, reached) = (&mut self.queue, &mut self.waits, &mut self.reached);
        let fronts = (self.fronts.times.as_mut_slice(), self.fronts.carried.as_mut_slice());
        self.kind.start(self.edges.chart(), seeds, fronts, |_, point, [before, after]| {
            if before.time >= R::FAR {
                reached.push(point as u32);
            }
            if after != before {
                waits[point] = true;
                queue.push(point as u32, after.time.wide());
            }
        });
    }

    /// Lets points pass on their fronts until none waits, up to the limit.
    fn run(&mut self) -> Convergence {
        let targets = self.settings.limit.targets().len();
        let (mut lanes, mut arrivals) = (Box::new(Pushed::new()), None);
        let mut buckets = 0u64;
        loop {
            let instructions = self.settings.instructions;
            instructions.run(Bucket {
                solver: &mut *self,
                lanes: &mut lanes,
                arrivals: &mut arrivals,
            });
            buckets += 1;
            if targets > 0 && (targets <= FEW_TARGETS || buckets.is_multiple_of(SELDOM)) {
                let (chart, times) = (self.edges.chart(), &self.fronts.times);
                self.settings.limit.lower(|[row, col]| times[chart.bordered(row, col)].wide());
            }
            let (times, waits) = (&self.fronts.times, &self.waits);
            let time = |point: u32| waits[point as usize].then(|| times[point as usize].wide());
            if !self.queue.advance(time) || self.queue.time() > self.settings.limit.time() {
                break;
            }
            if buckets.is_multiple_of(SELDOM) && self.settings.monitor.is_cancelled() {
                break;
            }
        }
        self.settings.monitor.note(1, 0.0);
        Convergence { iterations: 1, residual: 0.0 }
    }

    /// Takes up to [`BATCH`] points of the bucket in work, and passes their fronts on. Returns whether there were any.
    #[inline(always)]
    fn run_batch(
        &mut self,
        lanes: &mut Pushed<R, K::Carried>,
        arrivals: &mut Option<[K::Arrival; MOST]>,
    ) -> bool {
        let (mut batch, mut count) = ([0; BATCH], 0);
        while count < BATCH {
            let Some(point) = self.queue.take() else { break };
            if let Some(ahead) = self.queue.ahead(2 * BATCH) {
                self.neighbours.prefetch(&self.lengths, &self.fronts.times, ahead as usize);
            }
            let point = point as usize;
            if std::mem::replace(&mut self.waits[point], false) {
                batch[count] = point;
                count += 1;
            }
        }
        let batch = &batch[..count];
        lanes.count = 0;
        for &point in batch {
            let fronts = (self.fronts.times.as_slice(), self.fronts.carried.as_slice());
            self.neighbours.add(&self.lengths, fronts, &self.waits, point, lanes);
        }
        self.triangles += lanes.count as u64;
        if lanes.count > 0 {
            let none = K::Carried::arrival_of_front(StoredFront {
                time: R::FAR,
                carried: K::Carried::default(),
            });
            let arrivals = arrivals.get_or_insert([none; MOST]);
            self.kind.arrivals(lanes, arrivals);
            for (k, &arrival) in arrivals[..lanes.count].iter().enumerate() {
                self.lower(lanes.corners[0][k] as usize, arrival);
            }
        }
        if self.edges.copies().is_some() {
            batch.iter().for_each(|&point| self.push_to_copies(point));
        }
        if self.parts.is_some() {
            batch.iter().for_each(|&point| self.push_through_parts(point));
        }
        self.taken += count as u64;
        count > 0
    }

    /// Gives the front at a point to the point's other copies on a glued surface.
    #[inline(never)]
    fn push_to_copies(&mut self, point: usize) {
        let edges = self.edges.clone();
        let copies = edges.copies().and_then(|groups| groups.around(point)).into_iter().flatten();
        for &copy in copies.filter(|&&copy| copy as usize != point) {
            self.lower(copy as usize, K::Carried::arrival_of_front(self.fronts.at(point)));
        }
    }

    /// Passes on the front at a point through the parts of obtuse triangles.
    #[inline(never)]
    fn push_through_parts(&mut self, point: usize) {
        let Some(parts) = self.parts.take() else { return };
        for (x0, part) in parts.around(point) {
            let [a, b] = part.corners.map(|x| self.fronts.at(x));
            let [l1, l2, c] = part.lengths;
            let triangle = Triangle { t1: a.time, t2: b.time, l1, l2, c };
            let (corners, carried) =
                ([x0, part.corners[0], part.corners[1]], [a.carried, b.carried]);
            self.lower(x0, self.kind.arrival_over(corners, triangle, carried, part.slowness));
        }
        self.parts = Some(parts);
    }

    /// Offers a front to a point. If the point's front changes by more than rounding, the point joins the queue.
    #[inline(always)]
    fn lower(&mut self, point: usize, arrival: K::Arrival) {
        let before = self.fronts.at(point);
        if K::Carried::time(arrival) > before.time {
            return;
        }
        let after = K::Carried::accept(before, arrival, PUSHED, false);
        let waits = self.waits[point];
        if !waits && K::Carried::change(before, after) <= R::Bits::from(CHANGE) {
            return;
        }
        (self.fronts.times[point], self.fronts.carried[point]) = (after.time, after.carried);
        if before.time >= R::FAR {
            self.reached.push(point as u32);
        }
        let [from, to] = [before.time.wide(), after.time.wide()];
        if !waits || !self.queue.share(from, to) {
            self.waits[point] = true;
            self.queue.push(point as u32, to);
        }
    }
}

/// Returns the time that a bucket spans: half the harmonic mean of the costs of edges along rows and columns. Wider
/// buckets bring points out of order, narrower ones cost more than they save.
fn width<R: Real>(edges: &EdgeLengths<R>) -> f64 {
    let [east, north, ..] = edges.planes();
    let (mut sum, mut total, mut count) = (0.0, 0.0, 0u64);
    for length in east.iter().chain(north).map(|length| length.wide()) {
        if length < geosweep_surface::FAR {
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

/// The bucket in work, whose points pass on their fronts.
struct Bucket<'a, R: Real, K: TriangleKind<R>> {
    solver: &'a mut BucketScanner<R, K>,
    lanes: &'a mut Pushed<R, K::Carried>,
    arrivals: &'a mut Option<[K::Arrival; MOST]>,
}

impl<R: Real, K: TriangleKind<R>> Loop for Bucket<'_, R, K> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        while self.solver.run_batch(self.lanes, self.arrivals) {}
    }
}

impl<R: Real, K: TriangleKind<R>> Scans<R> for BucketScanner<R, K> {
    fn solve(&mut self, seeds: &[Seed], _: Stop) -> Convergence {
        self.forget();
        self.seed(seeds);
        self.run()
    }

    fn add(&mut self, seeds: &[Seed], _: Stop) -> Convergence {
        for &point in &self.reached {
            let carried = &mut self.fronts.carried[point as usize];
            *carried = carried.released();
        }
        let (times, waits) = (&self.fronts.times, &self.waits);
        self.queue.restart(|point| waits[point as usize].then(|| times[point as usize].wide()));
        self.seed(seeds);
        self.run()
    }

    fn go_on(&mut self, _: &[Seed], _: Stop, limit: Limit) -> Option<Convergence> {
        self.settings.limit = limit;
        let any = self.queue.has_points();
        any.then(|| self.run())
    }

    fn used(&self) -> Vec<Block> {
        let chart = self.edges.chart();
        let places = self.reached.iter().map(|&point| chart.bordered_position(point as usize));
        places.map(|(row, col)| Block { rows: row..row + 1, cols: col..col + 1 }).collect()
    }

    fn settings(&mut self) -> &mut Settings {
        &mut self.settings
    }

    fn times(&self) -> &[R] {
        &self.fronts.times
    }

    fn into_times(self: Box<Self>) -> Vec<R> {
        self.fronts.times
    }

    fn visits(&self) -> u64 {
        self.taken
    }

    fn updates(&self) -> u64 {
        self.triangles
    }

    fn bytes(&self) -> usize {
        size_of_val(self.fronts.times.as_slice())
            + size_of_val(self.fronts.carried.as_slice())
            + self.waits.len()
            + size_of_val(self.lengths.as_slice())
            + size_of_val(self.reached.as_slice())
            + self.parts.as_ref().map_or(0, PartsAround::bytes)
    }

    fn is_in_order_of_time(&self) -> bool {
        true
    }

    fn boxed(&self) -> Box<dyn Scans<R>> {
        Box::new(self.clone())
    }
}
