//! Writes output files. Their names must suit their contents and differ from inputs and from one another.
//! Files appear whole or not at all.

use std::error::Error;
use std::fmt;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use geosweep::io::{IoError, OutputFile, StagedFile};

use crate::picture::Canvas;
use crate::terminal::{Spinner, say};

/// Returns a file to write, checked before the computation starts. `what` is a noun and a verb for messages, such as "a
/// picture is".
pub fn output_file(path: &Path, what: &str, extension: &str) -> Result<OutputFile, Box<dyn Error>> {
    if path.extension().is_none_or(|found| !found.eq_ignore_ascii_case(extension)) {
        let name = path.display();
        return Err(format!(
            "{name}: {what} written as .{extension}; choose a name that ends in .{extension}"
        )
        .into());
    }
    Ok(OutputFile::new(path)?)
}

/// Returns the file to write, if one is requested.
pub fn wanted_file(
    path: Option<&PathBuf>,
    what: &str,
    extension: &str,
) -> Result<Option<OutputFile>, Box<dyn Error>> {
    path.map(|path| output_file(path, what, extension)).transpose()
}

/// Returns a picture to write.
pub fn png_output(path: &Path) -> Result<OutputFile, Box<dyn Error>> {
    output_file(path, "a picture is", "png")
}

/// Returns the picture to write, if one is requested.
pub fn wanted_png(path: Option<&PathBuf>) -> Result<Option<OutputFile>, Box<dyn Error>> {
    path.map(|path| png_output(path)).transpose()
}

/// Refuses to write a file twice or over an input. A command must not overwrite its inputs or its own outputs.
pub fn check_outputs<'a>(
    outputs: &[&OutputFile],
    inputs: impl Iterator<Item = &'a Path>,
) -> Result<(), String> {
    for (index, output) in outputs.iter().enumerate() {
        if outputs[..index].iter().any(|before| before.is_same(output)) {
            let name = output.path().display();
            return Err(format!("{name} is given for two outputs; choose another name"));
        }
    }
    let resolve = |path: &Path| fs::canonicalize(path).ok();
    let inputs: Vec<_> = inputs.filter_map(resolve).collect();
    for output in outputs {
        let target = resolve(output.path());
        if target.is_some_and(|target| inputs.contains(&target)) {
            let name = output.path().display();
            return Err(format!("{name} is also an input; choose another name"));
        }
    }
    Ok(())
}

/// Draws a picture and writes it. The file does not have its final name yet.
pub fn stage_picture(
    output: OutputFile,
    draw: impl FnOnce() -> Canvas,
) -> Result<StagedFile, IoError> {
    let _spinner = Spinner::new("drawing");
    let picture = draw();
    output.stage(|writer| picture.write_png(writer))
}

/// Writes a text. The file does not have its final name yet.
pub fn stage_text(output: OutputFile, text: &str) -> Result<StagedFile, IoError> {
    output.stage(|writer| writer.write_all(text.as_bytes()))
}

/// Moves all files to their final names, once all are written.
pub fn commit(staged: impl IntoIterator<Item = StagedFile>) -> Result<Written, IoError> {
    let mut written = Written::default();
    for file in staged {
        written.add(file.path());
        file.commit()?;
    }
    Ok(written)
}

/// The names of files that have been written.
#[derive(Default)]
pub struct Written(Vec<PathBuf>);

impl Written {
    pub fn add(&mut self, path: &Path) {
        self.0.push(path.to_owned());
    }
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<_> = self.0.iter().map(|path| path.display().to_string()).collect();
        if names.is_empty() { Ok(()) } else { write!(f, "wrote {}", names.join(", ")) }
    }
}

/// Prints one line with the parts of a command's result and the files that it has written.
pub fn done(parts: impl IntoIterator<Item = String>, written: &Written) {
    let parts = parts.into_iter().chain([written.to_string()]);
    let parts: Vec<_> = parts.filter(|part| !part.is_empty()).collect();
    if !parts.is_empty() {
        say("done", parts.join("; "));
    }
}
