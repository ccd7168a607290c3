//! Lets another thread follow a computation and cancel it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

use crate::{Convergence, Error};

/// A view on a computation that runs in another thread: how far it is, and a way to cancel it. Clones share
/// the same state.
///
/// A computation that is cancelled ends with [`Error::Cancelled`] after the current band of lines, part of the
/// edges or submission to a device: on the CPU within milliseconds. Matrices on the CPU whose maps are computed in
/// batches ([`PairwiseScan`](crate::cpu::PairwiseScan)) end after the current batches, of up to 16 maps on each
/// thread. Fast marching goes on to the end of its map.
///
/// ```
/// use geosweep::{Error, Monitor, Options, Sources, Spacing, Surface, distance_map};
///
/// let surface = Surface::from_heights(40, 50, vec![0.0; 2000], Spacing::square(1.0))?;
/// let monitor = Monitor::default();
/// let options = Options::default().with_monitor(monitor.clone());
/// distance_map(&surface, &Sources::point(3.0, 4.0), &options)?;
/// assert!(monitor.progress().iterations >= 1);
///
/// monitor.cancel();
/// let cancelled = distance_map(&surface, &Sources::point(3.0, 4.0), &options);
/// assert!(matches!(cancelled, Err(Error::Cancelled)));
/// # Ok::<(), geosweep::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Monitor(Arc<State>);

#[derive(Debug, Default)]
struct State {
    is_cancelled: AtomicBool,
    iterations: AtomicU32,
    /// Bits of the residual.
    residual: AtomicU64,
}

impl Monitor {
    /// Cancels the computation. This cannot be undone: later computations with this monitor are cancelled when
    /// they start.
    pub fn cancel(&self) {
        self.0.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Returns whether the computation has been cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.0.is_cancelled.load(Ordering::Relaxed)
    }

    /// Returns the number of iterations that the map has finished, and the relative change of the last one.
    /// Both are 0 before the first iteration ends. Where several maps are computed, they are those of the map
    /// that has finished an iteration last. On a device they stay at 0.
    pub fn progress(&self) -> Convergence {
        Convergence {
            iterations: self.0.iterations.load(Ordering::Relaxed),
            residual: f64::from_bits(self.0.residual.load(Ordering::Relaxed)),
        }
    }

    /// Notes that an iteration has ended.
    pub(crate) fn note(&self, iterations: u32, residual: f64) {
        self.0.residual.store(residual.to_bits(), Ordering::Relaxed);
        self.0.iterations.store(iterations, Ordering::Relaxed);
    }

    /// Returns an error if the computation has been cancelled.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if self.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }
}

/// Monitors are equal if they belong to the same computation.
impl PartialEq for Monitor {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::thread;

    use crate::pairwise::Pairwise;
    use crate::surface::Surface;
    use crate::{
        Engine, Error, Monitor, Options, Sources, Spacing, Wavefront, distance_map,
        distance_map_f64,
    };

    /// A corridor that winds through the grid, so that a front takes one iteration for each of its turns.
    fn winding(side: usize) -> Surface {
        let is_open = |row: usize, col: usize| {
            let end = if row % 4 == 1 { side - 1 } else { 0 };
            row.is_multiple_of(2) || col == end
        };
        let mask: Vec<_> = (0..side * side).map(|at| is_open(at / side, at % side)).collect();
        let heights = vec![0.0; side * side];
        Surface::from_heights(side, side, heights, Spacing::square(1.0))
            .and_then(|surface| surface.with_mask(&mask))
            .expect("a flat surface")
    }

    #[test]
    fn a_map_is_cancelled_while_it_is_computed() {
        let (surface, monitor) = (winding(401), Monitor::default());
        let options = Options::default().with_engine(Engine::Cpu).with_monitor(monitor.clone());
        let result = thread::scope(|scope| {
            let map = scope.spawn(|| distance_map(&surface, &Sources::point(0.0, 0.0), &options));
            while monitor.progress().iterations < 3 {
                thread::yield_now();
            }
            monitor.cancel();
            map.join().unwrap()
        });
        assert!(matches!(result, Err(Error::Cancelled)), "{result:?}");
        assert!(monitor.progress().iterations < 100);
    }

    #[test]
    fn no_engine_starts_with_a_cancelled_monitor() {
        let (surface, monitor, source) = (winding(9), Monitor::default(), Sources::point(0.0, 0.0));
        monitor.cancel();
        for engine in [Engine::FastMarching, Engine::Cpu, Engine::Auto] {
            let options = Options::default().with_engine(engine.clone());
            let options = options.with_wavefront(Wavefront::Planar).with_monitor(monitor.clone());
            let single = distance_map(&surface, &source, &options);
            assert!(matches!(single, Err(Error::Cancelled)), "{engine:?}: {single:?}");
            let double = distance_map_f64(&surface, &source, &options);
            assert!(matches!(double, Err(Error::Cancelled)), "{engine:?}: {double:?}");
        }
    }

    /// The matrix has 625 rows. So the batches of its first generation, of 256 rows, cannot be all.
    #[test]
    fn a_symmetric_matrix_is_cancelled() {
        let (surface, monitor) = (winding(25), Monitor::default());
        let options = Options::default().with_wavefront(Wavefront::Planar);
        let options = options.with_monitor(monitor.clone());
        let mut pairwise = Pairwise::new(&surface, &options).unwrap();
        let seen = AtomicUsize::new(0);
        let mut matrix = || {
            pairwise.matrix_by_symmetry(|rows| {
                seen.fetch_add(rows, Ordering::Relaxed);
                monitor.cancel();
                Ok::<_, Error>(())
            })
        };
        let result = matrix();
        let rows = seen.load(Ordering::Relaxed);
        assert!(matches!(result, Err(Error::Cancelled)) && (1..=256).contains(&rows), "{rows}");
        assert!(matches!(matrix(), Err(Error::Cancelled)), "it does not start");
        assert_eq!(seen.load(Ordering::Relaxed), rows);
    }

    #[test]
    fn rows_of_a_matrix_are_cancelled() {
        let (surface, monitor) = (winding(25), Monitor::default());
        let options = Options::default().with_monitor(monitor.clone());
        let mut pairwise = Pairwise::new(&surface, &options).unwrap();
        let sources: Vec<usize> = (0..surface.chart().points()).collect();
        let mut seen = 0;
        let result = pairwise.rows(&sources, |rows| {
            seen += rows.sources.len();
            monitor.cancel();
            Ok::<_, Error>(())
        });
        assert!(matches!(result, Err(Error::Cancelled)) && seen < sources.len(), "{seen}");
    }
}
