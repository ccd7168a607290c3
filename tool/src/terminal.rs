//! What a person sees while the tool runs and when it ends: lines, notes, signs of life.

use std::error::Error;
use std::fmt::Display;
use std::io::{self, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use geosweep::shown::shortened;
use indicatif::{ProgressBar, ProgressStyle};
use serde::{Serialize, Serializer};

/// What a command ends with: a status, or a message for people.
pub type Outcome = Result<ExitCode, Box<dyn Error>>;

/// Whether only warnings and errors are wanted.
static QUIET: AtomicBool = AtomicBool::new(false);

/// From now on, nothing but warnings and errors.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Says something on standard error; nothing can be done if that is closed.
pub fn say(kind: &str, message: impl Display) {
    if !is_quiet() || ["warning", "error"].contains(&kind) {
        let message = message.to_string();
        let words = message.split_inclusive(char::is_whitespace);
        let message: String = words.map(|word| shortened(word, LONGEST_WORD)).collect();
        let _ = writeln!(io::stderr(), "geosweep: {kind}: {message}");
    }
}

/// Most characters of a word in a message: more than any name of a file that a person reads.
const LONGEST_WORD: usize = 300;

/// So many of something.
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

/// Raised whenever a name in the JSON of a command is taken away or means something else.
const JSON_VERSION: u32 = 1;

/// What a command prints with --json: docs/geosweep.schema.json describes it.
#[derive(Serialize)]
struct Json<'a, T> {
    version: u32,
    command: &'a str,
    #[serde(flatten)]
    value: &'a T,
}

/// Prints an object as JSON, in one line, with the version of its names and the command that it is of.
pub fn print_json(command: &str, value: &impl Serialize) -> io::Result<()> {
    print(serde_json::to_string(&Json { version: JSON_VERSION, command, value })?)
}

/// Things under one name.
pub struct List<'a, T>(pub &'static str, pub &'a [T]);

impl<T: Serialize> Serialize for List<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map([(self.0, self.1)])
    }
}

/// A sign of life on a terminal while it lives.
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
    if is_quiet() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(template).expect("templates are part of the program");
    let bar = ProgressBar::new(steps as u64).with_style(style);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
