//! What can go wrong with files.

use std::path::{Path, PathBuf};

use crate::surface::SurfaceError;

/// Why a file cannot be read or written. Messages begin with the file's name.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The operating system refuses to read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// Writing failed, or would fail.
    #[error("{}: cannot be written: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why, and what to do.
        reason: String,
    },
    /// The name's extension says a format that is not supported here.
    #[error("{}: {found}; {role} is read from or written to {supported}", path.display())]
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
    #[error("{}: {reason}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong, where, and what to do.
        reason: String,
    },
    /// The content is well-formed and no surface.
    #[error("{}: {source}", path.display())]
    Surface {
        /// The file.
        path: PathBuf,
        /// What the surface's checks say.
        source: SurfaceError,
    },
}

impl IoError {
    pub(crate) fn content(path: &Path, reason: impl Into<String>) -> Self {
        Self::Content { path: path.to_owned(), reason: reason.into() }
    }

    pub(crate) fn write(path: &Path, reason: impl ToString) -> Self {
        Self::Write { path: path.to_owned(), reason: reason.to_string() }
    }

    pub(crate) fn extension(path: &Path, role: &'static str, supported: &'static str) -> Self {
        let found = match path.extension() {
            Some(extension) => format!("unknown extension .{}", extension.display()),
            None => "the name has no extension".into(),
        };
        Self::Extension { path: path.to_owned(), found, role, supported }
    }
}
