//! Runs computations without the interpreter's lock, on threads of this process.

use std::any::Any;
use std::cell::RefCell;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::mem::ManuallyDrop;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use geosweep::Monitor;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Time between two checks for signals, after each of which the progress callback is called.
const INTERVAL: Duration = Duration::from_millis(20);

/// Number of grid points up to which work is done by the calling thread alone. Waking other threads takes about 0.05 ms,
/// and a map of so many points about 1 ms.
const SMALL: usize = 64 * 64;

/// Runs `work` on a grid of so many points as [`detached`] does. The calling thread does it alone if they are few.
pub fn on_points<T: Send>(
    py: Python<'_>,
    points: usize,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    if points > SMALL {
        return detached(py, work);
    }
    join_own_pool()?;
    py.detach(|| catch_unwind(AssertUnwindSafe(work))).map_err(panicked)
}

/// Makes the calling thread the only thread of a pool, in which its parallel loops run, unless it is in a pool already.
/// A child that this thread makes by `fork` inherits the whole pool.
fn join_own_pool() -> PyResult<()> {
    if rayon::current_thread_index().is_none() {
        let own = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
        // The thread stays in the pool until it ends.
        own.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    }
    Ok(())
}

/// Runs `work` without the lock, on the threads that all calls share. A panic becomes a `RuntimeError`.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = shared_pool()?;
    let run = || pool.threads.install(work);
    py.detach(|| catch_unwind(AssertUnwindSafe(run))).map_err(panicked)
}

/// Runs `work` on a grid of so many points as [`watched`] does. The calling thread does it alone if they are few, and then
/// it checks for nothing meanwhile.
pub fn watched_on_points<T: Send>(
    py: Python<'_>,
    points: usize,
    threads: Option<usize>,
    monitor: &Monitor,
    tell: impl Fn(Python<'_>) -> PyResult<()> + Sync,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    if points > SMALL {
        return watched(py, threads, monitor, tell, work);
    }
    let done = on_points(py, points, work)?;
    py.check_signals()?;
    Ok(done)
}

/// Runs `work` without the lock, on `threads` threads or, if that is `None`, on the threads that all calls share.
/// Meanwhile this thread checks for signals and calls `tell`. If either fails (Ctrl-C raises `KeyboardInterrupt`),
/// `monitor` cancels the work.
pub fn watched<T: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    monitor: &Monitor,
    tell: impl Fn(Python<'_>) -> PyResult<()> + Sync,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    let pool = match threads {
        Some(threads) => own_pool(threads)?,
        None => shared_pool()?,
    };
    py.detach(|| {
        let (send, receive) = channel();
        let job = move || {
            let done = catch_unwind(AssertUnwindSafe(work));
            // The receiver lives until the work is done.
            let _ = send.send(done);
        };
        let look = || {
            Python::attach(|py| {
                py.check_signals()?;
                tell(py)
            })
        };
        pool.threads.in_place_scope(|scope| {
            scope.spawn(|_| job());
            let mut failure = None;
            let done = loop {
                match receive.recv_timeout(INTERVAL) {
                    Ok(done) => break done,
                    Err(RecvTimeoutError::Timeout) if failure.is_none() => {
                        failure = look().err();
                        if failure.is_some() {
                            monitor.cancel();
                        }
                    }
                    Err(RecvTimeoutError::Timeout) => (),
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(PyRuntimeError::new_err("the computation has ended early"));
                    }
                }
            };
            match failure {
                Some(failure) => Err(failure),
                None => done.map_err(panicked),
            }
        })
    })
}

/// Runs `work` like [`watched`], on the threads that all calls share and without a callback.
pub fn stoppable<T: Send>(py: Python<'_>, work: impl FnOnce(&Monitor) -> T + Send) -> PyResult<T> {
    let monitor = Monitor::default();
    watched(py, None, &monitor, |_| Ok(()), || work(&monitor))
}

/// Threads of the process that has made them.
///
/// A child that this process makes by `fork` inherits the pool without its threads. In the child, work in the pool
/// would never start, and dropping the pool may wait for a lock that one of the threads held. That is why nothing runs
/// in rayon's global pool, which no child can replace.
struct Pool {
    process: u32,
    threads: ManuallyDrop<ThreadPool>,
}

impl Pool {
    /// Makes a pool of `threads` threads, or of as many as rayon chooses if that is 0.
    fn new(threads: usize) -> PyResult<Self> {
        let made = ThreadPoolBuilder::new().num_threads(threads).build();
        let made = made.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        Ok(Self { process: process::id(), threads: ManuallyDrop::new(made) })
    }

    /// Returns whether this process has made the pool.
    fn is_own(&self) -> bool {
        self.process == process::id()
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        if self.is_own() {
            // SAFETY: nothing uses the threads after this.
            unsafe { ManuallyDrop::drop(&mut self.threads) };
        }
    }
}

/// Returns the pool that all calls of this process share. The caller holds the interpreter's lock, so that no other
/// thread forks while the pool is locked.
fn shared_pool() -> PyResult<Arc<Pool>> {
    static SHARED: Mutex<Option<Arc<Pool>>> = Mutex::new(None);
    let mut shared = SHARED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(pool) = shared.as_ref().filter(|pool| pool.is_own()) {
        return Ok(Arc::clone(pool));
    }
    let pool = Arc::new(Pool::new(0)?);
    *shared = Some(Arc::clone(&pool));
    Ok(pool)
}

/// Returns the pool of `threads` threads that calls from this thread share.
fn own_pool(threads: usize) -> PyResult<Arc<Pool>> {
    thread_local! {
        /// The pools that calls from this thread have asked for, by process and number of threads.
        static POOLS: RefCell<HashMap<(u32, usize), Arc<Pool>>> = RefCell::default();
    }
    POOLS.with_borrow_mut(|pools| match pools.entry((process::id(), threads)) {
        Entry::Occupied(pool) => Ok(Arc::clone(pool.get())),
        Entry::Vacant(place) => Ok(Arc::clone(place.insert(Arc::new(Pool::new(threads)?)))),
    })
}

fn panicked(panic: Box<dyn Any + Send>) -> PyErr {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("unknown cause");
    PyRuntimeError::new_err(format!("geosweep has a fault, please report it: {text}"))
}
