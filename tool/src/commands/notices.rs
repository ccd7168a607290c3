//! Implements `geosweep notices`, which prints the third-party code in the tool and its licences.

use std::process::ExitCode;

use crate::terminal::{Outcome, print};

/// The text, generated from the packages by tests/tool/notices.rs.
const NOTICES: &str = include_str!("../../THIRD-PARTY.txt");

pub fn run() -> Outcome {
    print(NOTICES.trim_end())?;
    Ok(ExitCode::SUCCESS)
}
