//! Random cases of properties.

use std::env::{self, VarError};
use std::hash::{BuildHasher, RandomState};

use proptest::prelude::ProptestConfig;
use proptest::test_runner::RngSeed;

/// Returns a configuration with `usual` or `GEOSWEEP_CASES` random cases. They are the same in every run, so that a
/// failing test is caused by a change. The environment variable `GEOSWEEP_SEED` selects other cases: by a number, or by
/// `random` for a fresh number, which a failing test prints.
pub fn cases(usual: u32) -> ProptestConfig {
    let cases = env::var("GEOSWEEP_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(usual);
    let seed = match env::var("GEOSWEEP_SEED").as_deref() {
        Ok("random") => RandomState::new().hash_one(usual),
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("GEOSWEEP_SEED={text} is not a number")),
        Err(VarError::NotPresent) => 0,
        Err(other) => panic!("GEOSWEEP_SEED: {other}"),
    };
    println!("GEOSWEEP_SEED={seed} repeats these cases");
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(seed),
        ..ProptestConfig::default()
    }
}
