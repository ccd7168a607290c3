//! Runs computations without the interpreter's lock.

use std::any::Any;
use std::cell::RefCell;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use geosweep::Monitor;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{Scope, ThreadPool, ThreadPoolBuilder};

/// Time between two checks for signals, after each of which the progress callback is called.
const INTERVAL: Duration = Duration::from_millis(20);

/// Runs `work` without the lock. A panic becomes a `RuntimeError`.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| catch_unwind(AssertUnwindSafe(work))).map_err(panicked)
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
        in_scope(threads, |scope| {
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
        })?
    })
}

/// Runs `work` like [`watched`], on the threads that all calls share and without a callback.
pub fn stoppable<T: Send>(py: Python<'_>, work: impl FnOnce(&Monitor) -> T + Send) -> PyResult<T> {
    let monitor = Monitor::default();
    watched(py, None, &monitor, |_| Ok(()), || work(&monitor))
}

/// Runs `start` in this thread. Jobs that it spawns run on `threads` threads, or on the threads that all calls share.
fn in_scope<'s, T>(threads: Option<usize>, start: impl FnOnce(&Scope<'s>) -> T) -> PyResult<T> {
    thread_local! {
        /// The pools that calls from this thread have asked for.
        static POOLS: RefCell<HashMap<usize, std::rc::Rc<ThreadPool>>> = RefCell::default();
    }
    let Some(threads) = threads else { return Ok(rayon::in_place_scope(start)) };
    let pool = POOLS.with_borrow_mut(|pools| match pools.get(&threads) {
        Some(pool) => Ok(pool.clone()),
        None => {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build();
            let pool = pool.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
            Ok::<_, PyErr>(pools.entry(threads).or_insert(pool.into()).clone())
        }
    })?;
    Ok(pool.in_place_scope(start))
}

fn panicked(panic: Box<dyn Any + Send>) -> PyErr {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("unknown cause");
    PyRuntimeError::new_err(format!("geosweep has a fault, please report it: {text}"))
}
