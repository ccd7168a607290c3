//! Runs a command line and ends with the exit status of its outcome. The tool and the laboratory share it.

use std::error::Error;
use std::io;
use std::process::ExitCode;

use clap::Parser;
use clap::error::{ContextValue, ErrorKind};
use geosweep::shown::excerpt;

use crate::pipelines;
use crate::terminal::{self, Outcome, say};

/// A program's arguments.
pub trait CommandLine: Parser {
    /// Whether notes and progress are suppressed.
    fn is_quiet(&self) -> bool;

    fn run(&self) -> Outcome;
}

/// The exit status for errors. As in diff, 1 stands for a difference: `compare` and `tune` return it if maps differ.
const TROUBLE: u8 = 2;

/// Parses the arguments of the process and runs them.
pub fn main<C: CommandLine>() -> ExitCode {
    let line = match C::try_parse() {
        Ok(line) => line,
        Err(usage) => return usage_exit(&usage),
    };
    if line.is_quiet() {
        terminal::be_quiet();
    }
    pipelines::keep();
    line.run().unwrap_or_else(|error| {
        if !is_broken_pipe(error.as_ref()) {
            say("error", error);
        }
        ExitCode::from(TROUBLE)
    })
}

/// Prints the result of clap when it returns no arguments. Help and version go to standard output. Errors go
/// to standard error in the tool's own form. A command without any arguments prints its help.
fn usage_exit(usage: &clap::Error) -> ExitCode {
    if usage.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        // An error is ignored for the same reason as below.
        let _ = terminal::print(usage.render().to_string().trim_end());
        ExitCode::SUCCESS
    } else if usage.use_stderr() {
        let text = in_short(usage);
        say("error", text.strip_prefix("error: ").unwrap_or(&text).trim_end());
        ExitCode::from(TROUBLE)
    } else {
        // An error is ignored: a reader that has closed the pipe has read enough.
        let _ = usage.print();
        ExitCode::SUCCESS
    }
}

/// Returns clap's message with long quoted arguments shortened.
fn in_short(usage: &clap::Error) -> String {
    let mut text = usage.render().to_string();
    for (_, value) in usage.context() {
        if let ContextValue::String(quoted) = value {
            text = text.replace(quoted.as_str(), &excerpt(quoted));
        }
    }
    text
}

/// Returns whether the error means that the reader of standard output has closed it.
fn is_broken_pipe(error: &(dyn Error + 'static)) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}
