//! The case that runs, so that it can be named where a panic is not possible.

use std::io::Write;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use crate::bodies::BODIES;

static BODY: AtomicUsize = AtomicUsize::new(BODIES.len());
static SEED: AtomicU64 = AtomicU64::new(0);

/// Lock that each test holds while it runs, since memory is counted for the whole process.
pub static ALONE: Mutex<()> = Mutex::new(());

pub fn set(body: usize, seed: u64) {
    BODY.store(body, Ordering::Relaxed);
    SEED.store(seed, Ordering::Relaxed);
}

/// Reports a refused allocation to standard error without allocating.
pub fn tell_of_refusal(bytes: usize) {
    let name = BODIES.get(BODY.load(Ordering::Relaxed)).map_or("no body", |body| body.name);
    let seed = SEED.load(Ordering::Relaxed);
    let mut line = [0; 160];
    let mut rest = &mut line[..];
    let _ = writeln!(rest, "{bytes} bytes refused: {name}, GEOSWEEP_FUZZ_SEED={seed}");
    let left = rest.len();
    let _ = std::io::stderr().write_all(&line[..160 - left]);
}
