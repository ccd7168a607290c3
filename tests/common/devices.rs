//! Devices that tests of a binary use in turn: to open one under the validation layers and to compile
//! its pipelines takes longer than most tests. They are closed when the process ends: Debian 13's validation layers
//! (1.4.309) abort it where a device outlives them.

use std::ffi::c_int;
use std::ops::{Deref, DerefMut};
use std::sync::Mutex;

use geosweep::DeviceChoice;
use geosweep::vulkan::Solver;

/// The device that `GEOSWEEP_TEST_DEVICE` names, or any.
pub fn device_choice() -> DeviceChoice {
    DeviceChoice::Name(std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default())
}

static SOLVERS: Pool<Solver> = Pool::new();

/// A headless solver on [`device_choice`], under the validation layers: a call that leaves a
/// validation message fails. No device is a failure too, not a reason to skip.
pub fn vulkan_solver() -> Lent<Solver> {
    let open = || {
        Solver::with_validation(&device_choice()).expect(
            "the tests need a Vulkan device and the validation layers; ci/setup installs them",
        )
    };
    SOLVERS.lend(open, |solver| {
        let said = solver.validation_log().expect("validation is on").messages();
        assert!(said.is_empty(), "{said:?}");
    })
}

/// What lies ready for the next test; as many as tests have run at a time.
pub struct Pool<T: 'static>(Mutex<Vec<T>>);

impl<T: Send> Pool<T> {
    pub const fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    /// Lends one, or opens one more. It is checked when it comes back. That of a test that fails does
    /// not come back, so that the next begins with nothing of it.
    pub fn lend(&'static self, open: impl FnOnce() -> T, check: fn(&T)) -> Lent<T> {
        let idle = self.0.lock().unwrap().pop();
        let opened = || {
            let item = open();
            let close = move || self.0.lock().unwrap().clear();
            LAST.lock().unwrap().push(Box::new(close));
            item
        };
        Lent { item: Some(idle.unwrap_or_else(opened)), back: Some((self, check)) }
    }
}

/// What is left to do when the process ends.
static LAST: Mutex<Vec<Box<dyn FnOnce() + Send>>> = Mutex::new(Vec::new());

/// Has what is left done when the process ends, before all that libraries have asked for by now: what is asked for
/// last comes first. Layers ask when they are used as well as when they are loaded, so each use of a device ends with this.
fn close_at_exit() {
    // SAFETY: so C declares it, and it asks nothing of its caller.
    unsafe extern "C" {
        safe fn atexit(function: extern "C" fn()) -> c_int;
    }
    extern "C" fn all() {
        let last = std::mem::take(&mut *LAST.lock().unwrap());
        last.into_iter().for_each(|last| last());
    }
    assert_eq!(atexit(all), 0, "no more can be done at exit");
}

/// One of a [`Pool`], for one test; or one of the test's own.
pub struct Lent<T: 'static> {
    item: Option<T>,
    /// Where it goes when the test has done with it, and what is to hold of it then.
    back: Option<Return<T>>,
}

type Return<T> = (&'static Pool<T>, fn(&T));

impl<T> From<T> for Lent<T> {
    fn from(own: T) -> Self {
        Self { item: Some(own), back: None }
    }
}

impl<T> Deref for Lent<T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.item.as_ref().expect("it goes back last")
    }
}

impl<T> DerefMut for Lent<T> {
    fn deref_mut(&mut self) -> &mut T {
        self.item.as_mut().expect("it goes back last")
    }
}

impl<T> Drop for Lent<T> {
    fn drop(&mut self) {
        if !std::thread::panicking()
            && let (Some((pool, check)), Some(item)) = (self.back, self.item.take())
        {
            check(&item);
            pool.0.lock().unwrap().push(item);
            close_at_exit();
        }
    }
}
