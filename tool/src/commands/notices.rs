//! `geosweep notices`: what the tool contains of others, and under which licences.

use std::process::ExitCode;

use crate::terminal::{Outcome, print};

/// Made from the packages by tests/tool/notices.rs.
const NOTICES: &str = include_str!("../../THIRD-PARTY.txt");

pub fn run() -> Outcome {
    print(NOTICES.trim_end())?;
    Ok(ExitCode::SUCCESS)
}
