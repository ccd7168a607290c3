//! The bodies of cargo-fuzz on stable Rust: mutated files for each reader, and random surfaces.
//!
//! This is a separate binary, since it replaces the global allocator by one with a cap. Each case has a seed.
//! A failure prints the seed, and leaves the case's bytes in the folder for temporary files. Environment:
//!
//! - `GEOSWEEP_FUZZ_CASES`: cases per body (default 500).
//! - `GEOSWEEP_FUZZ_SEED`: seed of the first case; each further case adds 1 (default: a fresh number).

mod bodies;
mod cap;
mod current;
mod mutate;
mod seeds;

use std::hash::{BuildHasher, RandomState};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::sync::PoisonError;

use bodies::BODIES;
use bodies::dice::Dice;

const CASES: u64 = 500;

/// Runs a body on its valid files, first unchanged and then mutated.
fn fuzz(name: &str) {
    let _alone = current::ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let (index, body) = BODIES.iter().enumerate().find(|(_, body)| body.name == name).unwrap();
    let seeds = seeds::of(name);
    seeds.iter().for_each(|seed| (body.run)(seed));
    let fresh = RandomState::new().hash_one(name) >> 16;
    let first = setting("GEOSWEEP_FUZZ_SEED").unwrap_or(fresh);
    for seed in (first..).take(setting("GEOSWEEP_FUZZ_CASES").unwrap_or(CASES) as usize) {
        current::set(index, seed);
        let bytes = mutate::mutated(name, &seeds, &mut Dice::new(&seed.to_le_bytes()));
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| (body.run)(&bytes))) {
            let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{seed}"));
            std::fs::write(&path, &bytes).unwrap();
            eprintln!(
                "{name}: GEOSWEEP_FUZZ_SEED={seed} GEOSWEEP_FUZZ_CASES=1 repeats this; its bytes lie in {}",
                path.display()
            );
            resume_unwind(panic);
        }
    }
}

/// Returns a number from the environment.
fn setting(name: &str) -> Option<u64> {
    let text = std::env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name}={text} is not a number")))
}

macro_rules! tests {
    ($($name:ident)*) => {
        $(
            #[test]
            fn $name() {
                fuzz(stringify!($name));
            }
        )*

        /// Each body has a test and a target for cargo-fuzz.
        #[test]
        fn every_body_is_fuzzed() {
            let tested = [$(stringify!($name)),*];
            assert_eq!(tested, BODIES.map(|body| body.name));
            for name in tested {
                let path = format!("fuzz/fuzz_targets/{name}.rs");
                let target = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path));
                assert!(target.unwrap().contains(&format!("run(\"{name}\"")), "{name}");
            }
        }
    };
}

tests!(npy npz png tiff asc exr table matrix checkpoint surface);

/// An allocation beyond the cap fails.
#[test]
fn memory_is_capped() {
    let _alone = current::ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    current::set(BODIES.len(), 0);
    assert!(Vec::<u8>::new().try_reserve_exact(cap::CAP).is_err());
    assert!(Vec::<u8>::new().try_reserve_exact(cap::CAP / 2).is_ok());
}
