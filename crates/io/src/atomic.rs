//! Writes output files that appear with their complete content or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use super::IoError;

/// A path at which a file can be written. It is checked before the computation of the content begins.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("map.txt");
/// use std::io::Write;
/// let output = geosweep::io::OutputFile::new(&path)?;
/// let staged = output.stage(|writer| writer.write_all(b"the whole content"))?;
/// assert!(!path.exists());
/// staged.commit()?;
/// assert_eq!(std::fs::read(&path)?, b"the whole content");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct OutputFile {
    path: PathBuf,
    /// The path after following links.
    target: PathBuf,
}

/// A complete temporary file in the folder of the final one. It is removed unless it is committed.
#[derive(Debug)]
pub struct StagedFile {
    file: NamedTempFile,
    output: OutputFile,
}

impl OutputFile {
    /// Checks that a file can be written at `path`. The file may already exist.
    ///
    /// # Errors
    /// If the folder is missing or not writable, or if `path` is something other than a writable regular
    /// file.
    pub fn new(path: &Path) -> Result<Self, IoError> {
        let error = |reason: &str| IoError::write(path, reason);
        if path.file_name().is_none() {
            return Err(error("the name of a file is missing"));
        }
        // Links are followed, so that the target of a link is replaced and not the link.
        let target = follow_links(path).map_err(|source| IoError::write(path, source))?;
        match fs::metadata(&target) {
            Ok(found) if found.is_dir() => return Err(error("a folder has this name")),
            Ok(found) if !found.is_file() => return Err(error("it is not a regular file")),
            Ok(found) if found.permissions().readonly() => {
                return Err(error("the file there is read-only; remove it or choose another name"));
            }
            _ => {}
        }
        let output = Self { path: path.to_owned(), target };
        if !output.folder().is_dir() {
            let folder = output.folder().display();
            return Err(error(&format!("there is no folder {folder}; create it first")));
        }
        output
            .temporary_file()
            .map_err(|source| error(&format!("no file can be created in its folder: {source}")))?;
        Ok(output)
    }

    /// Returns the path, as given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the path after following links.
    pub(super) fn target(&self) -> &Path {
        &self.target
    }

    /// Returns whether another output would replace the same file, under the same path or a different one.
    pub fn is_same(&self, other: &Self) -> bool {
        let place = |output: &Self| {
            let folder = fs::canonicalize(output.folder()).ok();
            let name = output.target.file_name().map(|name| name.to_string_lossy().into_owned());
            (folder, if IGNORES_CASE { name.map(|name| name.to_lowercase()) } else { name })
        };
        place(self) == place(other)
    }

    /// Writes the content to a temporary file in the same folder.
    ///
    /// # Errors
    /// The errors of `write`, with the file's name. Nothing is left behind.
    pub fn stage(
        self,
        write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
    ) -> Result<StagedFile, IoError> {
        let error = |source: io::Error| IoError::write(&self.path, source);
        let file = self.temporary_file().map_err(error)?;
        let mut writer = BufWriter::new(file.as_file());
        write(&mut writer).and_then(|()| writer.flush()).map_err(error)?;
        drop(writer);
        // Otherwise a power failure after the renaming could leave the file's name without its content.
        file.as_file().sync_data().map_err(error)?;
        Ok(StagedFile { file, output: self })
    }

    fn folder(&self) -> &Path {
        match self.target.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        }
    }

    fn temporary_file(&self) -> io::Result<NamedTempFile> {
        let mut builder = Builder::new();
        builder.prefix(".geosweep-").suffix(".part");
        // Temporary files are private by default. The mode 0o666, less the umask, is that of other new files.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        builder.tempfile_in(self.folder())
    }
}

/// Whether the usual file systems take `map.npy` and `Map.npy` for the same file.
const IGNORES_CASE: bool = cfg!(any(windows, target_vendor = "apple"));

/// Maximum number of links to follow. More links count as a cycle. Linux has the same limit.
const MOST_LINKS: usize = 40;

/// Follows the links of a path, even if its target does not exist yet.
fn follow_links(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(link) = fs::read_link(&target) else { return Ok(target) };
        // The link is relative to its folder. An absolute link replaces the whole path.
        target = target.parent().unwrap_or(Path::new("")).join(link);
    }
    Err(io::Error::other("its links lead in a circle; remove them"))
}

impl StagedFile {
    /// Returns the path that the file will have, as given.
    pub fn path(&self) -> &Path {
        self.output.path()
    }

    /// Gives the file its name, in one step.
    ///
    /// # Errors
    /// If the folder has changed in the meantime.
    pub fn commit(self) -> Result<(), IoError> {
        let Self { file, output } = self;
        file.persist(&output.target)
            .map(drop)
            .map_err(|failure| IoError::write(&output.path, explained(&failure.error)))
    }
}

/// Adds to an error of the system what it stands for on Windows, where a file that a program has open cannot be
/// replaced.
fn explained(error: &io::Error) -> String {
    /// `ERROR_ACCESS_DENIED`, `ERROR_SHARING_VIOLATION`, `ERROR_LOCK_VIOLATION`.
    const IN_USE: [i32; 3] = [5, 32, 33];
    let in_use = cfg!(windows) && error.raw_os_error().is_some_and(|code| IN_USE.contains(&code));
    let cure = if in_use { "; if another program has the file open, close it there" } else { "" };
    format!("{error}{cure}")
}

#[cfg(test)]
mod portable_tests {
    use super::*;

    #[test]
    fn names_of_one_file_are_the_same_output() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| OutputFile::new(&folder.path().join(name)).unwrap();
        assert!(at("map.npy").is_same(&at("./map.npy")));
        assert!(!at("map.npy").is_same(&at("other.npy")));
        assert_eq!(at("map.npy").is_same(&at("Map.NPY")), IGNORES_CASE);
    }

    /// A file that is open elsewhere is replaced or refused by name, and never half-written.
    #[test]
    fn a_file_that_is_open_is_replaced_or_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("K\u{e4}rtchen \u{5730}\u{56fe}.npy");
        fs::write(&path, b"old").unwrap();
        let open = File::open(&path).unwrap();
        let output = OutputFile::new(&path).unwrap();
        let staged = output.stage(|writer| writer.write_all(b"new")).unwrap();
        let written = staged.commit();
        drop(open);
        let content = fs::read(&path).unwrap();
        match written {
            Ok(()) => assert_eq!(content, b"new"),
            Err(error) => {
                assert!(cfg!(windows) && error.to_string().contains("close it there"), "{error}");
                assert_eq!(content, b"old");
            }
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "a part is left behind");
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    fn write(path: &Path) {
        let output = OutputFile::new(path).unwrap();
        output.stage(|writer| writer.write_all(b"map")).unwrap().commit().unwrap();
    }

    #[test]
    fn links_are_followed_to_files_that_are_not_there_yet() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("maps")).unwrap();
        symlink("maps/second", at("first")).unwrap();
        symlink("map.npy", at("maps/second")).unwrap();
        write(&at("first"));
        assert_eq!(fs::read(at("maps/map.npy")).unwrap(), b"map");
        assert!(fs::symlink_metadata(at("first")).unwrap().is_symlink());
        // The second write replaces the file, which exists now.
        write(&at("first"));
        assert!(fs::symlink_metadata(at("maps/second")).unwrap().is_symlink());
    }

    #[test]
    fn links_in_a_circle_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        symlink(&a, &b).unwrap();
        symlink(&b, &a).unwrap();
        assert!(OutputFile::new(&a).unwrap_err().to_string().contains("circle"));
    }
}
