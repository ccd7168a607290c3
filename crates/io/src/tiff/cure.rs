//! Tells the user how to convert an unsupported TIFF file.

use std::path::Path;

/// The conversion of an unsupported file to a supported one.
pub(super) struct Cure<'a>(pub &'a Path);

impl Cure<'_> {
    /// Returns the command line of GDAL's tool with the given options.
    pub(super) fn translate(&self, options: &str) -> String {
        format!("gdal_translate {options} {} plain.tif", self.0.display())
    }
}
