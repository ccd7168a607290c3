//! What can go wrong with files.

use std::path::{Path, PathBuf};

use crate::shown::{excerpt, shortened};
use crate::surface::SurfaceError;

/// Most characters of a file's name in a message.
const MOST_OF_NAME: usize = 300;
/// Most characters of a reason. Some come from other crates, and quote what a file holds.
const MOST_OF_REASON: usize = 800;

/// A file's name, of which a message holds only as much as a person reads.
fn shown(path: &Path) -> String {
    shortened(&path.display().to_string(), MOST_OF_NAME).into_owned()
}

/// Why a file cannot be read or written. Messages begin with the file's name.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The operating system refuses to read.
    #[error("{}: cannot be read: {source}", shown(path))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// Writing failed, or would fail.
    #[error("{}: cannot be written: {reason}", shown(path))]
    Write {
        /// The file.
        path: PathBuf,
        /// Why, and what to do.
        reason: String,
    },
    /// The name's extension says a format that is not supported here.
    #[error("{}: {found}; {role} is read from or written to {supported}", shown(path))]
    Extension {
        /// The file.
        path: PathBuf,
        /// What the extension is.
        found: String,
        /// What the file was to hold.
        role: &'static str,
        /// The extensions that would do.
        supported: &'static str,
    },
    /// The content does not fit its format or its role.
    #[error("{}: {reason}", shown(path))]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong, where, and what to do.
        reason: String,
    },
    /// The content is well-formed and no surface.
    #[error("{}: {source}", shown(path))]
    Surface {
        /// The file.
        path: PathBuf,
        /// What the surface's checks say.
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
