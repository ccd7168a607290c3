//! Where reports go.

use std::error::Error;
use std::process::ExitCode;

use geosweep::io::{OutputFile, StagedFile};
use serde::Serialize;

use crate::output::{commit, done, stage_text};
use crate::terminal::{Outcome, print, print_json};

/// A report in Markdown, the same as JSON, and what is drawn of it.
pub struct Publication<'a, T> {
    /// That prints it.
    pub command: &'static str,
    pub markdown: String,
    /// The file for the Markdown, if any.
    pub output: Option<OutputFile>,
    /// Pictures, written but for their names.
    pub pictures: Vec<StagedFile>,
    pub rows: &'a T,
}

impl<T: Serialize> Publication<'_, T> {
    /// Writes the files; then prints the JSON if it is wanted, else the Markdown if it has no file.
    pub fn publish(self, json: bool) -> Outcome {
        let is_written = self.output.is_some();
        let text = self.output.map(|output| stage_text(output, &self.markdown)).transpose()?;
        done([], &commit(text.into_iter().chain(self.pictures))?);
        if json {
            print_json(self.command, self.rows)?;
        } else if !is_written {
            print(self.markdown.trim_end())?;
        }
        Ok::<_, Box<dyn Error>>(ExitCode::SUCCESS)
    }
}
