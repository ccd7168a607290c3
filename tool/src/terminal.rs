//! What a person sees while the tool runs and when it ends: lines, notes, signs of life.

use std::error::Error;
use std::fmt::Display;
use std::io::{self, Write};
use std::process::ExitCode;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

/// What a command ends with: a status, or a message for people.
pub type Outcome = Result<ExitCode, Box<dyn Error>>;

/// Says something on standard error; nothing can be done if that is closed.
pub fn say(kind: &str, message: impl Display) {
    let _ = writeln!(io::stderr(), "geosweep: {kind}: {message}");
}

/// Prints a line on standard output.
pub fn print(line: impl Display) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    writeln!(stdout, "{line}").and_then(|()| stdout.flush()).map_err(|error| {
        io::Error::new(error.kind(), format!("cannot write to standard output: {error}"))
    })
}

/// Prints a value as JSON, in one line.
pub fn print_json(value: &impl Serialize) -> io::Result<()> {
    print(serde_json::to_string(value)?)
}

/// Prints a value as JSON, in many lines.
pub fn print_pretty_json(value: &impl Serialize) -> io::Result<()> {
    print(serde_json::to_string_pretty(value)?)
}

/// A sign of life on a terminal while it lives.
pub struct Spinner(ProgressBar);

impl Spinner {
    pub fn new(doing: &'static str) -> Self {
        let bar = ProgressBar::new_spinner().with_message(doing);
        bar.enable_steady_tick(Duration::from_millis(100));
        Self(bar)
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// A bar on a terminal, and nothing elsewhere.
pub fn progress(steps: usize) -> ProgressBar {
    bar(steps, "{wide_msg} {bar:30} {pos}/{len}")
}

/// A bar for the rows of a matrix, of which some were there before, with the time left.
pub fn progress_of_rows(rows: usize, done: usize) -> ProgressBar {
    let bar = bar(rows, "computing distances {bar:30} {human_pos}/{human_len} rows, {eta} left");
    bar.set_position(done as u64);
    bar.reset_eta();
    bar
}

fn bar(steps: usize, template: &str) -> ProgressBar {
    let style = ProgressStyle::with_template(template).expect("templates are part of the program");
    let bar = ProgressBar::new(steps as u64).with_style(style);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
