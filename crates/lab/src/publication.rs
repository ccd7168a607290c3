//! Publishes reports to files and standard output.

use std::error::Error;
use std::process::ExitCode;

use geosweep::io::{OutputFile, StagedFile};
use serde::Serialize;

use geosweep_cli::output::{commit, done, stage_text};
use geosweep_cli::terminal::{Outcome, print, print_json};

/// A report as Markdown and as JSON, with its pictures.
pub struct Publication<'a, T> {
    /// The command that publishes the report.
    pub command: &'static str,
    pub markdown: String,
    /// The file for the Markdown, if any.
    pub output: Option<OutputFile>,
    /// The pictures, written but not moved to their final names yet.
    pub pictures: Vec<StagedFile>,
    pub rows: &'a T,
}

impl<T: Serialize> Publication<'_, T> {
    /// Writes the files. Then prints the JSON if `json` is set, and otherwise the Markdown if it has no file.
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
