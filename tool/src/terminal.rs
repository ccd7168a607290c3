//! Prints results, notes and progress while the tool runs and when it ends.

use std::error::Error;
use std::fmt::Display;
use std::io::{self, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use geosweep::shown::shortened;
use indicatif::{ProgressBar, ProgressStyle};
use serde::{Serialize, Serializer};

/// The result of a command: an exit status, or an error message.
pub type Outcome = Result<ExitCode, Box<dyn Error>>;

/// Whether notes and progress are suppressed. Results, warnings and errors are always printed.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Suppresses notes and progress from now on. Results, warnings and errors are still printed.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints a message on standard error. A failure is ignored, since it could not be reported.
pub fn say(kind: &str, message: impl Display) {
    if !is_quiet() || ["warning", "error"].contains(&kind) {
        let message = message.to_string();
        let words = message.split_inclusive(char::is_whitespace);
        let message: String = words.map(|word| shortened(word, LONGEST_WORD)).collect();
        let _ = writeln!(io::stderr(), "geosweep: {kind}: {message}");
    }
}

/// Prints a note, formatted as by `format!`.
#[macro_export]
macro_rules! note {
    ($($words:tt)*) => { $crate::terminal::say("note", format_args!($($words)*)) };
}

/// Prints a warning, formatted as by `format!`.
#[macro_export]
macro_rules! warning {
    ($($words:tt)*) => { $crate::terminal::say("warning", format_args!($($words)*)) };
}

/// The largest number of characters of a word in a message. Longer words are shortened. Usual file names are shorter.
const LONGEST_WORD: usize = 300;

/// Formats a count with its noun in the singular or plural.
pub fn counted(count: impl Into<u64>, what: &str) -> String {
    match count.into() {
        1 => format!("1 {what}"),
        count => format!("{count} {what}s"),
    }
}

/// Prints a line on standard output.
pub fn print(line: impl Display) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    writeln!(stdout, "{line}").and_then(|()| stdout.flush()).map_err(|error| {
        io::Error::new(error.kind(), format!("cannot write to standard output: {error}"))
    })
}

/// The version of the JSON output. It is raised whenever a name is removed or changes its meaning.
const JSON_VERSION: u32 = 1;

/// The output of a command with --json, described by docs/geosweep.schema.json.
#[derive(Serialize)]
struct Json<'a, T> {
    version: u32,
    command: &'a str,
    #[serde(flatten)]
    value: &'a T,
}

/// Prints an object as JSON, in one line, with the version and the command.
pub fn print_json(command: &str, value: &impl Serialize) -> io::Result<()> {
    print(serde_json::to_string(&Json { version: JSON_VERSION, command, value })?)
}

/// A list that is printed as a JSON object with a single member.
pub struct List<'a, T>(pub &'static str, pub &'a [T]);

impl<T: Serialize> Serialize for List<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map([(self.0, self.1)])
    }
}

/// A spinner on a terminal, shown until it is dropped.
pub struct Spinner(ProgressBar);

impl Spinner {
    pub fn new(doing: &'static str) -> Self {
        if is_quiet() {
            return Self(ProgressBar::hidden());
        }
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

/// Returns a progress bar on a terminal. Elsewhere nothing is shown.
pub fn progress(steps: usize) -> ProgressBar {
    bar(steps, "{wide_msg} {bar:30} {pos}/{len}")
}

/// Returns a progress bar for the rows of a matrix, with the remaining time. An earlier run has already
/// computed `done` of them.
pub fn progress_of_rows(rows: usize, done: usize) -> ProgressBar {
    let bar = bar(rows, "computing distances {bar:30} {human_pos}/{human_len} rows, {eta} left");
    bar.set_position(done as u64);
    bar.reset_eta();
    bar
}

fn bar(steps: usize, template: &str) -> ProgressBar {
    if is_quiet() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(template).expect("templates are part of the program");
    let bar = ProgressBar::new(steps as u64).with_style(style);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
