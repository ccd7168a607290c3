//! The command-line tool `geosweep`; the library of this package is all of it.

use std::process::ExitCode;

fn main() -> ExitCode {
    geosweep_cli::main()
}
