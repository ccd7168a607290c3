//! Output files whose names say what is in them.

use std::error::Error;
use std::path::Path;

use geosweep::io::OutputFile;

/// A file to write, checked before the work begins; `what` ends with the verb, as in "a picture
/// is".
pub fn output_file(path: &Path, what: &str, extension: &str) -> Result<OutputFile, Box<dyn Error>> {
    if path.extension().is_none_or(|found| !found.eq_ignore_ascii_case(extension)) {
        let name = path.display();
        return Err(format!("{name}: {what} written as .{extension}; choose such a name").into());
    }
    Ok(OutputFile::new(path)?)
}

/// A picture to write.
pub fn png_output(path: &Path) -> Result<OutputFile, Box<dyn Error>> {
    output_file(path, "a picture is", "png")
}
