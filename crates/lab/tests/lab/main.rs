//! The laboratory through its command line: what it measures, and the figures that it draws.

mod bench;
mod committed;
mod figures;
mod tuning;
#[path = "../../../../tool/tests/tool/workbench.rs"]
#[allow(dead_code, reason = "tests of the tool use all of it")]
mod workbench;

/// The program that the tests run.
const TOOL: &str = env!("CARGO_BIN_EXE_geosweep-lab");
