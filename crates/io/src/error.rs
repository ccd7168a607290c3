//! Defines the errors of reading and writing files.

use std::path::{Path, PathBuf};

use geosweep_surface::SurfaceError;
use geosweep_surface::shown::{excerpt, shortened};

/// Maximum number of characters of a file's name in a message.
const MOST_OF_NAME: usize = 300;
/// Maximum number of characters of a reason. Some reasons come from other crates and quote the content of a
/// file.
const MOST_OF_REASON: usize = 800;

/// Formats a file's name, shortened to a readable length.
fn shown(path: &Path) -> String {
    shortened(&path.display().to_string(), MOST_OF_NAME).into_owned()
}

/// The reason why a file cannot be read or written. Messages begin with the file's name.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The operating system cannot read the file.
    #[error("{}: cannot be read: {source}", shown(path))]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// Writing failed, or would fail.
    #[error("{}: cannot be written: {reason}", shown(path))]
    Write {
        /// The file.
        path: PathBuf,
        /// The reason, and what to do.
        reason: String,
    },
    /// The name's extension stands for a format that is not supported for this purpose.
    #[error("{}: {found}; {role} is read from or written to {supported}", shown(path))]
    Extension {
        /// The file.
        path: PathBuf,
        /// Description of the extension found.
        found: String,
        /// The intended content of the file.
        role: &'static str,
        /// The supported extensions.
        supported: &'static str,
    },
    /// The content does not fit its format or its role.
    #[error("{}: {reason}", shown(path))]
    Content {
        /// The file.
        path: PathBuf,
        /// Description of the error, its place, and what to do.
        reason: String,
    },
    /// The content is well-formed, but does not make a surface.
    #[error("{}: {source}", shown(path))]
    Surface {
        /// The file.
        path: PathBuf,
        /// The error of the surface's checks.
        source: SurfaceError,
    },
}

impl IoError {
    pub(crate) fn content(path: &Path, reason: impl Into<String>) -> Self {
        let reason = shortened(&reason.into(), MOST_OF_REASON).into_owned();
        Self::Content { path: path.to_owned(), reason }
    }

    pub(crate) fn write(path: &Path, reason: impl ToString) -> Self {
        let reason = shortened(&reason.to_string(), MOST_OF_REASON).into_owned();
        Self::Write { path: path.to_owned(), reason }
    }

    pub(crate) fn extension(path: &Path, role: &'static str, supported: &'static str) -> Self {
        let found = match path.extension() {
            Some(extension) => {
                format!("unknown extension .{}", excerpt(&extension.display().to_string()))
            }
            None => "the name has no extension".into(),
        };
        Self::Extension { path: path.to_owned(), found, role, supported }
    }
}
