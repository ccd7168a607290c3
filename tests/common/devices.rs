//! Devices that the tests of a binary share. Opening one under the validation layers and compiling its
//! pipelines takes longer than most tests. The devices are closed when the process ends: Debian 13's
//! validation layers (1.4.309) abort the process if a device outlives them.

use std::ffi::c_int;
use std::ops::{Deref, DerefMut};
use std::sync::Mutex;

use geosweep::DeviceChoice;
use geosweep::vulkan::{HeadlessSolver, TileLanes, Tuning};

/// Returns the device that `GEOSWEEP_TEST_DEVICE` names, or any.
pub fn device_choice() -> DeviceChoice {
    DeviceChoice::Name(std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default())
}

static SOLVERS: Pool<HeadlessSolver> = Pool::new();
static GPU_LIKE_SOLVERS: Pool<HeadlessSolver> = Pool::new();

/// Lends a headless solver on [`device_choice`], under the validation layers. A call that causes a validation
/// message fails. A missing device is a failure too, not a reason to skip the test.
pub fn vulkan_solver() -> Lent<HeadlessSolver> {
    SOLVERS.lend(open, assert_nothing_said)
}

/// Lends a solver like [`vulkan_solver`] whose passes have the forms of a GPU: scans go in pairs, tiles have a lane for
/// each point and pass fronts on by shuffles, and shaders access memory of the device alone.
pub fn gpu_like_solver() -> Lent<HeadlessSolver> {
    GPU_LIKE_SOLVERS.lend(|| tuned(gpu_like), assert_nothing_said)
}

/// Returns the forms in which a GPU runs passes, in sizes that suit lavapipe: a line of a tile has as many points as a
/// subgroup has lanes.
fn gpu_like(tuning: Tuning) -> Tuning {
    Tuning {
        scan_pairs: true,
        tile_lanes: TileLanes::Shuffled,
        tile: 8,
        small_grid: 0,
        tile_edges: true,
        inner: 1,
        staged: true,
        ..tuning
    }
}

/// Opens a device under the validation layers.
fn open() -> HeadlessSolver {
    HeadlessSolver::with_validation(&device_choice())
        .expect("the tests need a Vulkan device and the validation layers; ci/setup installs them")
}

/// Opens a device under the validation layers, with the tuning that `change` returns.
pub fn tuned(change: impl FnOnce(Tuning) -> Tuning) -> HeadlessSolver {
    let solver = open();
    let tuning = change(solver.tuning());
    solver.with_tuning(tuning).unwrap()
}

/// Asserts that the validation layers have reported nothing.
pub fn assert_nothing_said(solver: &HeadlessSolver) {
    let said = solver.validation_log().expect("validation is on").messages();
    assert!(said.is_empty(), "{said:?}");
}

/// Items that are ready for the next test. Their number is the largest number of tests that ran at the same
/// time.
pub struct Pool<T: 'static>(Mutex<Vec<T>>);

impl<T: Send> Pool<T> {
    pub const fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    /// Lends an item, or opens a new one. The item is checked when it is returned. A failing test does not
    /// return its item, so that the next test does not see its state.
    pub fn lend(&'static self, open: impl FnOnce() -> T, check: fn(&T)) -> Lent<T> {
        let idle = self.0.lock().unwrap().pop();
        Lent { item: Some(idle.unwrap_or_else(open)), back: Some((self, check, Self::take_back)) }
    }

    fn take_back(&'static self, item: T) {
        self.0.lock().unwrap().push(item);
        LAST.lock().unwrap().push(Box::new(move || self.0.lock().unwrap().clear()));
        let mut most = MOST.lock().unwrap();
        if resident() > *most {
            close_idle();
            // The rest belongs to items in use, or to the heap. Without this, each further item would be closed.
            *most = (*most).max(resident() + (1 << 28));
        }
    }
}

/// Functions that close idle items.
static LAST: Mutex<Vec<Box<dyn FnOnce() + Send>>> = Mutex::new(Vec::new());
/// Bytes of the process above which idle items are closed: their pipelines take up to hundreds of megabytes. Pipelines
/// that are made again come from the driver's cache.
static MOST: Mutex<u64> = Mutex::new(5 << 28);

/// Returns the bytes of the process in memory, or 0 where the system does not tell.
fn resident() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").ok();
    let pages = pages.and_then(|text| text.split(' ').nth(1)?.parse::<u64>().ok());
    4096 * pages.unwrap_or(0)
}

fn close_idle() {
    let closers = std::mem::take(&mut *LAST.lock().unwrap());
    closers.into_iter().for_each(|close| close());
}

/// Registers the function that runs when the process ends. It runs before all functions that libraries have
/// registered so far, since the last one registered runs first. Layers register functions when they are
/// loaded and also when they are used, so each use of a device ends with this call.
fn close_at_exit() {
    // SAFETY: `atexit` has this declaration in C, and it requires nothing of its caller.
    unsafe extern "C" {
        safe fn atexit(function: extern "C" fn()) -> c_int;
    }
    extern "C" fn all() {
        close_idle();
    }
    assert_eq!(atexit(all), 0, "no more can be done at exit");
}

/// An item of a [`Pool`] for one test, or the test's own item.
pub struct Lent<T: 'static> {
    item: Option<T>,
    /// Pool to which the item returns after the test, and the check that it must pass.
    back: Option<Return<T>>,
}

type Return<T> = (&'static Pool<T>, fn(&T), fn(&'static Pool<T>, T));

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
            && let (Some((pool, check, take_back)), Some(item)) = (self.back, self.item.take())
        {
            check(&item);
            take_back(pool, item);
            close_at_exit();
        }
    }
}
